"""What a detector must do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated


@dataclass(frozen=True)
class Wish:
    """What a detector must do.

    Args:
        deviation: of the residual [its unit]
        shift: that must be found [same unit]
        interval: between false alarms [s]
        rate: of the residual [Hz]
        sides: "both", "upper" or "lower"
    """

    deviation: Annotated[float, "unit of the signal"]
    shift: Annotated[float, "unit of the signal"]
    interval: Annotated[float, "s"]
    rate: Annotated[float, "Hz"]
    sides: str = "both"

    @property
    def samples(self) -> float:
        """Between false alarms."""
        return self.interval * self.rate
