"""How signals fail, in a recording and in a control loop of the car."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.toml_builder import SIGNAL_UNIT
from tierod.proving_ground.faults.behaviour import (
    ACTUATOR,
    LOOP,
    PARAMETER,
    SIGNAL,
    SURROUNDING,
    Amount,
    Behaviour,
    Change,
    si,
)
from tierod.proving_ground.faults.chance import Chance

_VALUES = frozenset({SIGNAL, LOOP, ACTUATOR})
_ALL = _VALUES | {PARAMETER, SURROUNDING}


@dataclass(frozen=True)
class TotalLoss(Behaviour):
    """The signal is zero."""

    fits: ClassVar[frozenset[str]] = _VALUES

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """Zero."""
        return Change(gain=0.0)


@dataclass(frozen=True)
class Stuck(Behaviour):
    """The signal stays where it is, or at a value.

    Args:
        value: where it stays; where it was when the fault began, if None
    """

    value: Annotated[Amount, SIGNAL_UNIT] | None = None
    fits: ClassVar[frozenset[str]] = _VALUES
    main: ClassVar[str | None] = "value"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """Held, or the value."""
        return Change(held=True) if self.value is None else Change(gain=0.0, offset=si(self.value))


@dataclass(frozen=True)
class Offset(Behaviour):
    """A constant is added, of either sign."""

    size: Annotated[Amount, SIGNAL_UNIT]
    fits: ClassVar[frozenset[str]] = _ALL
    main: ClassVar[str | None] = "size"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """The constant."""
        return Change(offset=si(self.size))


@dataclass(frozen=True)
class Gain(Behaviour):
    """The signal is multiplied: 1 is right, -1 has the wrong sign."""

    gain: Annotated[float, ""]
    fits: ClassVar[frozenset[str]] = _ALL
    main: ClassVar[str | None] = "gain"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """The factor."""
        return Change(gain=self.gain)


@dataclass(frozen=True)
class Drift(Behaviour):
    """What is added grows from zero.

    Args:
        rate: growth per second
        limit: magnitude at which it stops; never if None
    """

    rate: Annotated[Amount, "{signal}/s"]
    limit: Annotated[Amount, SIGNAL_UNIT] | None = None
    fits: ClassVar[frozenset[str]] = _ALL
    main: ClassVar[str | None] = "rate"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """The growing offset."""
        offset = si(self.rate) * since
        if self.limit is None:
            return Change(offset=offset)
        limit = abs(si(self.limit))
        return Change(offset=np.clip(offset, -limit, limit))


@dataclass(frozen=True)
class Outlier(Behaviour):
    """For a second the signal is far off: a multiple of itself, or a value.

    Source: Li, Frey, Gauterin, Sensors 23 (2023) 887, section 5: "a large outlier in the sensor data over a very short
    time such as one second".

    Args:
        factor: of the signal
        value: in its place, if not None
    """

    factor: Annotated[float, ""] = 3.0
    value: Annotated[Amount, SIGNAL_UNIT] | None = None
    fits: ClassVar[frozenset[str]] = _VALUES
    main: ClassVar[str | None] = "factor"
    usual_duration: ClassVar[float | None] = 1.0

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """The multiple or the value."""
        return Change(gain=self.factor) if self.value is None else Change(gain=0.0, offset=si(self.value))


@dataclass(frozen=True)
class Spikes(Behaviour):
    """Short pulses of either sign are added, at random instants.

    Args:
        size: height
        rate: how many per second on average
        width: duration of each; a channel whose readings lie further apart misses some
    """

    size: Annotated[Amount, SIGNAL_UNIT]
    rate: Annotated[float, "Hz", POSITIVE] = 1.0
    width: Annotated[float, "s", POSITIVE] = 0.01
    fits: ClassVar[frozenset[str]] = _VALUES
    main: ClassVar[str | None] = "size"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """The pulses."""
        times, signs = chance.events(self.rate)
        if not len(times):
            return Change()
        latest = np.searchsorted(times, since, side="right") - 1
        inside = (latest >= 0) & (since - times[latest] < self.width)
        return Change(offset=np.where(inside, si(self.size) * signs[latest], 0.0))


@dataclass(frozen=True)
class Noise(Behaviour):
    """White noise is added: anew every millisecond, or with every reading where there are more."""

    deviation: Annotated[Amount, SIGNAL_UNIT, NOT_NEGATIVE]
    fits: ClassVar[frozenset[str]] = _VALUES
    main: ClassVar[str | None] = "deviation"

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """The noise."""
        return Change(offset=si(self.deviation) * chance.normal(since))
