"""Tyres as data, coefficients of the Magic Formula, and what the contact patch of one wheel does."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, Range
from tierod.core.graph.maths import limit, maximum, sin, sqrt
from tierod.physics.magic_formula import combined_forces, friction_at_load, stiffness_per_load, trail
from tierod.physics.tyre import bounded_relaxation_rate, relaxation_speed


@dataclass(frozen=True)
class Tyre:
    """One tyre, in the parameters of the Magic Formula.

    Defaults are assumed for a 205/55 R16 summer tyre: stiffness and friction in the range of published sets
    (for example pKy1 21.9, pKx1 22.3, pDy1 1.05, C 1.35 of the ADAMS handbook tyre that CommonRoad prints), relaxation
    length and pneumatic trail in the range that Pacejka, 3rd ed., ch. 4 and 5, shows.

    Args:
        radius: effective rolling radius
        nominal_load: to which the coefficients belong, Fz0
        cornering_stiffness: greatest one over nominal load, pKy1
        load_of_greatest: load of the greatest cornering stiffness over nominal load, pKy2
        longitudinal_stiffness: over load, pKx1
        friction: greatest lateral force over load at nominal load on a road of adhesion 1, pDy1
        longitudinal_friction: greatest longitudinal over greatest lateral force
        load_sensitivity: of the friction, pDy2
        shape, curvature: C and E of the forces
        trail: pneumatic trail at nominal load without slip
        trail_shape: Ct
        lateral_relaxation, longitudinal_relaxation: rolled distances over which the forces build up
        damping_time: carcass damping over its stiffness, which calms a standing car
        greatest_slip: slip of a tyre that slides without rolling
        pressure: of inflation, for the scrub torque at standstill
        twist_angle: angle over which the scrub torque of a standing tyre builds up
        twist_length: rolled distance over which it fades; less than the half contact length, since of a turning brush
            patch only what its width gives resists while rolling
        rolling_coefficient: of the rolling resistance
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
"""Soft blocks with sipes: a quarter less stiff than the summer tyre, less grip on a dry road. Assumed."""

WORN = replace(
    SUMMER,
    cornering_stiffness=27.5,
    longitudinal_stiffness=31.0,
    friction=0.90,
    lateral_relaxation=0.42,
    trail=0.022,
    rolling_coefficient=0.009,
)
"""Old, hard and with little tread: stiffer, with less grip. Assumed."""

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
"""A third of the pressure missing: a soft carcass and a long contact patch. Assumed."""

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
"""Wide, with low side walls: stiff, quick, a short patch. Assumed."""

TYRES = {"summer": SUMMER, "winter": WINTER, "worn": WORN, "low pressure": LOW_PRESSURE, "sport": SPORT}
"""Kinds of tyre by name, the noise factor of a study."""


LEAST_ADHESION = 0.01
"""Keeps the slip that is normalised by the friction finite [-]."""

TREAD_LAG = 1e-3
"""Of the tread against the rim [s]: keeps a spinning or locked wheel within what a step of 1 ms can follow."""

REVERSING = 0.1
"""Speed below which the trail changes over to the other side, since the patch then rolls backwards [m/s]."""


class Hub(NamedTuple):
    """Steer of a wheel, and the velocity of its contact point along and across it."""

    sine: Scalar
    cosine: Scalar
    along: Scalar
    across: Scalar

    def to_body(self, along: Scalar, across: Scalar) -> tuple[Scalar, Scalar]:
        """A force in the directions of the wheel, in those of the body."""
        return self.cosine * along - self.sine * across, self.sine * along + self.cosine * across


def hub(angle: Scalar, along_body: Scalar, across_body: Scalar) -> Hub:
    """The hub of a wheel.

    Args:
        angle: steer [rad], within a quarter turn
        along_body, across_body: velocity of the contact point in the directions of the body [m/s]
    """
    sine = sin(angle)
    cosine = sqrt(1.0 - sine * sine)
    return Hub(sine, cosine, cosine * along_body + sine * across_body, cosine * across_body - sine * along_body)


class Contact(NamedTuple):
    """Forces of one tyre in the directions of its wheel [N], its trail [m], and the rates of its deflections [m/s].

    `slip` is the tangent of the slip angle that acts, `friction` the greatest lateral force over load.
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
    """Forces and rates of the contact patch of a tyre.

    Args:
        tyre: its coefficients
        load: vertical load [N], not negative
        adhesion: of the road; 1 is the road to which the coefficients belong [-]
        hub: motion of the contact point
        rolling_speed: rotation times effective radius [m/s]
        longitudinal_deflection, deflection: of the carcass, along and across [m]
    """
    driving, sliding = rolling_speed - hub.along, -hub.across
    squared = 0.5 * (hub.along * hub.along + rolling_speed * rolling_speed)
    speed = relaxation_speed(squared, driving * driving + sliding * sliding, tyre.greatest_slip)
    longitudinal_rate = bounded_relaxation_rate(
        longitudinal_deflection, driving, speed, tyre.longitudinal_relaxation, TREAD_LAG
    )
    lateral_rate = bounded_relaxation_rate(deflection, sliding, speed, tyre.lateral_relaxation, TREAD_LAG)
    slips = (
        (longitudinal_deflection + tyre.damping_time * longitudinal_rate) / tyre.longitudinal_relaxation,
        (deflection + tyre.damping_time * lateral_rate) / tyre.lateral_relaxation,
    )
    friction = maximum(adhesion, LEAST_ADHESION) * friction_at_load(
        load, tyre.nominal_load, tyre.friction, tyre.load_sensitivity
    )
    stiffness = stiffness_per_load(load, tyre.nominal_load, tyre.cornering_stiffness, tyre.load_of_greatest)
    forces = combined_forces(
        slips,
        (tyre.longitudinal_stiffness, stiffness),
        (tyre.longitudinal_friction * friction, friction),
        load,
        tyre.shape,
        tyre.curvature,
    )
    lever = trail(load, tyre.nominal_load, tyre.trail, forces.angle, tyre.trail_shape)
    lever = lever * limit(hub.along / REVERSING, -1.0, 1.0)
    return Contact(forces.longitudinal, forces.lateral, lever, longitudinal_rate, lateral_rate, slips[1], friction)
