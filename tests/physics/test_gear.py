import pytest

from tierod.physics.gear import gear_coupling_torque, superposed_angle


def test_elastic_gear_works_without_loss():
    """The potential of its spring gives both torques."""
    stiffness, ratio, motor, shaft, small = 7.26, 18.0, 0.5, 0.02, 1e-6

    def energy(motor, shaft):
        return 0.5 * stiffness * (motor - ratio * shaft) ** 2

    torque = gear_coupling_torque(motor, shaft, ratio, stiffness)
    assert torque == pytest.approx((energy(motor + small, shaft) - energy(motor - small, shaft)) / (2.0 * small))
    assert ratio * torque == pytest.approx(-(energy(motor, shaft + small) - energy(motor, shaft - small)) / (2 * small))


def test_either_input_alone_turns_the_pinion_by_its_ratio():
    assert superposed_angle(22.5, 0.0, 22.5, 1.0) == pytest.approx(1.0)
    assert superposed_angle(0.0, 1.0, 22.5, 1.1) == pytest.approx(1.0 / 1.1)
    assert superposed_angle(22.5, -1.0, 22.5, 1.0) == pytest.approx(0.0)
