"""The monitor of the motor's sensor: faults on the bench and in the car, and fault-free hours."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.monitors.motor_angle.definition import MotorAngleMonitor
from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod.monitors.motor_angle.plausibility import (
    MOTOR,
    NONE,
    NOT_MOTOR,
    PINION,
    WHEEL,
    AnglePlausibility,
    Superposition,
    VariableGain,
    WhichAngle,
)
from tierod.vehicles import load
from tierod_lab.ground import courses
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.faults import AtTime, Drift, Fault, Offset, Stuck
from tierod_lab.ground.faults.behaviours import AnyBehaviour
from tierod_lab.ground.run import run
from tierod_lab.papers.motor_angle.bench import FAULTS, RATE, clean_drive, noisy
from tierod_lab.papers.motor_angle.fault_trials import AlarmWatch, begin, found, other_motor
from tierod_lab.papers.motor_angle.observer_datasets import CAR
from tierod_lab.studies.metrics import Row

LONG = 60.0  # Duration of a fault-free drive [s]
MOTORS = 3
"""Motors, each with its own noise, that share one simulated drive, since the bench takes as long as the monitor."""


def faults(seed: int) -> list[Row]:
    """At a random instant at which the motor turns, a fault begins inside the loop and is watched for 1.5 s.

    A delay runs from when the fault is as large as five degrees electrical to the first alarm of any test: from the
    clock, and of time in which the motor turned so fast that its currents show the angle. Between two strokes it
    stands, and without an induced voltage no current of a motor without saliency shows its angle.
    """
    begun = begin(seed)
    outcomes = {} if begun is None else {fault.name: found(begun, fault) for fault in FAULTS}
    return [
        {"fault": name, "found": float(np.isfinite(each.delay)), **each._asdict()} for name, each in outcomes.items()
    ]


def fault_free(seed: int) -> list[Row]:
    """Fault-free drives of a minute on the bench, every one with a motor that differs from the vehicle file."""
    clean = clean_drive(seed, LONG)
    rows: list[Row] = []
    for motor in range(MOTORS):
        seen = noisy(clean, np.random.default_rng([seed, 11, motor]))
        outputs = scan(AlarmWatch(other_motor(seed * MOTORS + motor)), seen.samples)
        hours, alarmed = float(outputs["known"].sum()) / RATE / 3600.0, float(outputs["alarmed"][-1] > 0.5)
        rows.append({"turning_hours": hours, "alarmed": alarmed})
    return rows


COURSES = {"slalom": 24.0, "parking": 36.0}  # Duration of a drive by course [s]
ANGLES = {
    "motor": ("motor_angle_mechanical", 22.5),
    "wheel, in the loop": ("steering_wheel_angle", 1.0),
    "wheel, recorded": ("sensor.steering_wheel_angle", 1.0),
    "pinion": ("pinion_angle", 1.0),
}
"""Element of a fault, and factor of its magnitude over that at the pinion, by name of the angle."""
KINDS: dict[str, tuple[type, float | None]] = {"offset": (Offset, 0.06), "drift": (Drift, 0.03), "stuck": (Stuck, None)}
"""Behaviour of a fault, and its size at the pinion [rad], [rad/s]."""
CODES = {NONE: "none", MOTOR: "motor", WHEEL: "wheel", PINION: "pinion", NOT_MOTOR: "not the motor"}
"""Name of a fault hypothesis by its code."""
OWN_TESTS = ("angle", "speed", "backwards", "stuck", "not_following", "electrical.angle_gradient")
"""Tests of the motor's sensor itself."""


class AngleCase(NamedTuple):
    """A drive with a fault of a kind in an angle; fault-free where the angle is empty."""

    course: str
    seed: int
    angle: str = ""
    kind: str = ""


def three_angles(case: AngleCase) -> list[Row]:
    """The pinion turns by motor / i_M + wheel / i_D, less the twist of the torsion bar (eq 1); one sensor is faulty.

    In a slalom and a parking manoeuvre it gets an offset of 0.06 rad, a drift of 0.03 rad/s at the pinion, or is stuck.
    Motion blames the angle that stood still or jumped. The observer of the motor is a fourth estimate, and the variable
    ratio (eq 4), which the control follows, a fifth.
    """
    seconds = COURSES[case.course]
    start = float(np.round(np.random.default_rng([case.seed, 21]).uniform(7.0, 0.6 * seconds), 3))
    faulty = _angle_fault(case, start)
    drive = run(catalogue.load(CAR).block, courses.load(case.course), seconds, case.seed, faults=faulty)
    outputs = scan(_plausibility_monitor(), _samples_of(drive.recording))
    alarm, at = outputs["alarms.plausibility"] > 0.5, round(start * RATE)
    late = np.flatnonzero(alarm[at:])
    motion, suspect = (_mostly(outputs[f"plausible.{name}"][alarm]) for name in ("by_motion", "suspect"))
    if len(late) and any((outputs[f"alarms.{name}"][at : at + late[0]] > 0.5).any() for name in OWN_TESTS):
        suspect = CODES[MOTOR]
    true = case.angle.partition(",")[0]
    vague = suspect == "none" or (suspect == "not the motor" and true != "motor")
    return [
        {
            "angle": case.angle,
            "kind": case.kind,
            "found": float(bool(case.angle) and len(late) > 0),
            "delay": float(late[0]) / RATE if len(late) and case.angle else np.inf,
            "by_motion": float(motion == true),
            "named": float(suspect == true),
            "not_wrong": float(suspect == true or vague),
            "early": float(alarm[: at if case.angle else None].any()),
        }
    ]


def _mostly(codes: np.ndarray) -> str:
    """Name of the most frequent fault hypothesis; "none" where there was none."""
    # Code 0, no hypothesis, does not count.
    counts = np.bincount(codes.astype(int), minlength=2)[1:]
    return CODES[float(np.argmax(counts) + 1) if counts.any() else NONE]


def _angle_fault(case: AngleCase, start: float) -> tuple[Fault, ...]:
    if not case.angle:
        return ()
    element, larger = ANGLES[case.angle]
    kind, size = KINDS[case.kind]
    behaviour: AnyBehaviour = kind() if size is None else kind(size * larger)
    return (Fault(element, behaviour, AtTime(start)),)


def _samples_of(recording: Recording) -> np.ndarray:
    """Samples of the monitor on its grid; NaN where a slower signal has no reading."""
    length = max(len(recording[name].time) for name in ("motor_current_alpha", "motor_voltage_alpha"))
    samples = np.full((length, len(MotorAngleSample._fields)), np.nan)
    for column, name in enumerate(MotorAngleSample._fields):
        if name in recording:
            channel = recording[name]
            places = np.round(channel.time * RATE).astype(int)
            kept = places < length
            samples[places[kept], column] = channel.values[kept]
    return samples


def _plausibility_monitor() -> MotorAngleMonitor:
    vehicle = load(CAR)
    gear, gain = vehicle.parameters_for(Superposition), vehicle.parameters_for(VariableGain)
    plausibility = AnglePlausibility(gear, 1.0 / RATE, gain=gain, which=WhichAngle(1.0 / RATE))
    return MotorAngleMonitor.of_vehicle(vehicle, 1.0 / RATE, plausibility)
