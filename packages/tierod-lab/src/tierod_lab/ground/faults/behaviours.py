"""Behaviours of actuators, parameters and surroundings, the intermittent behaviour, and the list of all behaviours."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, get_args

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, Range
from tierod.core.toml import SIGNAL_UNIT, kind_name
from tierod.physics.lag import share_reached
from tierod_lab.ground.faults.behaviour import (
    ACTUATOR,
    PARAMETER,
    SURROUNDING,
    Amount,
    Behaviour,
    Chance,
    Change,
    si,
)
from tierod_lab.ground.faults.signals import (
    BitFlip,
    Delay,
    Drift,
    DropOut,
    Gain,
    Noise,
    Offset,
    Outlier,
    Spikes,
    Stuck,
    TotalLoss,
)
from tierod_lab.ground.sensors import Sensor

_PARAMETERS = frozenset({PARAMETER, SURROUNDING})


@dataclass(frozen=True)
class TorqueLoss(Behaviour):
    """An actuator delivers less torque than requested."""

    # share of the torque that is lost; 1 is all of it
    share: Annotated[float, "", Range(0.0, 1.0, open_low=True)] = 1.0
    fits: ClassVar[frozenset[str]] = frozenset({ACTUATOR})
    main: ClassVar[str | None] = "share"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=1.0 - self.share)


@dataclass(frozen=True)
class Sluggish(Behaviour):
    """An actuator follows its request with another time constant, which replaces that parameter of the car."""

    time_constant: Annotated[float, "s", POSITIVE]
    fits: ClassVar[frozenset[str]] = frozenset({ACTUATOR})
    main: ClassVar[str | None] = "time_constant"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=0.0, offset=self.time_constant)


@dataclass(frozen=True)
class Step(Behaviour):
    """A parameter jumps to another value."""

    to: Annotated[Amount, SIGNAL_UNIT]
    fits: ClassVar[frozenset[str]] = _PARAMETERS
    main: ClassVar[str | None] = "to"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=0.0, offset=si(self.to))


@dataclass(frozen=True)
class Ramp(Behaviour):
    """A parameter changes linearly to another value and stays there."""

    to: Annotated[Amount, SIGNAL_UNIT]
    over: Annotated[float, "s", POSITIVE]
    fits: ClassVar[frozenset[str]] = _PARAMETERS
    main: ClassVar[str | None] = "to"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        share = np.clip(since / self.over, 0.0, 1.0)
        return Change(gain=1.0 - share, offset=share * si(self.to))


@dataclass(frozen=True)
class Scale(Behaviour):
    """A parameter is multiplied by a factor, at once or along a ramp."""

    factor: Annotated[float, ""]
    over: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    fits: ClassVar[frozenset[str]] = _PARAMETERS
    main: ClassVar[str | None] = "factor"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        share = np.clip(since / self.over, 0.0, 1.0) if self.over > 0.0 else 1.0
        return Change(gain=1.0 + share * (self.factor - 1.0))


@dataclass(frozen=True)
class Course(Behaviour):
    """A parameter follows given values, linear between them and constant before and after."""

    times: Annotated[tuple[float, ...], "s"]
    values: Annotated[tuple[Amount, ...], SIGNAL_UNIT]
    fits: ClassVar[frozenset[str]] = _PARAMETERS

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.times or len(self.times) != len(self.values) or (np.diff(self.times) <= 0.0).any():
            raise ParameterError(
                f"a course needs as many values as times, and ascending times; given: {len(self.values)} values at "
                f"{list(self.times)} s"
            )

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        return Change(gain=0.0, offset=np.interp(since, self.times, [si(value) for value in self.values]))


@dataclass(frozen=True)
class WithTemperature(Behaviour):
    """A parameter depends linearly on a temperature, which approaches its final value exponentially.

    The parameter has its own value at the reference temperature. The default coefficient is that of the resistance of
    copper; the flux of neodymium magnets has about -0.0011 1/K.
    """

    temperature: Annotated[float, "K", POSITIVE]
    coefficient: Annotated[float, "1/K"] = 0.00393
    reference: Annotated[float, "K", POSITIVE] = 293.15
    time_constant: Annotated[float, "s", POSITIVE] = 300.0
    fits: ClassVar[frozenset[str]] = frozenset({PARAMETER})
    main: ClassVar[str | None] = "temperature"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        warmer = (self.temperature - self.reference) * share_reached(since / self.time_constant)
        return Change(gain=1.0 + self.coefficient * warmer)


@dataclass(frozen=True)
class Intermittent(Behaviour):
    """Another behaviour is switched on and off at random, as by a loose contact; it starts switched on."""

    behaviour: AnyBehaviour
    mean_on: Annotated[float, "s", POSITIVE] = 0.2
    mean_off: Annotated[float, "s", POSITIVE] = 1.0
    main: ClassVar[str | None] = "behaviour"

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.behaviour, Intermittent):
            raise ParameterError("what comes and goes cannot itself be intermittent; give mean_on and mean_off once")

    @property
    def core(self) -> Behaviour:
        return self.behaviour

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        there = chance.on(since, self.mean_on, self.mean_off)
        change = self.behaviour.change(since, chance)
        return Change(np.where(there, change.gain, 1.0), np.where(there, change.offset, 0.0), there & change.held)

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
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
"""Union of all behaviours of a fault."""

BEHAVIOURS: dict[str, type[Behaviour]] = {kind_name(each): each for each in get_args(AnyBehaviour)}
"""Every behaviour by its name in files."""


def described(behaviour: Behaviour) -> dict[str, Any]:
    """A behaviour as a table of numbers, texts and tables."""
    table: dict[str, Any] = {"kind": kind_name(type(behaviour))}
    for field in dataclasses.fields(behaviour):
        value = getattr(behaviour, field.name)
        table[field.name] = described(value) if isinstance(value, Behaviour) else value
    return table
