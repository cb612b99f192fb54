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


TARGET = "target of tierod"
"""Source of the claims that no paper makes."""

SIDE_BY_SIDE, LOAD = "the observers side by side", "a load that steps"
STEP_COST, IN_THE_CAR = "what a step costs", "in the car"
DRAWN, RAMPED, GUARANTEED = "motors that differ", "warm and warming motors", "guaranteed intervals"
STANDING, TEMPERATURE, RESISTANCE, INVERTER = "standing", "temperature", "a warmer winding", "voltages as commanded"
TURNING, BY_SPEED, ANYWHERE = "faults while turning", "faults by speed", "faults anywhere"
THREE_ANGLES, FAULT_FREE = "three angles", "fault-free drives"
SALIENT, SALIENT_FAULTS, SALIENT_HOURS = "salient motors", "faults of salient motors", "fault-free salient motors"
IDENTIFIED = "parameters from a drive"

SEEDS = ReportedSeeds(
    _judged,
    {
        SIDE_BY_SIDE: 0,
        LOAD: 10,
        STEP_COST: 20,
        IN_THE_CAR: 30,
        THREE_ANGLES: 60,
        IDENTIFIED: 400,
        DRAWN: 700,
        RAMPED: 800,
        GUARANTEED: 900,
        TEMPERATURE: 1000,
        TURNING: 2000,
        BY_SPEED: 2100,
        ANYWHERE: 2600,
        STANDING: 3000,
        RESISTANCE: 4000,
        INVERTER: 4900,
        FAULT_FREE: 10_000,
        SALIENT: 40_000,
        SALIENT_FAULTS: 40_100,
        SALIENT_HOURS: 41_000,
    },
    "the monitor of the motor's angle and its observer of commanded voltages",
)
