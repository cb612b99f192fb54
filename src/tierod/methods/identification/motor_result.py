"""What the identification of a motor finds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from tierod.methods.identification.column_result import Found
from tierod.methods.identification.motor_electrical import Electrical, Value
from tierod.methods.identification.motor_mechanical import Mechanical

UNEXPLAINED = 0.25
"""Share of the voltage from which a motor does not explain it: a sound bench leaves below 0.03."""


class Untold(NamedTuple):
    """A parameter that the recordings do not tell.

    Args:
        name: as in a vehicle file
        why: what is lacking
        cure: what to drive
    """

    name: str
    why: str
    cure: str


@dataclass(frozen=True, eq=False)
class MotorIdentification:
    """What was found of a motor.

    Args:
        found: parameters, resistance and flux at 20 degrees
        untold: parameters that the recordings do not tell
        electrical: what currents and voltages tell, as warm as the motor was
        mechanical: what torque and angle tell; None where the shaft did not turn, or the flux is not known
        torque_ratio: measured torque over that of flux and current; None where no torque was recorded
        remarks: what was noticed
    """

    found: tuple[Found, ...]
    untold: tuple[Untold, ...]
    electrical: Electrical
    mechanical: Mechanical | None
    torque_ratio: Value | None
    remarks: tuple[str, ...]

    @property
    def doubt(self) -> str:
        """Why the values may not be used; empty where they may."""
        if not self.found:
            return "these recordings tell no parameter of the motor"
        if self.electrical.unexplained > UNEXPLAINED:
            return f"a motor leaves {100.0 * self.electrical.unexplained:.0f} % of these voltages unexplained"
        return ""
