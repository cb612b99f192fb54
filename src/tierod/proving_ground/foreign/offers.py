"""Signals that we can give a unit that computes a vehicle, and signals that we read of it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from tierod.core.block import leaves, skeleton, units
from tierod.core.signals import SIGNALS
from tierod.proving_ground.cars.body import Body
from tierod.proving_ground.parts import Demand, Port, Road, Wind

DRIVER: Mapping[str, str] = {
    "hand_torque": "N*m",
    "steering_wheel_angle": "rad",
    "steering_wheel_rate": "rad/s",
    "drive_force": "N",
    "traction_force": "N",
    "braking_force": "N",
}
"""What the driver does: torque on the steering wheel, or the angle and rate that the arms have reached; force asked for
along the road, or its two parts, both not negative."""

ASSIST = "motor_torque"
"""What the assist unit asks of its motor [N*m]."""

ASSIST_READS = ("driver_torque", "vehicle_speed", "steering_wheel_angle", "steering_wheel_rate")
"""Signals that the assist unit reads, each through a port."""

SPEED = ("truth_speed", "vehicle_speed")
"""Channels that state the speed, the better first."""

_GROUPS: Mapping[str, Any] = {"road": Road, "wind": Wind, "demand": Demand}


@cache
def offered() -> dict[str, str]:
    """Unit of everything that can be given, by name; "ports.NAME.gain" and the like aside."""
    found: dict[str, str] = {}
    for group, kind in _GROUPS.items():
        names = [f"{group}.{name}" for name, _ in leaves(skeleton(kind))]
        found |= dict(zip(names, units(kind), strict=True))
    return {**found, **DRIVER, ASSIST: "N*m"}


def port_of(name: str) -> str:
    """The port of "ports.NAME.gain" and the like; "" for any other name."""
    parts = name.split(".")
    return parts[1] if len(parts) == 3 and parts[0] == "ports" and parts[2] in Port._fields else ""


@cache
def channels() -> dict[str, str | None]:
    """Unit of every channel that a unit can give, by name; of the truth of a signal too."""
    known: dict[str, str | None] = {name: each.unit for name, each in SIGNALS.items()}
    known |= {f"truth_{name}": each.unit for name, each in SIGNALS.items()}
    return known | dict(zip(Body._fields, units(Body), strict=True))
