"""One modulation period of a permanent-magnet motor: flux, current and rotor under a voltage that stands still."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from tierod.physics.clarke_park import Direction, StatorVector, direction, electrical_angle, turned
from tierod.physics.friction import dahl_update
from tierod.physics.pm_motor import (
    cogging_torque,
    copper_loss,
    current_of_flux,
    rotor_acceleration,
    stator_flux_rate,
    torque_of_flux,
)
from tierod.proving_ground.motor.machine import Machine

Load = Callable[[Any, Any, Any], Any]
"""(angle [rad], speed [rad/s], time since the start of the step [s]) -> torque that opposes the rotor [N*m]."""


class Rotor(NamedTuple):
    """The shaft: mechanical angle [rad] and speed [rad/s]."""

    angle: Any
    speed: Any


class Winding(NamedTuple):
    """Resistance of a phase [ohm] and flux linkage of the magnets [V*s], as warm as they are."""

    resistance: Any
    flux: Any


class Instant(NamedTuple):
    """A machine between two periods.

    Args:
        rotor: of the shaft
        linkage: flux of the stator [V*s]
        dry: dry friction over its level [-]
        current: that goes with flux and angle [A]
        at: direction of the electrical angle
    """

    rotor: Rotor
    linkage: StatorVector
    dry: Any
    current: StatorVector
    at: Direction


class Mean(NamedTuple):
    """What a period gave: torque on the shaft without dry friction [N*m], heat in the winding [W]."""

    torque: Any
    heat: Any


def begin(machine: Machine, rotor: Rotor, linkage: StatorVector, dry: Any, winding: Winding) -> Instant:
    """The machine at the start of a step, its direction from sine and cosine of the library."""
    at = direction(electrical_angle(rotor.angle, machine.pole_pairs))
    return Instant(rotor, linkage, dry, _current(machine, linkage, at, winding), at)


def advance(
    machine: Machine,
    now: Instant,
    voltage: StatorVector,
    winding: Winding,
    period: Any,
    elapsed: Any,
    load: Load | None,
    free: Any,
) -> tuple[Instant, Mean]:
    """One period on, by the explicit midpoint rule.

    Args:
        machine: windings, magnets and rotor
        now: before
        voltage: mean over the period, in the stator's axes [V]
        winding: resistance and flux
        period: [s]
        elapsed: since the start of the step [s]
        load: what opposes the rotor; None for a rotor that is carried at its speed
        free: 1, or 0 for a rotor that is held
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


def shaft_torque(machine: Machine, now: Instant) -> Any:
    """Torque of current and slots on the shaft [N*m]."""
    torque = torque_of_flux(now.linkage, now.current, machine.pole_pairs)
    return torque + cogging_torque(now.at, machine.cogging)


def _acceleration(machine: Machine, now: Instant, rotor: Rotor, load: Load | None, elapsed: Any) -> Any:
    if load is None:
        return 0.0
    opposing = load(rotor.angle, rotor.speed, elapsed) + machine.friction * now.dry
    return rotor_acceleration(shaft_torque(machine, now), opposing, rotor.speed, machine.inertia, machine.damping)


def _current(machine: Machine, linkage: StatorVector, at: Direction, winding: Winding) -> StatorVector:
    return current_of_flux(linkage, at, winding.flux, machine.inductance_d, machine.inductance_q)


def _moved(vector: StatorVector, rate: StatorVector, time: Any) -> StatorVector:
    return StatorVector(vector.alpha + time * rate.alpha, vector.beta + time * rate.beta)
