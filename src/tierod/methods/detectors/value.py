"""What every detector takes: one value, and whether it counts."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from tierod.core.graph.maths import both, present


class Value(NamedTuple):
    """One sample of a residual, in whatever unit it has; NaN where it is missing."""

    value: Annotated[float, "unit of the signal"]


def number(sample: Any) -> Any:
    """The value of a sample, given as a `Value` or as the bare number."""
    return sample[0] if isinstance(sample, tuple) else sample


def counts(value: Any, enabled: Any) -> Any:
    """Whether a value is present and enabled; the Python value True leaves the second question out."""
    return present(value) if enabled is True else both(present(value), enabled)
