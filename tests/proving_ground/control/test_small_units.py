import pytest

from tierod.proving_ground.control.angle_control import Feel, SpeedControl, VariableRatio


def test_ratio_falls_from_standing_to_fast_and_is_half_way_at_the_middle_speed():
    ratio = VariableRatio(standing=1.4, fast=0.8, middle_speed=18.0)
    assert ratio.gain(0.0) == pytest.approx(1.4)
    assert ratio.gain(18.0) == pytest.approx(1.1)
    assert ratio.gain(1e6) == pytest.approx(0.8)
    assert ratio.gain(-5.0) == ratio.gain(5.0)


def test_feel_opposes_angle_rate_and_load_up_to_its_limit():
    feel = Feel(stiffness=1.0, damping=0.2, load_share=10.0, torque_limit=5.0)
    assert feel.torque(1.0, 2.0, 0.1) == pytest.approx(-(1.0 + 0.4 + 1.0))
    assert feel.torque(-100.0, 0.0, 0.0) == 5.0


def test_speed_control_learns_a_slope_and_stays_within_its_limit():
    control, memory, speed = SpeedControl(), 0.0, 5.0
    for _ in range(20_000):
        memory, acceleration = control.decide(memory, 8.0, 0.0, speed)
        assert abs(acceleration) <= control.greatest_acceleration
        speed += 1e-3 * (acceleration - 1.0)
        assert speed < 8.3
    assert speed == pytest.approx(8.0, abs=1e-3)
    assert memory == pytest.approx(1.0, abs=1e-2)
