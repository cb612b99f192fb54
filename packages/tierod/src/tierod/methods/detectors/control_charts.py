"""Control charts: a cumulative, averaged or counted statistic of a residual, its alarm threshold, and debouncing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple, Protocol

from tierod.core.block import Scalar, Tree, Truth
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import absolute, any_of, both, either, maximum, minimum, negated, present, where


class Value(NamedTuple):
    """One sample of a residual in its own unit; NaN where it is missing."""

    value: Annotated[float, "unit of the signal"]


class Condition(NamedTuple):
    """A logic value: 1.0 or 0.0; NaN where it is not known."""

    condition: Annotated[float, ""]


class Detector(Protocol):
    """A block of `Value` whose output has an `alarm`: 1.0 or 0.0."""

    @property
    def Sample(self) -> type[Value]: ...

    def init(self) -> Tree: ...

    def step(self, state: Tree, sample: Value | Scalar, enabled: Truth = True, /) -> tuple[Tree, Tree]:
        """State and output after one value; `enabled` is whether the value counts."""


def number(sample: Value | Condition | Scalar) -> Scalar:
    """The number of a sample that is given as a `Value`, a `Condition` or the number itself."""
    return sample[0] if isinstance(sample, tuple) else sample


def counts(value: Scalar, enabled: Truth) -> Truth:
    """Whether a value is present and enabled; the Python value True adds no operation to a graph."""
    return present(value) if enabled is True else both(present(value), enabled)


SIDES = ("both", "upper", "lower")


def check_sides(sides: str) -> None:
    """Check that a name is one of `SIDES`."""
    if sides not in SIDES:
        raise ParameterError(f"sides is '{sides}'; expected {', '.join(SIDES)}")


def watched(value: Scalar, sides: str) -> Scalar:
    """Quantity to compare with a threshold, for the sides of `SIDES`: a value, its negative or its absolute value."""
    return {"both": absolute(value), "upper": value, "lower": -value}[sides]


@dataclass(frozen=True)
class Cusum:
    """Cumulative sum: alarm when a residual has been above (or below) zero by more than `drift` for long enough.

    up <- max(0, up + value - drift), down <- max(0, down - value - drift); alarm while one is at `threshold` or above.

    For white Gaussian residuals of standard deviation sigma, one side, with k = drift / sigma and
    b = threshold / sigma + 1.166, the expected number of samples between false alarms is about
    (exp(2 k b) - 2 k b - 1) / (2 k^2): 938 for k = 0.5, threshold 5 sigma; half of it for both sides. Autocorrelated
    residuals alarm far more often. `CusumRule` gives the threshold for a wanted number.

    A missing value, or one that is not enabled, leaves the sums unchanged.

    Source: E. S. Page, 1954, doi 10.1093/biomet/41.1-2.100; run length, D. Siegmund, Sequential Analysis, 1985, (2.57).
    """

    # subtracted per sample [unit of the residual]: half of the smallest change worth an alarm. A larger one
    # tolerates slow drifts and model errors; a smaller one detects smaller changes and gives more false alarms
    drift: Annotated[float, "unit of the signal"]
    # sum at which the alarm is raised [same unit]. The detection delay grows in proportion, about threshold /
    # (change - drift) samples; the time between false alarms grows exponentially
    threshold: Annotated[float, "unit of the signal"]
    # upper limit of the sums [same unit], at least the threshold: after a long fault it takes at most ceiling /
    # drift fault-free samples until the alarm ends
    ceiling: Annotated[float, "unit of the signal"]
    sides: str = "both"  # "both", "upper" (increases only) or "lower"
    restart: bool = False  # whether an alarm resets the sums, so that every alarm lasts one sample

    Sample = Value

    class State(NamedTuple):
        up: float
        down: float

    class Output(NamedTuple):
        """Sums (0 on a side that is not monitored), and whether one has reached the threshold (1.0) or not (0.0)."""

        up: Annotated[float, ""]
        down: Annotated[float, ""]
        alarm: Annotated[float, ""]

    def __post_init__(self) -> None:
        check_sides(self.sides)
        if not self.threshold > 0.0:
            raise ParameterError(f"threshold is {self.threshold}; expected a number greater than zero")
        if not self.drift >= 0.0:
            raise ParameterError(f"drift is {self.drift}; expected a number that is not negative")
        if not self.ceiling >= self.threshold:
            raise ParameterError(f"ceiling is {self.ceiling}; expected at least the threshold, {self.threshold}")

    def init(self) -> State:
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: Value | Scalar, enabled: Truth = True) -> tuple[State, Output]:
        value = number(sample)
        use = counts(value, enabled)
        up, down = state
        alarm: Truth = 0.0
        if self.sides != "lower":
            up = where(use, minimum(maximum(0.0, up + value - self.drift), self.ceiling), up)
            alarm = up >= self.threshold
        if self.sides != "upper":
            down = where(use, minimum(maximum(0.0, down - value - self.drift), self.ceiling), down)
            alarm = either(alarm, down >= self.threshold) if self.sides == "both" else down >= self.threshold
        alarm = where(alarm, 1.0, 0.0)
        after = self.State(up, down)
        if self.restart:
            after = self.State(where(alarm, 0.0, up), where(alarm, 0.0, down))
        return after, self.Output(up, down, alarm)


@dataclass(frozen=True)
class HeldThreshold:
    """Alarm when a residual has been at a threshold or beyond in `hold` consecutive samples.

    With a probability p per independent sample, false alarms are (1 / p^hold - 1) / (1 - p) samples apart. A missing
    value, or one that is not enabled, neither counts nor interrupts the run.
    """

    threshold: Annotated[float, "unit of the signal"]  # [unit of the residual]
    hold: int = 1
    sides: str = "both"  # "both", "upper" or "lower"
    restart: bool = False  # whether an alarm resets the count, so that every alarm lasts one sample

    Sample = Value

    class State(NamedTuple):
        held: float

    class Output(NamedTuple):
        """Number of consecutive samples beyond, at most `hold`, and whether it is `hold` (1.0) or less (0.0)."""

        held: Annotated[float, ""]
        alarm: Annotated[float, ""]

    def __post_init__(self) -> None:
        check_sides(self.sides)
        if not (self.threshold > 0.0 and self.hold >= 1):
            raise ParameterError(
                f"threshold is {self.threshold} and hold {self.hold}; expected a threshold above zero and 1 or more"
            )

    def init(self) -> State:
        return self.State(0.0)

    def step(self, state: State, sample: Value | Scalar, enabled: Truth = True) -> tuple[State, Output]:
        value = number(sample)
        use = counts(value, enabled)
        more = minimum(state.held + 1.0, float(self.hold))
        held = where(use, where(both(use, watched(value, self.sides) >= self.threshold), more, 0.0), state.held)
        alarm = where(held > self.hold - 0.5, 1.0, 0.0)
        return self.State(where(alarm, 0.0, held) if self.restart else held), self.Output(held, alarm)


@dataclass(frozen=True)
class Debounce:
    """Debounced condition: on once the condition has held for a time, off once it has been false for a time.

    With a false condition of probability p per independent sample, and n = on_time / sample_time samples, false alarms
    are (1 / p^n - 1) / (1 - p) samples apart.

    An unknown condition, or a sample that is not enabled, neither confirms nor interrupts a run.
    """

    # time for which the condition must hold without interruption [s]; every further sample multiplies the time
    # between false alarms by 1 / (probability of one), if samples are independent
    on_time: Annotated[float, "s"]
    off_time: Annotated[float, "s"]  # time for which it must be false without interruption until the output is off [s]
    sample_time: Annotated[float, "s"]  # sampling interval [s]

    Sample = Condition

    class State(NamedTuple):
        """The output, and the time for which the condition has contradicted it [s]."""

        active: float
        against: float

    class Output(NamedTuple):
        """The debounced condition (1.0 or 0.0), and the progress towards its next change (0 to 1)."""

        active: Annotated[float, ""]
        progress: Annotated[float, ""]

    def __post_init__(self) -> None:
        _require_times(on_time=self.on_time, off_time=self.off_time)
        _require_sample_time(self.sample_time)

    def init(self) -> State:
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: Condition | Scalar, enabled: Truth = True) -> tuple[State, Output]:
        condition = number(sample)
        use = counts(condition, enabled)
        holds = where(condition > 0.5, 1.0, 0.0)
        differs = any_of(both(holds, negated(state.active)), both(negated(holds), state.active))
        needed = where(state.active, self.off_time, self.on_time)
        against = where(use, where(differs, state.against + self.sample_time, 0.0), state.against)
        switch = both(both(use, differs), against + 0.5 * self.sample_time > needed)
        active = where(switch, 1.0 - state.active, state.active)
        progress = where(switch, 0.0, minimum(against / maximum(needed, self.sample_time), 1.0))
        return self.State(active, where(switch, 0.0, against)), self.Output(active, progress)


def _require_times(**times: float) -> None:
    for name, value in times.items():
        if not value >= 0.0:
            raise ParameterError(f"{name} is {value}; expected a time that is not negative [s]")


def _require_sample_time(value: float) -> None:
    if not value > 0.0:
        raise ParameterError(f"sample_time is {value}; expected a time greater than zero [s]")
