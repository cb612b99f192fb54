"""Charts of flags and states over time, as the paper draws them: one row above the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tierod.core.content import Lines, Panel

GAP = 1.5
"""Between two rows of flags; each is one high."""

STATES = (("sound", 0.0), ("one of several", 0.5), ("faulty", 1.0))
"""Heights of what is declared of an element."""


def flags(title: str, time: np.ndarray, rows: Mapping[str, np.ndarray], begin: float, end: float = np.inf) -> Panel:
    """Flags over time, row above row: 0 at the foot of a row, 1 above.

    Args:
        title: of the panel
        time: [s]
        rows: by name, from bottom to top
        begin, end: of the fault [s]
    """
    heights = (GAP * place + np.asarray(values, float) for place, values in enumerate(rows.values()))
    marks = tuple(Lines(name, *steps(time, each)) for name, each in zip(rows, heights, strict=True))
    upright = [("fault", begin)] + ([("end", end)] if end < time[-1] else [])
    names = tuple((name, GAP * place + 0.5) for place, name in enumerate(rows))
    return Panel(title, "time [s]", "beyond its threshold", marks, uprights=tuple(upright), rows=names)


def states(title: str, time: np.ndarray, real: np.ndarray, said: Mapping[str, np.ndarray]) -> Panel:
    """Real and declared state of one element over time.

    Args:
        title: of the panel
        time: [s]
        real: whether it is at fault
        said: what is declared, by diagnosis, as in `STATES`; drawn slightly above each other
    """
    marks = [Lines("real state", *steps(time, np.asarray(real, float)))]
    marks += [
        Lines(name, *steps(time, np.asarray(values, float) + 0.03 * (place + 1)), dashed=True)
        for place, (name, values) in enumerate(said.items())
    ]
    return Panel(title, "time [s]", "state", tuple(marks), rows=STATES)


def steps(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve of steps by its corners alone."""
    change = np.flatnonzero(np.diff(values)) + 1
    keep = np.unique(np.concatenate([[0], change - 1, change, [len(values) - 1]]))
    return time[keep], values[keep]


def curves(title: str, y_title: str, time: np.ndarray, values: Mapping[str, np.ndarray], every: int = 5) -> Panel:
    """Signals over time.

    Args:
        title, y_title: of the panel
        time: [s]
        values: by name
        every: only each so many samples are drawn
    """
    drawn = slice(None, None, every)
    return Panel(
        title, "time [s]", y_title, tuple(Lines(name, time[drawn], each[drawn]) for name, each in values.items())
    )


def between(time: np.ndarray, start: float, stop: float, *columns: np.ndarray) -> Sequence[np.ndarray]:
    """Time and columns from start to stop [s]."""
    kept = (time >= start) & (time < stop)
    return [time[kept], *(column[kept] for column in columns)]
