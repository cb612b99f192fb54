"""Causes of claims that do not hold, as text: the drives that keep a figure from its goal."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from tierod_lab.papers.condition.scoring import FOUND, MISSED, NEVER, DriveScore, FaultScore
from tierod_lab.papers.condition.summary import injected_name

MOST = 4  # Largest number of items of a list that are written out


def wrong_time(of: Sequence[DriveScore]) -> str:
    """Cause of a low accuracy: parts of the time with a wrong state, mean over all drives and in the worst one."""
    faults = _faults(of)
    if not faults:
        return ""
    mean = np.mean([_parts(each, fault) for each, fault in faults], axis=0)
    drive, fault = min(faults, key=lambda pair: pair[1].accuracy)
    return (
        f"Wrong {mean[0]:.2f} s a drive on the mean: {mean[1]:.2f} s before the declaration, {mean[2]:.2f} s after the "
        f"fault, {mean[3]:.2f} s of all of that unobservable. Worst: {_words(drive, fault)}."
    )


def _parts(drive: DriveScore, fault: FaultScore) -> tuple[float, float, float, float]:
    """Time with a wrong state [s]: total, before the declaration, after it, and the unobservable part of the total."""
    total, lasts = drive.drive.seconds, fault.injected.end - fault.injected.start
    # The delay of a missed fault is infinite.
    wrong, before = total * (1.0 - fault.accuracy), min(fault.delay, lasts)
    return wrong, before, max(wrong - before, 0.0), total * (fault.accuracy_excused - fault.accuracy)


def _words(drive: DriveScore, fault: FaultScore) -> str:
    wrong, before, after, unobservable = _parts(drive, fault)
    return f"{_name(drive)}, {wrong:.2f} s ({before:.2f} before, {after:.2f} after, {unobservable:.2f} unobservable)"


def late(of: Sequence[DriveScore], delay: Callable[[FaultScore], float]) -> str:
    """Cause of a long delay: the longest one and the median.

    Args:
        delay: function that gives the delay of a detected fault [s]
    """
    found = [(drive, delay(fault)) for drive, fault in _faults(of) if fault.outcome == FOUND]
    found = [pair for pair in found if not math.isnan(pair[1])]
    if not found:
        return "None was found."
    drive, longest = max(found, key=lambda pair: pair[1])
    median = float(np.median([each for _, each in found]))
    return f"Latest: {_name(drive)}, {longest:.2f} s; the median of {len(found)} is {median:.2f} s."


def missed(of: Sequence[DriveScore]) -> str:
    """Cause of missed faults: the faults, and the time for which they were observable."""
    faults = [(drive, fault) for drive, fault in _faults(of) if fault.outcome == MISSED]
    times = [fault.shown for _, fault in faults]
    seen = f" Observable for {min(times):.2f} to {max(times):.2f} s each." if times else ""
    return f"Missed: {_counted(_fault(fault) for _, fault in faults)}.{seen}"


def misnamed(of: Sequence[DriveScore]) -> str:
    """Cause of wrong isolation: faults that were named otherwise, and drives with a fault-free element named."""
    pairs = (
        f"{injected_name(each)} as {each.named}"
        for each in of
        if each.faults and each.named not in (NEVER, injected_name(each))
    )
    wrong = (_name(each) for each in of if each.faults and each.wrong_share > 0.0)
    return f"Most of the time by another name: {_counted(pairs)}; something fault-free named: {_counted(wrong)}."


def kinds(of: Sequence[DriveScore]) -> str:
    """Cause of wrong kinds: the faults whose kind was named wrongly."""
    known = [fault for _, fault in _faults(of) if fault.kind_right is not None]
    return f"Of {len(known)} not rightly: {_counted(_fault(each) for each in known if not each.kind_right)}."


def sizes(of: Sequence[DriveScore]) -> str:
    """Cause of wrong sizes: the largest error, and the coverage of the intervals by kind."""
    known = [(drive, fault) for drive, fault in _faults(of) if not math.isnan(fault.size_error)]
    if not known:
        return "None was named."
    drive, worst = max(known, key=lambda pair: pair[1].size_error)
    parts = []
    for kind in dict.fromkeys(fault.injected.kind for _, fault in known):
        held = [f.size_covered for _, f in known if f.injected.kind == kind and f.size_covered is not None]
        if held:
            parts.append(f"{kind} {np.mean(held):.3f} of {len(held)}")
    return f"Worst: {_name(drive)}, off by {worst.size_error:.1%}. Within their interval by kind: {', '.join(parts)}."


def alarms(of: Sequence[DriveScore]) -> str:
    """Cause of false alarms: the drives that have them."""
    return f"In {_counted(_name(each) for each in of for _ in range(each.false_alarms))}."


def _faults(of: Sequence[DriveScore]) -> list[tuple[DriveScore, FaultScore]]:
    return [(drive, fault) for drive in of for fault in drive.faults]


def _name(each: DriveScore) -> str:
    return each.drive.name.replace("_", " ")


def _fault(each: FaultScore) -> str:
    return f"{each.injected.element} {each.injected.kind}".replace("_", " ")


def _counted(words: Iterable[str]) -> str:
    counts = Counter(word.replace("_", " ") for word in words)
    shown = [f"{word} ({count})" if count > 1 else word for word, count in counts.most_common(MOST)]
    rest = counts.total() - sum(count for _, count in counts.most_common(MOST))
    return ", ".join([*shown, f"{rest} more"] if rest else shown) or "none"
