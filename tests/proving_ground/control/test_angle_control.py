import numpy as np
import pytest

from tierod.proving_ground.control.angle_control import AngleControl

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
    """A step far beyond what the torque can do at once overshoots by no larger share than a small one."""
    angles, torques = follow(CONTROL, np.full(4000, 4.0))
    small, _ = follow(CONTROL, np.full(4000, 0.1))
    assert np.max(np.abs(torques)) == CONTROL.torque_limit
    assert np.max(angles) / 4.0 < np.max(small) / 0.1
    assert angles[-1] == pytest.approx(4.0, abs=1e-3)
