"""Seeds of the reported unknown cars; they change whenever one of the judged monitors changes."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.block import Block
from tierod.vehicles import load
from tierod_lab.papers.seeds import ReportedSeeds


def _judged() -> Sequence[Block]:
    """The judged monitors, each with the file of one car; other files change only numbers in the same graph."""
    from tierod.monitors.condition.definition import condition_monitor
    from tierod.monitors.driver_torque.hands import HandsMonitor
    from tierod.monitors.driver_torque.observer import ColumnObserver
    from tierod.monitors.friction.definition import FrictionMonitor
    from tierod.monitors.motor_angle.definition import MotorAngleMonitor
    from tierod.monitors.sideslip.estimator import CombinedSideslip

    car, step = load("midsize-eps"), 0.01
    column = ColumnObserver.of_vehicle(car, step), HandsMonitor.of_vehicle(car, step)
    motion = CombinedSideslip.of_vehicle(car, step), condition_monitor(load("rav4"))
    motor = MotorAngleMonitor.of_vehicle(load("motor-bench"), 1e-4)
    return FrictionMonitor.of_vehicle(car, step), *column, *motion, motor


CARS, MOTORS = "cars and drives", "motors and drives"

SEEDS = ReportedSeeds(
    _judged, {CARS: 0, MOTORS: 1}, "the monitors of friction, hands, sideslip, condition and motor angle"
)
