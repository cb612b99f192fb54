"""Two detectors, one for each direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.graph.maths import maximum
from tierod.methods.detectors.value import Value


@dataclass(frozen=True)
class TwoSided:
    """Alarm when one of two detectors alarms.

    Args:
        up, down: detectors with an output `alarm`
    """

    up: Any
    down: Any

    Sample = Value

    class Output(NamedTuple):
        """Whether one alarms (1.0) or none (0.0)."""

        alarm: Annotated[float, ""]

    def init(self) -> tuple[Any, Any]:
        """Both at their beginning."""
        return self.up.init(), self.down.init()

    def step(self, state: tuple[Any, Any], sample: Any, enabled: Any = True) -> tuple[tuple[Any, Any], Output]:
        """One value on; `enabled` (logic) says whether it counts."""
        up, above = self.up.step(state[0], sample, enabled)
        down, below = self.down.step(state[1], sample, enabled)
        return (up, down), self.Output(maximum(above.alarm, below.alarm))
