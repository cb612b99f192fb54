"""Plausibility of the angles of motor, steering wheel and pinion: detection and isolation of a faulty one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_least, exactly
from tierod.core.content import Heading, Item, Table
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
from tierod_lab.papers.motor_angle.fault_drives import RATE
from tierod_lab.papers.motor_angle.figures import CAR
from tierod_lab.papers.motor_angle.reported import SEEDS, THREE_ANGLES
from tierod_lab.studies.effort import Effort

COURSES = {"slalom": 24.0, "parking": 36.0}
"""Duration of a drive by course [s]."""
RATIO = 22.5
"""Turns of the motor per turn of the pinion, the factor of faults of its sensor [-]."""
NAMED = 0.9
"""Goal for the share of detected faults that are isolated; two angles that differ do not show which one is wrong."""
SIZE, RAMP = 0.06, 0.03
"""Fault magnitudes at the pinion: offset [rad] and drift [rad/s]."""
CODES = {NONE: "none", MOTOR: "motor", WHEEL: "wheel", PINION: "pinion", NOT_MOTOR: "not the motor"}
"""Name of a fault hypothesis by its code."""
ANGLES = {
    "motor": ("motor_angle_mechanical", RATIO),
    "wheel, in the loop": ("steering_wheel_angle", 1.0),
    "wheel, recorded": ("sensor.steering_wheel_angle", 1.0),
    "pinion": ("pinion_angle", 1.0),
}
"""Element of a fault, and factor of its magnitude over that at the pinion, by name of the angle."""
OWN_TESTS = ("angle", "speed", "backwards", "stuck", "not_following", "electrical.angle_gradient")
"""Tests of the motor's sensor itself."""
KINDS = ("offset", "drift", "stuck")


class Case(NamedTuple):
    """A drive with a fault of a kind in an angle; fault-free where the angle is empty."""

    course: str
    seed: int
    angle: str = ""
    kind: str = ""


class Findings(NamedTuple):
    """Results of the plausibility check over a drive.

    Args:
        delay: detection delay [s]; infinite without an alarm
        motion: most frequent fault hypothesis during the alarm by motion alone
        suspect: the same with the observer and the variable ratio; "motor" where a test of its own alarmed before
        largest: largest disagreement at the pinion before the fault [rad]
        early: whether the check alarmed before the fault
    """

    delay: float
    motion: str
    suspect: str
    largest: float
    early: bool


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Which of three angles is wrong",
        (
            "The pinion turns by motor / i_M + wheel / i_D, less the twist of the torsion bar (eq 1). In a slalom and "
            f"a parking manoeuvre one sensor gets an offset of {SIZE:g} rad, a drift of {RAMP:g} rad/s, or is stuck, "
            "at a random instant; sizes are at the pinion, those of the motor's 22.5 times as large. Faults of motor "
            "and wheel are inside the loop, so that the superposition follows them; the wheel's also in the recording "
            "alone.",
            "Motion blames the angle that stood still or jumped. The observer of the motor is a fourth estimate, and "
            "the variable ratio (eq 4), which the control follows, a fifth.",
        ),
    )
    seeds = SEEDS.of(THREE_ANGLES, 1 if effort.quick else 3)
    chosen = {"slalom": COURSES["slalom"]} if effort.quick else COURSES
    fault_free = effort.made(findings_of, [Case(course, seed) for course in chosen for seed in seeds])
    kinds = [(angle, kind) for angle in ANGLES for kind in KINDS]
    cases = [Case(course, seed, angle, kind) for angle, kind in kinds for course in chosen for seed in seeds]
    found = dict(zip(cases, effort.made(findings_of, cases), strict=True))
    groups = {pair: [each for case, each in found.items() if (case.angle, case.kind) == pair] for pair in kinds}
    yield _table(groups)
    yield from _claims(groups, fault_free)


def findings_of(case: Case) -> Findings:
    """Simulate a drive, and evaluate the plausibility check of the monitor."""
    seconds = COURSES[case.course]
    start = float(np.round(np.random.default_rng([case.seed, 21]).uniform(7.0, 0.6 * seconds), 3))
    recording = run(
        catalogue.load(CAR).block, courses.load(case.course), seconds, case.seed, faults=_faults(case, start)
    ).recording
    samples, monitor = _samples(recording), _monitor()
    found = scan(monitor, samples)
    alarm, begin = found["alarms.plausibility"] > 0.5, round(start * RATE)
    late = np.flatnonzero(alarm[begin:])
    delay = float(late[0]) / RATE if len(late) and case.angle else np.inf
    motion, suspect = (_mostly(found[f"plausible.{name}"][alarm]) for name in ("by_motion", "suspect"))
    sooner = len(late) and any((found[f"alarms.{name}"][begin : begin + late[0]] > 0.5).any() for name in OWN_TESTS)
    until = begin if case.angle else len(alarm)
    largest, early = float(np.abs(found["plausible.mismatch"][:until]).max()), bool(alarm[:until].any())
    return Findings(delay, motion, CODES[MOTOR] if sooner else suspect, largest, early)


def _mostly(codes: np.ndarray) -> str:
    # Code 0, no hypothesis, does not count.
    counts = np.bincount(codes.astype(int), minlength=2)[1:]
    return CODES[float(np.argmax(counts) + 1) if counts.any() else NONE]


def _faults(case: Case, start: float) -> tuple[Fault, ...]:
    if not case.angle:
        return ()
    element, larger = ANGLES[case.angle]
    kinds: dict[str, AnyBehaviour] = {
        "offset": Offset(SIZE * larger),
        "drift": Drift(RAMP * larger),
        "stuck": Stuck(),
    }
    return (Fault(element, kinds[case.kind], AtTime(start)),)


def _samples(recording: Recording) -> np.ndarray:
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


def _monitor() -> MotorAngleMonitor:
    vehicle = load(CAR)
    gear, gain = vehicle.parameters_for(Superposition), vehicle.parameters_for(VariableGain)
    plausibility = AnglePlausibility(gear, 1.0 / RATE, gain=gain, which=WhichAngle(1.0 / RATE))
    return MotorAngleMonitor.of_vehicle(vehicle, 1.0 / RATE, plausibility)


def _right(angle: str, suspect: str) -> bool:
    return suspect == angle.partition(",")[0]


def _not_wrong(angle: str, suspect: str) -> bool:
    return _right(angle, suspect) or suspect == "none" or (suspect == "not the motor" and angle != "motor")


def _table(groups: dict[tuple[str, str], list[Findings]]) -> Table:
    rows = []
    for (angle, kind), found in groups.items():
        delays = np.array([each.delay for each in found])
        alarmed = [each for each in found if np.isfinite(each.delay)]
        named = Counter(each.suspect for each in alarmed).most_common()
        rows.append(
            (
                f"{angle}: {kind}",
                f"{len(alarmed)} of {len(found)}",
                f"{np.median(delays):.2f}" if len(alarmed) > len(found) / 2 else "∞",
                f"{sum(_right(angle, each.motion) for each in alarmed)}",
                f"{sum(_right(angle, each.suspect) for each in alarmed)}",
                ", ".join(f"{name} {count}" for name, count in named),
            )
        )
    header = ("fault", "found", "median [s]", "named by motion", "named with all", "named")
    return Table("Faults of one of three angles", header, tuple(rows), "Found by eq (1), the other tests left out.")


def _unnamed(groups: dict[tuple[str, str], list[Findings]]) -> str:
    counts = {
        f"{angle}, {kind}": (sum(not _right(angle, each.suspect) for each in alarmed), len(alarmed))
        for (angle, kind), found in groups.items()
        if (alarmed := [each for each in found if np.isfinite(each.delay)])
    }
    return "; ".join(f"{name} {missed} of {count}" for name, (missed, count) in counts.items() if missed)


def _claims(groups: dict[tuple[str, str], list[Findings]], fault_free: list[Findings]) -> Iterator[Claim]:
    alarmed = [(angle, each) for (angle, _), found in groups.items() for each in found if np.isfinite(each.delay)]
    motion = np.mean([_right(angle, each.motion) for angle, each in alarmed])
    named = np.mean([_right(angle, each.suspect) for angle, each in alarmed])
    harmless = np.mean([_not_wrong(angle, each.suspect) for angle, each in alarmed])
    source = "target of tierod"
    yield Claim(
        "angles.named",
        "Of the found faults the right angle is named, with the observer and the variable ratio.",
        source,
        None,
        float(named),
        at_least(NAMED),
        "",
        f"{motion:.2f} by motion alone; of {len(alarmed)}",
        cause=f"Not named rightly: {_unnamed(groups)}. Which of two angles is off shows only while the motion, or the "
        "observer of the motor, is more exact than the fault.",
    )
    yield Claim(
        "angles.not-misled",
        "No wrong angle is named: the right one, none, or two of which one is right.",
        source,
        None,
        float(harmless),
        at_least(0.95),
    )
    late = [each for each in [*fault_free, *(each for found in groups.values() for each in found)] if each.early]
    most = max(each.largest for each in fault_free)
    yield Claim(
        "angles.none-false",
        "No alarm of the three angles in fault-free drives, nor before a fault.",
        source,
        None,
        float(len(late)),
        exactly(0.0),
        "",
        f"{len(fault_free)} fault-free drives; they disagree by {most:.4f} rad at most, 0.02 rad alarm",
    )
