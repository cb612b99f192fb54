"""Plant of small slow cars: four tyres that slide and scrub, steered to 35 degrees, forward and in reverse.

It shares no equation with the monitors: forces of brush-like tyres move a rigid body; wheels read their hubs' speed.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.vehicles.classes import Known
from tierod.vehicles.vehicle import Vehicle
from tierod.vehicles.writer import begun

STEP = 0.002
"""Step of the integration [s]."""
EVERY = 5
"""Steps from one sample to the next: 100 Hz."""
ALL_WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


class SmallCar(NamedTuple):
    """Parameters of the plant."""

    mass: float = 400.0  # [kg]
    inertia: float = 290.0  # [kg*m**2]
    front: float = 0.9  # front, rear, track: distances [m]
    rear: float = 0.8
    track: float = 1.1
    stiffness: float = 14e3  # of one tyre [N/rad]
    friction: float = 0.85  # largest force over load
    ackermann: float = 0.6  # share of Ackermann's difference between the front wheels
    ratio: float = 1.0 / 16.0  # road wheel angle per steering wheel angle
    lag: float = 0.05  # from the steering wheel to the road wheels [s]
    zero: float = 0.03  # standard deviation of the zero of the angle sensor [rad]
    uneven: float = 0.02  # standard deviation of a wheel's speed by the road [m/s]


QUADRICYCLE = SmallCar()
SCALE_CAR = SmallCar(22.0, 1.3, 0.33, 0.32, 0.40, 900.0, 0.8, 0.3, 1.0, 0.04, 0.008, 0.03)
"""A car at a scale of 1:4, whose steering signal is the mean angle of its front wheels."""


def course(seed, wheelbase=1.7, seconds=90.0, fastest=8.0, reverse=False):
    """Speed and road wheel angle over time [m/s], [rad]: halts, walking pace, tight turns; with reverse gear or not."""
    most, chance, time = math.radians(35.0), np.random.default_rng(seed), np.arange(0.0, seconds, STEP)
    knots, speeds, angles, at = [0.0], [0.0], [0.0], 1.0
    while at < seconds:
        halts = chance.random() < 0.25
        direction = -1.0 if reverse and chance.random() < 0.4 else 1.0
        if halts:
            knots += [at, at + chance.uniform(1.0, 3.0)]
            speeds += [0.0, 0.0]
            angles += [angles[-1], chance.uniform(-most, most)]
        elif not reverse or speeds[-1] == 0.0 or speeds[-1] * direction > 0.0:
            speed = chance.choice([chance.uniform(0.4, 1.5), chance.uniform(1.0, 3.0), chance.uniform(2.0, fastest)])
            speed = min(speed, 2.5) if direction < 0.0 else speed
            # The car is steered for 4 m/s**2 at the most, and passes through more where it slows down late.
            bound = min(most, math.atan(4.0 * wheelbase / max(speed, abs(speeds[-1]), 0.5) ** 2))
            knots.append(at)
            speeds.append(direction * speed)
            angles.append(float(np.clip(chance.normal(0.0, bound), -bound, bound)))
        at = knots[-1] + chance.uniform(1.5, 4.0)
    return np.interp(time, knots, speeds), np.interp(time, knots, angles)


def vehicle_of(p, kind="quadricycle"):
    """Vehicle file of a car of which a tape measure and a scale are known."""
    known = {"mass": p.mass, "wheelbase": p.front + p.rear, "track_width": p.track, "steering_ratio": p.ratio}
    _, parameters = begun({name: Known(value, None, "measured") for name, value in known.items()}, kind)
    named = {each.name: each for each in parameters}
    return Vehicle("small", "small car", "typical of its class", (), (), "N*m", named, Path("small.toml"))


def backs_out(forward=1.0):
    """Course of a car that backs out of a parking space, or drives out forward, and goes on through gentle bends."""
    time = np.arange(0.0, 40.0, STEP)
    speed = np.interp(time, [0, 4, 6, 8, 9, 11, 17, 40], [0, 0, -2 * forward, -1.8 * forward, 0, 0, 6, 8])
    out = np.interp(time, [0, 3.5, 6, 8, 9.5, 11], [0, 0, 0.58, 0.5, 0.2, 0.0])
    return speed, out + np.where(time > 13.0, 0.06 * np.sin(0.6 * (time - 13.0)), 0.0)


def driven(cars_courses):
    """Speed along and across, yaw rate and steer of several cars on their courses, simulated together."""
    cars = [car for car, _ in cars_courses]
    p = SmallCar(*(np.array(each, float) for each in zip(*cars, strict=True)))
    wanted, angle = (np.array([each[k] for _, each in cars_courses]).T for k in (0, 1))
    along, across, yaw, steer = (np.zeros(len(cars)) for _ in range(4))
    wheelbase, found = p.front + p.rear, []
    load = {"f": 0.5 * p.mass * 9.81 * p.rear / wheelbase, "r": 0.5 * p.mass * 9.81 * p.front / wheelbase}
    for number in range(len(wanted)):
        if number % EVERY == 0:
            found.append((along, across, yaw, steer))
        steer = steer + STEP / p.lag * (angle[number] - steer)
        push = p.mass * np.clip(8.0 * (wanted[number] - along), -4.0, 3.0)
        force_x, force_y, moment = push, 0.0, 0.0
        for name in ALL_WHEELS:
            side = 0.5 * p.track * (1.0 if "left" in name else -1.0)
            arm, turned = (p.front, wheel_angle(p, steer, side)) if "front" in name else (-p.rear, 0.0)
            u, v = along - side * yaw, across + arm * yaw
            forward, sideways = u * np.cos(turned) + v * np.sin(turned), v * np.cos(turned) - u * np.sin(turned)
            most = p.friction * load[name[0]]
            force = -most * np.tanh(p.stiffness / most * np.arctan2(sideways, np.abs(forward) + 0.25))
            fx, fy = -force * np.sin(turned), force * np.cos(turned)
            force_x, force_y, moment = force_x + fx, force_y + fy, moment + arm * fy - side * fx
        along = along + STEP * (force_x / p.mass + across * yaw)
        across = across + STEP * (force_y / p.mass - along * yaw)
        yaw = yaw + STEP * moment / p.inertia
    return np.array(found).transpose(1, 0, 2)


def wheel_angle(p, steer, side):
    """Angle of a front wheel at a place to the left of the middle [rad]: partly Ackermann's, partly parallel."""
    wheelbase = p.front + p.rear
    curvature = np.tan(steer) / wheelbase
    own = np.arctan(wheelbase * curvature / np.maximum(1.0 - side * curvature, 0.1))
    return steer + p.ackermann * (own - steer)


def recordings(cars_courses, seed, unsigned=False, step=0.01):
    """Recordings of the motion sensors, as a bus carries them: rounded, noisy, with offsets, wheels that end at 0.1.

    Shorter courses end earlier; `unsigned` may be given for each.
    """
    counts = [len(speed) for _, (speed, _) in cars_courses]
    padded = [(car, [np.pad(each, (0, max(counts) - len(each)), "edge") for each in way]) for car, way in cars_courses]
    states, flags = driven(padded), np.broadcast_to(unsigned, len(counts))
    kept = [states[:, : -(-count // EVERY), k] for k, count in enumerate(counts)]
    cars = [car for car, _ in cars_courses]
    return [_recorded(*each, step) for each in zip(cars, kept, range(seed, seed + len(cars)), flags, strict=True)]


def _recorded(p, states, seed, unsigned, step):
    chance, (along, across, yaw, steer) = np.random.default_rng([seed, 7]), states
    time = np.arange(len(along)) * STEP * EVERY

    def read(values, noise, rounded, offset=0.0):
        return np.round((values + offset + noise * chance.standard_normal(len(time))) / rounded) * rounded

    signals = {
        "steering_wheel_angle": (read(steer / p.ratio, 0.0, 0.0017, chance.normal(0.0, p.zero)), "rad"),
        "yaw_rate": (read(yaw, 0.004, 0.001, chance.normal(0.0, 0.003)), "rad/s"),
    }
    for name in ALL_WHEELS:
        side = 0.5 * p.track * (1.0 if "left" in name else -1.0)
        turned = wheel_angle(p, steer, side) if "front" in name else 0.0
        arm = p.front if "front" in name else -p.rear
        speed = (along - side * yaw) * np.cos(turned) + (across + arm * yaw) * np.sin(turned)
        speed = speed * (1.0 + chance.normal(0.0, 0.004))
        speed = np.where(
            np.abs(speed) > 0.1, speed + p.uneven * np.tanh(np.abs(speed)) * chance.standard_normal(len(time)), 0.0
        )
        speed = np.round((np.abs(speed) if unsigned else speed) / step) * step
        signals[f"wheel_speed_{name}"] = speed, "m/s"
    signals["vehicle_speed"] = 0.5 * (signals["wheel_speed_rear_left"][0] + signals["wheel_speed_rear_right"][0]), "m/s"
    return Recording({name: Channel(name, time, values, unit) for name, (values, unit) in signals.items()})
