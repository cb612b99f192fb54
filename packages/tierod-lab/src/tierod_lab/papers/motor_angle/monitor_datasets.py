"""The monitor of the motor's sensor: faults on the bench and in the car, fault-free hours, salient motors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.methods.detectors.stopping_rules import AverageRule, CusumRule, HoldRule, SequentialRule, StoppingRule
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
from tierod_lab.papers.motor_angle.bench import FLUX, RATE, RESISTANCE, clean_drive, noisy, rms
from tierod_lab.papers.motor_angle.fault_trials import AlarmWatch, Trial, anywhere, begin, found, other_motor
from tierod_lab.papers.motor_angle.observer_datasets import CAR
from tierod_lab.papers.motor_angle.salient_bench import (
    RIGHT,
    Assumed,
    fast_drive,
    found_on_salient,
    salient_drive,
    salient_monitor,
)
from tierod_lab.papers.motor_angle.sensor_faults import FAULTS, offset
from tierod_lab.studies.metrics import Row

LONG = 60.0  # Duration of a fault-free drive [s]
MOTORS = 3
"""Motors, each with its own noise, that share one simulated drive, since the bench takes as long as the monitor."""


def faults(trial: Trial) -> list[Row]:
    """At a random instant at which the motor turns, a fault begins inside the loop and is watched for 1.5 s.

    A delay runs from when the fault is as large as five degrees electrical to the first alarm of any test: from the
    clock, and of time in which the motor turned so fast that its angle was known. Between two strokes it stands. Drives
    have many speeds up to some 100 rad/s, or one of those named.
    """
    begun = begin(trial)
    outcomes = {} if begun is None else {fault.name: found(begun, fault) for fault in FAULTS}
    return [
        {"fault": name, "speed": trial.speed, "found": float(np.isfinite(each.delay)), **each._asdict()}
        for name, each in outcomes.items()
    ]


def faults_anywhere(task: tuple[str, int]) -> list[Row]:
    """Faults that stall the drive, begun at any instant: standing, reversing, and in the first seconds."""
    name, seed = task
    each = anywhere(next(fault for fault in FAULTS if fault.name == name), seed)
    return [{"fault": name, "found": float(np.isfinite(each.delay)), **each._asdict()}]


def fault_free(seed: int) -> list[Row]:
    """Fault-free drives of a minute on the bench, every one with a motor that differs from the vehicle file."""
    clean = clean_drive(seed, LONG)
    rows: list[Row] = []
    for motor in range(MOTORS):
        seen = noisy(clean, np.random.default_rng([seed, 11, motor]))
        outputs = scan(AlarmWatch(other_motor(seed * MOTORS + motor)), seen.samples)
        rows.append(_watched(outputs["known"], outputs["alarmed"]))
    return rows


def _watched(known: np.ndarray, alarmed: np.ndarray) -> Row:
    return {"turning_hours": float(known.sum()) / RATE / 3600.0, "alarmed": float(alarmed[-1] > 0.5)}


RULES: tuple[StoppingRule, ...] = (
    CusumRule(0.25),
    CusumRule(0.5),
    CusumRule(1.0),
    AverageRule(0.1),
    HoldRule(3),
    SequentialRule(1.0),
)


def run_length(task: tuple[int, float, int]) -> list[Row]:
    """Stopping rules on white residuals: samples between false alarms, as designed and as simulated."""
    number, wanted, samples = task
    rule = RULES[number]
    threshold = rule.threshold_for(wanted)
    values = np.random.default_rng(number).normal(size=samples)
    alarms = rule.alarms(scan(rule.block(threshold, 1.0, restart=True), values)["alarm"])
    length = samples / alarms if alarms else np.nan
    miss = 100.0 * abs(length / wanted - 1.0)
    return [{"rule": rule.name, "wanted": wanted, "alarms": alarms, "length": length, "miss": miss}]


class Course(NamedTuple):
    """A drive of a salient motor: ratio, seed, what the vehicle file has wrong, and whether it is fast."""

    ratio: float
    seed: int
    wrong: str = "nothing"
    fast: bool = False


WRONG = {
    "nothing": RIGHT,
    "along the flux 5 % high": Assumed(direct=1.05),
    "across the flux 5 % high": Assumed(quadrature=1.05),
    "across the flux 10 % high": Assumed(quadrature=1.1),
    "resistance 20 % low": Assumed(resistance=0.8),
    "flux 4 % high": Assumed(flux=1.04),
}
"""Errors of the vehicle file by name."""


def salient(course: Course) -> list[Row]:
    """Motors with more inductance across the flux than along it, under a load that steps by up to 1.6 N·m.

    Fast drives turn at up to 165 rad/s on 11 V, where the drive weakens the flux. Only a wrong inductance across the
    flux moves the angle; resistance and flux are learnt.
    """
    seen = (fast_drive if course.fast else salient_drive)(course.ratio, course.seed, 20.0)
    outputs = scan(salient_monitor(course.ratio, WRONG[course.wrong]), seen.samples)
    away = (outputs["estimate.motor_angle"] - seen.angle)[round(2.0 * RATE) :]
    return [{"ratio": course.ratio, "wrong": course.wrong, "fast": float(course.fast), "rms": rms(away)}]


def salient_offsets(task: tuple[float, int, float]) -> list[Row]:
    """An offset of five degrees electrical on a salient motor, begun while its angle is known."""
    ratio, seed, degrees = task
    each = found_on_salient(ratio, seed, offset(degrees))
    return [] if each is None else [{"ratio": ratio, **each._asdict()}]


def salient_fault_free(seed: int) -> list[Row]:
    """Fault-free minutes of salient motors that differ at random from the vehicle file; one in five is fast."""
    random = np.random.default_rng([seed, 19])
    ratio = float(random.uniform(1.0, 3.0))
    spans = ((0.95, 1.05), (0.95, 1.05), RESISTANCE, FLUX)
    assumed = Assumed(*(1.0 / float(random.uniform(*span)) for span in spans))
    seen = (fast_drive if random.random() < 0.2 else salient_drive)(ratio, seed, LONG)
    outputs = scan(AlarmWatch(salient_monitor(ratio, assumed)), seen.samples)
    return [_watched(outputs["known"], outputs["alarmed"])]


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
    outputs = scan(_plausibility_monitor(), samples_of(drive.recording))
    alarm, at = outputs["alarms.plausibility"] > 0.5, round(start * RATE)
    late = np.flatnonzero(alarm[at:])
    motion, suspect = (_mostly(outputs[f"plausible.{name}"][alarm]) for name in ("by_motion", "suspect"))
    if len(late) and any((outputs[f"alarms.{name}"][at : at + late[0]] > 0.5).any() for name in OWN_TESTS):
        suspect = CODES[MOTOR]
    until = at if case.angle else len(alarm)
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
            "early": float(alarm[:until].any()),
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


def samples_of(recording: Recording) -> np.ndarray:
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
