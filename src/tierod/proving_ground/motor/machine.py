"""What a permanent-magnet motor and its inverter are made of: the truth, which no monitor may read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.fields import COUNT, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.physics.inverter import longest_voltage


@dataclass(frozen=True)
class Machine:
    """Windings, magnets and rotor; resistance and flux at 20 degrees Celsius.

    The defaults are those of a 12 V motor of 450 W in an active front steering; no paper prints such a set.

    Args:
        resistance: of a phase
        inductance_d, inductance_q: along and across the rotor flux
        flux: linkage of the magnets
        inertia: of the rotor
        damping: viscous, of the rotor
        friction: level of dry friction at the shaft: bearings, seals, worm
        dahl_angle: of that friction, at the shaft
        cogging: amplitude of the slots' torque
        pole_pairs: electrical turns per turn of the shaft
    """

    resistance: Annotated[float, "ohm", POSITIVE] = 0.05
    inductance_d: Annotated[float, "H", POSITIVE] = 1e-4
    inductance_q: Annotated[float, "H", POSITIVE] = 1e-4
    flux: Annotated[float, "V*s", POSITIVE] = 0.0085
    inertia: Annotated[float, "kg*m**2", POSITIVE] = 1.2e-4
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 4e-4
    friction: Annotated[float, "N*m", NOT_NEGATIVE] = 0.02
    dahl_angle: Annotated[float, "rad", POSITIVE] = 0.05
    cogging: Annotated[float, "N*m", NOT_NEGATIVE] = 0.01
    pole_pairs: Annotated[int, "", COUNT] = 4


@dataclass(frozen=True)
class Inverter:
    """Six switches on a battery; the modulation period is that of the current control.

    Args:
        supply_voltage: at the inverter
        dead_time: between the switches of a leg; 1 us is usual for MOSFETs
        forward_drop: of switch and diode, mean
        knee_current: below it the loss of a phase falls in proportion to its current
        modulation: share of the longest possible voltage that is used
    """

    supply_voltage: Annotated[float, "V", POSITIVE] = 13.0
    dead_time: Annotated[float, "s", NOT_NEGATIVE] = 1e-6
    forward_drop: Annotated[float, "V", NOT_NEGATIVE] = 0.1
    knee_current: Annotated[float, "A", POSITIVE] = 1.0
    modulation: Annotated[float, "", SHARE] = 0.97

    @property
    def longest_voltage(self) -> Any:
        """Of the vectors that are used [V]."""
        return self.modulation * longest_voltage(self.supply_voltage)


class Warmth(NamedTuple):
    """Temperatures of winding and housing [K]; the magnets are as warm as the housing."""

    winding: Any
    housing: Any


@dataclass(frozen=True)
class Warming:
    """Two bodies that store heat: the winding on the housing, the housing in the air.

    Args:
        winding_capacity: of some 0.25 kg of copper
        housing_capacity: of some 1 kg of iron and aluminium
        winding_conductance: from winding to housing; with the capacity a time constant of about 80 s
        housing_conductance: from housing to air; about 20 minutes
        ambient_temperature: of the air; a run begins with everything as warm as this
    """

    winding_capacity: Annotated[float, "J/K", POSITIVE] = 100.0
    housing_capacity: Annotated[float, "J/K", POSITIVE] = 600.0
    winding_conductance: Annotated[float, "W/K", POSITIVE] = 1.2
    housing_conductance: Annotated[float, "W/K", POSITIVE] = 0.5
    ambient_temperature: Annotated[float, "K", POSITIVE] = 298.15

    def init(self) -> Warmth:
        """As warm as the air."""
        return Warmth(self.ambient_temperature, self.ambient_temperature)

    def after(self, warmth: Warmth, heat: Any, step: Any) -> Warmth:
        """Temperatures after a step.

        Args:
            warmth: before
            heat: in the winding [W]
            step: [s], short against the time constants
        """
        inward = self.winding_conductance * (warmth.winding - warmth.housing)
        outward = self.housing_conductance * (warmth.housing - self.ambient_temperature)
        return Warmth(
            warmth.winding + step / self.winding_capacity * (heat - inward),
            warmth.housing + step / self.housing_capacity * (inward - outward),
        )
