"""Current set points of a salient motor: least current for a torque, and less flux where the voltage ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tierod.core.graph.maths import absolute, limit, maximum, minimum, sqrt
from tierod.physics.clarke_park import RotorVector

_ROUNDS = 6
"""Of the search for the current that makes a torque."""


@dataclass(frozen=True)
class SetPoints:
    """Current along and across the flux for a torque, by the motor parameters that the control unit assumes.

    Args:
        inductance_d, inductance_q: along and across the flux [H]
        flux: linkage of the magnets [V*s]
        current_limit: longest current vector [A]

    Source: Morimoto et al., IEEE Trans. Industry Applications 26 (1990) 866: maximum torque per ampere, and beyond the
    speed at which the voltage ends the current along the flux that holds the voltage, the resistance left out.
    """

    inductance_d: float
    inductance_q: float
    flux: float
    current_limit: float

    def of(self, wanted: Any, electrical_speed: Any, longest: Any) -> RotorVector:
        """Set points [A].

        Args:
            wanted: current across the flux that would make the torque with the magnets alone [A]
            electrical_speed: [rad/s]
            longest: voltage that these currents may take [V]
        """
        along: Any = 0.0
        for _ in range(_ROUNDS):
            along = 0.5 * (along + self._least(self._across(wanted, along)))
        linkage = longest / maximum(absolute(electrical_speed), 1.0)
        room = sqrt(maximum(linkage * linkage - (self.inductance_q * self._across(wanted, along)) ** 2, 0.0))
        along = maximum(minimum(along, (room - self.flux) / self.inductance_d), -self.current_limit)
        left = sqrt(maximum(linkage * linkage - (self.flux + self.inductance_d * along) ** 2, 0.0)) / self.inductance_q
        most = minimum(sqrt(maximum(self.current_limit**2 - along * along, 0.0)), left)
        return RotorVector(along, limit(self._across(wanted, along), -most, most))

    def _across(self, wanted: Any, along: Any) -> Any:
        return self.flux * wanted / (self.flux - (self.inductance_q - self.inductance_d) * along)

    def _least(self, across: Any) -> Any:
        """Current along the flux with which the current across makes the most torque per ampere [A]."""
        apart = (self.inductance_q - self.inductance_d) * across
        return -2.0 * apart * across / (self.flux + sqrt(self.flux * self.flux + 4.0 * apart * apart))
