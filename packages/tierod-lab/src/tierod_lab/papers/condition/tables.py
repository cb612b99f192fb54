"""Tables and panels that several parts of the study share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from tierod.core.content import Lines, Panel, Table
from tierod_lab.papers.condition.runs import VARIANTS
from tierod_lab.papers.condition.scoring import DriveScore
from tierod_lab.papers.condition.summary import Summary, confusion, share_within, summary

Scores = Mapping[str, Sequence[DriveScore]]

HEADER = (
    *("diagnosis", "accuracy", "worst", "without unobservable samples", "worst", "wrong name", "missed"),
    *("false alarms", "median delay [s]", "95 %", "kind right", "size within"),
)


def compared(title: str, scores: Scores, note: str = "") -> Table:
    """Table with one row of statistics for every diagnosis."""
    rows = tuple((VARIANTS[name].title, *_figures(summary(each))) for name, each in scores.items())
    return Table(title, HEADER, rows, note)


def _figures(of: Summary) -> tuple[str, ...]:
    delays = of.delays_shown
    return (
        f"{of.accuracy:.4f}",
        f"{of.worst:.4f}",
        f"{of.excused:.4f}",
        f"{of.worst_excused:.4f}",
        f"{of.wrong:.3f}",
        f"{of.missed} of {of.missed + len(delays)}",
        f"{of.false_alarms} in {of.healthy_hours:.1f} h",
        _number(float(np.median(delays)) if len(delays) else np.nan, "{:.2f}"),
        _number(float(np.quantile(delays, 0.95)) if len(delays) else np.nan, "{:.2f}"),
        _number(of.kinds, "{:.3f}"),
        _number(of.size_error, "{:.3f}"),
    )


def _number(value: float, form: str) -> str:
    return form.format(value) if np.isfinite(value) else "–"


def by_group(title: str, scores: Scores, group: Callable[[DriveScore], str], header: str, note: str = "") -> Table:
    """Table with mean and worst accuracy of every diagnosis, one row per group of drives in order of appearance.

    Args:
        group: function that gives the group of a drive
    """
    groups = list(dict.fromkeys(group(each) for several in scores.values() for each in several))
    rows = []
    for name in groups:
        cells = [name]
        for several in scores.values():
            found = summary([each for each in several if group(each) == name])
            cells.append(f"{found.accuracy:.3f} / {found.worst:.3f}")
        rows.append(tuple(cells))
    return Table(title, (header, *(VARIANTS[name].title for name in scores)), tuple(rows), note)


def confused(title: str, scores: Sequence[DriveScore], note: str = "") -> Table:
    """Confusion matrix of declared names, one row per true fault."""
    found = confusion(scores)
    names = sorted({name for row in found.values() for name in row}, key=lambda name: (name not in found, name))
    rows = tuple((failed, *(str(row.get(name, 0)) for name in names)) for failed, row in found.items())
    return Table(title, ("failed", *names), rows, note)


def named(title: str, scores: Sequence[DriveScore], note: str = "") -> Table:
    """Confusion matrix with the counts as text, for many names."""
    rows = tuple((failed, _words(row)) for failed, row in confusion(scores).items())
    return Table(title, ("failed", "named"), rows, note)


def _words(row: Counter[str]) -> str:
    return ", ".join(f"{name} ({count})" for name, count in row.most_common())


def delays(title: str, scores: Sequence[DriveScore], groups: Mapping[str, Callable[[DriveScore], bool]]) -> Table:
    """Table of detection delays by group of drives: from the fault, from the first observable sample, and so on."""
    rows = []
    for name, belongs in groups.items():
        of = summary([each for each in scores if belongs(each)])
        for start, times in (
            ("the fault", of.delays),
            ("where it is first observable", of.delays_shown),
            ("where it is first observable, unobservable time left out", of.delays_excited),
            ("likewise, until it is one of several named", of.delays_suspected),
        ):
            if len(times):
                cells = (f"{np.median(times):.2f}", f"{np.quantile(times, 0.95):.2f}", f"{times[-1]:.2f}")
                rows.append((name, start, *cells, f"{share_within(times, 0.2):.3f}"))
    return Table(title, ("faults", "from", "median", "95 %", "longest", "share within 0.2 s"), tuple(rows))


GAP = 1.5  # Distance of two rows of flags, each of height one

STATES = (("fault-free", 0.0), ("one of several", 0.5), ("faulty", 1.0))
"""Declared states of an element and their heights in a chart."""


def flags(title: str, time: np.ndarray, rows: Mapping[str, np.ndarray], begin: float, end: float = np.inf) -> Panel:
    """Panel of flags over time, one row above the other.

    Args:
        time: sampling times [s]
        begin, end: beginning and end of the fault [s]
    """
    heights = (GAP * place + np.asarray(values, float) for place, values in enumerate(rows.values()))
    marks = tuple(Lines(name, *steps(time, each)) for name, each in zip(rows, heights, strict=True))
    upright = [("fault", begin)] + ([("end", end)] if end < time[-1] else [])
    names = tuple((name, GAP * place + 0.5) for place, name in enumerate(rows))
    return Panel(title, "time [s]", "beyond its threshold", marks, uprights=tuple(upright), rows=names)


def states(title: str, time: np.ndarray, real: np.ndarray, said: Mapping[str, np.ndarray]) -> Panel:
    """Panel of true and declared states of one element over time.

    Args:
        time: sampling times [s]
        said: declared state as in `STATES`, by diagnosis; drawn slightly above each other
    """
    marks = [Lines("real state", *steps(time, np.asarray(real, float)))]
    marks += [
        Lines(name, *steps(time, np.asarray(values, float) + 0.03 * (place + 1)), dashed=True)
        for place, (name, values) in enumerate(said.items())
    ]
    return Panel(title, "time [s]", "state", tuple(marks), rows=STATES)


def steps(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The corners of a step curve."""
    change = np.flatnonzero(np.diff(values)) + 1
    keep = np.unique(np.concatenate([[0], change - 1, change, [len(values) - 1]]))
    return time[keep], values[keep]


def curves(title: str, y_title: str, time: np.ndarray, values: Mapping[str, np.ndarray], every: int = 5) -> Panel:
    """Panel of signals over time.

    Args:
        time: sampling times [s]
    """
    drawn = slice(None, None, every)
    return Panel(
        title, "time [s]", y_title, tuple(Lines(name, time[drawn], each[drawn]) for name, each in values.items())
    )


def between(time: np.ndarray, start: float, stop: float, *columns: np.ndarray) -> Sequence[np.ndarray]:
    """Time and columns from start to stop [s]."""
    kept = (time >= start) & (time < stop)
    return [time[kept], *(column[kept] for column in columns)]
