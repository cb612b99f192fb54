"""Ranges of physical parameters, written beside the unit: `Annotated[float, "kg", POSITIVE]`."""

from __future__ import annotations

import math
from typing import NamedTuple


class Range(NamedTuple):
    """The values that make sense, in the unit beside it.

    Args:
        low, high: limits
        open_low: whether the lower limit itself is excluded
    """

    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False

    def holds(self, value: float) -> bool:
        """Whether a number is finite and lies inside."""
        return (
            math.isfinite(value) and (self.low < value if self.open_low else self.low <= value) and value <= self.high
        )

    def __str__(self) -> str:
        if self.high == math.inf:
            return f"above {self.low:g}" if self.open_low else f"at least {self.low:g}"
        return f"above {self.low:g} and at most {self.high:g}" if self.open_low else f"{self.low:g} to {self.high:g}"


ANY = Range()
POSITIVE = Range(0.0, math.inf, open_low=True)
NOT_NEGATIVE = Range(0.0)
SHARE = Range(0.0, 1.0)
COUNT = Range(1.0)
