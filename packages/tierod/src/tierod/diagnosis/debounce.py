"""Debounce counters, which turn single test results into the verdicts of the fault memory."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, named_tuple
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import any_of, both, maximum, minimum, present, where

LOWEST, HIGHEST = -128.0, 127.0


@dataclass(frozen=True)
class DebounceCounter:
    """Counter that rises with every failed and falls with every passed result, limited to -128 to 127.

    The verdict is failed from 127 on and passed from -128 on; in between the last verdict remains. Without a result the
    counter keeps its value.

    Args:
        increment: steps per failed result; 127 for a monitor with a stopping rule of its own
        decrement: steps per passed result
        jump: whether the counter first goes to zero when the direction changes

    Source: counter-based debouncing of AUTOSAR's Diagnostic Event Manager; ISO 14229-1:2020, annex D.
    """

    increment: Annotated[float, ""] = 1.0
    decrement: Annotated[float, ""] = 1.0
    jump: bool = True

    class Sample(NamedTuple):
        """Result of a test: 1 failed, -1 passed, 0 (or missing) none."""

        result: Annotated[float, ""]

    class State(NamedTuple):
        """Counter, and present verdict: 1 failed, -1 passed, 0 none yet."""

        counter: Scalar
        verdict: Scalar

    class Output(NamedTuple):
        """Counter, and present verdict: 1 failed, -1 passed, 0 none yet."""

        counter: Annotated[float, ""]
        verdict: Annotated[float, ""]

    def __post_init__(self) -> None:
        for name in ("increment", "decrement"):
            value = getattr(self, name)
            if not 0.0 < value <= 255.0:
                raise ParameterError(f"{name} is {value}; expected more than 0 and at most 255 steps per result")

    def init(self) -> State:
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        result = where(present(sample.result), sample.result, 0.0)
        counter, verdict = state
        up, down = (maximum(counter, 0.0), minimum(counter, 0.0)) if self.jump else (counter, counter)
        risen, fallen = minimum(up + self.increment, HIGHEST), maximum(down - self.decrement, LOWEST)
        counter = where(result > 0.5, risen, where(result < -0.5, fallen, counter))
        verdict = where(counter >= HIGHEST, 1.0, where(counter <= LOWEST, -1.0, verdict))
        after = self.State(counter, verdict)
        return after, self.Output(counter, verdict)


@dataclass(frozen=True)
class DebounceCounters:
    """One debounce counter per code; the counter of a consequence is frozen while one of its causes has failed.

    A consequence that has failed before loses its verdict then: if it is still present when its causes have passed, it
    fails again.
    """

    counters: tuple[DebounceCounter, ...]
    causes: tuple[tuple[int, ...], ...]  # positions of the codes that cause each code

    def __post_init__(self) -> None:
        known = range(len(self.counters))
        if len(self.causes) != len(self.counters) or any(k not in known for causes in self.causes for k in causes):
            raise ParameterError(f"causes must give places from 0 to {len(self.counters) - 1} for each counter")

    @property
    def Sample(self) -> type:
        """NamedTuple class with one result per code, see `DebounceCounter.Sample`."""
        return _numbered("result", len(self.counters))

    @property
    def Output(self) -> type:
        """NamedTuple class with one verdict per code, see `DebounceCounter.Output`."""
        return _numbered("verdict", len(self.counters))

    def init(self) -> tuple[DebounceCounter.State, ...]:
        return tuple(counter.init() for counter in self.counters)

    def step(
        self, state: tuple[DebounceCounter.State, ...], sample: Tree
    ) -> tuple[tuple[DebounceCounter.State, ...], Tree]:
        after, verdicts = [], []
        # Causes are judged by their verdicts before this result, so that the order of the codes does not matter.
        for counter, own, causes, result in zip(self.counters, state, self.causes, sample, strict=True):
            if causes:
                caused = any_of(*[state[k].verdict > 0.5 for k in causes])
                result, again = where(caused, 0.0, result), both(caused, own.verdict > 0.5)
                own = DebounceCounter.State(where(again, 0.0, own.counter), where(again, 0.0, own.verdict))
            counted, output = counter.step(own, DebounceCounter.Sample(result))
            after.append(counted)
            verdicts.append(output.verdict)
        return tuple(after), self.Output(*verdicts)


@lru_cache(maxsize=64)
def _numbered(name: str, count: int) -> type:
    return named_tuple(name.capitalize(), [(f"{name}_{k}", Annotated[float, ""]) for k in range(count)])
