"""A chassis alone under whatever a test wants of steer, torques, road and wind."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from tierod.core.graph import Result, scan
from tierod_lab.ground.chassis import TwoTrack
from tierod_lab.ground.integration import rosenbrock
from tierod_lab.ground.parts import Reaction, Road, Steer, Wheels, Wind

STEP = 1e-3


class Inputs(NamedTuple):
    steer: float = 0.0
    steer_rate: float = 0.0
    drive_left: float = 0.0
    drive_right: float = 0.0
    brake: float = 0.0
    bank: float = 0.0
    grade: float = 0.0
    adhesion_left: float = 1.0
    adhesion_right: float = 1.0
    support: float = 1.0
    crosswind: float = 0.0
    headwind: float = 0.0


def surroundings(sample: Inputs) -> tuple[Steer, Road, Wind]:
    return (
        Steer(sample.steer, sample.steer, sample.steer_rate, sample.steer_rate),
        Road(0.0, sample.bank, sample.grade, sample.adhesion_left, sample.adhesion_right, sample.support),
        Wind(sample.crosswind, sample.headwind),
    )


class Seen(NamedTuple):
    reaction: Reaction
    motion: Any


@dataclass(frozen=True)
class Bench:
    chassis: Any = field(default_factory=TwoTrack)
    speed: float = 20.0
    step_time: float = STEP

    Sample = Inputs

    def init(self) -> Any:
        return self.chassis.init(self.speed)

    def step(self, state: Any, sample: Inputs) -> tuple[Any, Seen]:
        around = surroundings(sample)
        torques = Wheels(sample.drive_left, sample.drive_right, 0.0, 0.0)
        brakes = Wheels(*[sample.brake] * 4)

        def slope(motion: tuple) -> tuple:
            reaction = self.chassis.reaction(motion[0], *around)
            return (self.chassis.derivative(motion[0], reaction, torques, brakes),)

        reaction = self.chassis.reaction(state, *around)
        (after,) = rosenbrock(slope, (state,), self.step_time, "", [])
        return after, Seen(reaction._replace(private=0.0), state)


def columns(seconds: float, **given: Any) -> np.ndarray:
    time = np.arange(round(seconds / STEP)) * STEP
    inputs = np.tile(np.array(Inputs()), (len(time), 1))
    for name, value in given.items():
        inputs[:, Inputs._fields.index(name)] = value(time) if callable(value) else value
    if "steer_rate" not in given:
        inputs[:, 1] = np.gradient(inputs[:, 0], STEP)
    return inputs


def drive(chassis: Any, seconds: float, speed: float, **given: Any) -> Result:
    return scan(Bench(chassis, speed), columns(seconds, **given))


def finite(out: Result) -> bool:
    return bool(np.isfinite(out.values).all())
