import numpy as np
import pytest

from tierod_lab.ground.control.angle_control import AngleControl, Feel, SpeedControl, VariableRatio

STEP = 1e-3
CONTROL = AngleControl(stiffness=40.0, damping=1.5, integral=100.0, torque_limit=10.0)


def follow(control, target, disturbance=0.0, inertia=0.05, damping=0.5):
    """A damped inertia under the control, by semi-implicit steps of 1 ms."""
    memory, angle, rate, angles, torques = control.remembered(), 0.0, 0.0, [], []
    for wanted in target:
        memory, torque = control.decide(memory, float(wanted), angle)
        rate += STEP * (torque + disturbance - damping * rate) / inertia
        angle += STEP * rate
        angles.append(angle)
        torques.append(torque)
    return np.array(angles), np.array(torques)


def test_it_reaches_a_step_and_stays():
    angles, _ = follow(CONTROL, np.full(3000, 0.2))
    assert angles[-1] == pytest.approx(0.2, abs=1e-4)
    assert 0.2 < np.max(angles) < 0.24
    assert np.argmax(angles > 0.18) < 150


def test_lasting_resistance_is_learnt():
    angles, torques = follow(CONTROL, np.full(4000, 0.2), disturbance=-3.0)
    assert angles[-1] == pytest.approx(0.2, abs=1e-4)
    assert torques[-1] == pytest.approx(3.0, abs=1e-2)


def test_damping_ahead_follows_a_ramp_without_lag():
    ramp = np.arange(1000) * STEP
    with_it, _ = follow(AngleControl(40.0, 1.5, 0.0, 10.0, forward_damping=0.5), ramp)
    without, _ = follow(AngleControl(40.0, 1.5, 0.0, 10.0), ramp)
    lag = ramp[-1] + STEP - without[-1]
    assert lag == pytest.approx(0.5 / 40.0, rel=0.05)
    assert abs(ramp[-1] + STEP - with_it[-1]) < 0.1 * lag


def test_the_limit_holds_and_nothing_winds_up():
    angles, torques = follow(CONTROL, np.full(4000, 4.0))
    small, _ = follow(CONTROL, np.full(4000, 0.1))
    assert np.max(np.abs(torques)) == CONTROL.torque_limit
    assert np.max(angles) / 4.0 < np.max(small) / 0.1
    assert angles[-1] == pytest.approx(4.0, abs=1e-3)


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
