"""What the implicit integration knows of dry friction, and what that makes of friction that sticks stiffly."""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.linalg import expm

from ground.steering.rig import STEP, Rig
from tierod.core.block import leaves, rebuild
from tierod.core.graph.derivatives import jacobian
from tierod_lab.ground.integration import GAMMA, implicit_inverse, rosenbrock, runge_kutta, with_entry
from tierod_lab.ground.parts import Loads
from tierod_lab.ground.steering.active_front import ActiveFront
from tierod_lab.ground.steering.column_eps import ColumnEps, WormGear
from tierod_lab.ground.steering.demonstrator import Demonstrator
from tierod_lab.ground.steering.friction import Coulomb, Dahl, DryFriction, LuGre
from tierod_lab.ground.steering.linkage import Linkage
from tierod_lab.ground.steering.rack_eps import RackEps
from tierod_lab.ground.steering.steer_by_wire import SteerByWire


class Swing(NamedTuple):
    place: float
    speed: float


class Nested(NamedTuple):
    swing: Swing
    extra: tuple


def error(step):
    state = Nested(Swing(1.0, 0.0), ())
    for _ in range(round(1.0 / step)):
        state = runge_kutta(lambda s: Nested(Swing(s.swing.speed, -s.swing.place), ()), state, step)
    return abs(state.swing.place - math.cos(1.0))


def test_error_falls_with_the_fourth_power():
    assert error(0.1) / error(0.05) == pytest.approx(16.0, rel=0.1)


class Coupled(NamedTuple):
    gear: tuple[Any, ...]
    swing: Swing


FAST = 2.0 * math.pi * 667.0


def gear_rate(gear, push=0.0):
    first, first_speed, second, second_speed = gear
    force = FAST**2 * (first - second) + 0.4 * FAST * (first_speed - second_speed)
    return first_speed, push - force - first, second_speed, force - 2.0 * second_speed


def coupled_rate(state):
    return Coupled(gear_rate(state.gear, state.swing.place), Swing(state.swing.speed, -4.0 * state.swing.place))


def at_one_second(step, share=1.0):
    still = (0.0,) * 4
    inverse = implicit_inverse(lambda gear: tuple(share * rate for rate in gear_rate(gear)), still, step)
    state = Coupled(still, Swing(1.0, 0.0))
    for _ in range(round(1.0 / step)):
        state = rosenbrock(coupled_rate, state, step, "gear", inverse)
    return state


@pytest.fixture(scope="module")
def exact():
    """The gear after a second: the equations are linear."""
    rates = jacobian(coupled_rate, Coupled((0.0,) * 4, Swing(0.0, 0.0)))
    return (expm(np.array(rates, float)) @ [0.0, 0.0, 0.0, 0.0, 1.0, 0.0])[2]


@pytest.mark.parametrize("share", [1.0, 1.3])
def test_a_stiff_gear_is_followed_in_second_order_whatever_the_jacobian(share, exact):
    errors = [abs(at_one_second(step, share).gear[2] - exact) for step in (4e-3, 2e-3, 1e-3)]
    assert errors[2] < 1e-5 * abs(exact)
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2]


def test_the_explicit_part_is_of_second_order():
    errors = [abs(at_one_second(step).swing.place - math.cos(2.0)) for step in (4e-3, 2e-3)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_what_is_too_fast_for_the_step_is_damped():
    still = (0.0,) * 4
    inverse = implicit_inverse(gear_rate, still, 1e-3)
    state = Coupled((1e-3, 0.0, -1e-3, 0.0), Swing(0.0, 0.0))
    for _ in range(100):
        state = rosenbrock(coupled_rate, state, 1e-3, "gear", inverse)
    assert abs(state.gear[0] - state.gear[2]) < 1e-6


def test_one_more_entry_of_the_jacobian_is_as_if_it_had_been_there():
    matrix = np.random.default_rng(2).normal(size=(4, 4))
    matrix[1, 3] = 0.0

    def inverse(of):
        return implicit_inverse(
            lambda at: tuple(sum(a * x for a, x in zip(row, at, strict=True)) for row in of), 4 * (0.0,), 0.1
        )

    without = inverse(matrix)
    matrix[1, 3] = -7.0
    np.testing.assert_allclose(with_entry(without, 1, 3, -7.0, 0.1), inverse(matrix), rtol=1e-12)
    np.testing.assert_allclose(inverse(matrix), np.linalg.inv(np.eye(4) - 0.1 * GAMMA * matrix), rtol=1e-12)


HAIR = 1e-7
RUBBING = Linkage(friction=DryFriction(20.0, Dahl(0.01)))
STEERINGS = {
    "column": ColumnEps(linkage=RUBBING),
    "rigid column with a worm": ColumnEps(torsion_bar=None, worm_gear=WormGear(), linkage=RUBBING),
    "rack": RackEps(linkage=RUBBING),
    "rack that rubs at the pinion": RackEps(friction_on_rack=False, motor_on_rack=False, linkage=RUBBING),
    "by wire": SteerByWire(),
    "superposed": ActiveFront(),
    "demonstrator": Demonstrator(),
}


@pytest.mark.parametrize("name", STEERINGS)
def test_friction_enters_as_its_derivative_by_the_angle(name):
    steering = STEERINGS[name]
    memory = rebuild(steering.remembered(), [0.5 for _ in leaves(steering.remembered())])
    idle = Loads(0.0, 0.0, 0.0, (0.0,) * len(steering.actuators), 0.0, 0.0)
    start = steering.stiff()
    ahead = rebuild(start, [value + HAIR for _, value in leaves(start)])
    whole = np.array(jacobian(lambda at: steering.derivative(at, start, memory, idle), ahead), dtype=float)
    smooth = np.array(jacobian(lambda at: steering.derivative(at, at, memory, idle), ahead), dtype=float)
    entries = np.zeros_like(whole)
    place = [path for path, _ in leaves(start)].index
    for (rate, angle), entry in steering.sticking(ahead, memory).items():
        entries[place(rate), place(angle)] = entry
    assert np.min(entries) < -50.0
    np.testing.assert_allclose(whole - smooth, entries, rtol=1e-3, atol=1e-6 * np.max(np.abs(whole)))


@pytest.mark.parametrize(
    "steering",
    [
        ColumnEps(friction=DryFriction(12.5, Coulomb()), worm_gear=WormGear()),
        RackEps(friction=DryFriction(12.5, Coulomb()), friction_on_rack=False),
        RackEps(friction=DryFriction(12.5, Dahl(math.radians(0.1))), friction_on_rack=False),
        RackEps(friction=DryFriction(12.5, LuGre()), friction_on_rack=False),
    ],
    ids=["coulomb, worm", "coulomb at the pinion", "dahl at the pinion", "lugre at the pinion"],
)
def test_what_is_light_neither_chatters_where_it_sticks_nor_is_braked_where_it_slides(steering):
    """The motor turns the steering to and fro for 2 s and lets it stick, held against steps of 25 us."""

    def swing(size):
        return lambda time: size * np.sin(1.5 * time) * (time < 2.0)

    rig = Rig(steering, kingpin_stiffness=3000.0, arm_stiffness=60.0, arm_damping=2.0)
    result = {"hand_angle": swing(0.6), "motor_torque": swing(0.4)}
    _, coarse = rig.run(3.0, **result)
    _, fine = replace(rig, step_time=STEP / 40.0).run(3.0, **result)
    for name in ("steering_wheel_angle", "driver_torque", "pinion_angle"):
        error = coarse[name] - fine[name][::40]
        assert np.sqrt(np.mean(error**2)) < 0.01 * np.std(fine[name]), name
