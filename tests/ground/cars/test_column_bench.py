from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from ground.channels import Run
from tierod.core.block import rebuild, skeleton
from tierod.core.graph.derivatives import jacobian
from tierod_lab.ground.cars.column_bench import Acting, Arms, ColumnBench, ColumnMotion
from tierod_lab.ground.steering.friction import DryFriction

TABLE_3 = (
    -0.491074732452 + 706.750702094704j,
    -0.491074732452 - 706.750702094704j,
    -0.000000000001,
    -8.114907494361,
    -3.839922431729 + 79.657898579634j,
    -3.839922431729 - 79.657898579634j,
)
SMOOTH = replace(ColumnBench(), friction=DryFriction(level=0.0))
IDLE = rebuild(skeleton(Acting), [0.0] * 10)


def linear(bench):
    def slope(motion):
        return bench.derivative(motion, motion, bench.friction.remembered(), 0.0, IDLE)

    return np.array(jacobian(slope, ColumnMotion(*[0.0] * 6)))


def ordered(values):
    return sorted(values, key=lambda value: (round(value.real, 3), value.imag))


def test_it_has_the_published_eigenvalues():
    np.testing.assert_allclose(ordered(np.linalg.eigvals(linear(SMOOTH))), ordered(TABLE_3), atol=1e-5)
    relative = np.abs(np.subtract(ordered(np.linalg.eigvals(linear(SMOOTH))), ordered(TABLE_3)))
    assert np.max(relative / np.maximum(np.abs(ordered(TABLE_3)), 1.0)) < 1e-6


def test_steps_follow_the_linear_equations():
    """A motor step over 0.5 s, against the matrix exponential."""
    count, extended = 500, np.zeros((7, 7))
    extended[:6, :6] = linear(SMOOTH)
    extended[4, 6] = 0.2 / SMOOTH.motor_inertia
    run, one_step = Run(SMOOTH, count, motor_torque=0.2), expm(1e-3 * extended)
    exact = np.eye(7)[6] + np.zeros((count, 1))
    for row in range(1, count):
        exact[row] = one_step @ exact[row - 1]
    for column, name in ((0, "steering_wheel_angle"), (1, "motor_angle_mechanical"), (5, "truth_gear_rate")):
        size = np.max(np.abs(exact[:, column]))
        np.testing.assert_allclose(run[name], exact[:, column], atol=1e-4 * size, err_msg=name)


def test_with_friction_it_follows_a_fine_integration():
    """Dahl's law as a differential equation of its own, by SciPy."""
    bench, time = ColumnBench(), np.arange(400) * 1e-3
    torque = 0.4 * np.sin(2.0 * np.pi * 3.0 * time)
    run = Run(bench, len(time), motor_torque=torque)

    def slope(now, state):
        motion, share = ColumnMotion(*state[:6]), state[6]
        free = replace(bench, friction=DryFriction(level=0.0))
        given = 0.4 * np.sin(2.0 * np.pi * 3.0 * (np.floor(now * 1e3 + 1e-9) * 1e-3))
        rates = free.derivative(motion, motion, 0.0, given - bench.friction.level * share, IDLE)
        bristle = motion.motor_rate / bench.friction.law.angle
        return [*rates, bristle - abs(bristle) * share]

    fine = solve_ivp(slope, (0.0, time[-1]), [0.0] * 7, t_eval=time, max_step=1e-4, rtol=1e-6)
    scale = np.max(np.abs(fine.y[1]))
    np.testing.assert_allclose(run["motor_angle_mechanical"], fine.y[1], atol=2e-3 * scale)
    np.testing.assert_allclose(run["truth_motor_friction_torque"], 0.1 * fine.y[6], atol=2e-3)


def test_a_locked_wheel_stands_still_and_the_bar_takes_the_torque():
    bench = replace(SMOOTH, motor_damping=0.02)
    run = Run(bench, 3000, motor_torque=0.1, locked=1.0)
    assert not np.any(run["steering_wheel_angle"])
    assert run["driver_torque"][-1] == pytest.approx(-0.1 * bench.gear_ratio, rel=1e-3)
    assert run["truth_hand_torque"][-1] == pytest.approx(-0.1 * bench.gear_ratio, rel=1e-3)


def test_locking_stops_a_turning_wheel():
    run = Run(SMOOTH, 600, motor_torque=0.1, locked=np.where(np.arange(600) < 300, 0.0, 1.0))
    assert run["steering_wheel_rate"][299] > 0.5
    assert abs(run["steering_wheel_rate"][310]) < 1e-3


def test_hand_torque_is_what_turns_the_wheel():
    time = np.arange(2000) * 1e-3
    hand = np.sin(5.0 * time)
    free = Run(ColumnBench(), 2000, hand_torque=hand)
    np.testing.assert_allclose(free["truth_hand_torque"], hand, atol=1e-9)
    bench = replace(ColumnBench(), arms=Arms(inertia=0.007, damping=0.08, stiffness=20.0))
    held = Run(bench, 2000, motor_torque=0.2 * hand, grip=1.0)
    let_go = Run(bench, 2000, motor_torque=0.2 * hand)
    assert np.std(held["steering_wheel_angle"]) < 0.5 * np.std(let_go["steering_wheel_angle"])
    assert np.max(np.abs(held["truth_hand_torque"])) > 0.5
    assert np.max(np.abs(let_go["truth_hand_torque"])) < 1e-9


def test_a_fault_reaches_the_motor_and_not_its_target():
    run = Run(ColumnBench(), 100, motor_torque=0.3, ports__motor_torque__gain=0.5)
    assert run["motor_target_torque"][50] == 0.3
    assert run["truth_motor_torque"][50] == 0.15
