"""Base of filters that treat several signals alike and bridge missing samples, with a hold."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, Truth, leaves, rebuild, skeleton, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, negated, present, where


class Held(NamedTuple):
    """The last value that was present, and its age in samples (infinite before the first)."""

    value: Scalar
    age: Scalar


NEVER = Held(0.0, math.inf)


def hold(memory: Held, value: Scalar) -> Held:
    """The memory after one more sample."""
    there = present(value)
    return Held(where(there, value, memory.value), where(there, 0.0, memory.age + 1.0))


def is_fresh(memory: Held, maximum_age: Scalar, sample_time: Scalar) -> Truth:
    """Whether a held value is at most as old as a limit [s]; half a sampling interval is a margin for rounding."""
    return (memory.age - 0.5) * sample_time < maximum_age


class Channel(NamedTuple):
    """State of one signal: its last present value, and the memory of its filter."""

    held: Held
    memory: Tree


@dataclass(frozen=True)
class EachSignal(ABC):
    """Base of the filters of several signals, which all have the same delay because all are filtered alike.

    Args:
        signals: NamedTuple class of the signals; it is the sample, and the output has its shape
        sample_time: sampling interval [s]
        maximum_gap: longest time over which missing samples are bridged with the last present value [s]; a longer one
            bridges more, and relies on old values longer. After it the output is missing (NaN) too, and the filter
            restarts without a transient at the next present sample

    The memory never holds NaN.
    """

    signals: type
    sample_time: Annotated[float, "s"]
    maximum_gap: Annotated[float, "s"]

    def __post_init__(self) -> None:
        if not list(leaves(skeleton(self.signals))):
            raise ParameterError(f"{type(self).__name__} needs at least one signal; {self.signals!r} declares none")
        if not self.sample_time > 0.0:
            raise ParameterError(f"sample_time is {self.sample_time}; expected a time greater than zero [s]")
        if not self.maximum_gap >= 0.0:
            raise ParameterError(f"maximum_gap is {self.maximum_gap}; expected a time that is not negative [s]")

    @property
    def Sample(self) -> type:
        """The NamedTuple class of the signals."""
        return self.signals

    @property
    def Output(self) -> type:
        """The NamedTuple class of the output."""
        return self.signals

    def init(self) -> tuple[Channel, ...]:
        return tuple(Channel(NEVER, self._settled(0.0)) for _ in leaves(skeleton(self.signals)))

    def step(self, state: tuple[Channel, ...], sample: Tree) -> tuple[tuple[Channel, ...], Tree]:
        pairs = [self._channel(channel, value) for channel, (_, value) in zip(state, leaves(sample), strict=True)]
        outputs = rebuild(skeleton(self.Output), [output for _, output in pairs])
        return tuple(channel for channel, _ in pairs), outputs

    def _channel(self, channel: Channel, value: Scalar) -> tuple[Channel, Scalar]:
        # Whether the gap before this sample was too long must be decided before `hold` resets the age.
        known = is_fresh(channel.held, self.maximum_gap, self.sample_time)
        held = hold(channel.held, value)
        restart = both(present(value), negated(known))
        settled = values_of(self._settled(held.value))
        now = values_of(channel.memory)
        started = [where(restart, new, old) for new, old in zip(settled, now, strict=True)]
        memory, output = self._advance(rebuild(channel.memory, started), held.value)
        fresh = is_fresh(held, self.maximum_gap, self.sample_time)
        return Channel(held, memory), where(fresh, output, value)

    @abstractmethod
    def _settled(self, value: Scalar) -> Tree: ...

    @abstractmethod
    def _advance(self, memory: Tree, value: Scalar) -> tuple[Tree, Scalar]: ...


@dataclass(frozen=True)
class InputHold(EachSignal):
    """Bridge missing samples with the last value, for an estimator whose inputs must be present.

    The arguments are those of `EachSignal`. Present samples pass unchanged; the output is missing (NaN) before the
    first sample of a signal and after it has been missing for longer than `maximum_gap`.
    """

    def _settled(self, value: Scalar) -> tuple[()]:
        return ()

    def _advance(self, memory: tuple[()], value: Scalar) -> tuple[tuple[()], Scalar]:
        return memory, value
