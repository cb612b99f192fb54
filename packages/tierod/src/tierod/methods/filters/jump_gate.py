"""Gate against jumps: an implausibly large change of a signal is held back until enough time has passed for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import maximum, where
from tierod.methods.filters.each import EachSignal


class Accepted(NamedTuple):
    """The last value that passed the gate, and its age in samples."""

    value: Scalar
    age: Scalar


@dataclass(frozen=True)
class JumpGate(EachSignal):
    """Replace values that are further from the last accepted one than the signal moves in that time.

    The allowed distance grows with the time since the last accepted value, so that a lasting step, for example of a
    sensor that was recalibrated, passes after a while and the gate never locks up.

    Args:
        deviation_per_second: standard deviation of the change of the signal in a second [unit of the signals]
        interval: longest time between two values before they were resampled [s]; a signal that is held between them
            moves by the change of that time in one sample. Zero where every sample is a new value
        gate: quantile of chi-square with one degree of freedom (10.83 for 99.9 %); a larger one passes larger jumps

    The other arguments are those of `EachSignal`.
    """

    deviation_per_second: Annotated[float, "unit of the signal"]
    interval: Annotated[float, "s"] = 0.0
    gate: Annotated[float, ""] = 10.83

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("deviation_per_second", "gate"):
            if not getattr(self, name) > 0.0:
                raise ParameterError(f"{name} is {getattr(self, name)}; expected a number greater than zero")
        if not self.interval >= 0.0:
            raise ParameterError(f"interval is {self.interval}; expected a time that is not negative [s]")

    def _settled(self, value: Scalar) -> Accepted:
        return Accepted(value, 0.0)

    def _advance(self, memory: Accepted, value: Scalar) -> tuple[Accepted, Scalar]:
        age = memory.age + 1.0
        since = maximum(age * self.sample_time, self.interval)
        way, moved = value - memory.value, since * self.deviation_per_second
        passes = way * way <= self.gate * moved * moved
        now = Accepted(where(passes, value, memory.value), where(passes, 0.0, age))
        return now, now.value
