"""Score of a diagnosis against the injected faults: accuracy, delay, isolation, kind, size, and substitute values."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod_lab.papers.condition.drives import ACTUATORS, SENSORS, Drive, Injected
from tierod_lab.papers.condition.truth import Declared, Truth, truths

ELEMENTS = (*SENSORS, *ACTUATORS)  # All judged elements
NAMED_AFTER = 2.0
"""Time after the declaration at which kind and size are judged [s]; at the end of a fault that is shorter."""
GRACE = 2.0
"""Time after a fault in which its declaration is no false alarm [s]; the accuracy counts it as wrong at once."""
SETTLED = 0.5  # Time after a fault is first observable before its name counts [s]

INTERVAL = 1.96  # Half width of a 95 % interval in standard deviations

FOUND, MISSED, NOT_TESTABLE = "found", "missed", "not testable"
UNNAMED, AMBIGUOUS, NEVER = "none", "ambiguous", "never shows"
"""Stand for a name where nothing is declared, where several are candidates, and where a fault never is observable."""


class StrictScore(NamedTuple):
    """Score of a fault that counts as observable where a likelihood-ratio test with true parameters detects it."""

    outcome: str  # outcome, accuracy_excused, delay_shown: as in `FaultScore`
    accuracy_excused: float
    delay_shown: Annotated[float, "s"]


class FaultScore(NamedTuple):
    """Score of the diagnosis of one fault."""

    injected: Injected  # the fault
    accuracy: float  # share of all samples of the drive at which the state of the element is right; eq (53)
    # the same without the samples at which the state is wrong but not observable, as the present or past fault does not
    # change the reading
    accuracy_excused: float
    outcome: str  # FOUND, MISSED, or NOT_TESTABLE for a fault that is neither declared nor ever observable
    delay: Annotated[float, "s"]  # detection delay from the beginning of the fault; infinite if it is not declared
    # detection delay from the first observable sample; negative if declared before it, and counted to the end of a
    # fault that never is observable
    delay_shown: Annotated[float, "s"]
    # observable time before the declaration: a torque that is hardly commanded, or a signal near zero, carries no
    # information, and a fault may be observable for a moment long before it is again
    delay_excited: Annotated[float, "s"]
    # observable time until the element is declared or is one of several candidates
    delay_suspected: Annotated[float, "s"]
    shown: Annotated[float, "s"]  # total observable time
    kind_right: bool | None  # whether the named kind is right; None if none is named
    size_error: float  # relative error of the named size; NaN if none is named
    # whether the true size is within `INTERVAL` of the estimate; None without a size of the right kind
    size_covered: bool | None
    rmse: float  # root mean square error of the substitute value while the sensor is declared; NaN without one
    largest: float  # largest magnitude of that error
    strict: StrictScore | None = None  # score of the same fault by `Truth.strict`; None where the noise is unknown


class DriveScore(NamedTuple):
    """Score of the diagnosis of one drive."""

    drive: Drive  # the drive
    faults: tuple[FaultScore, ...]  # score of every injected fault
    wrong_share: float  # share of the time with faults in which a fault-free element is declared [-]
    # declarations that begin while no fault is present, except of an element whose fault has just ended
    false_alarms: int
    healthy_hours: Annotated[float, "h"]  # fault-free time
    flagged_share: float  # share of the fault-free time in which anything is declared [-]
    # elements that are declared most often at the samples at which a fault is observable and all have been observable
    # for `SETTLED`
    named: str


def score(drive: Drive, truth: Truth, declared: Declared) -> DriveScore:
    """The score of the diagnosis of one drive.

    Args:
        declared: declarations of the diagnosis on the same samples
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
    here = (time >= each.start - 1e-9) & (time < each.end - 1e-9)
    right, gone = said == there, (time >= each.end) & ~there
    # After the fault, a remaining declaration is excused where the fault would not change the reading.
    counted = right | ~((there & ~shown) | (gone & ~truth.would_show(each, time)))
    first, began = _first(said & here), _first(shown & here)
    accuracy = float(np.mean(right[counted]))
    if first is None:
        return StrictScore(NOT_TESTABLE if began is None else MISSED, accuracy, math.inf)
    last = int(np.flatnonzero(here)[-1])
    return StrictScore(FOUND, accuracy, float(time[first] - time[last if began is None else began]))


def _excited(shows: np.ndarray, first: int | None, time: np.ndarray) -> float:
    """Observable time of a fault before a sample [s]; infinite without that sample."""
    return math.inf if first is None else float(np.sum(shows[:first])) * _step(time)


def _kind(
    each: Injected, declared: Declared, first: int | None, here: np.ndarray
) -> tuple[bool | None, float, bool | None]:
    """Whether the kind is right, the relative error of the size, and whether its interval contains the true size."""
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
    value = declared.value.get(each.element)
    if value is None or each.element not in truth.fault_free or not within.any():
        return math.nan, math.nan
    error = (value - truth.fault_free[each.element])[within]
    return float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error)))


def _name(declared: Declared, shown: Mapping[str, np.ndarray], time: np.ndarray) -> str:
    """Most frequent set of declared elements once all faults have been observable, joined by " + "."""
    if not shown:
        return NEVER
    late = np.logical_and.reduce([_after(each, round(SETTLED / _step(time))) for each in shown.values()])
    late &= np.logical_or.reduce(list(shown.values()))
    if not late.any():
        return NEVER
    flags = np.array([declared.said("faulty", element)[late] for element in ELEMENTS])
    unsure = np.logical_or.reduce([declared.said("candidates", element)[late] for element in ELEMENTS])
    # One bit per element makes sets of elements countable.
    codes = (1 << np.arange(len(ELEMENTS))) @ flags
    code, _ = Counter(zip(codes.tolist(), (unsure & (codes == 0)).tolist(), strict=True)).most_common(1)[0]
    names = [element for place, element in enumerate(ELEMENTS) if code[0] >> place & 1]
    return " + ".join(names) or (AMBIGUOUS if code[1] else UNNAMED)


def _after(shows: np.ndarray, samples: int) -> np.ndarray:
    ever = np.logical_or.accumulate(shows)
    return np.concatenate([np.zeros(min(samples, len(ever)), bool), ever[: max(len(ever) - samples, 0)]])


def _false_alarms(said: np.ndarray, faulty: np.ndarray, any_fault: np.ndarray, time: np.ndarray) -> int:
    """Number of declarations that begin outside all faults, except soon after the fault of the element itself."""
    begins = said & ~np.concatenate([[False], said[:-1]])
    return int(np.sum(begins & ~any_fault & ~_soon_after(faulty, time)))


def _soon_after(faulty: np.ndarray, time: np.ndarray) -> np.ndarray:
    last = np.maximum.accumulate(np.where(faulty, time, -math.inf))
    return time - last <= GRACE


def _share(true: np.ndarray, among: np.ndarray) -> float:
    return float(np.mean(true[among])) if among.any() else 0.0


def _first(true: np.ndarray) -> int | None:
    return int(np.argmax(true)) if true.any() else None


def _step(time: np.ndarray) -> Any:
    return float(time[1] - time[0])
