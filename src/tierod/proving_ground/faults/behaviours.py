"""All behaviours of faults, and the one that lets another come and go."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, get_args

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import POSITIVE
from tierod.core.toml_builder import kind_name
from tierod.proving_ground.faults.behaviour import Behaviour, Change
from tierod.proving_ground.faults.bus import BitFlip, Delay, DropOut
from tierod.proving_ground.faults.chance import Chance
from tierod.proving_ground.faults.changes import Course, Ramp, Scale, Sluggish, Step, TorqueLoss, WithTemperature
from tierod.proving_ground.faults.signals import (
    Drift,
    Gain,
    Noise,
    Offset,
    Outlier,
    Spikes,
    Stuck,
    TotalLoss,
)
from tierod.proving_ground.sensors import Sensor


@dataclass(frozen=True)
class Intermittent(Behaviour):
    """Another behaviour that comes and goes at random, as with a loose contact; it begins as being there.

    Args:
        behaviour: what it is while it is there
        mean_on, mean_off: mean durations of being there and not, which are of exponential law
    """

    behaviour: AnyBehaviour
    mean_on: Annotated[float, "s", POSITIVE] = 0.2
    mean_off: Annotated[float, "s", POSITIVE] = 1.0
    main: ClassVar[str | None] = "behaviour"

    def __post_init__(self):
        super().__post_init__()
        if isinstance(self.behaviour, Intermittent):
            raise ParameterError("what comes and goes cannot itself be intermittent; give mean_on and mean_off once")

    @property
    def core(self) -> Behaviour:
        """What comes and goes."""
        return self.behaviour

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """That of the behaviour, while it is there."""
        there = chance.on(since, self.mean_on, self.mean_off)
        change = self.behaviour.change(since, chance)
        return Change(np.where(there, change.gain, 1.0), np.where(there, change.offset, 0.0), there & change.held)

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
        """That of the behaviour, while it is there."""
        there = active.copy()
        there[active] = chance.on(time[active] - chance.start, self.mean_on, self.mean_off)
        return self.behaviour.on_channel(time, values, there, sensor, chance)


AnyBehaviour = (
    TotalLoss
    | Stuck
    | Offset
    | Gain
    | Drift
    | Outlier
    | Spikes
    | Noise
    | Delay
    | BitFlip
    | DropOut
    | TorqueLoss
    | Sluggish
    | Step
    | Ramp
    | Scale
    | Course
    | WithTemperature
    | Intermittent
)
"""Every behaviour of a fault."""

BEHAVIOURS: dict[str, type[Behaviour]] = {kind_name(each): each for each in get_args(AnyBehaviour)}
"""Every behaviour by the name that files use."""


def described(behaviour: Behaviour) -> dict[str, Any]:
    """A behaviour as numbers, texts and tables, for a file."""
    table: dict[str, Any] = {"kind": kind_name(type(behaviour))}
    for field in dataclasses.fields(behaviour):
        value = getattr(behaviour, field.name)
        table[field.name] = described(value) if isinstance(value, Behaviour) else value
    return table
