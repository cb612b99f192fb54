"""One wheel on the road: what its contact patch does."""

from __future__ import annotations

from typing import Any, NamedTuple

from tierod.core.graph.maths import limit, maximum, sin, sqrt
from tierod.physics.magic_formula import combined_forces, friction_at_load, stiffness_per_load, trail
from tierod.physics.tyre import bounded_relaxation_rate, relaxation_speed
from tierod.proving_ground.chassis.tyres import Tyre

LEAST_ADHESION = 0.01
"""Keeps the slip that is normalised by the friction finite [-]."""

TREAD_LAG = 1e-3
"""Of the tread against the rim [s]: keeps a spinning or locked wheel within what a step of 1 ms can follow."""

REVERSING = 0.1
"""Speed below which the trail changes over to the other side, since the patch then rolls backwards [m/s]."""


class Hub(NamedTuple):
    """Steer of a wheel, and the velocity of its contact point along and across it."""

    sine: Any
    cosine: Any
    along: Any
    across: Any

    def to_body(self, along: Any, across: Any) -> tuple[Any, Any]:
        """A force in the directions of the wheel, in those of the body."""
        return self.cosine * along - self.sine * across, self.sine * along + self.cosine * across


def hub(angle: Any, along_body: Any, across_body: Any) -> Hub:
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

    longitudinal_force: Any
    lateral_force: Any
    trail: Any
    longitudinal_rate: Any
    lateral_rate: Any
    slip: Any
    friction: Any


def contact(
    tyre: Tyre, load: Any, adhesion: Any, hub: Hub, rolling_speed: Any, longitudinal_deflection: Any, deflection: Any
) -> Contact:
    """What the contact patch of a tyre does.

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
