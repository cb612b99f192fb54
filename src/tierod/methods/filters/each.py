"""A filter that treats every one of several signals alike, and what it does where samples are missing."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Tree, leaves, rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, negated, present, where


class Held(NamedTuple):
    """The last value that was present, and how many samples ago that was (infinitely many before the first)."""

    value: Any
    age: Any


NEVER = Held(0.0, math.inf)


def hold(memory: Held, value: Any) -> Held:
    """The memory after one more sample."""
    there = present(value)
    return Held(where(there, value, memory.value), where(there, 0.0, memory.age + 1.0))


def is_fresh(memory: Held, maximum_age: Any, sample_time: Any) -> Any:
    """Whether a held value is at most this old [s]; half a sample of slack for rounding."""
    return (memory.age - 0.5) * sample_time < maximum_age


class Channel(NamedTuple):
    """Memory of one signal."""

    held: Held
    memory: Any


@dataclass(frozen=True)
class EachSignal(ABC):
    """Base of the filters over several signals, which are all delayed alike because all are filtered alike.

    Args:
        signals: NamedTuple class of the signals; it is the sample, and the output has its shape
        sample_time: time between two samples [s]
        maximum_gap: how long missing samples are bridged with the last value that was present [s]; longer bridges
            more, and believes old values longer. After that the output is missing (NaN) too, and the filter starts
            anew, without a transient, at the next sample that is present

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
        """No signal has been seen yet."""
        return tuple(Channel(NEVER, self._settled(0.0)) for _ in leaves(skeleton(self.signals)))

    def step(self, state: tuple[Channel, ...], sample: Tree) -> tuple[tuple[Channel, ...], Any]:
        """One sample on."""
        pairs = [self._channel(channel, value) for channel, (_, value) in zip(state, leaves(sample), strict=True)]
        outputs = rebuild(skeleton(self.Output), [output for _, output in pairs])
        return tuple(channel for channel, _ in pairs), outputs

    def _channel(self, channel: Channel, value: Any) -> tuple[Channel, Any]:
        known = is_fresh(channel.held, self.maximum_gap, self.sample_time)
        held = hold(channel.held, value)
        restart = both(present(value), negated(known))
        settled = [leaf for _, leaf in leaves(self._settled(held.value))]
        now = [leaf for _, leaf in leaves(channel.memory)]
        started = [where(restart, new, old) for new, old in zip(settled, now, strict=True)]
        memory, output = self._advance(rebuild(channel.memory, started), held.value)
        fresh = is_fresh(held, self.maximum_gap, self.sample_time)
        return Channel(held, memory), where(fresh, output, value)

    @abstractmethod
    def _settled(self, value: Any) -> Tree:
        """The memory after the signal has had this value for ever."""

    @abstractmethod
    def _advance(self, memory: Tree, value: Any) -> tuple[Tree, Any]:
        """One (present or bridged) value on."""
