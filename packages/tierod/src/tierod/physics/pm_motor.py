"""Permanent-magnet synchronous motor: flux, current, torque, and the effect of temperature on them.

Vectors are amplitude-invariant (`tierod.physics.clarke_park`). Speed and angle are those of the shaft (mechanical)
unless the name says electrical; z_p is the number of pole pairs.
"""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number
from tierod.physics.clarke_park import Direction, RotorVector, StatorVector, inverse_park, park

COPPER = 1.0 / 255.0  # Temperature coefficient of the resistance of copper, referred to 20 degrees Celsius [1/K]
NEODYMIUM = -1.1e-3  # Temperature coefficient of the remanence of sintered NdFeB, referred to 20 degrees Celsius [1/K]
REFERENCE_TEMPERATURE = 293.15  # Temperature to which stated resistances and flux linkages refer [K]


def back_emf_constant(pole_pairs: Scalar, flux: Scalar) -> Scalar:
    """Voltage per mechanical speed, c_M [V*s/rad].

    Args:
        pole_pairs: z_p [-]
        flux: linkage of the magnets, psi [V*s]

    Source: Reinelt et al., below eq (14): c_M = z_p psi.
    """
    return pole_pairs * flux


def torque_constant(pole_pairs: Scalar, flux: Scalar) -> Scalar:
    """Torque per current in the q axis, K_t [N*m/A].

    Args:
        pole_pairs: z_p [-]
        flux: linkage of the magnets, psi [V*s]

    Source: 3/2 c_M for amplitude-invariant vectors; Reinelt et al., eqs (14) and (16), print c_M itself, which holds
    for power-invariant ones only.
    """
    return 1.5 * back_emf_constant(pole_pairs, flux)


def electromagnetic_torque(
    current: RotorVector, pole_pairs: Scalar, flux: Scalar, inductance_d: Scalar, inductance_q: Scalar
) -> Scalar:
    """Torque [N*m] of a motor with or without saliency, on its shaft.

    Args:
        current: [A]
        pole_pairs: z_p [-]
        flux: linkage of the magnets [V*s]
        inductance_d, inductance_q: along and across the rotor flux [H]

    Source: Krause, Wasynczuk, Sudhoff, Analysis of Electric Machinery, ch. 4:
    3/2 z_p (psi i_q + (L_d - L_q) i_d i_q).
    """
    return 1.5 * pole_pairs * (flux + (inductance_d - inductance_q) * current.d) * current.q


def torque_of_flux(linkage: StatorVector, current: StatorVector, pole_pairs: Scalar) -> Scalar:
    """Torque [N*m] on the shaft from flux linkage and current, both in the same axes.

    Args:
        linkage: of the stator [V*s]
        current: [A]
        pole_pairs: z_p [-]

    Source: 3/2 z_p (psi x i), equal to `electromagnetic_torque`.
    """
    return 1.5 * pole_pairs * (linkage.alpha * current.beta - linkage.beta * current.alpha)


def flux_linkage(current: RotorVector, flux: Scalar, inductance_d: Scalar, inductance_q: Scalar) -> RotorVector:
    """Flux linkage of the stator [V*s].

    Args:
        current: [A]
        flux: linkage of the magnets [V*s]
        inductance_d, inductance_q: along and across the rotor flux [H]
    """
    return RotorVector(flux + inductance_d * current.d, inductance_q * current.q)


def current_of_flux(
    linkage: StatorVector, rotor: Direction, flux: Scalar, inductance_d: Scalar, inductance_q: Scalar
) -> StatorVector:
    """Current [A] in the stator's axes from a flux linkage: `flux_linkage` solved for the current.

    Args:
        linkage: of the stator [V*s]
        flux: linkage of the magnets [V*s]
        inductance_d, inductance_q: along and across the rotor flux [H]
    """
    own = park(linkage, rotor)
    return inverse_park(RotorVector((own.d - flux) / inductance_d, own.q / inductance_q), rotor)


def stator_flux_rate(voltage: StatorVector, current: StatorVector, resistance: Scalar) -> StatorVector:
    """Rate of the stator's flux linkage [V], in the stator's axes.

    Args:
        voltage: [V]
        current: [A]
        resistance: of a phase [ohm]

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

    Args:
        current: [A]
        voltage: [V]
        speed: mechanical [rad/s]
        resistance: of a phase [ohm]
        inductance_d, inductance_q: along and across the rotor flux [H]
        flux: linkage of the magnets [V*s]
        pole_pairs: z_p [-]

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

    Args:
        current: [A]
        voltage: [V]
        speed: mechanical [rad/s]
        resistance: of a phase [ohm]
        inductance: of both axes [H]
        flux: linkage of the magnets [V*s]
        pole_pairs: z_p [-]

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

    Args:
        current: [A]
        voltage: [V]
        speed: mechanical [rad/s]
        resistance: of a phase [ohm]
        inductance_d, inductance_q: along and across the rotor flux [H]
        flux: linkage of the magnets [V*s]
        pole_pairs: z_p [-]

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

    Args:
        torque: electromagnetic [N*m]
        load_torque: opposing, with dry friction [N*m]
        speed: mechanical [rad/s]
        inertia: of the rotor, J_M [kg*m**2]
        damping: viscous, b_M [N*m*s/rad]

    Source: Reinelt et al., eqs (14) and (16), with the electromagnetic torque in place of c_M I_sq.
    """
    return (torque - damping * speed - load_torque) / inertia


def cogging_torque(rotor: Direction, amplitude: Scalar) -> Scalar:
    """Cogging torque [N*m] of the slots: the sixth harmonic of the electrical angle.

    Args:
        amplitude: [N*m]

    Source: least common multiple of slots and poles; six per electrical turn for 3 slots per pole pair, the usual
    concentrated winding.
    """
    twice = 2.0 * rotor.sine * rotor.cosine
    return amplitude * twice * (3.0 - 4.0 * twice * twice)


def resistance_at(temperature: Number, reference: Scalar) -> Number:
    """Resistance of a copper winding at a temperature [ohm].

    Args:
        temperature: of the winding [K]
        reference: resistance at 20 degrees Celsius [ohm]

    Validity: 200 to 500 K. Source: IEC 60034-1, 235 K rule, written for 20 degrees.
    """
    return reference * (1.0 + COPPER * (temperature - REFERENCE_TEMPERATURE))


def flux_at(temperature: Number, reference: Scalar) -> Number:
    """Flux linkage of the magnets [V*s] at a temperature, without irreversible demagnetisation.

    Args:
        temperature: of the magnets [K]
        reference: flux at 20 degrees Celsius [V*s]

    Validity: sintered NdFeB, 230 to 420 K.
    """
    return reference * (1.0 + NEODYMIUM * (temperature - REFERENCE_TEMPERATURE))


def copper_loss(current: StatorVector, resistance: Scalar) -> Scalar:
    """Copper loss of the three windings [W].

    Args:
        current: [A]
        resistance: of a phase [ohm]
    """
    return 1.5 * resistance * (current.alpha * current.alpha + current.beta * current.beta)


def electric_power(voltage: StatorVector, current: StatorVector) -> Scalar:
    """Electric power into the motor [W].

    Args:
        voltage: [V]
        current: [A]
    """
    return 1.5 * (voltage.alpha * current.alpha + voltage.beta * current.beta)
