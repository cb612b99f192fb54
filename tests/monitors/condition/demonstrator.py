"""The demonstrator as its vehicle file gives it, and motions of it in closed form."""

import math

import numpy as np

from tierod.monitors.condition.signals import ConditionSample
from tierod.vehicles import load
from tierod_lab.papers.condition.rules.parameters import CarParameters

CAR = load("smartload").parameters_for(CarParameters)


def circle(radius=20.0, speed=6.0, seconds=5.0, **changed):
    """Columns of ConditionSample of a slow circle without slip; `changed` replaces signals by constants."""
    time = np.arange(round(seconds * 100.0)) / 100.0
    yaw = speed / radius
    values = dict.fromkeys(ConditionSample._fields, 0.0) | {
        "wheel_speed_rear_left": yaw * (radius - CAR.track_width / 2),
        "wheel_speed_rear_right": yaw * (radius + CAR.track_width / 2),
        "yaw_rate": yaw,
        "steering_wheel_angle": math.atan((CAR.front_distance + CAR.rear_distance) / radius) / CAR.steering_ratio,
        "longitudinal_acceleration": -yaw * yaw * CAR.rear_distance,
        "lateral_acceleration": yaw * speed,
        "target_vehicle_speed": speed,
    }
    values |= changed
    return np.stack([np.full(len(time), values[name]) for name in ConditionSample._fields], axis=1)
