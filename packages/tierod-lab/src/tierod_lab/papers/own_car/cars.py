"""Virtual cars drawn over the classes, each with its brochure data and its true parameters."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tierod.core.fields import numbers, replaced
from tierod.physics.motion import understeer_gradient
from tierod.vehicles import classes
from tierod.vehicles.vehicle import Vehicle
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.chassis import TwoTrack, Tyre
from tierod_lab.ground.chassis.two_track import Axle, Kingpins
from tierod_lab.ground.courses.roads import AnyRoad, City, Country, Motorway
from tierod_lab.ground.steering.rack_eps import RackEps
from tierod_lab.papers.own_car.brochure import brochure_car, with_values

BROCHURE_MASS = 0.05  # Relative standard deviation of the mass in a brochure about the mass as driven


class Base(NamedTuple):
    """A virtual car around which cars are drawn."""

    kind: str  # name of its class
    block: Callable[[], Any]  # function that builds the car
    roads: tuple[AnyRoad, ...] = (City(), Country(), Motorway())


def _shipped(name: str) -> Any:
    return catalogue.load(name).block


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
    car = _shipped("small-eps")
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
    car = _shipped("large-rack-eps")
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


BASES: tuple[Base, ...] = (
    Base("midsize", lambda: _shipped("midsize-rack-eps")),
    Base("quadricycle", quadricycle, (City(), Country())),
    Base("large", lambda: _shipped("large-rack-eps")),
    Base("small", lambda: _shipped("small-eps")),
    Base("van", van),
    Base("suv", lambda: _shipped("rav4-like")),
    Base("midsize", lambda: _shipped("midsize-eps")),
)
"""Base cars. Large and quadricycle have rear drive, large, van and one midsize rack EPS, the others column EPS."""


SPREAD: tuple[tuple[float, tuple[str, ...]], ...] = (
    (0.05, ("steering.linkage.ratio",)),
    (0.35, ("steering.damping", "steering.pinion_damping", "steering.rack_damping", "steering.motor.damping")),
    (0.2, ("steering.friction.level",)),
    (0.25, ("chassis.kingpins.mechanical_trail", "chassis.front.tyre.trail")),
    (0.25, ("steering.wheel_damping",)),
    (0.22, ("chassis.front.tyre.lateral_relaxation", "chassis.rear.tyre.lateral_relaxation")),
    (0.15, ("steering.wheel_inertia",)),
    (0.10, ("steering.torsion_bar.stiffness", "assist.bar_stiffness")),
    (0.10, ("steering.motor.ratio", "assist.motor_ratio")),
    (0.05, ("chassis.centre_height",)),
)
"""Relative standard deviation over the cars of a class, of paths that share one factor: that of `tierod new`, or a
little smaller where the bases of a class already differ. The assist scales with the bar and gear it is designed for."""

LEAST_UNDERSTEER = 1e-3  # Least understeer gradient of a drawn car [rad*s**2/m], half a degree per g

SENSOR_FORWARD = 0.25  # Standard deviation of the longitudinal position of the inertial unit [m]


@dataclass(frozen=True)
class UnknownCar:
    """A virtual car and the vehicle files for it."""

    name: str  # number and class
    block: Any  # the simulated car
    brochure: Vehicle  # vehicle file from the brochure
    true: Vehicle  # the same with the true values of all parameters that the plant has, at standard deviation 0
    roads: tuple[AnyRoad, ...]

    def friction_over_level(self, load: float) -> float:
        """Ratio of the gear friction at a torque of the road at the steering wheel [N*m] to that at the reference."""
        steering = self.block.steering
        return 1.0 + float(steering.friction.load_share) * (load / float(steering.reference_load) - 1.0)


def drawn(number: int, seed: int) -> UnknownCar:
    """Draw a car; successive numbers run through the classes."""
    base = BASES[number % len(BASES)]
    chance = np.random.default_rng([seed, number])

    def factor(deviation: float) -> float:
        return math.exp(deviation * float(chance.standard_normal()))

    block = base.block()
    chassis = block.chassis
    wheelbase = chassis.front_distance + chassis.rear_distance
    front = chassis.rear_distance / wheelbase + 0.03 * float(chance.standard_normal())
    lighter = factor(0.07)
    # Axle stiffnesses and yaw inertia scale with the mass, as in the rules of the classes.
    usual = [lighter * _axle(chassis.front, chassis.front_load), lighter * _axle(chassis.rear, chassis.rear_load)]
    moved = replace(
        chassis,
        mass=lighter * chassis.mass,
        yaw_inertia=lighter * factor(0.09) * chassis.yaw_inertia,
        front_distance=(1.0 - front) * wheelbase,
        rear_distance=front * wheelbase,
    )
    gradient = -math.inf
    while gradient < LEAST_UNDERSTEER:  # as every production car understeers
        stiffness = [factor(0.18) * each for each in usual]
        gradient = understeer_gradient(moved.mass, moved.front_distance, moved.rear_distance, *stiffness)
    moved = moved.with_axle_stiffness(*stiffness)
    block = replace(block, chassis=moved)
    known, changes = numbers(block), dict[str, float]()
    for deviation, paths in SPREAD:
        by = factor(deviation)
        changes |= {path: by * known[path].value for path in paths if path in known}
    changes["inertial_unit.forward"] = SENSOR_FORWARD * float(chance.standard_normal())
    block = replaced(block, changes)
    names = ("mass", "wheelbase", "rear_distance", "understeer_gradient")
    at_hand = {name: getattr(moved, name) for name in names} | {"steering_ratio": block.steering.linkage.ratio}
    block = replace(block, driver=replace(block.driver, **at_hand))
    name = f"{number + 1} {base.kind}"
    brochure = brochure_car(name, base.kind, factor(BROCHURE_MASS) * moved.mass, round(wheelbase, 2))
    return UnknownCar(name, block, brochure, with_values(brochure, true_values(block)), base.roads)


def _axle(axle: Any, load: float) -> float:
    return float(axle.stiffness(load))


def true_values(block: Any) -> dict[str, float]:
    """True values of the parameters of a vehicle file, in SI units, from an `EpsCar` with a two-track chassis."""
    chassis, steering, tyre = block.chassis, block.steering, block.chassis.front.tyre
    motor, bar = steering.motor, steering.torsion_bar
    if isinstance(steering, RackEps):
        rack = steering.linkage.rack_ratio**2
        inertia = steering.pinion_inertia + steering.rack_mass * rack
        damping = steering.pinion_damping + steering.rack_damping * rack
    else:
        inertia, damping = steering.column_inertia, steering.damping
    inertia += motor.inertia * motor.ratio**2 + steering.linkage.road_wheel_inertia * steering.linkage.ratio**2
    same = ("mass", "yaw_inertia", "front_distance", "rear_distance", "centre_height")
    return {
        **{name: getattr(chassis, name) for name in same},
        "front_cornering_stiffness": _axle(chassis.front, chassis.front_load),
        "rear_cornering_stiffness": _axle(chassis.rear, chassis.rear_load),
        "track_width": chassis.rear.track,
        "tyre_friction": tyre.friction,
        "relaxation_length": tyre.lateral_relaxation,
        "trail": chassis.kingpins.mechanical_trail + tyre.trail * 0.5 * chassis.front_load / tyre.nominal_load,
        "drive_front_share": block.powertrain.front_share,
        "brake_front_share": block.powertrain.front_brake_share,
        "steering_ratio": steering.linkage.ratio,
        "column_inertia": steering.wheel_inertia + inertia,
        "column_damping": steering.wheel_damping + damping + motor.damping * motor.ratio**2,
        **{f"steering_wheel_{name}": getattr(steering, f"wheel_{name}") for name in ("inertia", "damping")},
        "torsion_bar_stiffness": bar.stiffness,
        **{f"motor_{name}": getattr(motor, name) for name in ("ratio", "inertia", "damping")},
        "sensor_forward": block.inertial_unit.forward,
        **limits(steering.friction.level),
    }


def limits(nominal: float) -> dict[str, float]:
    """Limits of friction by the rules of the classes, from a known fault-free friction [N*m]."""
    rules = classes.rules()
    factors = {name: rules[name].values[classes.USUAL] for name in ("rising_friction", "fault_friction")}
    return {"nominal_friction": nominal} | {name: factor * nominal for name, factor in factors.items()}
