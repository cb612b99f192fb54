"""Runs of equal values of a signal, and related signals that contradict them, sample by sample."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of, both, maximum, minimum, negated, present, where


class EqualValues(NamedTuple):
    """Memory of one signal and its run of equal values.

    Args:
        value: its last, the one that it repeats [its unit]
        seconds: for which it has repeated that [s]
        moving_seconds: ... of them while the car moved [s]
        longest: such time that ended with a change [s]
        seen: time for which it was present and not stuck [s]
        driven: ... of that while the car moved [s]
        low, high: least and greatest value [its unit]
        step: smallest change [its unit]
        rests_at_zero: whether it was zero before
        stuck: whether it is stuck
    """

    value: Scalar
    seconds: Scalar
    moving_seconds: Scalar
    longest: Scalar
    seen: Scalar
    driven: Scalar
    low: Scalar
    high: Scalar
    step: Scalar
    rests_at_zero: Scalar
    stuck: Scalar


NEW = EqualValues(math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, math.inf, -math.inf, math.inf, 0.0, 0.0)
"""A signal that has not been seen yet."""


def repeated(run: EqualValues, value: Scalar, moves: Scalar, sample_time: float, residue: float = 0.0) -> EqualValues:
    """The run of a signal one sample on; a missing sample changes nothing.

    Args:
        run: before the sample
        value: of the signal; not finite where missing
        moves: whether the car moves
        sample_time: since the last sample [s]
        residue: difference up to which values are equal [its unit], see `residue_of`
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
    """Whether a signal is present and changes with every sample.

    Args:
        run: before the sample
        value: of the signal; not finite where missing
        jitter: longest run of equal values of such a signal [s]
    """
    return both(present(value), run.seconds < jitter)


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

    start: Scalar
    far: Scalar
    seconds: Scalar


class PairLimits(NamedTuple):
    """The parameters of `StuckSignals` by which two signals may differ; units and reasons stand there."""

    sample_time: Any
    learning: Scalar
    delay: Scalar
    angle: Scalar
    drift: Scalar
    turn: Scalar
    speed: Scalar
    slip: Scalar


def rate_beside_angle(
    limits: PairLimits,
    old: Contradiction,
    now: dict[str, Scalar],
    runs: dict[str, EqualValues],
    rate: str,
    angle: str,
    offset: Scalar,
) -> tuple[Contradiction, Scalar]:
    """A rate that stays while its angle moves by another way than the rate integrates to."""
    run, there = runs[rate], present(now[angle])
    since = run.seconds - limits.delay
    start = where(both(there, since < 0.0), now[angle], old.start)
    apart = absolute(now[angle] - start - (run.value - offset) * since)
    return Contradiction(start, 0.0, old.seconds), _beyond(limits, apart, since, runs[rate], runs[angle])


def angle_beside_rate(
    limits: PairLimits,
    old: Contradiction,
    now: dict[str, Scalar],
    runs: dict[str, EqualValues],
    rate: str,
    angle: str,
    offset: Scalar,
) -> tuple[Contradiction, Scalar]:
    """An angle that stays while its rate integrates to a way."""
    since = runs[angle].seconds - limits.delay
    moved = where(both(present(now[rate]), present(now[angle])), limits.sample_time * (now[rate] - offset), 0.0)
    way = where(since < 0.0, 0.0, old.far + moved)
    return Contradiction(0.0, way, old.seconds), _beyond(limits, absolute(way), since, runs[angle], runs[rate])


def _beyond(limits: PairLimits, apart: Scalar, since: Scalar, run: EqualValues, other: EqualValues) -> Scalar:
    """Whether rate and angle differ by more than their steps and offsets explain."""
    rate, angle = minimum(run.step, other.step), maximum(run.step, other.step)
    return all_of(
        since > 0.0,
        other.stuck < 0.5,
        apart > limits.angle + STEPS * angle + (limits.drift + STEPS * rate) * since,
    )


def beside_turn(
    limits: PairLimits, old: Contradiction, run: EqualValues, turn: Scalar, shows: Any
) -> tuple[Contradiction, Scalar]:
    """A signal of a turn that stays while the others turn."""
    memory = _agreed(old, run, turn)
    apart = both(absolute(turn) > limits.turn, memory.start < AGREED * limits.turn)
    return memory, all_of(run.seconds > limits.delay, apart, shows)


def angle_beside_bends(
    limits: PairLimits, old: Contradiction, run: EqualValues, bend: Scalar
) -> tuple[Contradiction, Scalar]:
    """A steering angle that stays while the car turns to one side and then to the other [m/s^2]."""
    early = run.seconds < limits.delay
    least = where(early, bend, minimum(old.start, bend))
    most = where(early, bend, maximum(old.far, bend))
    passed = all_of(negated(early), least < -limits.turn, most > limits.turn)
    return Contradiction(least, most, old.seconds), passed


def bend_of(acceleration: Scalar, yaw: Scalar, speed: Scalar) -> Scalar:
    """Lateral acceleration that both signals of a turn show; 0 where they part or one is missing [m/s^2].

    A car that rolls back keeps its sign, and a spike of one signal shows nothing.
    """
    turned = yaw * speed
    agree = all_of(present(acceleration), present(turned), acceleration * turned > 0.0)
    size = minimum(absolute(acceleration), absolute(turned))
    return where(agree, where(acceleration > 0.0, size, -size), 0.0)


def speed_beside_others(
    limits: PairLimits,
    old: Contradiction,
    now: dict[str, Scalar],
    runs: dict[str, EqualValues],
    name: str,
    others: tuple[str, ...],
) -> tuple[Contradiction, Scalar]:
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
    limits: PairLimits, old: Contradiction, other: Scalar, run: EqualValues, beside: EqualValues, share: float
) -> tuple[Contradiction, Scalar]:
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


def _agreed(old: Contradiction, run: EqualValues, residual: Scalar) -> Contradiction:
    """Contradiction with the residual before the run: signals that disagreed then have another defect."""
    return Contradiction(where(run.seconds > 0.0, old.start, absolute(old.far)), residual, old.seconds)
