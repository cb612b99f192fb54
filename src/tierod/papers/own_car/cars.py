"""Virtual cars drawn over the classes, each with what a brochure says of it, and with its true parameters."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tierod.core.fields import numbers, replaced
from tierod.papers.own_car.brochure import brochure_car, with_values
from tierod.papers.own_car.shapes import quadricycle, van
from tierod.proving_ground.cars import catalogue
from tierod.proving_ground.courses.natural import AnyRoad, City, Country, Motorway
from tierod.proving_ground.steering.rack_eps import RackEps
from tierod.vehicles.vehicle import Vehicle

BROCHURE_MASS = 0.05
"""Relative standard deviation of the mass as driven about that of the brochure."""


@dataclass(frozen=True)
class Base:
    """A virtual car around which cars are drawn.

    Args:
        kind: class as a user names it
        block: makes the car
        roads: that it drives on
    """

    kind: str
    block: Callable[[], Any]
    roads: tuple[AnyRoad, ...] = (City(), Country(), Motorway())


def _shipped(name: str) -> Any:
    return catalogue.load(name).block


BASES: tuple[Base, ...] = (
    Base("midsize", lambda: _shipped("midsize-rack-eps")),
    Base("quadricycle", quadricycle, (City(), Country())),
    Base("large", lambda: _shipped("large-rack-eps")),
    Base("small", lambda: _shipped("small-eps")),
    Base("van", van),
    Base("suv", lambda: _shipped("rav4-like")),
    Base("midsize", lambda: _shipped("midsize-eps")),
)
"""Rear drive and rack EPS: large and quadricycle, large and one midsize; front drive and column EPS the others."""


class Spread(NamedTuple):
    """Relative standard deviations of what differs from car to car of a class; narrower than what a class is given."""

    mass: float = 0.07
    yaw_inertia: float = 0.07
    stiffness: float = 0.12
    ratio: float = 0.05
    damping: float = 0.25
    friction: float = 0.15
    front_share: float = 0.02


@dataclass(frozen=True)
class UnknownCar:
    """A virtual car of which its user knows the brochure.

    Args:
        name: number and class
        block: the truth
        brochure: vehicle file that a user begins
        true: the same with the true values of all that the plant has, and no spread of those
        roads: that it drives on
    """

    name: str
    block: Any
    brochure: Vehicle
    true: Vehicle
    roads: tuple[AnyRoad, ...]


def drawn(number: int, seed: int, spread: Spread | None = None) -> UnknownCar:
    """A car of the class that comes next.

    Args:
        number: from 0 on; classes take turns
        seed: of all chance
        spread: within a class
    """
    base, share = BASES[number % len(BASES)], spread or Spread()
    chance = np.random.default_rng([seed, number])

    def factor(deviation: float) -> float:
        return math.exp(deviation * float(chance.standard_normal()))

    block = base.block()
    chassis = block.chassis
    wheelbase = chassis.front_distance + chassis.rear_distance
    front = chassis.rear_distance / wheelbase + share.front_share * float(chance.standard_normal())
    stiffness = (_axle(chassis.front, chassis.front_load), _axle(chassis.rear, chassis.rear_load))
    lighter = factor(share.mass)
    moved = replace(
        chassis,
        mass=lighter * chassis.mass,
        yaw_inertia=lighter * factor(share.yaw_inertia) * chassis.yaw_inertia,
        front_distance=(1.0 - front) * wheelbase,
        rear_distance=front * wheelbase,
    ).with_axle_stiffness(*(lighter * factor(share.stiffness) * each for each in stiffness))
    ratio = factor(share.ratio) * block.steering.linkage.ratio
    block = replace(block, chassis=moved, driver=_knowing(block.driver, moved, ratio))
    known, damping = numbers(block), factor(share.damping)
    changes = {f"steering.{each}": damping for each in ("damping", "pinion_damping", "rack_damping", "motor.damping")}
    changes |= {"steering.friction.level": factor(share.friction)}
    block = replaced(block, {path: by * known[path].value for path, by in changes.items() if path in known})
    block = replaced(block, {"steering.linkage.ratio": ratio})
    name = f"{number + 1} {base.kind}"
    brochure = brochure_car(name, base.kind, factor(BROCHURE_MASS) * moved.mass, round(wheelbase, 2))
    return UnknownCar(name, block, brochure, with_values(brochure, true_values(block)), base.roads)


def _axle(axle: Any, load: float) -> float:
    return float(axle.stiffness(load))


def _knowing(driver: Any, chassis: Any, ratio: float) -> Any:
    """The driver who knows the car."""
    return replace(
        driver,
        mass=chassis.mass,
        wheelbase=chassis.wheelbase,
        rear_distance=chassis.rear_distance,
        steering_ratio=ratio,
        understeer_gradient=chassis.understeer_gradient,
    )


def true_values(block: Any) -> dict[str, float]:
    """What the plant has of the parameters of a vehicle file, in SI units.

    Args:
        block: an `EpsCar` on two tracks
    """
    chassis, steering, tyre = block.chassis, block.steering, block.chassis.front.tyre
    motor, bar = steering.motor, steering.torsion_bar
    if isinstance(steering, RackEps):
        rack = steering.linkage.rack_ratio**2
        inertia = steering.pinion_inertia + steering.rack_mass * rack
        damping = steering.pinion_damping + steering.rack_damping * rack
    else:
        inertia, damping = steering.column_inertia, steering.damping
    inertia += motor.inertia * motor.ratio**2 + steering.linkage.road_wheel_inertia * steering.linkage.ratio**2
    return {
        "mass": chassis.mass,
        "yaw_inertia": chassis.yaw_inertia,
        "front_distance": chassis.front_distance,
        "rear_distance": chassis.rear_distance,
        "front_cornering_stiffness": _axle(chassis.front, chassis.front_load),
        "rear_cornering_stiffness": _axle(chassis.rear, chassis.rear_load),
        "centre_height": chassis.centre_height,
        "track_width": chassis.rear.track,
        "tyre_friction": tyre.friction,
        "relaxation_length": tyre.lateral_relaxation,
        "trail": chassis.kingpins.mechanical_trail + tyre.trail * 0.5 * chassis.front_load / tyre.nominal_load,
        "drive_front_share": block.powertrain.front_share,
        "brake_front_share": block.powertrain.front_brake_share,
        "steering_ratio": steering.linkage.ratio,
        "column_inertia": steering.wheel_inertia + inertia,
        "column_damping": steering.wheel_damping + damping + motor.damping * motor.ratio**2,
        "steering_wheel_inertia": steering.wheel_inertia,
        "steering_wheel_damping": steering.wheel_damping,
        "torsion_bar_stiffness": bar.stiffness,
        "motor_ratio": motor.ratio,
        "motor_inertia": motor.inertia,
        "motor_damping": motor.damping,
        "nominal_friction": steering.friction.level,
    }
