"""What a filter expects of the readings of one sample, and what it sees in them."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from tierod.monitors.condition.bank.updates import Correction


class Readings(NamedTuple):
    """One number per sensor, in its unit or about it."""

    wheel_speed_rear_left: Annotated[float, "m/s"]
    wheel_speed_rear_right: Annotated[float, "m/s"]
    yaw_rate: Annotated[float, "rad/s"]
    steering_wheel_angle: Annotated[float, "rad"]
    steering_shaft_torque: Annotated[float, "N*m"]
    tie_rod_force: Annotated[float, "N"]


class Surprise(NamedTuple):
    """Squared innovation over its variance of every sensor, before any reading of the sample; 0 where missing."""

    wheel_speed_rear_left: Annotated[float, ""]
    wheel_speed_rear_right: Annotated[float, ""]
    yaw_rate: Annotated[float, ""]
    steering_wheel_angle: Annotated[float, ""]
    steering_shaft_torque: Annotated[float, ""]
    tie_rod_force: Annotated[float, ""]


class Seen(NamedTuple):
    """What one sample said.

    Args:
        expected: readings, before any of the sample
        rows: their derivatives by the state
        innovations: readings less the expected ones
        used: whether they count
        spread: variance of the first six innovations
        correction: by all that count
    """

    expected: Any
    rows: Any
    innovations: tuple[Any, ...]
    used: Any
    spread: tuple[Any, ...]
    correction: Correction
