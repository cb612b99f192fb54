"""Tyres with the Magic Formula, forces of one contact patch, and resistances of air and rolling."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, Range
from tierod.core.graph.maths import limit, maximum, sin, sqrt
from tierod.physics.tyre import trail
from tierod_lab.ground.chassis.laws import (
    bounded_relaxation_rate,
    combined_forces,
    relaxation_speed,
    stiffness_per_load,
)

AIR_DENSITY = 1.2  # Density of dry air at 20 degC and 1013 hPa [kg/m**3]


class AirForces(NamedTuple):
    """Aerodynamic forces on a car along and across its body [N], and yaw moment [N*m]."""

    longitudinal: Scalar
    lateral: Scalar
    yaw_moment: Scalar


def air_forces(forward: Scalar, sideways: Scalar, drag_area: Scalar, side_area: Scalar, lead: Scalar) -> AirForces:
    """Aerodynamic forces [N] and yaw moment [N*m] at the centre of gravity.

    Args:
        forward, sideways: speed of the car through the air, along and across the body [m/s]
        drag_area: drag coefficient times frontal area [m**2], about 0.65
        side_area: slope of the side force coefficient over the flow angle, times frontal area [m**2], about 5
        lead: distance of the side force ahead of the centre of gravity [m]

    Validity: flow angles up to about 25 degrees, the range of measured slopes; without lift and roll moment.
    Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., section 3.1: F = c A rho/2 V^2, with the
    sine of the flow angle in the place of the angle, and drag along the body.
    """
    pressure = 0.5 * AIR_DENSITY * sqrt(forward * forward + sideways * sideways)
    side = -side_area * pressure * sideways
    return AirForces(-drag_area * pressure * forward, side, lead * side)


def rolling_resistance(load: Scalar, coefficient: Scalar) -> Scalar:
    """Largest force [N] of the rolling resistance at a load [N]; it holds a wheel at rest on a slight grade.

    The coefficient is 0.008 to 0.015 on asphalt.
    Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., section 2.1: F = f Fz.
    """
    return coefficient * load


def holding_friction(
    speed: Scalar, driving: Scalar, greatest: Scalar, inertia: Scalar, stopping_time: Scalar
) -> Scalar:
    """Dry friction [N or N*m] that stops a body, then holds it against the driving force, without reversing its motion.

    Args:
        driving: sum of all other forces or torques on it [N or N*m]
        greatest: largest friction of the brake or the bearing, not negative [N or N*m]
        stopping_time: time constant with which the remaining speed decays [s]; above half the step of an integration

    Coulomb's law in motion, equilibrium at rest: while the friction suffices, the speed obeys v' = -v/T, so that it
    decays without a change of sign and nothing creeps. The result is subtracted in a balance.
    """
    return limit(driving + inertia / stopping_time * speed, -greatest, greatest)


@dataclass(frozen=True)
class Tyre:
    """One tyre, with the parameters of the Magic Formula.

    The defaults are assumed for a 205/55 R16 summer tyre: stiffness and friction in the range of published sets
    (for example pKy1 21.9, pKx1 22.3, pDy1 1.05, C 1.35 of the ADAMS handbook tyre that CommonRoad prints), relaxation
    length and pneumatic trail in the range of Pacejka, 3rd ed., ch. 4 and 5.
    """

    radius: Annotated[float, "m", POSITIVE] = 0.31
    nominal_load: Annotated[float, "N", POSITIVE] = 4500.0
    cornering_stiffness: Annotated[float, "1/rad", POSITIVE] = 23.5
    load_of_greatest: Annotated[float, "", POSITIVE] = 2.0
    longitudinal_stiffness: Annotated[float, "", POSITIVE] = 25.0
    friction: Annotated[float, "", POSITIVE] = 1.0
    longitudinal_friction: Annotated[float, "", POSITIVE] = 1.1
    load_sensitivity: Annotated[float, "", Range(-0.5, 0.0)] = -0.10
    shape: Annotated[float, "", Range(1.0, 2.0)] = 1.38
    curvature: Annotated[float, "", Range(-10.0, 1.0)] = -0.3
    trail: Annotated[float, "m", NOT_NEGATIVE] = 0.024
    trail_shape: Annotated[float, "", Range(0.5, 1.5)] = 1.15
    lateral_relaxation: Annotated[float, "m", POSITIVE] = 0.40
    longitudinal_relaxation: Annotated[float, "m", POSITIVE] = 0.20
    damping_time: Annotated[float, "s", NOT_NEGATIVE] = 0.003
    greatest_slip: Annotated[float, "", POSITIVE] = 0.30
    pressure: Annotated[float, "Pa", POSITIVE] = 2.2e5
    twist_angle: Annotated[float, "rad", POSITIVE] = math.radians(2.0)
    # rolled distance over which it fades; less than half the contact length, since while rolling only the width of the
    # brush patch resists turning
    twist_length: Annotated[float, "m", POSITIVE] = 0.05
    rolling_coefficient: Annotated[float, "", NOT_NEGATIVE] = 0.010

    def stiffness(self, load: float) -> float:
        """Cornering stiffness at a load [N/rad]."""
        return load * stiffness_per_load(load, self.nominal_load, self.cornering_stiffness, self.load_of_greatest)


SUMMER = Tyre()
WINTER = replace(
    SUMMER,
    cornering_stiffness=18.0,
    longitudinal_stiffness=20.0,
    friction=0.88,
    lateral_relaxation=0.46,
    trail=0.026,
    rolling_coefficient=0.012,
)
"""Soft blocks with sipes: a quarter less stiff than the summer tyre, less adhesion on a dry road. Assumed."""
WORN = replace(
    SUMMER,
    cornering_stiffness=27.5,
    longitudinal_stiffness=31.0,
    friction=0.90,
    lateral_relaxation=0.42,
    trail=0.022,
    rolling_coefficient=0.009,
)
"""Old, hard tyre with little tread: stiffer, with less adhesion. Assumed."""
LOW_PRESSURE = replace(
    SUMMER,
    cornering_stiffness=20.0,
    load_of_greatest=1.7,
    lateral_relaxation=0.48,
    longitudinal_relaxation=0.24,
    trail=0.030,
    pressure=1.5e5,
    twist_angle=math.radians(2.6),
    rolling_coefficient=0.014,
)
"""Inflation pressure a third too low: a soft carcass and a long contact patch. Assumed."""
SPORT = replace(
    SUMMER,
    cornering_stiffness=29.0,
    load_of_greatest=2.3,
    longitudinal_stiffness=30.0,
    friction=1.10,
    lateral_relaxation=0.30,
    longitudinal_relaxation=0.16,
    trail=0.020,
    pressure=2.5e5,
    twist_angle=math.radians(1.6),
)
"""Wide tyre with low side walls: stiff, with short relaxation lengths and a short patch. Assumed."""
TYRES = {"summer": SUMMER, "winter": WINTER, "worn": WORN, "low pressure": LOW_PRESSURE, "sport": SPORT}
"""Tyres by the name of their kind, the noise factor of a study."""

LEAST_ADHESION = 0.01  # Lower bound of the adhesion, which keeps the slip normalised by the friction finite [-]
TREAD_LAG = 1e-3
"""Time constant of the tread relative to the rim, which keeps spinning or locked wheels stable at steps of 1 ms [s]."""
REVERSING = 0.1  # Speed range in which the trail changes sign, since the patch rolls backwards when reversing [m/s]


class Hub(NamedTuple):
    """Steering angle of a wheel, and the velocity of its contact point along and across it."""

    sine: Scalar
    cosine: Scalar
    along: Scalar
    across: Scalar

    def to_body(self, along: Scalar, across: Scalar) -> tuple[Scalar, Scalar]:
        """Transform a force from the axes of the wheel to those of the body."""
        return self.cosine * along - self.sine * across, self.sine * along + self.cosine * across


def hub(angle: Scalar, along_body: Scalar, across_body: Scalar) -> Hub:
    """Motion of the hub of a wheel.

    Args:
        angle: steering angle, magnitude below 90 degrees [rad]
        along_body, across_body: velocity of the contact point in the axes of the body [m/s]
    """
    sine = sin(angle)
    cosine = sqrt(1.0 - sine * sine)
    return Hub(sine, cosine, cosine * along_body + sine * across_body, cosine * across_body - sine * along_body)


class Contact(NamedTuple):
    """Forces of one tyre in the axes of its wheel [N], its trail [m], and the rates of its deflections [m/s].

    `slip` is the tangent of the slip angle that acts, `friction` the maximum lateral force divided by the load.
    """

    longitudinal_force: Scalar
    lateral_force: Scalar
    trail: Scalar
    longitudinal_rate: Scalar
    lateral_rate: Scalar
    slip: Scalar
    friction: Scalar


def contact(
    tyre: Tyre,
    load: Scalar,
    adhesion: Scalar,
    hub: Hub,
    rolling_speed: Scalar,
    longitudinal_deflection: Scalar,
    deflection: Scalar,
) -> Contact:
    """Forces and deflection rates of the contact patch of a tyre.

    Args:
        load: vertical load, not negative [N]
        adhesion: adhesion of the road; 1 is the road to which the coefficients refer [-]
        rolling_speed: angular speed times effective radius [m/s]
        longitudinal_deflection, deflection: deflections of the carcass, along and across [m]
    """
    driving, sliding = rolling_speed - hub.along, -hub.across
    # The mean square of travelling and rolling speed keeps locked and spinning wheels relaxing.
    squared = 0.5 * (hub.along * hub.along + rolling_speed * rolling_speed)
    speed = relaxation_speed(squared, driving * driving + sliding * sliding, tyre.greatest_slip)
    length, side = tyre.longitudinal_relaxation, tyre.lateral_relaxation
    longitudinal_rate = bounded_relaxation_rate(longitudinal_deflection, driving, speed, length, TREAD_LAG)
    lateral_rate = bounded_relaxation_rate(deflection, sliding, speed, side, TREAD_LAG)
    along = (longitudinal_deflection + tyre.damping_time * longitudinal_rate) / length
    across = (deflection + tyre.damping_time * lateral_rate) / side
    # Pacejka, 3rd ed., section 4.3.2: mu = pD1 + pD2 (Fz - Fz0)/Fz0.
    at_load = tyre.friction + tyre.load_sensitivity * (load / tyre.nominal_load - 1.0)
    friction = maximum(adhesion, LEAST_ADHESION) * at_load
    stiffness = stiffness_per_load(load, tyre.nominal_load, tyre.cornering_stiffness, tyre.load_of_greatest)
    forces = combined_forces(
        (along, across),
        (tyre.longitudinal_stiffness, stiffness),
        (tyre.longitudinal_friction * friction, friction),
        load,
        tyre.shape,
        tyre.curvature,
    )
    lever = trail(load, tyre.nominal_load, tyre.trail, forces.angle, tyre.trail_shape)
    lever = lever * limit(hub.along / REVERSING, -1.0, 1.0)
    return Contact(forces.longitudinal, forces.lateral, lever, longitudinal_rate, lateral_rate, across, friction)
