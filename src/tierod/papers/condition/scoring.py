"""A diagnosis of a drive held against what was injected: accuracy, delay, wrong names, kind, size, replaced values."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.papers.condition.drives import ACTUATORS, SENSORS, Drive
from tierod.papers.condition.faults import Injected
from tierod.papers.condition.truth import Declared, Truth, truths

ELEMENTS = (*SENSORS, *ACTUATORS)
"""Everything that is judged."""
NAMED_AFTER = 2.0
"""So long after the declaration kind and size are judged, or at the end of a shorter fault [s]."""
GRACE = 2.0
"""So long after the end of a fault its own declaration is no false alarm [s]; in the accuracy it counts at once."""
SETTLED = 0.5
"""Time after a fault is first observable from which its name counts [s]."""

INTERVAL = 1.96
"""Standard deviations to either side that hold a size 95 times in a hundred."""

FOUND, MISSED, NOT_TESTABLE = "found", "missed", "not testable"
UNNAMED, AMBIGUOUS, NEVER = "none", "ambiguous", "never shows"
"""In place of names: nothing is declared, several together, or the fault was never observable."""


class StrictScore(NamedTuple):
    """Score of a fault, observable as soon as a likelihood-ratio test with true parameters detects it.

    Args:
        outcome, accuracy_excused, delay_shown: as of `FaultScore`
    """

    outcome: str
    accuracy_excused: float
    delay_shown: Annotated[float, "s"]


class FaultScore(NamedTuple):
    """Score of one fault's diagnosis.

    Args:
        injected: the fault
        accuracy: share of all samples of the drive at which the element's state is right
        accuracy_excused: the same, without the samples at which the state is not observable and not right: the
            fault is present or past, and makes no difference to the readings
        outcome: FOUND, MISSED, or NOT_TESTABLE where it never was observable
        delay: from its beginning to the first declaration; infinite where there is none
        delay_shown: from the first sample at which it is observable; below zero where it was declared before, and
            counted to the end of a fault that never is
        delay_excited: the same, less the time in which it is not observable: a torque hardly commanded or a
            signal near zero carries no information, and a fault may be observable for a moment long before it is again
        delay_suspected: likewise, to where it is declared or named as one of several
        shown: how long it was observable
        kind_right: whether the kind is right; None where none is named
        size_error: relative error of the size; NaN where none is named
        size_covered: whether the true size is within `INTERVAL` of the estimate; None without a size of the right kind
        rmse: of the substitute value against that of a fault-free sensor, while declared; NaN without one
        largest: greatest magnitude of that error
        strict: the same fault by `Truth.strict`; None where that grade is not known
    """

    injected: Injected
    accuracy: float
    accuracy_excused: float
    outcome: str
    delay: Annotated[float, "s"]
    delay_shown: Annotated[float, "s"]
    delay_excited: Annotated[float, "s"]
    delay_suspected: Annotated[float, "s"]
    shown: Annotated[float, "s"]
    kind_right: bool | None
    size_error: float
    size_covered: bool | None
    rmse: float
    largest: float
    strict: StrictScore | None = None


class DriveScore(NamedTuple):
    """Score of one drive's diagnosis.

    Args:
        drive: what was driven
        faults: score of everything that was injected
        wrong_share: share of the time with faults in which a fault-free element is declared
        false_alarms: declarations that begin while nothing, or something else, is at fault, those within a fault aside
        healthy_hours: without fault
        flagged_share: share of the fault-free time in which anything at all is declared
        named: what was declared at most samples at which a fault shows and all have shown for a while
    """

    drive: Drive
    faults: tuple[FaultScore, ...]
    wrong_share: float
    false_alarms: int
    healthy_hours: Annotated[float, "h"]
    flagged_share: float
    named: str


def score(drive: Drive, truth: Truth, declared: Declared) -> DriveScore:
    """The score of one drive.

    Args:
        drive: with what was injected
        truth: of its recording
        declared: by the diagnosis, on the same samples
    """
    time = declared.time
    faulty = truths(drive, time)
    any_fault = np.logical_or.reduce([*faulty.values(), np.zeros(len(time), bool)])
    strict = truth.strict if truth.noise else None
    shown = {element: truth.shows(element, there) for element, there in faulty.items()}
    nothing = np.zeros(len(time), bool)
    wrong = np.logical_or.reduce([declared.said("faulty", e) & ~faulty.get(e, nothing) for e in ELEMENTS])
    flagged = np.logical_or.reduce([declared.said("faulty", element) for element in ELEMENTS])
    return DriveScore(
        drive,
        tuple(_of_fault(each, truth, declared, faulty, shown, strict) for each in drive.injected),
        _share(wrong, any_fault),
        sum(_false_alarms(declared.said("faulty", e), faulty.get(e, nothing), any_fault, time) for e in ELEMENTS),
        float(np.sum(~any_fault)) * _step(time) / 3600.0,
        _share(flagged & ~_soon_after(any_fault, time), ~any_fault),
        _name(declared, shown, time),
    )


def _of_fault(
    each: Injected,
    truth: Truth,
    declared: Declared,
    faulty: Mapping[str, np.ndarray],
    shown: Mapping[str, np.ndarray],
    strict: Truth | None,
) -> FaultScore:
    time, there = declared.time, faulty[each.element]
    here = (time >= each.start - 1e-9) & (time < each.end - 1e-9)
    said, shows = declared.said("faulty", each.element), shown[each.element] & here
    right = said == there
    first = _first(said & here)
    delay = math.inf if first is None else float(time[first]) - each.start
    graded = _graded(each, truth, time, said, there, shown[each.element])
    kind_right, size_error, size_covered = _kind(each, declared, first, here)
    rmse, largest = _replaced(each, truth, declared, said & here)
    return FaultScore(
        each,
        float(np.mean(right)),
        graded.accuracy_excused,
        graded.outcome,
        delay,
        graded.delay_shown,
        _excited(shows, first, time),
        _excited(shows, _first((said | declared.said("candidates", each.element)) & here), time),
        float(np.sum(shows)) * _step(time),
        kind_right,
        size_error,
        size_covered,
        rmse,
        largest,
        None if strict is None else _graded(each, strict, time, said, there, strict.shows(each.element, there)),
    )


def _graded(
    each: Injected, truth: Truth, time: np.ndarray, said: np.ndarray, there: np.ndarray, shown: np.ndarray
) -> StrictScore:
    """Outcome, accuracy where the state is observable, and delay, by one grade of what is observable."""
    here = (time >= each.start - 1e-9) & (time < each.end - 1e-9)
    right, gone = said == there, (time >= each.end) & ~there
    counted = right | ~((there & ~shown) | (gone & ~truth.would_show(each, time)))
    first, began = _first(said & here), _first(shown & here)
    accuracy = float(np.mean(right[counted]))
    if first is None:
        return StrictScore(NOT_TESTABLE if began is None else MISSED, accuracy, math.inf)
    last = int(np.flatnonzero(here)[-1])
    return StrictScore(FOUND, accuracy, float(time[first] - time[last if began is None else began]))


def _excited(shows: np.ndarray, first: int | None, time: np.ndarray) -> float:
    """Time for which a fault has shown before a sample [s]; infinite where there is none."""
    return math.inf if first is None else float(np.sum(shows[:first])) * _step(time)


def _kind(
    each: Injected, declared: Declared, first: int | None, here: np.ndarray
) -> tuple[bool | None, float, bool | None]:
    """Whether the kind is right, the relative error of the size, and whether its interval holds it."""
    kinds, sizes = declared.kind.get(each.element), declared.size.get(each.element)
    if first is None or kinds is None:
        return None, math.nan, None
    last = int(np.flatnonzero(here)[-1])
    at = min(int(np.searchsorted(declared.time, declared.time[first] + NAMED_AFTER)), last)
    error, covered, right = math.nan, None, bool(kinds[at] == each.kind)
    if sizes is not None and not math.isnan(each.size):
        error = float(abs(sizes[at] - each.size) / abs(each.size))
        deviations = declared.deviation.get(each.element)
        if right and deviations is not None:
            covered = bool(abs(sizes[at] - each.size) <= INTERVAL * deviations[at])
    return right, error, covered


def _replaced(each: Injected, truth: Truth, declared: Declared, within: np.ndarray) -> tuple[float, float]:
    """Root mean square and greatest magnitude of the error of the value in the sensor's place."""
    value = declared.value.get(each.element)
    if value is None or each.element not in truth.fault_free or not within.any():
        return math.nan, math.nan
    error = (value - truth.fault_free[each.element])[within]
    return float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error)))


def _name(declared: Declared, shown: Mapping[str, np.ndarray], time: np.ndarray) -> str:
    """Names of the elements declared for most of the time once all faults are observable, joined by " + "."""
    if not shown:
        return NEVER
    late = np.logical_and.reduce([_after(each, round(SETTLED / _step(time))) for each in shown.values()])
    late &= np.logical_or.reduce(list(shown.values()))
    if not late.any():
        return NEVER
    flags = np.array([declared.said("faulty", element)[late] for element in ELEMENTS])
    unsure = np.logical_or.reduce([declared.said("candidates", element)[late] for element in ELEMENTS])
    codes = (1 << np.arange(len(ELEMENTS))) @ flags
    code, _ = Counter(zip(codes.tolist(), (unsure & (codes == 0)).tolist(), strict=True)).most_common(1)[0]
    names = [element for place, element in enumerate(ELEMENTS) if code[0] >> place & 1]
    return " + ".join(names) or (AMBIGUOUS if code[1] else UNNAMED)


def _after(shows: np.ndarray, samples: int) -> np.ndarray:
    """Whether something has shown at least once, so many samples ago or more."""
    ever = np.logical_or.accumulate(shows)
    return np.concatenate([np.zeros(min(samples, len(ever)), bool), ever[: max(len(ever) - samples, 0)]])


def _false_alarms(said: np.ndarray, faulty: np.ndarray, any_fault: np.ndarray, time: np.ndarray) -> int:
    """Declarations that begin outside all faults, those of the element itself soon after its fault aside."""
    begins = said & ~np.concatenate([[False], said[:-1]])
    return int(np.sum(begins & ~any_fault & ~_soon_after(faulty, time)))


def _soon_after(faulty: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Whether it is at fault or was within the time of grace."""
    last = np.maximum.accumulate(np.where(faulty, time, -math.inf))
    return time - last <= GRACE


def _share(true: np.ndarray, among: np.ndarray) -> float:
    return float(np.mean(true[among])) if among.any() else 0.0


def _first(true: np.ndarray) -> int | None:
    return int(np.argmax(true)) if true.any() else None


def _step(time: np.ndarray) -> Any:
    return float(time[1] - time[0])
