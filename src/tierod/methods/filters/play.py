"""Play (backlash) operator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tierod.core.errors import ParameterError
from tierod.core.graph.maths import limit
from tierod.methods.filters.each import EachSignal


@dataclass(frozen=True)
class Play(EachSignal):
    """The output stays until the input pushes it: reversals smaller than the play are swallowed.

    Args:
        half_width: half of the play [unit of the signals]; wider swallows more noise, and loses as much at each turn

    The other arguments are those of `EachSignal`.

    Source: A. Visintin, Differential Models of Hysteresis, 1994, section III.2.
    """

    half_width: Annotated[float, "unit of the signal"]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.half_width >= 0.0:
            raise ParameterError(f"half_width is {self.half_width}; expected a number that is not negative")

    def _settled(self, value: Any) -> Any:
        return value

    def _advance(self, memory: Any, value: Any) -> tuple[Any, Any]:
        output = limit(memory, value - self.half_width, value + self.half_width)
        return output, output
