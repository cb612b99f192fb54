"""Statistics over many scored drives."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from typing import Annotated, NamedTuple

import numpy as np

from tierod_lab.campaign.figures import rate_bound
from tierod_lab.papers.condition.scoring import (
    AMBIGUOUS,
    ELEMENTS,
    FOUND,
    MISSED,
    NEVER,
    NOT_TESTABLE,
    UNNAMED,
    DriveScore,
    FaultScore,
)


class Strict(NamedTuple):
    """Statistics with faults that count as observable if a likelihood-ratio test with true parameters sees them."""

    missed: int  # number of faults that were observable and never declared
    not_testable: int  # number of faults that were neither declared nor ever observable
    worst: float  # lowest accuracy without wrong samples at which the state is not observable [-]
    # detection delays of the found faults from the first observable sample, ascending
    delays: Annotated[np.ndarray, "s"]


class Summary(NamedTuple):
    """Statistics of many drives; NaN without data."""

    drives: int  # number of drives
    accuracy: float  # accuracy, worst: mean and lowest accuracy over all faults [-]
    worst: float
    excused: float  # excused, worst_excused: the same without wrong samples at which the state is not observable [-]
    worst_excused: float
    wrong: float  # mean share of the time with faults in which a fault-free element is declared [-]
    missed: int  # number of faults that were observable and never declared
    not_testable: int  # number of faults that were neither declared nor ever observable
    delays: Annotated[np.ndarray, "s"]  # detection delays of the found faults from their beginning, ascending
    delays_shown: Annotated[np.ndarray, "s"]  # the same from the first observable sample, ascending
    delays_excited: Annotated[np.ndarray, "s"]  # observable time before the declaration of the found faults, ascending
    # observable time until the element is declared or one of several candidates, ascending
    delays_suspected: Annotated[np.ndarray, "s"]
    kinds: float  # share of right kinds among those named [-]
    size_error: float  # 95 % quantile of the relative errors of the sizes [-]
    covered: float  # share of the sizes of rightly named kinds within their 95 % interval [-]
    false_alarms: int  # number of false alarms
    healthy_hours: Annotated[float, "h"]  # fault-free time
    bound: Annotated[float, "1/h"]  # upper 95 % bound of the rate of false alarms
    strict: Strict  # statistics with faults that are observable where a test with true parameters detects them


def summary(scores: Sequence[DriveScore]) -> Summary:
    """Statistics of scored drives."""
    faults = [fault for each in scores for fault in each.faults]
    faulty = [each for each in scores if each.faults]
    kinds = [fault.kind_right for fault in faults if fault.kind_right is not None]
    sizes = [fault.size_error for fault in faults if not math.isnan(fault.size_error)]
    alarms, hours = sum(each.false_alarms for each in scores), sum(each.healthy_hours for each in scores)
    return Summary(
        len(scores),
        mean(fault.accuracy for fault in faults),
        least(fault.accuracy for fault in faults),
        mean(fault.accuracy_excused for fault in faults),
        least(fault.accuracy_excused for fault in faults),
        mean(each.wrong_share for each in faulty),
        sum(fault.outcome == MISSED for fault in faults),
        sum(fault.outcome == NOT_TESTABLE for fault in faults),
        _delays(faults, lambda fault: fault.delay),
        _delays(faults, lambda fault: fault.delay_shown),
        _delays(faults, lambda fault: fault.delay_excited),
        _delays(faults, lambda fault: fault.delay_suspected),
        mean(kinds),
        float(np.quantile(sizes, 0.95)) if sizes else math.nan,
        mean(fault.size_covered for fault in faults if fault.size_covered is not None),
        alarms,
        hours,
        rate_bound(alarms, hours),
        _strict(faults),
    )


def _strict(faults: Iterable[FaultScore]) -> Strict:
    known = [fault.strict for fault in faults if fault.strict is not None]
    return Strict(
        sum(each.outcome == MISSED for each in known),
        sum(each.outcome == NOT_TESTABLE for each in known),
        least(each.accuracy_excused for each in known),
        np.sort([each.delay_shown for each in known if each.outcome == FOUND]),
    )


def _delays(faults: Iterable[FaultScore], delay: Callable[[FaultScore], float]) -> np.ndarray:
    return np.sort([delay(fault) for fault in faults if fault.outcome == FOUND])


def mean(values: Iterable[float]) -> float:
    """Mean; NaN without values."""
    known = list(values)
    return float(np.mean(known)) if known else math.nan


def least(values: Iterable[float]) -> float:
    """Smallest value; NaN without values."""
    return min(values, default=math.nan)


def share_within(delays: np.ndarray, limit: float) -> float:
    """Share of delays up to a limit [s]; NaN without delays."""
    return float(np.mean(delays <= limit + 1e-9)) if len(delays) else math.nan


def confusion(scores: Iterable[DriveScore]) -> dict[str, Counter[str]]:
    """Confusion matrix: true faults of a drive -> count of every declared name."""
    found: dict[str, Counter[str]] = defaultdict(Counter)
    for each in scores:
        if each.faults:
            found[injected_name(each)][each.named] += 1
    return dict(found)


def injected_name(each: DriveScore) -> str:
    """Name of the failed elements of a drive, in the form of `DriveScore.named`."""
    failed = {fault.injected.element for fault in each.faults}
    return " + ".join(element for element in ELEMENTS if element in failed)


class Isolated(NamedTuple):
    """Shares of drives by declaration: the true faults, a part of them, an ambiguous set, nothing, another element."""

    right: float
    partial: float
    ambiguous: float
    nothing: float
    wrong: float


def isolated(scores: Sequence[DriveScore]) -> Isolated:
    """Isolation of the faults of drives, by the names that were declared most of the time.

    Drives in which not all faults are observable for long enough are left out.
    """
    verdicts = [_verdict(each) for each in scores if each.faults and each.named != NEVER]
    return Isolated(*(mean(verdict == name for verdict in verdicts) for name in Isolated._fields))


def _verdict(each: DriveScore) -> str:
    if each.named in (AMBIGUOUS, UNNAMED):
        return "ambiguous" if each.named == AMBIGUOUS else "nothing"
    named, failed = set(each.named.split(" + ")), {fault.injected.element for fault in each.faults}
    if named == failed:
        return "right"
    return "partial" if named < failed else "wrong"
