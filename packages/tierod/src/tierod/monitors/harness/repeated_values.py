"""Runs of equal values of a signal, and the tests by which related signals contradict them, sample by sample.

The argument `limits` of a test is the `StuckSignals`, with the limits by which two signals may differ.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of, both, maximum, minimum, negated, present, where


class EqualValues(NamedTuple):
    """State of one signal and its current run of equal values."""

    value: Scalar  # value of the run [unit of the signal]
    seconds: Scalar  # duration of the run [s]
    moving_seconds: Scalar  # part of the run in which the car moved [s]
    longest: Scalar  # longest such part of a run that ended with a change [s]
    seen: Scalar  # time for which the signal was present and not stuck [s]
    driven: Scalar  # part of that time in which the car moved [s]
    low: Scalar  # low, high: least and greatest value so far [unit of the signal]
    high: Scalar
    step: Scalar  # smallest change so far [unit of the signal]
    rests_at_zero: Scalar  # whether a run at zero has ended with a change
    stuck: Scalar  # whether the signal is stuck


# State of a signal before its first sample
NEW = EqualValues(math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, math.inf, -math.inf, math.inf, 0.0, 0.0)


def repeated(run: EqualValues, value: Scalar, moves: Scalar, sample_time: float, residue: float = 0.0) -> EqualValues:
    """State of a signal after one sample; a missing sample changes nothing.

    Args:
        sample_time: sampling interval [s]
        residue: difference up to which values count as equal [unit of the signal], see `residue_of`
    """
    there = present(value)
    size = absolute(value - run.value)
    equal = both(there, size <= residue)
    changed = both(there, negated(equal))
    proven = both(changed, run.stuck < 0.5)
    watched = both(there, run.stuck < 0.5)
    return EqualValues(
        where(changed, value, run.value),
        where(equal, run.seconds + sample_time, where(there, 0.0, run.seconds)),
        where(changed, 0.0, run.moving_seconds + where(both(equal, moves), sample_time, 0.0)),
        where(proven, maximum(run.longest, run.moving_seconds), run.longest),
        run.seen + where(watched, sample_time, 0.0),
        run.driven + where(both(watched, moves), sample_time, 0.0),
        where(there, minimum(run.low, value), run.low),
        where(there, maximum(run.high, value), run.high),
        where(changed, minimum(run.step, size), run.step),
        where(both(proven, absolute(run.value) <= residue), 1.0, run.rests_at_zero),
        where(changed, 0.0, run.stuck),
    )


def is_changing(run: EqualValues, value: Scalar, jitter: Scalar) -> Scalar:
    """Whether a signal is present and changes with practically every sample.

    Args:
        jitter: longest run of equal values of such a signal [s]
    """
    return both(present(value), run.seconds < jitter)


STEPS = 1.5  # Error of a difference of two readings in steps of quantisation [-]: half a step each, and half in reserve

# Share of a limit within which two signals must have agreed before a run of equal values [-], so that a constant offset
# between them is not taken for a stuck signal
AGREED = 0.5


class Contradiction(NamedTuple):
    """State of the comparison of one signal with another one since its run of equal values began."""

    # by kind of comparison, least value of the other, its value at the start of the run, or the residual before the run
    start: Scalar
    far: Scalar  # by kind of comparison, greatest value of the other, its integral since the start, or the residual
    seconds: Scalar  # time for which the two have contradicted each other without interruption [s]


def rate_beside_angle(
    limits: Any,
    old: Contradiction,
    now: dict[str, Scalar],
    runs: dict[str, EqualValues],
    rate: str,
    angle: str,
    offset: Scalar,
) -> tuple[Contradiction, Scalar]:
    """Test of a constant rate: its angle changes by something else than the integral of the rate."""
    run, there = runs[rate], present(now[angle])
    since = run.seconds - limits.delay
    start = where(both(there, since < 0.0), now[angle], old.start)
    apart = absolute(now[angle] - start - (run.value - offset) * since)
    return Contradiction(start, 0.0, old.seconds), _beyond(limits, apart, since, runs, rate, angle, other=angle)


def angle_beside_rate(
    limits: Any,
    old: Contradiction,
    now: dict[str, Scalar],
    runs: dict[str, EqualValues],
    rate: str,
    angle: str,
    offset: Scalar,
) -> tuple[Contradiction, Scalar]:
    """Test of a constant angle: the integral of its rate departs from zero."""
    since = runs[angle].seconds - limits.delay
    moved = where(both(present(now[rate]), present(now[angle])), limits.sample_time * (now[rate] - offset), 0.0)
    way = where(since < 0.0, 0.0, old.far + moved)
    return Contradiction(0.0, way, old.seconds), _beyond(limits, absolute(way), since, runs, rate, angle, other=rate)


def _beyond(
    limits: Any, apart: Scalar, since: Scalar, runs: dict[str, EqualValues], rate: str, angle: str, other: str
) -> Scalar:
    """Whether rate and angle differ by more than their steps and offsets explain; `other` is not the one tested."""
    # The error of a coarse rate grows with time, that of a coarse angle does not.
    allowed = limits.angle + STEPS * runs[angle].step + (limits.drift + STEPS * runs[rate].step) * since
    return all_of(since > 0.0, runs[other].stuck < 0.5, apart > allowed)


def beside_turn(
    limits: Any, old: Contradiction, run: EqualValues, turn: Scalar, shows: Any
) -> tuple[Contradiction, Scalar]:
    """Test of a constant signal of a turn: it disagrees with the two others."""
    memory = _agreed(old, run, turn)
    apart = both(absolute(turn) > limits.turn, memory.start < AGREED * limits.turn)
    return memory, all_of(run.seconds > limits.delay, apart, shows)


def angle_beside_bends(limits: Any, old: Contradiction, run: EqualValues, bend: Scalar) -> tuple[Contradiction, Scalar]:
    """Test of a constant steering angle: the car turns to one side and then to the other; `bend` [m/s^2]."""
    early = run.seconds < limits.delay
    least = where(early, bend, minimum(old.start, bend))
    most = where(early, bend, maximum(old.far, bend))
    passed = all_of(negated(early), least < -limits.turn, most > limits.turn)
    return Contradiction(least, most, old.seconds), passed


def bend_of(acceleration: Scalar, yaw: Scalar, speed: Scalar) -> Scalar:
    """Lateral acceleration on which both signals of a turn agree; 0 if they disagree or one is missing [m/s^2].

    It keeps its sign when the car rolls backwards, and ignores a spike of one signal.
    """
    turned = yaw * speed
    agree = all_of(present(acceleration), present(turned), acceleration * turned > 0.0)
    size = minimum(absolute(acceleration), absolute(turned))
    return where(agree, where(acceleration > 0.0, size, -size), 0.0)


def speed_beside_others(
    limits: Any,
    old: Contradiction,
    now: dict[str, Scalar],
    runs: dict[str, EqualValues],
    name: str,
    others: tuple[str, ...],
) -> tuple[Contradiction, Scalar]:
    """Test of a constant speed: all others differ from it; a wheel at zero is excluded, since it may be locked."""
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
    limits: Any, old: Contradiction, other: Scalar, run: EqualValues, beside: EqualValues, share: float
) -> tuple[Contradiction, Scalar]:
    """Test of a constant signal: a signal that it follows passes over a large share of its own range."""
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


def _agreed(old: Contradiction, run: EqualValues, residual: Scalar) -> Contradiction:
    """State with the residual before the run: signals that disagreed then have another defect."""
    return Contradiction(where(run.seconds > 0.0, old.start, absolute(old.far)), residual, old.seconds)
