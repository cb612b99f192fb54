"""Three-phase inverter with pulse-width modulation, averaged over a period: what voltage can be made, what is lost."""

from __future__ import annotations

from typing import TypeVar

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, limit, maximum, sqrt
from tierod.physics.clarke_park import PhaseValues, RotorVector, StatorVector, clarke, inverse_clarke

Vector = TypeVar("Vector", StatorVector, RotorVector)

LONGEST_SIGN = 4.0 / 3.0
"""Length of the vector of the phase currents' signs where all three flow [-]: a loss of one volt takes so many."""


def longest_voltage(supply_voltage: Scalar) -> Scalar:
    """Length of the longest voltage vector [V] that can be made in every direction.

    Args:
        supply_voltage: of the intermediate circuit [V]

    Source: space-vector modulation, circle inside the hexagon; Holmes and Lipo, Pulse Width Modulation for Power
    Converters (2003), ch. 6: V_dc / sqrt(3).
    """
    share: float = 3.0**-0.5
    return supply_voltage * share


def limited_voltage(wanted: Vector, longest: Scalar) -> Vector:
    """A vector shortened to a length, its direction kept.

    Args:
        wanted: StatorVector or RotorVector [V]
        longest: [V], positive
    """
    first, second = wanted
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
    """Mean voltage [V] that dead time and semiconductors take from what was commanded.

    Args:
        current: into the motor [A]
        supply_voltage: of the intermediate circuit [V]
        dead_time: between the switches of a leg [s]
        period: of the modulation [s]
        forward_drop: of switch and diode, mean [V]
        knee_current: below it a phase's loss falls in proportion to its current, as the parasitic capacitances are
            charged by it [A], positive

    Source: Choi and Sul, IEEE Trans. Power Electronics 11 (1996) 221: every phase loses (V_dc t_d / T + V_drop) sgn(i),
    with the sign made continuous around zero; what all phases lose alike drops out.
    """
    loss = supply_voltage * dead_time / period + forward_drop
    signs = phase_signs(current, knee_current)
    return StatorVector(loss * signs.alpha, loss * signs.beta)


def phase_signs(current: StatorVector[Number], knee_current: Scalar) -> StatorVector[Number]:
    """Signs of the phase currents as a vector, continuous around zero: what a loss of one volt per phase takes [-].

    Args:
        current: into the motor [A]
        knee_current: below it a sign is the current over this [A], positive
    """
    shares = [limit(value / knee_current, -1.0, 1.0) for value in inverse_clarke(current)]
    return clarke(PhaseValues(*shares))


def commanded_voltage(duty_cycles: PhaseValues, supply_voltage: Scalar) -> StatorVector:
    """Mean voltage [V] over a period of modulation that is commanded to the switches, in the stator's axes.

    Args:
        duty_cycles: share of the period for which each phase is tied to the upper rail [-]
        supply_voltage: of the intermediate circuit [V]

    Source: Holmes and Lipo, Pulse Width Modulation for Power Converters (2003), ch. 5. A voltage that all legs share
    drops out in the star point; what dead time and semiconductors take is `lost_voltage`.
    """
    return clarke(PhaseValues(*(duty * supply_voltage for duty in duty_cycles)))
