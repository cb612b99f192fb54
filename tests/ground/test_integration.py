import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.linalg import expm

from tierod.core.graph.trace import jacobian
from tierod_lab.ground.integration import implicit_inverse, rosenbrock
from tierod_lab.ground.parts import Wheels
from tierod_lab.ground.powertrain import Powertrain, WheelMotors


class Swing(NamedTuple):
    place: float
    speed: float


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


class Moving(NamedTuple):
    speed: float
    spinning: float = 0.0

    @property
    def wheel_speeds(self) -> Wheels:
        return Wheels(self.speed, self.speed, self.speed, self.speed + self.spinning)


def test_a_wheel_that_spins_takes_the_power_from_the_car():
    train = Powertrain(front_share=0.0, greatest_drive_force=7000.0, greatest_power=110e3)
    drive, _ = train.torques(1e6, Moving(10.0, spinning=60.0))
    assert sum(drive) / 0.31 == pytest.approx(110e3 / 40.0)
    power = sum(each * speed for each, speed in zip(drive, (10.0, 10.0, 10.0, 70.0), strict=True)) / 0.31
    assert power == pytest.approx(110e3)
    assert sum(Powertrain().torques(2000.0, Moving(10.0, spinning=60.0))[0]) / 0.31 == pytest.approx(2000.0)


def test_friction_brakes_give_what_the_motors_lack():
    motors = WheelMotors()
    drive, brakes = motors.torques(-2000.0, Moving(20.0))
    assert -sum(drive) / 0.243 + sum(brakes) / 0.243 == pytest.approx(2000.0)
    assert sum(brakes) > 0.0
    _, lost = motors.wheels(0.0, 0.0, -2000.0)
    assert sum(lost) / 0.243 == pytest.approx(2000.0)
    _, driving = motors.wheels(50.0, 0.0, 200.0)
    assert sum(driving) == 0.0
    assert not math.copysign(1.0, driving.front_left) < 0.0
