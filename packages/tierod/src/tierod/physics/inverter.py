"""Three-phase inverter with pulse-width modulation, averaged over a period: available, commanded and lost voltage."""

from __future__ import annotations

from typing import TypeVar

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, limit, maximum, sqrt
from tierod.physics.clarke_park import PhaseValues, RotorVector, StatorVector, clarke, inverse_clarke

Vector = TypeVar("Vector", StatorVector, RotorVector)

LONGEST_SIGN = 4.0 / 3.0
"""Length of the space vector of the signs of three nonzero phase currents [-]: lost voltage per volt and phase."""


def longest_voltage(supply_voltage: Scalar) -> Scalar:
    """Length of the longest voltage vector [V] that the inverter can produce in every direction.

    Args:
        supply_voltage: of the DC link [V]

    Source: space-vector modulation, circle inside the hexagon; Holmes and Lipo, Pulse Width Modulation for Power
    Converters (2003), ch. 6: V_dc / sqrt(3).
    """
    share: float = 3.0**-0.5
    return supply_voltage * share


def limited_voltage(wanted: Vector, longest: Scalar) -> Vector:
    """Voltage vector limited in length, with its direction kept.

    Args:
        wanted: StatorVector or RotorVector [V]
        longest: [V], positive
    """
    first, second = wanted
    # The maximum under the root makes the factor 1 for short vectors, and defined for the zero vector.
    share = longest / sqrt(maximum(first * first + second * second, longest * longest))
    return type(wanted)(share * first, share * second)


def lost_voltage(
    current: StatorVector,
    supply_voltage: Scalar,
    dead_time: Scalar,
    period: Scalar,
    forward_drop: Scalar,
    knee_current: Scalar,
) -> StatorVector:
    """Mean voltage [V] by which dead time and voltage drops of the semiconductors reduce the commanded one.

    Args:
        current: into the motor [A]
        supply_voltage: of the DC link [V]
        dead_time: between the switches of a leg [s]
        period: of the modulation [s]
        forward_drop: of switch and diode, mean [V]
        knee_current: below it the loss of a phase falls in proportion to its current, since that current charges the
            parasitic capacitances [A], positive

    Source: Choi and Sul, IEEE Trans. Power Electronics 11 (1996) 221: every phase loses (V_dc t_d / T + V_drop) sgn(i),
    with the sign made continuous around zero; a loss common to all phases drops out.
    """
    loss = supply_voltage * dead_time / period + forward_drop
    signs = phase_signs(current, knee_current)
    return StatorVector(loss * signs.alpha, loss * signs.beta)


def phase_signs(current: StatorVector[Number], knee_current: Scalar) -> StatorVector[Number]:
    """Space vector of the phase currents' signs, continuous around zero: lost voltage per volt lost in a phase [-].

    Args:
        current: into the motor [A]
        knee_current: below it the sign is replaced by the current over this one [A], positive
    """
    shares = [limit(value / knee_current, -1.0, 1.0) for value in inverse_clarke(current)]
    return clarke(PhaseValues(*shares))


def commanded_voltage(duty_cycles: PhaseValues, supply_voltage: Scalar) -> StatorVector:
    """Mean voltage [V] over a period of modulation that the duty cycles command, in the stator's axes.

    Args:
        duty_cycles: share of the period for which each phase is connected to the upper rail [-]
        supply_voltage: of the DC link [V]

    Source: Holmes and Lipo, Pulse Width Modulation for Power Converters (2003), ch. 5. A voltage common to all legs
    drops out at the star point; the loss by dead time and semiconductors is `lost_voltage`.
    """
    return clarke(PhaseValues(*(duty * supply_voltage for duty in duty_cycles)))
