"""Scenarios that are driven in a moment, and that fail in every way a test wants; importable by worker processes."""

import os
import signal
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.vehicles import load
from tierod_lab.campaign.matrix import Point
from tierod_lab.campaign.plan import Cell, Judge, Plan, drive_key, reference_drives
from tierod_lab.ground.faults.behaviours import Offset
from tierod_lab.ground.faults.fault import Fault

NAMES = (
    "steering_wheel_angle",
    "steering_wheel_rate",
    "driver_torque",
    "motor_torque",
    "yaw_rate",
    "lateral_acceleration",
)


@dataclass(frozen=True)
class Outcome:
    recording: Recording
    diverged_at: float | None
    windows: tuple


@dataclass(frozen=True)
class Toy:
    gain: float = 1.0


@dataclass(frozen=True)
class ToyScenario:
    """A sine of steering with some noise; `course` says what goes wrong."""

    course: str = "well"
    seed: int = 1
    faults: tuple = ()
    duration: float = 20.0
    car: Toy = Toy()
    sensors: tuple = ()
    scatter: None = None
    files: tuple = ()

    def with_run(self, seconds=None, seed=None):
        return replace(self, duration=seconds or self.duration, course="well")

    @property
    def provenance(self):
        return {"course": self.course, "seed": self.seed}

    def run(self, progress=lambda share: None):
        progress(0.5)
        if self.course == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.course == "refused":
            raise ParameterError("the toy has no wheels; give it some")
        if self.course == "defect":
            raise ZeroDivisionError("division by zero")
        generator = np.random.default_rng(self.seed)
        end = self.duration if self.course != "diverges" else 0.5 * self.duration
        time = np.arange(round(100.0 * end)) / 100.0
        channels = [Channel("vehicle_speed", time, 20.0 + 0.1 * generator.standard_normal(len(time)), "m/s")]
        for name in NAMES[: -1 if self.course == "poor" else None]:
            values = np.sin(time) + 0.1 * generator.standard_normal(len(time))
            channels.append(Channel(name, time, values, SIGNALS[name].unit))
        recording = Recording({channel.name: channel for channel in channels}, {"seed": self.seed})
        windows = tuple({"name": "step", "start": 10.0, "end": self.duration} for _ in self.faults)
        return Outcome(recording, end if self.course == "diverges" else None, windows)


FAULT = Fault("yaw_rate", Offset(0.1))


def plan(*scenarios, learns=False, keep=True, variant="pre-sliding", settling=50.0):
    """A plan with a cell for each scenario; those with faults are faulty."""
    points = [
        Point({"fault": "step" if s.faults else "fault-free", "size": "", "seed": str(n)}, (), s.seed)
        for n, s in enumerate(scenarios)
    ]
    references = reference_drives(points, ()) if learns else [None] * len(points)
    cells = [
        Cell(point, scenario, drive_key(scenario), reference)
        for point, scenario, reference in zip(points, scenarios, references, strict=True)
    ]
    judge = Judge("friction", "friction", variant, load("midsize-eps"), learns)
    return Plan(cells, (judge,), settling, keep)
