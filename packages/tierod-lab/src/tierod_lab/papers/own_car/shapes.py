"""Virtual cars of two classes that the proving ground does not ship: a quadricycle and a van."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from tierod.core.fields import replaced
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.chassis import TwoTrack, Tyre
from tierod_lab.ground.chassis.two_track import Axle, Kingpins


def _light_chassis() -> TwoTrack:
    """A light quadricycle with two seats: 450 kg, short, narrow tyres of low pressure, rear engine; assumed."""
    tyre = Tyre(
        radius=0.25, nominal_load=1100.0, cornering_stiffness=16.0, friction=0.9, lateral_relaxation=0.3, trail=0.015
    )
    return TwoTrack(
        mass=450.0,
        yaw_inertia=305.0,
        front_distance=0.95,
        rear_distance=0.74,
        centre_height=0.6,
        roll_inertia=80.0,
        drag_area=0.7,
        side_area=3.0,
        side_force_lead=0.2,
        front=Axle(1.10, 0.03, 10.6e3, 380.0, 0.0, 0.4, tyre),
        rear=Axle(1.09, 0.06, 8.6e3, 310.0, 0.0, 0.4, tyre),
        kingpins=Kingpins(mechanical_trail=0.015, scrub_radius=0.02, inclination=0.15),
    ).with_axle_stiffness(21.3e3, 29.8e3)


def quadricycle() -> Any:
    """A light quadricycle with rear drive and the column EPS of a small car."""
    car: Any = catalogue.load("small-eps").block
    chassis = _light_chassis()
    radius = chassis.front.tyre.radius
    steering = replace(car.steering, reference_load=1.0)
    steering = replaced(steering, {"friction.level": 1.5, "linkage.reference_load": chassis.front_load})
    powertrain = replace(
        car.powertrain,
        front_share=0.0,
        front_brake_share=0.6,
        wheel_radius=radius,
        greatest_drive_force=1800.0,
        greatest_power=15e3,
        greatest_speed=28.0,
        greatest_brake_force=4500.0,
    )
    return replace(car, chassis=chassis, steering=steering, powertrain=powertrain)


def van() -> Any:
    """A long and high delivery van of 2.6 t with front drive and the rack EPS of the large car."""
    car: Any = catalogue.load("large-rack-eps").block
    chassis = car.chassis
    body = replace(
        chassis,
        mass=2600.0,
        yaw_inertia=6900.0,
        front_distance=1.55,
        rear_distance=1.85,
        centre_height=0.8,
        roll_inertia=1250.0,
        drag_area=1.6,
        side_area=9.0,
        front=replace(chassis.front, track=1.72, roll_stiffness=115e3, roll_damping=6000.0),
        rear=replace(chassis.rear, track=1.70, roll_stiffness=90e3, roll_damping=4800.0),
    ).with_axle_stiffness(135e3, 178e3)
    powertrain = replace(car.powertrain, front_share=1.0, front_brake_share=0.68, greatest_power=110e3)
    steering = replaced(car.steering, {"linkage.ratio": 1.0 / 17.0, "linkage.reference_load": body.front_load})
    return replace(car, chassis=body, steering=steering, powertrain=powertrain)
