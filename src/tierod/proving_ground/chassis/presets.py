"""Chassis of known cars; a mid-size one is what `TwoTrack` is without arguments."""

from __future__ import annotations

from tierod.proving_ground.chassis.suspension import Axle, Kingpins
from tierod.proving_ground.chassis.two_track import TwoTrack
from tierod.proving_ground.chassis.tyres import Tyre


def demonstrator() -> TwoTrack:
    """The light electric demonstrator of Li, Frey and Gauterin, a car at a scale of 1 to 1.5.

    Source: Table A1 of the paper for mass, yaw inertia, distances, track and wheel radius. The cornering stiffness is
    35 kN/rad an axle, as usual for these loads; the printed 322 kN/rad would be some ten times that. Everything about
    roll, and the scrub radius, is assumed.
    """
    tyre = Tyre(
        radius=0.243, nominal_load=1000.0, cornering_stiffness=26.0, lateral_relaxation=0.3, trail=0.018, pressure=2.0e5
    )
    return TwoTrack(
        mass=403.2,
        yaw_inertia=548.3,
        front_distance=0.904,
        rear_distance=1.166,
        centre_height=0.35,
        roll_inertia=70.0,
        drag_area=0.5,
        side_area=2.5,
        side_force_lead=0.3,
        front=Axle(1.084, 0.03, 14e3, 700.0, 0.0, 0.45, tyre),
        rear=Axle(1.084, 0.05, 11e3, 600.0, 0.0, 0.40, tyre),
        kingpins=Kingpins(mechanical_trail=0.02, scrub_radius=0.05, inclination=0.1),
    ).with_axle_stiffness(35e3, 35e3)
