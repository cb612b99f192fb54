"""Fault-free drives of the bench with motors that differ from the vehicle file: false alarms and residuals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar, Tree
from tierod.core.graph import scan
from tierod.core.graph.maths import greatest_of, maximum
from tierod.monitors.motor_angle.definition import MotorAngleMonitor
from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.fault_drives import RATE, clean_drive, noisy
from tierod_lab.papers.motor_angle.observer_drives import FLUX, INDUCTANCE, RESISTANCE, with_true
from tierod_lab.studies.effort import Effort

SECONDS = 60.0
"""Duration of a drive [s]."""
MOTORS = 3
"""Motors, each with its own noise, that share one simulated drive, since the bench takes as long as the monitor."""
STEPS = (0.819173, 0.671044, 0.549700)
"""Increments of an additive recurrence that fills three ranges evenly: powers of 1/1.220744, root of x^4 = x + 1."""


@dataclass(frozen=True)
class AlarmWatch:
    """A monitor reduced to the outputs that a count of false alarms needs.

    Args:
        monitor: the monitor
    """

    monitor: MotorAngleMonitor

    Sample = MotorAngleSample

    class State(NamedTuple):
        monitor: Tree
        alarmed: Scalar

    class Output(NamedTuple):
        known: Annotated[float, ""]
        alarmed: Annotated[float, ""]
        residual: Annotated[float, "rad"]
        counts: Annotated[float, ""]

    def init(self) -> State:
        return self.State(self.monitor.init(), 0.0)

    def step(self, state: State, sample: MotorAngleSample) -> tuple[State, Output]:
        after, output = self.monitor.step(state.monitor, sample)
        alarmed = maximum(state.alarmed, greatest_of(*output.alarms.in_order()))
        return self.State(after, alarmed), self.Output(
            output.compared.known, alarmed, output.estimate.angle_residual_electrical, output.compared.counts
        )


class HealthyDrive(NamedTuple):
    """Result of one fault-free drive.

    Args:
        turning: time with a valid angle [s]
        alarmed: whether any test alarmed
        residuals: residuals that counted, one per millisecond, electrical [rad]
    """

    turning: float
    alarmed: bool
    residuals: np.ndarray


@dataclass(frozen=True)
class HealthyDrives:
    """Fault-free drives, each with its own motor.

    Args:
        drives: results in the order of their seeds
        seconds: duration of each drive [s]
    """

    drives: tuple[HealthyDrive, ...]
    seconds: float

    @property
    def hours(self) -> float:
        """Duration of all drives [h]."""
        return len(self.drives) * self.seconds / 3600.0

    @property
    def turning(self) -> float:
        """Total time with a valid angle [h]."""
        return sum(drive.turning for drive in self.drives) / 3600.0

    @property
    def alarms(self) -> int:
        """Number of drives with an alarm of any test."""
        return sum(drive.alarmed for drive in self.drives)

    @property
    def greatest(self) -> float:
        """Largest residual that counted, electrical [rad]."""
        return max(float(np.abs(drive.residuals).max(initial=0.0)) for drive in self.drives)

    def records(self, first: int, last: int, scale: float = 1.0) -> list[np.ndarray]:
        """Residuals of the drives from `first` to before `last`, times a scale [rad]."""
        return [scale * drive.residuals.astype(float) for drive in self.drives[first:last] if len(drive.residuals)]


def healthy_drives(courses: int, first: int, effort: Effort, seconds: float = SECONDS) -> HealthyDrives:
    """Simulate fault-free drives.

    Args:
        courses: number of courses, each driven by `MOTORS` motors
        first: first seed
        effort: runs the drives
        seconds: duration of each drive [s]

    Raises:
        TierodError: a drive failed
    """
    tasks = [(seed, seconds) for seed in range(first, first + courses)]
    made = effort.made(_drives, tasks)
    return HealthyDrives(tuple(drive for drives in made for drive in drives), seconds)


def other_motor(monitor: MotorAngleMonitor, number: int) -> MotorAngleMonitor:
    """The monitor with the parameters of another motor.

    Args:
        monitor: monitor with the parameters of the vehicle file
        number: number of the motor; successive numbers fill all three ranges evenly, by an additive recurrence
    """
    p = monitor.observer.parameters
    shares = [(0.5 + number * step) % 1.0 for step in STEPS]
    resistance, flux, inductance = (
        low + share * (high - low) for (low, high), share in zip((RESISTANCE, FLUX, INDUCTANCE), shares, strict=True)
    )
    assumed = with_true(p, resistance, flux, inductance)
    return replace(monitor, observer=replace(monitor.observer, parameters=assumed))


@cache
def bench_monitor() -> MotorAngleMonitor:
    """The monitor of the bench, with the parameters of its vehicle file."""
    return MotorAngleMonitor.of_vehicle(load("motor-bench"), 1.0 / RATE)


def _drives(task: tuple[int, float]) -> list[HealthyDrive]:
    seed, seconds = task
    clean, drives = clean_drive(seed, seconds), []
    for motor in range(MOTORS):
        random = np.random.default_rng([seed, 11, motor])
        watch = AlarmWatch(other_motor(bench_monitor(), seed * MOTORS + motor))
        found = scan(watch, noisy(clean, random).samples)
        kept = found["residual"][found["counts"] > 0.5].astype(np.float32)
        drives.append(HealthyDrive(float(found["known"].sum()) / RATE, bool(found["alarmed"][-1]), kept))
    return drives
