"""The result of a monitor by which the spread of its vehicle's parameters is judged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tierod.monitors.harness.decision import Decision
from tierod.monitors.harness.session import Session
from tierod.monitors.harness.spread.shown import AFTER, Pair, pairs_of


class Main(NamedTuple):
    """The result by which the directions are chosen.

    Args:
        pair: value and deviation; the deviation is "" where the value is compared with a threshold
        level: that threshold; 0 where there is a deviation
    """

    pair: Pair
    level: float


def main_result(session: Session, decisions: Sequence[Decision]) -> Main | None:
    """The first result of a session with a band, else its first decision's statistic; None where it has neither.

    Args:
        session: of a monitor
        decisions: of the monitor
    """
    after = [each for each in pairs_of(session.traces) if each.deviation.endswith(AFTER)]
    if after:
        return Main(after[0], 0.0)
    for each in decisions:
        if each.statistic in session.traces and each.levels and np.isfinite(each.levels[0]) and each.levels[0] != 0.0:
            return Main(Pair(each.statistic, ""), abs(each.levels[0]))
    return None


def scale_of(shown: Mapping[str, np.ndarray], main: Main) -> np.ndarray:
    """Scale of the moves of the result, in its unit, (n,).

    Args:
        shown: traces of the session
        main: the result
    """
    return shown[main.pair.deviation] if main.pair.deviation else np.full(len(shown[main.pair.value]), main.level)


def where_known(shown: Mapping[str, np.ndarray], main: Main) -> np.ndarray:
    """Mask of the samples at which the result is known and was being learnt, (n,) of truth values.

    Args:
        shown: traces of the session
        main: the result
    """
    scale = scale_of(shown, main)
    known: np.ndarray = np.isfinite(shown[main.pair.value]) & np.isfinite(scale) & (scale > 0.0)
    enabled = shown.get("enabled")
    return known if enabled is None else known & (enabled > 0.5)
