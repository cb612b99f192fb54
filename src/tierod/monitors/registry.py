"""Every monitor there is, by name."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping

from tierod.monitors.harness.session import Monitor

_PLACES = {
    "friction": "friction.definition:FRICTION",
    "hysteresis": "hysteresis.definition:HYSTERESIS",
    "sideslip": "sideslip.definition:SIDESLIP",
    "driver-torque": "driver_torque.definition:DRIVER_TORQUE",
    "motor-angle": "motor_angle.definition:MOTOR_ANGLE",
    "condition": "condition.definition:CONDITION",
}
"""Where each is defined, in this package."""


class _Monitors(Mapping[str, Monitor]):
    """Loads a monitor when it is asked for: one that is not run costs no time."""

    def __getitem__(self, name: str) -> Monitor:
        module, _, monitor = _PLACES[name].partition(":")
        return getattr(importlib.import_module(f"tierod.monitors.{module}"), monitor)

    def __iter__(self) -> Iterator[str]:
        return iter(_PLACES)

    def __len__(self) -> int:
        return len(_PLACES)


MONITORS: Mapping[str, Monitor] = _Monitors()
"""By name, as given on the command line."""
