"""True behaviour of a permanent-magnet motor and its inverter over one modulation period; monitors never read it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import COUNT, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.physics.clarke_park import Direction, StatorVector, direction, electrical_angle, turned
from tierod.physics.friction import dahl_update
from tierod.physics.inverter import longest_voltage
from tierod.physics.pm_motor import (
    cogging_torque,
    copper_loss,
    current_of_flux,
    rotor_acceleration,
    stator_flux_rate,
    torque_of_flux,
)


@dataclass(frozen=True)
class Machine:
    """Windings, magnets and rotor; resistance and flux at 20 degrees Celsius.

    The defaults are those of a 12 V motor of 450 W in an active front steering; no paper prints such a set.
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
    """Six switches on a battery; the modulation period is that of the current control."""

    supply_voltage: Annotated[float, "V", POSITIVE] = 13.0
    # dead time between the switches of a leg; 1 us is usual for MOSFETs
    dead_time: Annotated[float, "s", NOT_NEGATIVE] = 1e-6
    forward_drop: Annotated[float, "V", NOT_NEGATIVE] = 0.1
    knee_current: Annotated[float, "A", POSITIVE] = 1.0
    modulation: Annotated[float, "", SHARE] = 0.97

    @property
    def longest_voltage(self) -> Scalar:
        """Maximum length of the voltage vector in use [V]."""
        return self.modulation * longest_voltage(self.supply_voltage)


class Warmth(NamedTuple):
    """Temperatures of winding and housing [K]; the magnets have the temperature of the housing."""

    winding: Scalar
    housing: Scalar


@dataclass(frozen=True)
class Warming:
    """Thermal model of two bodies: the winding on the housing, and the housing in the air."""

    winding_capacity: Annotated[float, "J/K", POSITIVE] = 100.0
    housing_capacity: Annotated[float, "J/K", POSITIVE] = 600.0
    # thermal conductance from winding to housing; the time constant is about 80 s
    winding_conductance: Annotated[float, "W/K", POSITIVE] = 1.2
    # thermal conductance from housing to air; the time constant is about 20 minutes
    housing_conductance: Annotated[float, "W/K", POSITIVE] = 0.5
    ambient_temperature: Annotated[float, "K", POSITIVE] = 298.15

    def init(self) -> Warmth:
        return Warmth(self.ambient_temperature, self.ambient_temperature)

    def after(self, warmth: Warmth, heat: Scalar, step: Scalar) -> Warmth:
        """Temperatures after a step, by the explicit Euler method.

        Args:
            heat: heat in the winding [W]
            step: sampling interval, short compared with the time constants [s]
        """
        inward = self.winding_conductance * (warmth.winding - warmth.housing)
        outward = self.housing_conductance * (warmth.housing - self.ambient_temperature)
        return Warmth(
            warmth.winding + step / self.winding_capacity * (heat - inward),
            warmth.housing + step / self.housing_capacity * (inward - outward),
        )


Load = Callable[[Scalar, Scalar, Scalar], Scalar]
"""(angle [rad], speed [rad/s], time since the start of the step [s]) -> load torque on the rotor [N*m]."""


class Rotor(NamedTuple):
    """Mechanical angle [rad] and speed [rad/s] of the shaft."""

    angle: Scalar
    speed: Scalar


class Winding(NamedTuple):
    """Resistance of a phase [ohm] and flux linkage of the magnets [V*s], at their present temperatures."""

    resistance: Scalar
    flux: Scalar


class Instant(NamedTuple):
    """State of a machine between two periods."""

    rotor: Rotor
    linkage: StatorVector  # stator flux linkage [V*s]
    dry: Scalar  # dry friction divided by its level [-]
    current: StatorVector  # current that follows from flux linkage and angle [A]
    at: Direction


class Mean(NamedTuple):
    """Means over a period: shaft torque without dry friction [N*m], and heat in the winding [W]."""

    torque: Scalar
    heat: Scalar


def begin(machine: Machine, rotor: Rotor, linkage: StatorVector, dry: Scalar, winding: Winding) -> Instant:
    """State at the start of a step; the direction is computed anew, since `turned` accumulates small errors."""
    at = direction(electrical_angle(rotor.angle, machine.pole_pairs))
    return Instant(rotor, linkage, dry, _current(machine, linkage, at, winding), at)


def advance(
    machine: Machine,
    now: Instant,
    voltage: StatorVector,
    winding: Winding,
    period: Scalar,
    elapsed: Scalar,
    load: Load | None,
    free: Scalar,
) -> tuple[Instant, Mean]:
    """State after one period, by the explicit midpoint rule, and the means over the period.

    Args:
        voltage: mean voltage over the period, in the stator's axes [V]
        period: modulation period [s]
        elapsed: time since the start of the step [s]
        load: load torque on the rotor; None for a rotor whose speed is imposed
    """
    half, rotor = 0.5 * period, now.rotor
    slope = _acceleration(machine, now, rotor, load, elapsed)
    middle_rotor = Rotor(rotor.angle + half * rotor.speed, free * (rotor.speed + half * slope))
    dry = dahl_update(now.dry, half * middle_rotor.speed, machine.dahl_angle)
    linkage = _moved(now.linkage, stator_flux_rate(voltage, now.current, winding.resistance), half)
    at = turned(now.at, machine.pole_pairs * half * rotor.speed)
    middle = Instant(middle_rotor, linkage, dry, _current(machine, linkage, at, winding), at)
    slope = _acceleration(machine, middle, middle_rotor, load, elapsed + half)
    after_rotor = Rotor(rotor.angle + period * middle_rotor.speed, free * (rotor.speed + period * slope))
    linkage = _moved(now.linkage, stator_flux_rate(voltage, middle.current, winding.resistance), period)
    at = turned(now.at, machine.pole_pairs * period * middle_rotor.speed)
    dry = dahl_update(dry, half * middle_rotor.speed, machine.dahl_angle)
    after = Instant(after_rotor, linkage, dry, _current(machine, linkage, at, winding), at)
    return after, Mean(shaft_torque(machine, middle), copper_loss(middle.current, winding.resistance))


def shaft_torque(machine: Machine, now: Instant) -> Scalar:
    """Electromagnetic and cogging torque on the shaft [N*m]."""
    torque = torque_of_flux(now.linkage, now.current, machine.pole_pairs)
    return torque + cogging_torque(now.at, machine.cogging)


def _acceleration(machine: Machine, now: Instant, rotor: Rotor, load: Load | None, elapsed: Scalar) -> Scalar:
    if load is None:
        return 0.0
    opposing = load(rotor.angle, rotor.speed, elapsed) + machine.friction * now.dry
    return rotor_acceleration(shaft_torque(machine, now), opposing, rotor.speed, machine.inertia, machine.damping)


def _current(machine: Machine, linkage: StatorVector, at: Direction, winding: Winding) -> StatorVector:
    return current_of_flux(linkage, at, winding.flux, machine.inductance_d, machine.inductance_q)


def _moved(vector: StatorVector, rate: StatorVector, time: Scalar) -> StatorVector:
    return StatorVector(vector.alpha + time * rate.alpha, vector.beta + time * rate.beta)
