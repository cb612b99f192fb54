"""Chassis by name."""

from __future__ import annotations

from tierod.proving_ground.chassis.suspension import Axle, Kingpins
from tierod.proving_ground.chassis.two_track import TwoTrack
from tierod.proving_ground.chassis.tyres import Tyre


def midsize() -> TwoTrack:
    """A mid-size car, typical values: what `TwoTrack` is without arguments."""
    return TwoTrack()


def demonstrator() -> TwoTrack:
    """The light electric demonstrator of Li, Frey and Gauterin, its front wheels driven one by one.

    Mass, distances, track, wheel radius and yaw inertia as printed there in Table A1; the cornering stiffness printed
    (322 kN/rad an axle) is ten times too much for its loads, here 35 and 32 kN/rad result. All else is assumed; the
    scrub radius is large enough for a difference of the wheel torques to steer.
    """
    tyre = Tyre(
        radius=0.243,
        nominal_load=1100.0,
        cornering_stiffness=21.5,
        trail=0.018,
        lateral_relaxation=0.25,
        longitudinal_relaxation=0.12,
        pressure=2.0e5,
        rolling_coefficient=0.012,
    )
    return TwoTrack(
        mass=403.2,
        yaw_inertia=548.3,
        front_distance=0.904,
        rear_distance=1.166,
        centre_height=0.45,
        roll_inertia=90.0,
        drag_area=0.5,
        side_area=2.5,
        side_force_lead=0.2,
        front=Axle(1.084, 0.06, 12e3, 450.0, 2.3e-6, 0.40, tyre),
        rear=Axle(1.084, 0.08, 9e3, 350.0, 0.0, 0.25, tyre),
        kingpins=Kingpins(0.015, 0.04, 0.16),
    )


CHASSIS = {"midsize": midsize, "demonstrator": demonstrator}
"""Functions that give a chassis, by name."""
