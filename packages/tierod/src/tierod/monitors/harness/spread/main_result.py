"""Main result of a monitor, on which the effect of the parameters' spread is measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tierod.monitors.harness.decision import Decision
from tierod.monitors.harness.session import Session
from tierod.monitors.harness.spread.shown import AFTER, Pair, pairs_of


class Main(NamedTuple):
    """Result whose sensitivities determine the directions.

    Args:
        pair: traces of value and standard deviation; the latter is "" if the value is compared with a threshold
        level: magnitude of that threshold; 0 if there is a standard deviation
    """

    pair: Pair
    level: float


def main_result(session: Session, decisions: Sequence[Decision]) -> Main | None:
    """First result of a session with a band, or else the statistic of its first decision; None without either.

    Args:
        session: session of a monitor
        decisions: decisions of the monitor
    """
    after = [each for each in pairs_of(session.traces) if each.deviation.endswith(AFTER)]
    if after:
        return Main(after[0], 0.0)
    for each in decisions:
        if each.statistic in session.traces and each.levels and np.isfinite(each.levels[0]) and each.levels[0] != 0.0:
            return Main(Pair(each.statistic, ""), abs(each.levels[0]))
    return None


def scale_of(shown: Mapping[str, np.ndarray], main: Main) -> np.ndarray:
    """Scale for changes of the result, its standard deviation or threshold [unit of the result], (n,).

    Args:
        shown: traces of the session
        main: main result
    """
    return shown[main.pair.deviation] if main.pair.deviation else np.full(len(shown[main.pair.value]), main.level)


def where_known(shown: Mapping[str, np.ndarray], main: Main) -> np.ndarray:
    """Mask of the samples with a valid result and a fulfilled enabling condition, (n,).

    Args:
        shown: traces of the session
        main: main result
    """
    scale = scale_of(shown, main)
    known: np.ndarray = np.isfinite(shown[main.pair.value]) & np.isfinite(scale) & (scale > 0.0)
    enabled = shown.get("enabled")
    return known if enabled is None else known & (enabled > 0.5)
