"""Filters of several signals at once: blocks that filter all signals alike and bridge short gaps."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, Truth, derived, leaves, rebuild, skeleton, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, maximum, negated, present, tan, where
from tierod.physics.friction import share_reached


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

    The memory never holds NaN.
    """

    signals: type  # NamedTuple class of the signals; it is the sample, and the output has its shape
    sample_time: Annotated[float, "s"]  # sampling interval [s]
    # longest time over which missing samples are bridged with the last present value [s]; a longer one bridges
    # more, and relies on old values longer. After it the output is missing (NaN) too, and the filter restarts
    # without a transient at the next present sample
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
        return self.signals

    @property
    def Output(self) -> type:
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


def _require_time_constant(value: float) -> None:
    if not value > 0.0:
        raise ParameterError(f"time_constant is {value}; expected a time greater than zero [s]")


@dataclass(frozen=True)
class FirstOrderLowPass(EachSignal):
    """First-order low-pass y' = (u - y) / time_constant, exact for an input that is constant over a sampling interval.

    The other arguments are those of `EachSignal`.
    """

    # time to 63 % of a step [s]; a longer one removes more noise and delays by as much
    time_constant: Annotated[float, "s"]

    def __post_init__(self) -> None:
        super().__post_init__()
        _require_time_constant(self.time_constant)

    def _settled(self, value: Scalar) -> Scalar:
        return value

    def _advance(self, memory: Scalar, value: Scalar) -> tuple[Scalar, Scalar]:
        output = memory + share_reached(self.sample_time / self.time_constant) * (value - memory)
        return output, output


class Smoothed(NamedTuple):
    """State of one derivative: the low-passed signal."""

    smooth: Scalar


@dataclass(frozen=True)
class Differentiator(EachSignal):
    """Causal derivative: rate of change of the signal after a first-order low-pass; starts at zero.

    The other arguments are those of `EachSignal`; the output has the signals' names and their units per second.
    """

    # of the low-pass [s]; a longer one reduces the noise of the result and increases its delay
    time_constant: Annotated[float, "s"]

    def __post_init__(self) -> None:
        super().__post_init__()
        _require_time_constant(self.time_constant)

    @property
    def Output(self) -> type:
        return _per_second(self.signals)

    def _settled(self, value: Scalar) -> Smoothed:
        return Smoothed(value)

    def _advance(self, memory: Smoothed, value: Scalar) -> tuple[Smoothed, Scalar]:
        change = share_reached(self.sample_time / self.time_constant) * (value - memory.smooth)
        return Smoothed(memory.smooth + change), change / self.sample_time


@lru_cache(maxsize=256)
def _per_second(signals: type) -> type:
    rates: type = derived(signals, "Rates", "({})/s")
    return rates


class Accepted(NamedTuple):
    """The last value that passed the gate, and its age in samples."""

    value: Scalar
    age: Scalar


@dataclass(frozen=True)
class JumpGate(EachSignal):
    """Replace values that are further from the last accepted one than the signal moves in that time.

    The allowed distance grows with the time since the last accepted value, so that a lasting step, for example of a
    sensor that was recalibrated, passes after a while and the gate never locks up.

    The other arguments are those of `EachSignal`.
    """

    # standard deviation of the change of the signal in a second [unit of the signals]
    deviation_per_second: Annotated[float, "unit of the signal"]
    # longest time between two values before they were resampled [s]; a signal that is held between them moves by
    # the change of that time in one sample. Zero where every sample is a new value
    interval: Annotated[float, "s"] = 0.0
    # quantile of chi-square with one degree of freedom (10.83 for 99.9 %); a larger one passes larger jumps
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


class Biquad(NamedTuple):
    """Coefficients of (b0 + b1 / z + b2 / z^2) / (1 + a1 / z + a2 / z^2)."""

    b0: Scalar
    b1: Scalar
    b2: Scalar
    a1: Scalar
    a2: Scalar


class Delays(NamedTuple):
    """State of one biquad (transposed direct form II)."""

    first: Scalar
    second: Scalar


@dataclass(frozen=True)
class Butterworth(EachSignal):
    """Low-pass that is flat below its cutoff and falls with 20 dB per decade and order above it.

    The other arguments are those of `EachSignal`. Bilinear transform with the cutoff prewarped; the same numbers as
    scipy.signal.butter.

    Source: S. Butterworth, 1930; A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, section 7.2.
    """

    # frequency of -3 dB [Hz], below half the sample rate. A lower one removes more noise and delays more: the
    # second order has a delay of 0.225 / cutoff seconds at low frequency
    cutoff: Annotated[float, "Hz"]
    order: int = 2  # even, at least 2

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.order < 2 or self.order % 2:
            raise ParameterError(f"order is {self.order}; expected an even number of at least 2")
        if not 0.0 < self.cutoff < 0.5 / self.sample_time:
            raise ParameterError(
                f"cutoff is {self.cutoff} Hz; expected more than 0 and less than {0.5 / self.sample_time} Hz, "
                f"half the rate that sample_time = {self.sample_time} s gives"
            )

    def sections(self) -> list[Biquad]:
        """The biquads of the cascade, the one with the least damping last."""
        warped = tan(math.pi * self.cutoff * self.sample_time)
        square = warped * warped
        biquads = []
        for k in reversed(range(self.order // 2)):
            damped = 2.0 * math.sin((2 * k + 1) * math.pi / (2 * self.order)) * warped
            scale = 1.0 / (1.0 + damped + square)
            b0 = square * scale
            biquads.append(Biquad(b0, 2.0 * b0, b0, 2.0 * (square - 1.0) * scale, (1.0 - damped + square) * scale))
        return biquads

    def _settled(self, value: Scalar) -> tuple[Delays, ...]:
        return tuple(Delays(value - s.b0 * value, (s.b2 - s.a2) * value) for s in self.sections())

    def _advance(self, memory: tuple[Delays, ...], value: Scalar) -> tuple[tuple[Delays, ...], Scalar]:
        after = []
        for section, delays in zip(self.sections(), memory, strict=True):
            output = section.b0 * value + delays.first
            after.append(
                Delays(
                    section.b1 * value - section.a1 * output + delays.second,
                    section.b2 * value - section.a2 * output,
                )
            )
            value = output
        return tuple(after), value
