"""A car with column steering written for this study alone: it shares no equation and no parameter with tierod.

An elastic shaft connects steering wheel and pinion. The pinion has LuGre or generalised Maxwell slip friction. Tyre
forces saturate by a hyperbolic tangent, and the pneumatic trail falls with slip. The integration step is 0.5 ms.

Sources: Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE TAC 40 (1995) 419 (LuGre); Lampaert, Swevers, Al-Bender, IEEE
TAC 48 (2003) 683 (generalised Maxwell slip); Pacejka, Tyre and Vehicle Dynamics (2006), sections 1.3 and 7.2 (single
track, relaxation, trail); assist by a boost curve as in Mills and Wagner, SAE 2003-01-0585.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

STEP, EVERY = 5e-4, 20  # Step of the integration [s], and number of steps per sample of 100 Hz
LUGRE, MAXWELL = "LuGre", "generalised Maxwell slip"
ELEMENTS = 6  # Number of elements of generalised Maxwell slip
SIGNALS = {
    "steering_wheel_angle": 1e-3,
    "steering_wheel_rate": 0.01,
    "yaw_rate": 3e-3,
    "lateral_acceleration": 0.1,
    "driver_torque": 0.05,
    "motor_torque": 5e-3,
    "vehicle_speed": 0.05,
}
"""Recorded signals, in the order of the columns, with the standard deviation of their noise, in SI units."""


@dataclass(frozen=True)
class RubbingCar:
    """Parameters of the car in SI units; nominal values are typical of a mid-size car of 1.6 t."""

    law: str
    level: float  # friction at high sliding speed
    mass: float = 1600.0
    yaw_inertia: float = 2800.0
    front: float = 1.14  # front, rear: distances of the axles from the centre of gravity
    rear: float = 1.69
    front_stiffness: float = 110e3  # front_stiffness, rear_stiffness: cornering stiffness of the axles
    rear_stiffness: float = 130e3
    grip: float = 0.95  # largest lateral force over the load
    mechanical_trail: float = 0.025
    pneumatic_trail: float = 0.027
    relaxation: float = 0.4  # relaxation length of the front tyres
    ratio: float = 1.0 / 15.5  # ratio, motor_ratio: turns of road wheel and motor per turn of the column
    motor_ratio: float = 20.0
    wheel_inertia: float = 0.035
    pinion_inertia: float = 0.065
    shaft: float = 120.0
    shaft_damping: float = 0.3
    wheel_damping: float = 0.05
    pinion_damping: float = 0.75
    excess: float = 0.1  # relative excess of friction at rest, which decays with the Stribeck velocity
    stribeck: float = 0.3
    build_up: float = math.radians(0.8)  # angle over which friction builds up


class Course(NamedTuple):
    """Reference of the steering wheel angle [rad] and speed [m/s], a value every `STEP`."""

    angle: np.ndarray
    speed: np.ndarray


def course(minutes: float, seed: int) -> Course:
    """Bends of 0.5 to 3 m/s2 in both directions and straights, at 10 to 27 m/s, with small motions of the hands."""
    random = np.random.default_rng([seed, 1])
    count = round(60.0 * minutes / STEP)
    time = STEP * np.arange(count)
    knots, wanted, speeds = [0.0], [0.0], [15.0]
    while knots[-1] < time[-1]:
        knots.append(knots[-1] + random.uniform(1.2, 4.0))
        straight = random.random() < 0.35
        wanted.append(0.0 if straight else float(random.choice([-1.0, 1.0]) * random.uniform(0.5, 3.0)))
        speeds.append(float(np.clip(speeds[-1] + random.normal() * 1.5, 10.0, 27.0)))
    speed = np.interp(time, knots, speeds)
    place = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, len(knots) - 2)
    begin, end = np.array(knots)[place], np.array(knots)[place + 1]
    share = np.clip((time - begin) / np.minimum(end - begin, 1.5), 0.0, 1.0)
    blend = 0.5 - 0.5 * np.cos(np.pi * share)
    lateral = np.array(wanted)[place] * (1.0 - blend) + np.array(wanted)[place + 1] * blend
    curvature = lateral / speed**2
    restless = sum(
        0.01 * random.normal() * np.sin(2.0 * np.pi * frequency * time + random.uniform(0.0, 6.28))
        for frequency in random.uniform(0.2, 1.2, 6)
    )
    return Course(15.5 * curvature * (2.83 + 0.0035 * speed**2) + restless, speed)


def driven(car: RubbingCar, way: Course, seed: int) -> np.ndarray:
    """Simulate the car; returns sensor readings every 10 ms in the order of `SIGNALS`, (n, 7)."""
    friction = _LuGre(car) if car.law == LUGRE else _Maxwell(car)
    count = len(way.angle) // EVERY
    seen = np.empty((count, len(SIGNALS)))
    wheel = wheel_rate = pinion = pinion_rate = lateral = yaw = force = motor = across = 0.0
    angles, speeds = way.angle.tolist(), way.speed.tolist()
    front_load, rear_load = (car.mass * 9.81 * each / (car.front + car.rear) for each in (car.rear, car.front))
    for k in range(count * EVERY):
        speed = speeds[k]
        hand = 30.0 * (angles[k] - wheel) - 2.5 * wheel_rate
        bar = car.shaft * (wheel - pinion) + car.shaft_damping * (wheel_rate - pinion_rate)
        motor += STEP / 0.005 * (_assist(bar, speed) / car.motor_ratio - motor)
        slip = car.ratio * pinion - (lateral + car.front * yaw) / speed
        most = car.grip * front_load
        force += STEP * speed / car.relaxation * (most * math.tanh(car.front_stiffness * slip / most) - force)
        most = car.grip * rear_load
        behind = most * math.tanh(car.rear_stiffness * (car.rear * yaw - lateral) / speed / most)
        trail = car.mechanical_trail + car.pneumatic_trail * max(1.0 - abs(slip) / 0.15, 0.0)
        rubbing = friction.torque(pinion_rate)
        # Semi-implicit Euler: rates first, then angles from the new rates, which keeps the stiff shaft stable.
        across = (force + behind) / car.mass
        pinion_gain = bar + car.motor_ratio * motor - car.ratio * trail * force
        wheel_rate += STEP / car.wheel_inertia * (hand - bar - car.wheel_damping * wheel_rate)
        pinion_rate += STEP / car.pinion_inertia * (pinion_gain - car.pinion_damping * pinion_rate - rubbing)
        wheel += STEP * wheel_rate
        pinion += STEP * pinion_rate
        lateral += STEP * (across - speed * yaw)
        yaw += STEP / car.yaw_inertia * (car.front * force - car.rear * behind)
        if k % EVERY == EVERY - 1:
            seen[k // EVERY] = wheel, wheel_rate, yaw, across, bar, motor, speed
    return seen + np.random.default_rng([seed, 2]).normal(size=seen.shape) * list(SIGNALS.values())


def _assist(bar: float, speed: float) -> float:
    """Torque of the assist at the column [N*m]."""
    above = max(abs(bar) - 0.8, 0.0)
    return math.copysign(min(1.4 * above**1.6 * (0.4 + 9.0 / (speed + 5.0)), 60.0), bar)


def _sliding(car: RubbingCar, rate: float) -> float:
    """Stribeck curve: steady friction at a sliding rate [N*m]."""
    ratio = rate / car.stribeck
    return car.level * (1.0 + car.excess * math.exp(-ratio * ratio))


def sliding_level(car: RubbingCar, rates: np.ndarray) -> float:
    """Mean steady friction over sliding rates [N*m], the truth that an estimate is compared with."""
    return float(np.mean([_sliding(car, float(rate)) for rate in rates]))


class _LuGre:
    def __init__(self, car: RubbingCar):
        self.car, self.stiffness, self.bristle = car, car.level / car.build_up, 0.0
        self.damping = 0.6 * math.sqrt(self.stiffness * car.pinion_inertia)

    def torque(self, rate: float) -> float:
        slope = rate - self.stiffness * abs(rate) / _sliding(self.car, rate) * self.bristle
        self.bristle += STEP * slope
        return self.stiffness * self.bristle + self.damping * slope


class _Maxwell:
    def __init__(self, car: RubbingCar):
        self.car = car
        self.shares = [1.0 / ELEMENTS] * ELEMENTS
        # The stiffnesses are staggered so that the elements slip one after the other, up to twice the build-up angle.
        self.stiffness = [
            car.level / ELEMENTS / (car.build_up * 2.0 * (number + 1) / ELEMENTS) for number in range(ELEMENTS)
        ]
        self.forces = [0.0] * ELEMENTS

    def torque(self, rate: float) -> float:
        level, direction, total = _sliding(self.car, rate), math.copysign(1.0, rate), 0.0
        for number, share in enumerate(self.shares):
            force, limit = self.forces[number], share * level
            sliding = abs(force) >= limit and force * rate > 0.0
            # A slipping element approaches its Stribeck level with the attraction C = 50 levels per second.
            following = 50.0 * self.car.level * (share * direction - force / level)
            slope = following if sliding else self.stiffness[number] * rate
            force += STEP * slope
            if not sliding and abs(force) > limit and force * rate > 0.0:
                force = math.copysign(limit, force)
            self.forces[number] = force
            total += force
        return total
