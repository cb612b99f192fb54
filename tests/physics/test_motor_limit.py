import pytest

from tierod.physics.motor_limit import driving_limit


@pytest.mark.parametrize(
    ("speed", "torque"), [(-300.0, 3.0), (0.0, 3.0), (150.0, 3.0), (250.0, 1.5), (350.0, 0.0), (500.0, 0.0)]
)
def test_torque_falls_between_base_and_no_load_speed(speed, torque):
    assert driving_limit(speed, 3.0, 150.0, 350.0) == pytest.approx(torque)
