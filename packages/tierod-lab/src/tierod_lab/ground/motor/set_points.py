"""Current set points of a salient motor: minimum current for a torque, and field weakening at the voltage limit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tierod.core.graph.maths import absolute, limit, maximum, minimum, sqrt
from tierod.physics.clarke_park import RotorVector

_ROUNDS = 6
"""Number of iterations in the search for the current that makes a torque."""


@dataclass(frozen=True)
class SetPoints:
    """Currents along and across the flux for a torque, from the motor parameters of the control unit.

    Args:
        inductance_d, inductance_q: inductances along and across the flux [H]
        flux: flux linkage of the magnets [V*s]
        current_limit: maximum length of the current vector [A]

    Source: Morimoto et al., IEEE Trans. Industry Applications 26 (1990) 866: maximum torque per ampere, and above the
    speed of the voltage limit the current along the flux that keeps the voltage at its limit; resistance neglected.
    """

    inductance_d: float
    inductance_q: float
    flux: float
    current_limit: float

    def of(self, wanted: Any, electrical_speed: Any, longest: Any) -> RotorVector:
        """Current set points in the rotor's axes [A].

        Args:
            wanted: current across the flux that would make the torque with the magnets alone [A]
            electrical_speed: electrical speed [rad/s]
            longest: maximum voltage for these currents [V]
        """
        along: Any = 0.0
        # Under-relaxed fixed-point iteration, with a fixed number of rounds so that it can be traced into a program.
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
        """Current along the flux that gives, with a current across it, maximum torque per ampere [A]."""
        apart = (self.inductance_q - self.inductance_d) * across
        return -2.0 * apart * across / (self.flux + sqrt(self.flux * self.flux + 4.0 * apart * apart))
