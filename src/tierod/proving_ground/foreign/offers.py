"""Signals that can be inputs of a unit that computes a vehicle, and signals that can be its outputs."""

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
"""Outputs of the driver: torque on the steering wheel, or angle and rate of the arms; requested force along the road,
or its drive and brake parts, both not negative."""

ASSIST = "motor_torque"
"""Torque request of the assist unit to its motor [N*m]."""

ASSIST_READS = ("driver_torque", "vehicle_speed", "steering_wheel_angle", "steering_wheel_rate")
"""Signals that the assist unit reads, each through a port."""

SPEED = ("truth_speed", "vehicle_speed")
"""Channels of the speed, in order of preference."""

_GROUPS: Mapping[str, Any] = {"road": Road, "wind": Wind, "demand": Demand}


@cache
def offered() -> dict[str, str]:
    """Unit of every signal that can be an input of a unit, by name, without "ports.NAME.gain" and the like."""
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
    """Unit of every channel that can be an output of a unit, by name, including the true values of signals."""
    known: dict[str, str | None] = {name: each.unit for name, each in SIGNALS.items()}
    known |= {f"truth_{name}": each.unit for name, each in SIGNALS.items()}
    return known | dict(zip(Body._fields, units(Body), strict=True))
