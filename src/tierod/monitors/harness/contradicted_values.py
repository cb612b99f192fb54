"""Signals that repeat one value while a related one shows that they should have moved, sample by sample.

Every comparison takes the memory of the last sample, the present values and the runs of equal values by name, and
returns the memory after the sample and whether the other signal contradicts the run. It says so at each sample; how
long that must last is for `StuckSignals` to say.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tierod.core.graph.maths import absolute, all_of, both, maximum, minimum, negated, present, where
from tierod.monitors.harness.repeated_values import Run

STEPS = 1.5
"""Steps of quantisation by which a difference of two readings may be off [-]: half a step each, and half in reserve."""

AGREED = 0.5
"""Share of a limit within which two signals were before a run of equal values [-]: a standing offset is no such run."""


class Contradiction(NamedTuple):
    """Memory of one signal compared with another one since its run of equal values began.

    Args:
        start: least value of the other, its value at the start of the run, or the residual before it
        far: greatest value of the other, the way that it integrates to, or the residual
        seconds: for which the two have contradicted each other [s]
    """

    start: Any
    far: Any
    seconds: Any


class PairLimits(NamedTuple):
    """The parameters of `StuckSignals` by which two signals may differ; units and reasons stand there."""

    sample_time: Any
    learning: Any
    delay: Any
    angle: Any
    drift: Any
    turn: Any
    speed: Any
    slip: Any


def rate_beside_angle(
    limits: PairLimits,
    old: Contradiction,
    now: dict[str, Any],
    runs: dict[str, Run],
    rate: str,
    angle: str,
    offset: Any,
) -> tuple[Contradiction, Any]:
    """A rate that stays while its angle moves by another way than the rate integrates to."""
    run, there = runs[rate], present(now[angle])
    since = run.seconds - limits.delay
    start = where(both(there, since < 0.0), now[angle], old.start)
    apart = absolute(now[angle] - start - (run.value - offset) * since)
    return Contradiction(start, 0.0, old.seconds), _beyond(limits, apart, since, runs[rate], runs[angle])


def angle_beside_rate(
    limits: PairLimits,
    old: Contradiction,
    now: dict[str, Any],
    runs: dict[str, Run],
    rate: str,
    angle: str,
    offset: Any,
) -> tuple[Contradiction, Any]:
    """An angle that stays while its rate integrates to a way."""
    since = runs[angle].seconds - limits.delay
    moved = where(both(present(now[rate]), present(now[angle])), limits.sample_time * (now[rate] - offset), 0.0)
    way = where(since < 0.0, 0.0, old.far + moved)
    return Contradiction(0.0, way, old.seconds), _beyond(limits, absolute(way), since, runs[angle], runs[rate])


def _beyond(limits: PairLimits, apart: Any, since: Any, run: Run, other: Run) -> Any:
    """Whether rate and angle differ by more than their steps and offsets explain."""
    rate, angle = minimum(run.step, other.step), maximum(run.step, other.step)
    return all_of(
        since > 0.0,
        other.stuck < 0.5,
        apart > limits.angle + STEPS * angle + (limits.drift + STEPS * rate) * since,
    )


def beside_turn(limits: PairLimits, old: Contradiction, run: Run, turn: Any, shows: Any) -> tuple[Contradiction, Any]:
    """A signal of a turn that stays while the others turn."""
    memory = _agreed(old, run, turn)
    apart = both(absolute(turn) > limits.turn, memory.start < AGREED * limits.turn)
    return memory, all_of(run.seconds > limits.delay, apart, shows)


def speed_beside_others(
    limits: PairLimits,
    old: Contradiction,
    now: dict[str, Any],
    runs: dict[str, Run],
    name: str,
    others: tuple[str, ...],
) -> tuple[Contradiction, Any]:
    """A speed that stays while all others change; a wheel at rest may be locked."""
    run, nearest = runs[name], math.inf
    for other in others:
        apart = where(runs[other].stuck < 0.5, run.value - now[other], math.inf)
        nearest = where(absolute(apart) < absolute(nearest), apart, nearest)
    known = present(nearest)
    memory = _agreed(old, run, where(known, nearest, old.far))
    most = limits.speed + limits.slip * absolute(run.value - where(known, nearest, 0.0))
    free = 1.0 if name == "vehicle_speed" else absolute(run.value) > 0.0
    parted = all_of(known, absolute(nearest) > most, memory.start < AGREED * most)
    return memory, all_of(run.seconds > limits.delay, parted, free)


def beside_followed(
    limits: PairLimits, old: Contradiction, other: Any, run: Run, beside: Run, share: float
) -> tuple[Contradiction, Any]:
    """A signal that stays while one that it follows passes over much of its range."""
    early, there = run.seconds < limits.delay, present(other)
    least = where(there, where(early, other, minimum(old.start, other)), old.start)
    most = where(there, where(early, other, maximum(old.far, other)), old.far)
    passed = all_of(
        negated(early),
        beside.stuck < 0.5,
        beside.seen > limits.learning,
        most - least > share * (beside.high - beside.low),
    )
    return Contradiction(least, most, old.seconds), passed


def _agreed(old: Contradiction, run: Run, residual: Any) -> Contradiction:
    """With the residual of the sample before the run: what did not agree then contradicts by another defect."""
    return Contradiction(where(run.seconds > 0.0, old.start, absolute(old.far)), residual, old.seconds)
