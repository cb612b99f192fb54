"""Input and interface of every detector: one value, and whether it counts."""

from __future__ import annotations

from typing import Annotated, NamedTuple, Protocol

from tierod.core.block import Scalar, Tree, Truth
from tierod.core.graph.maths import both, present


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
