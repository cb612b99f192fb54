"""Seeds of the reported motor drives; they change whenever the judged monitor changes."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.block import Block
from tierod.vehicles import load
from tierod_lab.papers.seeds import ReportedSeeds


def _judged() -> Sequence[Block]:
    from tierod.monitors.motor_angle.definition import MotorAngleMonitor
    from tierod.monitors.motor_angle.observer import MotorAngleObserver

    vehicle, sample_time = load("motor-bench"), 1e-4
    commanded = MotorAngleObserver.of_vehicle(vehicle, sample_time, commanded=True)
    return MotorAngleMonitor.of_vehicle(vehicle, sample_time), commanded


SEEDS = ReportedSeeds(
    _judged,
    {
        "the observers side by side": 0,
        "a load that steps": 10,
        "what a step costs": 20,
        "in the car": 30,
        "three angles": 60,
        "parameters from a drive": 400,
        "motors that differ": 700,
        "guaranteed intervals": 900,
        "temperature": 1000,
        "faults while turning": 2000,
        "faults by speed": 2100,
        "faults anywhere": 2600,
        "standing": 3000,
        "a warmer winding": 4000,
        "voltages as commanded": 4900,
        "fault-free drives": 10_000,
        "salient motors": 40_000,
        "faults of salient motors": 40_100,
        "fault-free salient motors": 41_000,
    },
    "the monitor of the motor's angle and its observer of commanded voltages",
)
