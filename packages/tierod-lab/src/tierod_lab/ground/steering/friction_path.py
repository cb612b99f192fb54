"""Dry friction integrated over the angle: normalised laws, exact for a motion in one direction.

A friction share is friction over its level; it opposes motion. Dahl's laws are in `tierod.physics.friction`.
"""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, exp, limit, sign, where
from tierod.physics.friction import lugre_bristle_rate, lugre_torque


def elastoplastic_update(share: Scalar, angle_increment: Scalar, elastic_angle: Scalar) -> Scalar:
    """Friction share [-] of an elastic element that slips at its level, after an angle increment.

    Args:
        share: before the increment [-]
        angle_increment: [rad], without reversal inside
        elastic_angle: level over stiffness [rad], positive; tends to Coulomb's law as it tends to zero

    Source: one element of Iwan, J. Appl. Mech. 33 (1966) 893; the Maxwell slip model (Lampaert, Swevers, Al-Bender,
    IEEE TAC 47 (2002) 683) is a sum of such elements.
    """
    return limit(share + angle_increment / elastic_angle, -1.0, 1.0)


def elastoplastic_slope(share: Scalar, direction: Scalar, elastic_angle: Scalar) -> Scalar:
    """Derivative of the friction share with respect to the angle [1/rad]: slope of `elastoplastic_update`.

    Args:
        share: friction share at present [-]
        direction: sign of the rate [-]; zero at rest, where the element sticks
        elastic_angle: level over stiffness [rad], positive

    An elastic element that slips at its level.
    """
    return where(share * direction < 1.0, 1.0 / elastic_angle, 0.0)


def lugre_update(bristle: Scalar, angle_increment: Scalar, bristle_angle: Scalar, steady_share: Scalar) -> Scalar:
    """Normalised bristle deflection [-] of the LuGre model after an angle increment at a constant rate.

    Args:
        bristle: deflection times bristle stiffness over the sliding level, before the increment [-]
        angle_increment: [rad], without reversal inside
        bristle_angle: sliding level over bristle stiffness [rad], positive
        steady_share: steady friction at this rate over the sliding level, g of the paper [-], positive

    Source: Canudas de Wit et al., IEEE TAC 40 (1995) 419, eq (2), solved over the angle:
    dz/d theta = s - sigma_0 z / g with s = sgn(d theta).
    """
    settled = sign(angle_increment) * steady_share
    return settled + (bristle - settled) * exp(-absolute(angle_increment) / (bristle_angle * steady_share))


def lugre_slope(bristle: Scalar, direction: Scalar, bristle_angle: Scalar, steady_share: Scalar) -> Scalar:
    """Derivative of the normalised bristle deflection with respect to the angle [1/rad].

    Args:
        bristle: normalised deflection, from `lugre_update` [-]
        direction: sign of the rate [-]
        bristle_angle: sliding level over bristle stiffness [rad]
        steady_share: as in `lugre_update` [-]

    Source: the equation that `lugre_update` solves.
    """
    return (1.0 - direction * bristle / steady_share) / bristle_angle


def lugre_share(
    bristle: Scalar, rate: Scalar, bristle_angle: Scalar, steady_share: Scalar, micro_time: Scalar
) -> Scalar:
    """Friction share [-] of the LuGre model without its viscous term.

    Args:
        bristle: normalised deflection, from `lugre_update` [-]
        rate: angular rate [rad/s]
        bristle_angle: sliding level over bristle stiffness [rad]
        steady_share: as in `lugre_update` [-]
        micro_time: damping over stiffness of the bristles, sigma_1 / sigma_0 [s]

    Source: `lugre_torque`, with the sliding level as unit of torque and `bristle_angle` as unit of deflection.
    """
    bristle_rate = lugre_bristle_rate(bristle, rate, 1.0, steady_share) / bristle_angle
    return lugre_torque(bristle, bristle_rate, rate, 1.0, micro_time, 0.0)
