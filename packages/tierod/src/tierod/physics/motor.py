"""Permanent-magnet motor: Clarke and Park transforms, inverter, flux, current, torque, temperature.

Arguments, unless a function says otherwise: angle: any number of turns [rad]; current [A]; damping: viscous, b_M
[N*m*s/rad]; dead_time: between the switches of a leg [s]; duty_cycles: share of the period for which each phase is
connected to the upper rail [-]; flux: linkage of the magnets [V*s]; forward_drop: of switch and diode, mean [V];
inductance: of both axes [H]; inductance_d, inductance_q: along and across the rotor flux [H]; inertia: of the rotor,
J_M [kg*m**2]; knee_current: below it the loss of a phase falls in proportion to its current, since that current charges
the parasitic capacitances [A], positive; load_torque: opposing, with dry friction [N*m]; mechanical_angle: of the shaft
[rad]; period: of the modulation [s]; phases: currents [A] or voltages [V]; pole_pairs: z_p [-]; reference: resistance
at 20 degrees Celsius [ohm]; resistance: of a phase [ohm]; speed: mechanical [rad/s]; supply_voltage: of the DC link
[V]; temperature: of the winding [K]; torque: electromagnetic [N*m]; voltage [V].
"""

from __future__ import annotations

import math
from typing import Generic, NamedTuple, TypeVar

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, cos, floor, limit, sin


def wrapped(angle: Scalar) -> Scalar:
    """Angle wrapped to half a turn on either side of zero [rad].

    Returns:
        from -pi (included) to pi (excluded) [rad]
    """
    return angle - 2.0 * math.pi * floor(angle / (2.0 * math.pi) + 0.5)


_SQRT_3 = 3.0**0.5


class PhaseValues(NamedTuple, Generic[Number]):
    a: Number
    b: Number
    c: Number


class StatorVector(NamedTuple, Generic[Number]):
    """A vector in the stator's axes."""

    alpha: Number
    beta: Number


class RotorVector(NamedTuple, Generic[Number]):
    """A vector in the rotor's axes: d along the magnets' flux, q across."""

    d: Number
    q: Number


class Direction(NamedTuple, Generic[Number]):
    """Cosine and sine of an electrical angle, computed once for many vectors."""

    cosine: Number
    sine: Number


def electrical_angle(mechanical_angle: Scalar, pole_pairs: Scalar) -> Scalar:
    """Electrical angle [rad] of a rotor."""
    return pole_pairs * mechanical_angle


def direction(electrical_angle: Number) -> Direction[Number]:
    """Direction of an electrical angle [rad]."""
    return Direction(cos(electrical_angle), sin(electrical_angle))


def turned(before: Direction, electrical_increment: Scalar) -> Direction:
    """A direction turned by a small electrical angle [rad], by polynomials instead of sine and cosine.

    Validity: increments below 0.3 rad, where the error stays below 1e-6 (Taylor polynomials of order 4 and 5); the
    length drifts by as much, so recompute the direction with `direction` from time to time.
    """
    square = electrical_increment * electrical_increment
    cosine = 1.0 + square * (square * (1.0 / 24.0) - 0.5)
    sine = electrical_increment * (1.0 + square * (square * (1.0 / 120.0) - 1.0 / 6.0))
    return Direction(before.cosine * cosine - before.sine * sine, before.sine * cosine + before.cosine * sine)


def clarke(phases: PhaseValues[Number]) -> StatorVector[Number]:
    """Phase values in the stator's axes, amplitude-invariant; the zero sequence drops out.

    Source: Reinelt et al., eqs (5) to (7), to which this is equal where the phases add up to zero.
    """
    return StatorVector((2.0 * phases.a - phases.b - phases.c) / 3.0, (phases.b - phases.c) / _SQRT_3)


def inverse_clarke(vector: StatorVector[Number]) -> PhaseValues[Number]:
    """Phase values, adding up to zero, of a vector in the stator's axes.

    Source: Reinelt et al., eqs (5) to (7), solved for the phases.
    """
    half, side = 0.5 * vector.alpha, 0.5 * _SQRT_3 * vector.beta
    return PhaseValues(vector.alpha, side - half, -half - side)


def park(vector: StatorVector[Number], rotor: Direction[Number]) -> RotorVector[Number]:
    """A vector in the rotor's axes. Source: Reinelt et al., eqs (8) and (9), where theta is the electrical angle."""
    return RotorVector(
        vector.alpha * rotor.cosine + vector.beta * rotor.sine,
        vector.beta * rotor.cosine - vector.alpha * rotor.sine,
    )


def inverse_park(vector: RotorVector[Number], rotor: Direction[Number]) -> StatorVector[Number]:
    """A vector in the stator's axes. Source: Reinelt et al., eqs (10) and (11), where theta is the electrical angle."""
    return StatorVector(
        vector.d * rotor.cosine - vector.q * rotor.sine,
        vector.d * rotor.sine + vector.q * rotor.cosine,
    )


Vector = TypeVar("Vector", StatorVector, RotorVector)
# Length of the space vector of the signs of three nonzero phase currents [-]: lost voltage per volt and phase
LONGEST_SIGN = 4.0 / 3.0


def lost_voltage(
    current: StatorVector,
    supply_voltage: Scalar,
    dead_time: Scalar,
    period: Scalar,
    forward_drop: Scalar,
    knee_current: Scalar,
) -> StatorVector:
    """Mean voltage [V] by which dead time and voltage drops of the semiconductors reduce the commanded one.

    Source: Choi and Sul, IEEE Trans. Power Electronics 11 (1996) 221: every phase loses (V_dc t_d / T + V_drop) sgn(i),
    with the sign made continuous around zero; a loss common to all phases drops out. Args: current: into the motor [A].
    """
    loss = supply_voltage * dead_time / period + forward_drop
    signs = phase_signs(current, knee_current)
    return StatorVector(loss * signs.alpha, loss * signs.beta)


def phase_signs(current: StatorVector[Number], knee_current: Scalar) -> StatorVector[Number]:
    """Space vector of the phase currents' signs, continuous around zero: lost voltage per volt lost in a phase [-].

    Args: current: into the motor [A]; knee_current: below it the sign is replaced by the current over this one [A],
    positive.
    """
    shares = [limit(value / knee_current, -1.0, 1.0) for value in inverse_clarke(current)]
    return clarke(PhaseValues(*shares))


def commanded_voltage(duty_cycles: PhaseValues, supply_voltage: Scalar) -> StatorVector:
    """Mean voltage [V] over a period of modulation that the duty cycles command, in the stator's axes.

    Source: Holmes and Lipo, Pulse Width Modulation for Power Converters (2003), ch. 5. A voltage common to all legs
    drops out at the star point; the loss by dead time and semiconductors is `lost_voltage`.
    """
    return clarke(PhaseValues(*(duty * supply_voltage for duty in duty_cycles)))


COPPER = 1.0 / 255.0  # Temperature coefficient of the resistance of copper, referred to 20 degrees Celsius [1/K]
NEODYMIUM = -1.1e-3  # Temperature coefficient of the remanence of sintered NdFeB, referred to 20 degrees Celsius [1/K]
REFERENCE_TEMPERATURE = 293.15  # Temperature to which stated resistances and flux linkages refer [K]


def back_emf_constant(pole_pairs: Scalar, flux: Scalar) -> Scalar:
    """Voltage per mechanical speed, c_M [V*s/rad].

    Source: Reinelt et al., below eq (14): c_M = z_p psi. Args: flux: linkage of the magnets, psi [V*s].
    """
    return pole_pairs * flux


def torque_constant(pole_pairs: Scalar, flux: Scalar) -> Scalar:
    """Torque per current in the q axis, K_t [N*m/A].

    Source: 3/2 c_M for amplitude-invariant vectors; Reinelt et al., eqs (14) and (16), print c_M itself, which holds
    for power-invariant ones only. Args: flux: linkage of the magnets, psi [V*s].
    """
    return 1.5 * back_emf_constant(pole_pairs, flux)


def electromagnetic_torque(
    current: RotorVector, pole_pairs: Scalar, flux: Scalar, inductance_d: Scalar, inductance_q: Scalar
) -> Scalar:
    """Torque [N*m] of a motor with or without saliency, on its shaft.

    Source: Krause, Wasynczuk, Sudhoff, Analysis of Electric Machinery, ch. 4: 3/2 z_p (psi i_q + (L_d - L_q) i_d i_q).
    """
    return 1.5 * pole_pairs * (flux + (inductance_d - inductance_q) * current.d) * current.q


def stator_flux_rate(voltage: StatorVector, current: StatorVector, resistance: Scalar) -> StatorVector:
    """Rate of the stator's flux linkage [V], in the stator's axes.

    Source: Reinelt et al., eqs (17) and (18), where theta is the electrical angle.
    """
    return StatorVector(voltage.alpha - resistance * current.alpha, voltage.beta - resistance * current.beta)


def current_rate(
    current: RotorVector,
    voltage: RotorVector,
    speed: Scalar,
    *,
    resistance: Scalar,
    inductance_d: Scalar,
    inductance_q: Scalar,
    flux: Scalar,
    pole_pairs: Scalar,
) -> RotorVector:
    """Rate of the current [A/s] in the rotor's axes.

    Source: Reinelt et al., eqs (12) and (13), where theta is the mechanical angle.
    """
    electrical_speed = pole_pairs * speed
    d = voltage.d - resistance * current.d + electrical_speed * inductance_q * current.q
    q = voltage.q - resistance * current.q - electrical_speed * (inductance_d * current.d + flux)
    return RotorVector(d / inductance_d, q / inductance_q)


def stator_current_rate(
    current: StatorVector,
    voltage: StatorVector,
    rotor: Direction,
    speed: Scalar,
    *,
    resistance: Scalar,
    inductance: Scalar,
    flux: Scalar,
    pole_pairs: Scalar,
) -> StatorVector:
    """Rate of the current [A/s] in the stator's axes, for a motor without saliency.

    Source: Reinelt et al., eqs (17) and (18), differentiated, where theta is the electrical angle.
    """
    back_emf = back_emf_constant(pole_pairs, flux) * speed
    driving = stator_flux_rate(voltage, current, resistance)
    return StatorVector(
        (driving.alpha + back_emf * rotor.sine) / inductance, (driving.beta - back_emf * rotor.cosine) / inductance
    )


def salient_stator_current_rate(
    current: StatorVector,
    voltage: StatorVector,
    rotor: Direction,
    speed: Scalar,
    *,
    resistance: Scalar,
    inductance_d: Scalar,
    inductance_q: Scalar,
    flux: Scalar,
    pole_pairs: Scalar,
) -> StatorVector:
    """Rate of the current [A/s] in the stator's axes, for a motor with or without saliency.

    Source: `current_rate` in axes that turn with the rotor: d/dt(e^(j theta) i) = e^(j theta) (di/dt + j omega i).
    """
    own = current_rate(
        park(current, rotor),
        park(voltage, rotor),
        speed,
        resistance=resistance,
        inductance_d=inductance_d,
        inductance_q=inductance_q,
        flux=flux,
        pole_pairs=pole_pairs,
    )
    rate, turning = inverse_park(own, rotor), pole_pairs * speed
    return StatorVector(rate.alpha - turning * current.beta, rate.beta + turning * current.alpha)


def rotor_acceleration(torque: Scalar, load_torque: Scalar, speed: Scalar, inertia: Scalar, damping: Scalar) -> Scalar:
    """Mechanical acceleration of the rotor [rad/s**2].

    Source: Reinelt et al., eqs (14) and (16), with the electromagnetic torque in place of c_M I_sq.
    """
    return (torque - damping * speed - load_torque) / inertia


def resistance_at(temperature: Number, reference: Scalar) -> Number:
    """Resistance of a copper winding at a temperature [ohm].

    Validity: 200 to 500 K. Source: IEC 60034-1, 235 K rule, written for 20 degrees.
    """
    return reference * (1.0 + COPPER * (temperature - REFERENCE_TEMPERATURE))


def flux_at(temperature: Number, reference: Scalar) -> Number:
    """Flux linkage of the magnets [V*s] at a temperature, without irreversible demagnetisation.

    Validity: sintered NdFeB, 230 to 420 K. Args: temperature: of the magnets [K]; reference: flux at 20 degrees Celsius
    [V*s].
    """
    return reference * (1.0 + NEODYMIUM * (temperature - REFERENCE_TEMPERATURE))
