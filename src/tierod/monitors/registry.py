"""Every monitor there is, by name."""

from __future__ import annotations

from collections.abc import Mapping

from tierod.monitors.driver_torque.definition import DRIVER_TORQUE
from tierod.monitors.friction.definition import FRICTION
from tierod.monitors.hysteresis.definition import HYSTERESIS
from tierod.monitors.motor_angle.definition import MOTOR_ANGLE
from tierod.monitors.session import Monitor
from tierod.monitors.sideslip.definition import SIDESLIP

MONITORS: Mapping[str, Monitor] = {
    monitor.name: monitor for monitor in (FRICTION, HYSTERESIS, SIDESLIP, DRIVER_TORQUE, MOTOR_ANGLE)
}
"""By name, as given on the command line."""
