"""The semantic attack: one or two signals of a recording are wrong, and no verdict may be confidently wrong.

Of a changed faulty recording exit 0 must name a changed signal; of a changed fault-free one so must exit 1.
"""

from __future__ import annotations

import io
import itertools
import re
import time
import traceback
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from attack.semantic_drives import DRIVES, Drive, changed, changes, recorded, touched
from tierod.core.errors import TierodError
from tierod.core.findings import Diagnosis, Status
from tierod.core.recording import Recording
from tierod.monitors.diagnose import diagnose
from tierod.monitors.registry import MONITORS
from tierod.report import print_table

SEEDS = (11, 12)
"""Seeds of the recordings; no threshold was tuned on them."""

REFUSED, DEFECT = 3, 4
"""Exit codes of a recording that is refused, and of a defect of tierod itself."""

UNOBSERVABLE = (
    "driver_torque and motor_torque times one factor: only these two signals have the unit of a torque, so friction "
    "scales with them; each finding of friction says so",
    "all currents and voltages of a motor times one factor: its equations are linear, and the factor is that of the "
    "magnets' flux",
    "all signals late by the same time: nothing in the recording shows when something happened",
)
"""Changes of several signals at once that no signal can show, with the physical reason; no change of one signal is."""

ALIKE = ("sign", "x2", "x0.5", "gain that grows to 2")
"""Changes that scale a signal: of both torques at once nothing shows them."""

CALLED: dict[str, tuple[str, ...]] = {
    "vehicle_speed": ("the speed",),
    "steering_wheel_angle": ("steering angle", "steering wheel's angle"),
    "pinion_angle": ("pinion's angle", "the pinion's"),
    "road_wheel_angle": ("steering angle",),
    "motor_current": ("steering torque",),
    "motor_torque": ("steering torque",),
    "motor_angle_mechanical": ("motor's angle", "angle sensor"),
    "resolver_sine": ("sine and cosine",),
    "resolver_cosine": ("sine and cosine",),
    "supply_voltage": ("supply of the controller",),
    **{f"motor_current_{axis}": ("currents", "a current") for axis in ("a", "b", "c", "alpha", "beta")},
    **{f"motor_voltage_{axis}": ("voltages", "a voltage") for axis in ("alpha", "beta")},
    "wheel_speed_rear_left": ("rear wheel speeds",),
    "wheel_speed_rear_right": ("rear wheel speeds",),
}
"""What findings call a signal besides its name."""

_REFERENCE = ("than currents and voltages give", "that currents and voltages give", "what currents and voltages give")
"""Phrases that mention signals as what others are held against: they name none of them."""


@dataclass(frozen=True)
class Case:
    """Changes of signals of one recording, made one after the other."""

    drive: Drive
    changes: tuple[tuple[str, str], ...]
    seed: int

    @property
    def name(self) -> str:
        """For people."""
        what = " and ".join(f"{signal} {change}" for signal, change in self.changes)
        return f"{self.drive.monitor}, {self.drive.name}, seed {self.seed}: {what}"

    @property
    def touched(self) -> tuple[str, ...]:
        """The signals that are changed."""
        return tuple(dict.fromkeys(name for each in self.changes for name in touched(*each)))

    def recording(self, folder: Path) -> Recording:
        """The changed recording."""
        recording = recorded(self.drive, self.seed, folder)
        for signal, change in self.changes:
            recording = changed(recording, signal, change, self.seed)
        return recording


@dataclass(frozen=True)
class Outcome:
    """What became of a case."""

    code: int
    status: str
    named: bool
    blamed: bool
    text: str
    seconds: float = 0.0


def outcome(case: Case, folder: Path) -> Outcome:
    """Judge one case."""
    recording, signals = case.recording(folder), case.touched
    begun = time.perf_counter()
    try:
        diagnosis = judged(case.drive, recording)
    except TierodError as error:
        named = _names(str(error), signals)
        return Outcome(REFUSED, "refused", named, named, str(error), time.perf_counter() - begun)
    except Exception:
        return Outcome(DEFECT, "defect", False, False, traceback.format_exc(), time.perf_counter() - begun)
    seconds = time.perf_counter() - begun
    finding = diagnosis.findings[0]
    usual, usual_said, _ = unchanged(case.drive, case.seed, folder)
    text = " | ".join((finding.headline, *finding.details, finding.cause, *finding.warnings))
    return Outcome(
        finding.status.exit_code,
        str(finding.status),
        any(_names(line, signals) for line in printed(diagnosis) if _bare(line) not in usual),
        any(_names(line, signals) for line in _said(diagnosis) if _bare(line) not in usual_said),
        text,
        seconds,
    )


def judged(drive: Drive, recording: Recording) -> Diagnosis:
    """The diagnosis of a recording as that of a drive.

    Without the spread of parameters, which can only take a verdict back: the strict measure.
    """
    return diagnose(recording, drive.vehicle, drive.monitor, drive.variant, spread=False)


def wrong(case: Case, found: Outcome) -> str:
    """What is wrong with the outcome of a case; empty where nothing is."""
    if found.code == DEFECT:
        return "defect"
    if case.drive.faulty and found.code == 0 and not found.named:
        return "a fault is called healthy"
    if not case.drive.faulty and found.code == 1 and not found.blamed:
        return "something else is blamed"
    return ""


def printed(diagnosis: Diagnosis) -> list[str]:
    """The lines that the terminal prints."""
    from rich.console import Console

    stream = io.StringIO()
    print_table(diagnosis, Console(file=stream, width=5000, color_system=None))
    return [line.strip() for line in stream.getvalue().splitlines() if line.strip()]


def _said(diagnosis: Diagnosis) -> list[str]:
    """Headline, cause, action and warnings, and what elements are at fault or were not judged."""
    finding = diagnosis.findings[0]
    elements = [
        f"{each.name}: {each.status} {each.cause} {' '.join(c for e in each.episodes for c in e.candidates)}"
        for each in diagnosis.elements
        if each.status is not Status.HEALTHY or each.cause
    ]
    return [finding.headline, *finding.details, finding.cause, finding.action, *finding.warnings, *elements]


@lru_cache(maxsize=64)
def unchanged(drive: Drive, seed: int, folder: Path) -> tuple[frozenset[str], frozenset[str], int]:
    """The lines of the unchanged recording and those of its finding, without their numbers, and its exit code."""
    diagnosis = judged(drive, recorded(drive, seed, folder))
    code = diagnosis.findings[0].status.exit_code
    return frozenset(map(_bare, printed(diagnosis))), frozenset(map(_bare, _said(diagnosis))), code


def _bare(line: str) -> str:
    return re.sub(r"[-+−]?[\d.]+(e[-+]?\d+)?", "#", line)


def _names(text: str, signals: tuple[str, ...]) -> bool:
    """Whether a text names one of the signals, by its name or what findings call it."""
    plain = text.lower().replace("_", " ")
    for phrase in _REFERENCE:
        plain = plain.replace(phrase, "")
    called = [each for signal in signals for each in (signal.replace("_", " "), *CALLED.get(signal, ()))]
    return any(re.search(rf"\b{re.escape(each)}\b", plain) for each in called)


def signals_of(drive: Drive, recording: Recording) -> tuple[str, ...]:
    """The signals of a recording that its monitor reads."""
    monitor = MONITORS[drive.monitor]
    needs = dict.fromkeys((*monitor.required, *monitor.optional))
    return tuple(name for name in needs if name in recording)


def matrix(drive: Drive, seed: int, folder: Path) -> Iterator[Case]:
    """Every case of one recording."""
    names = signals_of(drive, recorded(drive, seed, folder))
    for signal in names:
        for change in changes(names, signal):
            yield Case(drive, ((signal, change),), seed)


def pairs(drive: Drive, seed: int, folder: Path, count: int, random: np.random.Generator) -> list[Case]:
    """Distinct cases of one recording in which two signals are changed at once, without those that nothing can show."""
    single = [case.changes[0] for case in matrix(drive, seed, folder)]
    found: dict[tuple[tuple[str, str], ...], Case] = {}
    while len(found) < count:
        first, second = (single[at] for at in sorted(random.choice(len(single), 2, replace=False)))
        if set(touched(*first)).isdisjoint(touched(*second)) and not _unobservable(first, second):
            found[first, second] = Case(drive, (first, second), seed)
    return list(found.values())


def _unobservable(first: tuple[str, str], second: tuple[str, str]) -> bool:
    """Whether two changes scale both torques by one factor, the one member of `UNOBSERVABLE` with two signals."""
    both = {first[0], second[0]}
    return first[1] == second[1] and first[1] in ALIKE and both == {"driver_torque", "motor_torque"}


def drawn(drives: Sequence[Drive], count: int, seed: int, folder: Path, seeds: Sequence[int] = SEEDS) -> list[Case]:
    """Cases drawn at random, as many of each recording; every one where count allows."""
    random = np.random.default_rng(seed)
    places = list(itertools.product(drives, seeds))
    if count < len(places):
        places = [places[at] for at in sorted(random.choice(len(places), count, replace=False))]
    cases = []
    for at, (drive, each) in enumerate(places):
        every = list(matrix(drive, each, folder))
        share = count * (at + 1) // len(places) - count * at // len(places)
        cases += [every[place] for place in sorted(random.permutation(len(every))[:share])]
    return cases


def run(
    count: int, seed: int, folder: Path, monitors: Iterable[str] = tuple(MONITORS), seeds: Sequence[int] = SEEDS
) -> dict[str, dict[str, Any]]:
    """Judge a sample of all cases, drawn at random."""
    chosen = tuple(monitors)
    cases = drawn([drive for drive in DRIVES if drive.monitor in chosen], count, seed, folder, seeds)
    figures: dict[str, dict[str, Any]] = {}
    for monitor in chosen:
        found = {case: outcome(case, folder) for case in cases if case.drive.monitor == monitor}
        reasons = {case: wrong(case, each) for case, each in found.items()}
        codes = Counter(each.code for each in found.values())
        figures[monitor] = {
            "cases": len(found),
            "exit_codes": {f"exit {code}": number for code, number in sorted(codes.items())},
            "without_a_word": sum(each.code == 0 and not each.named for each in found.values()),
            "defects": codes[DEFECT],
            "wrong_words": {case.name: f"{reason}: {found[case].text}" for case, reason in reasons.items() if reason},
            "slowest_s": max((each.seconds for each in found.values()), default=0.0),
        }
    return figures
