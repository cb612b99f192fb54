"""Virtual cars drawn over the classes, each with its brochure data and its true parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tierod.core.fields import numbers, replaced
from tierod.physics.motion import understeer_gradient
from tierod.vehicles import classes
from tierod.vehicles.vehicle import Vehicle
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.courses.roads import AnyRoad, City, Country, Motorway
from tierod_lab.ground.steering.rack_eps import RackEps
from tierod_lab.papers.own_car.brochure import brochure_car, with_values
from tierod_lab.papers.own_car.shapes import quadricycle, van

BROCHURE_MASS = 0.05  # Relative standard deviation of the mass in a brochure about the mass as driven


@dataclass(frozen=True)
class Base:
    """A virtual car around which cars are drawn."""

    kind: str  # name of its class
    block: Callable[[], Any]  # function that builds the car
    roads: tuple[AnyRoad, ...] = (City(), Country(), Motorway())  # kinds of road that it drives on


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
"""Base cars. Large and quadricycle have rear drive, large, van and one midsize rack EPS, the others column EPS."""


class Spread(NamedTuple):
    """Relative standard deviations of parameters over the cars of a class, about as large as those of `tierod new`.

    They are a little smaller where the virtual cars of a class already differ from its typical values.
    """

    mass: float = 0.07
    yaw_inertia: float = 0.09
    stiffness: float = 0.18
    ratio: float = 0.05
    damping: float = 0.35
    friction: float = 0.2
    front_share: float = 0.03


FURTHER: Mapping[float, tuple[tuple[str, ...], ...]] = {
    0.25: (("chassis.kingpins.mechanical_trail", "chassis.front.tyre.trail"), ("steering.wheel_damping",)),
    0.22: (("chassis.front.tyre.lateral_relaxation", "chassis.rear.tyre.lateral_relaxation"),),
    0.15: (("steering.wheel_inertia",),),
    0.10: (("steering.torsion_bar.stiffness", "assist.bar_stiffness"), ("steering.motor.ratio", "assist.motor_ratio")),
    0.05: (("chassis.centre_height",),),
}
"""Further relative standard deviations, and the groups of paths that share one factor.

The assist scales with its torsion bar and gear, since it is designed for them.
"""

LEAST_UNDERSTEER = 1e-3  # Least understeer gradient of a drawn car [rad*s**2/m], half a degree per g

SENSOR_FORWARD = 0.25  # Standard deviation of the longitudinal position of the inertial unit [m]


@dataclass(frozen=True)
class UnknownCar:
    """A virtual car and the vehicle files for it."""

    name: str  # number and class
    block: Any  # the simulated car
    brochure: Vehicle  # vehicle file from the brochure
    true: Vehicle  # the same with the true values of all parameters that the plant has, at standard deviation 0
    roads: tuple[AnyRoad, ...]  # kinds of road that it drives on

    def friction_over_level(self, load: float) -> float:
        """Ratio of the gear friction at a load to that at the reference load.

        Args:
            load: torque of the road at the steering wheel [N*m]
        """
        steering = self.block.steering
        return 1.0 + float(steering.friction.load_share) * (load / float(steering.reference_load) - 1.0)


def drawn(number: int, seed: int, spread: Spread | None = None) -> UnknownCar:
    """Draw a car; successive numbers run through the classes.

    Args:
        number: number of the car, from 0
        spread: spread within a class; the default `Spread` where None
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
    # Axle stiffnesses and yaw inertia scale with the mass, as in the rules of the classes.
    moved = replace(
        chassis,
        mass=lighter * chassis.mass,
        yaw_inertia=lighter * factor(share.yaw_inertia) * chassis.yaw_inertia,
        front_distance=(1.0 - front) * wheelbase,
        rear_distance=front * wheelbase,
    )
    moved = moved.with_axle_stiffness(*_stable(moved, [lighter * each for each in stiffness], factor, share.stiffness))
    ratio = factor(share.ratio) * block.steering.linkage.ratio
    block = replace(block, chassis=moved, driver=_knowing(block.driver, moved, ratio))
    known, damping = numbers(block), factor(share.damping)
    changes = {f"steering.{each}": damping for each in ("damping", "pinion_damping", "rack_damping", "motor.damping")}
    changes |= {"steering.friction.level": factor(share.friction)}
    block = replaced(block, {path: by * known[path].value for path, by in changes.items() if path in known})
    block = replaced(block, {"steering.linkage.ratio": ratio})
    block = replaced(block, _further(block, factor))
    block = replaced(block, {"inertial_unit.forward": SENSOR_FORWARD * float(chance.standard_normal())})
    name = f"{number + 1} {base.kind}"
    brochure = brochure_car(name, base.kind, factor(BROCHURE_MASS) * moved.mass, round(wheelbase, 2))
    return UnknownCar(name, block, brochure, with_values(brochure, true_values(block)), base.roads)


def _stable(chassis: Any, usual: Sequence[float], factor: Callable[[float], float], deviation: float) -> list[float]:
    """Cornering stiffness of both axles [N/rad], redrawn until the car understeers, as every production car does."""
    while True:
        front, rear = (factor(deviation) * each for each in usual)
        gradient = understeer_gradient(chassis.mass, chassis.front_distance, chassis.rear_distance, front, rear)
        if gradient >= LEAST_UNDERSTEER:
            return [front, rear]


def _further(block: Any, factor: Callable[[float], float]) -> dict[str, float]:
    known = numbers(block)
    found: dict[str, float] = {}
    for deviation, groups in FURTHER.items():
        for paths in groups:
            by = factor(deviation)
            found |= {path: by * known[path].value for path in paths if path in known}
    return found


def _axle(axle: Any, load: float) -> float:
    return float(axle.stiffness(load))


def _knowing(driver: Any, chassis: Any, ratio: float) -> Any:
    return replace(
        driver,
        mass=chassis.mass,
        wheelbase=chassis.wheelbase,
        rear_distance=chassis.rear_distance,
        steering_ratio=ratio,
        understeer_gradient=chassis.understeer_gradient,
    )


def true_values(block: Any) -> dict[str, float]:
    """True values of the parameters of a vehicle file, in SI units.

    Args:
        block: an `EpsCar` with a two-track chassis
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
        "sensor_forward": block.inertial_unit.forward,
    } | limits(steering.friction.level)


def limits(nominal: float) -> dict[str, float]:
    """Limits of friction by the rules of the classes, from a known fault-free friction [N*m].

    Args:
        nominal: fault-free friction [N*m]
    """
    rules = classes.rules()
    factors = {name: rules[name].values[classes.USUAL] for name in ("rising_friction", "fault_friction")}
    return {"nominal_friction": nominal} | {name: factor * nominal for name, factor in factors.items()}
