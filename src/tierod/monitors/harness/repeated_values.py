"""Runs of equal values of a signal, sample by sample."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tierod.core.graph.maths import absolute, both, maximum, minimum, negated, present, where


class Run(NamedTuple):
    """Memory of one signal and its run of equal values.

    Args:
        value: its last [its unit]
        seconds: for which it has repeated that [s]
        moving_seconds: ... of them while the car moved [s]
        longest: such time that ended with a change [s]
        seen: time for which it was present and not stuck [s]
        driven: ... of that while the car moved [s]
        low, high: least and greatest value [its unit]
        step: smallest change [its unit]
        rests_at_zero: whether it was exactly zero before
        stuck: whether it is stuck
    """

    value: Any
    seconds: Any
    moving_seconds: Any
    longest: Any
    seen: Any
    driven: Any
    low: Any
    high: Any
    step: Any
    rests_at_zero: Any
    stuck: Any


NEW = Run(math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, math.inf, -math.inf, math.inf, 0.0, 0.0)
"""A signal that has not been seen yet."""


def repeated(run: Run, value: Any, moves: Any, sample_time: float) -> Run:
    """The run of a signal one sample on; a missing sample changes nothing.

    Args:
        run: before the sample
        value: of the signal; not finite where missing
        moves: whether the car moves
        sample_time: since the last sample [s]
    """
    there = present(value)
    size = absolute(value - run.value)
    equal = both(there, size <= 0.0)
    changed = both(there, negated(equal))
    proven = both(changed, run.stuck < 0.5)
    watched = both(there, run.stuck < 0.5)
    return Run(
        where(there, value, run.value),
        where(equal, run.seconds + sample_time, where(there, 0.0, run.seconds)),
        where(changed, 0.0, run.moving_seconds + where(both(equal, moves), sample_time, 0.0)),
        where(proven, maximum(run.longest, run.moving_seconds), run.longest),
        run.seen + where(watched, sample_time, 0.0),
        run.driven + where(both(watched, moves), sample_time, 0.0),
        where(there, minimum(run.low, value), run.low),
        where(there, maximum(run.high, value), run.high),
        where(changed, minimum(run.step, size), run.step),
        where(both(proven, absolute(run.value) <= 0.0), 1.0, run.rests_at_zero),
        where(changed, 0.0, run.stuck),
    )


def is_changing(run: Run, value: Any, jitter: Any) -> Any:
    """Whether a signal is present and changes with every sample.

    Args:
        run: before the sample
        value: of the signal; not finite where missing
        jitter: longest run of equal values of such a signal [s]
    """
    return both(present(value), run.seconds < jitter)
