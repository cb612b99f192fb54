"""What the printed observers of a motor's angle share: their sample, their outputs, and how they begin."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Any

from tierod.core.block import named_tuple
from tierod.core.graph.maths import both, present, where
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.angle import wrapped

Sample = MotorAngleObserver.Sample

AXES = ("own", "measured")
"""By which angle Park's transform turns: the observer's own, or the sensor's, as printed."""

UNITS = {
    "motor_angle": "rad",
    "motor_speed": "rad/s",
    "motor_load_torque": "N*m",
    "angle_residual_electrical": "rad",
    "standing": "",
    "nis": "",
}

WIDEST = 0.3
"""Electrical angle between two samples [rad], up to which a vector is carried on while samples are missing."""


@lru_cache(maxsize=32)
def output_class(*extras: str) -> type:
    """Class of an output: angle, speed, what else is told, and how the sensor differs (electrical)."""
    names = ("motor_angle", "motor_speed", *extras, "angle_residual_electrical")
    return named_tuple("Output", [(name, Annotated[float, UNITS[name]]) for name in names])


def fresh(begun: Any, sample: Any) -> Any:
    """Whether this sample is the first one that tells an angle."""
    return both(begun < 0.5, present(sample.motor_angle_mechanical))


def residual(begun: Any, sample: Any, angle: Any, pole_pairs: Any) -> Any:
    """Electrical angle of the sensor less the observer's [rad]; zero until that has begun."""
    return where(begun, wrapped(pole_pairs * (sample.motor_angle_mechanical - angle)), 0.0)
