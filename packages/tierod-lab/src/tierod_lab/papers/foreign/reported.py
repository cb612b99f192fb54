"""Seeds of the reported drives on foreign plants; each follows from the monitor that is judged on it."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.block import Block
from tierod.vehicles import load
from tierod_lab.papers.seeds import ReportedSeeds


def _sensors() -> Sequence[Block]:
    from tierod.monitors.condition.definition import condition_monitor

    return (condition_monitor(load("rav4")),)


def _friction() -> Sequence[Block]:
    from tierod_lab.papers.friction.estimators import monitor

    return (monitor(),)


def _motors() -> Sequence[Block]:
    from tierod.monitors.motor_angle.definition import MotorAngleMonitor

    return (MotorAngleMonitor.of_vehicle(load("motor-bench"), 1e-4),)


CAR, COLUMN, MACHINES = "CommonRoad's car", "a foreign column", "motors of motulator"

SENSORS = ReportedSeeds(_sensors, {CAR: 70_000}, "the condition monitor of rav4")
FRICTION = ReportedSeeds(_friction, {COLUMN: 70_000}, "the friction monitor of midsize-eps")
MOTORS = ReportedSeeds(_motors, {MACHINES: 70_000}, "the motor-angle monitor of motor-bench")
