"""Stuck signals, sample by sample and over a recording: removed from the input of a monitor, and named."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, named_tuple
from tierod.core.graph.maths import absolute, all_of, any_of, both, either, maximum, minimum, negated, present, where
from tierod.core.signals import residue_of
from tierod.methods.relations import FOLLOWED, RATES, SAME_SPEED, SPEEDS, STEERED, TURN, is_moved, is_ordered
from tierod.physics.friction import share_reached


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


class Seen(NamedTuple):
    """Signals of one sample, and the runs of their values, by name."""

    now: dict[str, Scalar]
    runs: dict[str, EqualValues]


@dataclass(frozen=True)
class StuckSignals:
    """Detect stuck signals, which a monitor must not use; runs before the monitor.

    A signal that used to change with every sample and repeats one value for a second while the car moves is stuck. A
    signal with coarse quantisation rests without a fault, so that another one must contradict it: the angle changes
    while its rate is constant, speeds differ, a lateral acceleration comes without yaw rate, the car turns left and
    right while the steering wheel rests, or one torque changes without the other.
    """

    names: tuple[str, ...]  # canonical signals that are checked
    beside: tuple[str, ...]  # further signals that serve as evidence
    sample_time: Annotated[float, "s"]  # sampling interval [s]
    # shortest run of equal values that counts [s]; twice ten samples of the slowest channel that a monitor accepts
    shortest: Annotated[float, "s"] = 1.0
    # longest run of equal values of a signal that changes with every sample [s]; three samples at 20 Hz. A wheel at
    # rest under a sensor of 0.1 degrees has longer runs in every half minute of driving
    jitter: Annotated[float, "s"] = 0.15
    # multiple of the longest run so far from which a run counts [-]; lost frames also repeat a value
    longer: Annotated[float, ""] = 10.0
    learning: Annotated[float, "s"] = 30.0  # driving time after which a signal is known to change with every sample [s]
    # speed from which the car counts as moving [m/s]; below it sensors may rest with the car
    moving: Annotated[float, "m/s"] = 2.0
    # largest delay between signals that is not taken for a stuck signal [s]; half a second for a late channel, and a
    # tenth in reserve
    delay: Annotated[float, "s"] = 0.6
    # bound of the difference between rate and angle over a run [rad]; six degrees, above any sensor's step
    angle: Annotated[float, "rad"] = 0.1
    # growth of that bound per second of the run [rad/s]; rates have noise, and offsets, which are estimated
    drift: Annotated[float, "rad/s"] = 0.02
    # time constant of the estimated offset of a rate [s]; far longer than a turn
    offset_time: Annotated[float, "s"] = 60.0
    # bound of the difference between lateral acceleration and speed times yaw rate [m/s^2]; a road bank of 9 degrees. A
    # car that exceeds it to both sides was steered
    turn: Annotated[float, "m/s**2"] = 1.5
    # yaw rate from which a turn shows the speed [rad/s]; an offset of the lateral acceleration does not produce it at
    # 20 m/s and more
    yaw_rate: Annotated[float, "rad/s"] = 0.05
    # largest share of time with an inconsistent turn while all its signals change [-]; above it a unit, a sign or a
    # delay is wrong, and turns are no evidence
    misfit: Annotated[float, ""] = 0.05
    # time constant of the filter for the inconsistency of turns [s]; longer than the lags of a car
    smoothing: Annotated[float, "s"] = 0.5
    speed: Annotated[float, "m/s"] = 1.0  # bound of the difference of two speeds [m/s]
    # growth of that bound with the speed [-]; radius of the turn, wear of tyres and slip in braking
    slip: Annotated[float, ""] = 0.15

    class State(NamedTuple):
        """Runs of signals, contradictions of pairs, offsets of rates, residual of turns, and their misfit time [s]."""

        runs: tuple[EqualValues, ...]
        contradictions: tuple[Contradiction, ...]
        offsets: tuple[Scalar, ...]
        turn: Scalar
        misfit_seconds: Scalar

    @property
    def Sample(self) -> type:
        """All signals by name, those checked before those that serve as evidence."""
        return _sample(self.all_names)

    @property
    def Output(self) -> type:
        """Time for which each signal has been stuck [s]; 0 if it is not stuck."""
        return _sample(self.names)

    @property
    def all_names(self) -> tuple[str, ...]:
        """Signals that are checked, then those that serve as evidence."""
        return (*self.names, *self.beside)

    @property
    def rates(self) -> tuple[tuple[str, str], ...]:
        return tuple(pair for pair in RATES if self._has(pair))

    @property
    def turns(self) -> tuple[str, ...]:
        return tuple(name for name in TURN if name in self.names) if self._has(TURN) else ()

    @property
    def steered(self) -> tuple[str, ...]:
        return tuple(name for name in STEERED if name in self.names) if self._has(TURN) else ()

    @property
    def speeds(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        there = ((name, tuple(each for each in others if each in self.all_names)) for name, others in SAME_SPEED)
        return tuple((name, others) for name, others in there if name in self.names and others)

    @property
    def followers(self) -> tuple[tuple[str, str, float], ...]:
        return tuple(entry for entry in FOLLOWED if entry[0] in self.names and self._has(entry[:2]))

    def _has(self, names: tuple[str, ...]) -> bool:
        return all(name in self.all_names for name in names)

    def init(self) -> State:
        """State before the first sample."""
        pairs = 2 * len(self.rates) + len(self.turns) + len(self.speeds) + len(self.followers) + len(self.steered)
        none = (Contradiction(0.0, 0.0, 0.0),) * pairs
        return self.State((NEW,) * len(self.all_names), none, (0.0,) * len(self.rates), 0.0, 0.0)

    def step(self, state: State, sample: Any) -> tuple[State, Any]:
        """Process one sample."""
        now = dict(zip(self.all_names, sample, strict=True))
        before = dict(zip(self.all_names, state.runs, strict=True))
        moves = self._moves(now, before)
        runs = {
            name: repeated(before[name], now[name], moves[name], self.sample_time, residue_of(name))
            for name in self.all_names
        }
        offsets = tuple(
            self._offset(offset, now[rate], now[angle], before[angle].value)
            for offset, (rate, angle) in zip(state.offsets, self.rates, strict=True)
        )
        turn = self._turn(state.turn, now)
        misfit = state.misfit_seconds + self._misfit(turn, runs)
        contradictions, stuck = self._contradicted(state, Seen(now, runs), offsets, turn)
        for name in self.names:
            alone = self._rests_alone(runs[name], moves[name], name)
            found = either(alone, stuck.get(name, 0.0))
            still = both(runs[name].seconds > 0.0, either(runs[name].stuck, found))
            runs[name] = runs[name]._replace(stuck=where(still, 1.0, 0.0))
        flags = [runs[name].stuck > 0.5 for name in self.names]
        seconds = [where(flag, runs[name].seconds, 0.0) for name, flag in zip(self.names, flags, strict=True)]
        return self.State(tuple(runs.values()), contradictions, offsets, turn, misfit), self.Output(*seconds)

    def _moves(self, now: dict[str, Scalar], before: dict[str, EqualValues]) -> dict[str, Scalar]:
        """Whether the car moves, for each signal: by the speeds, or without any by changes of most force signals."""
        speeds = [name for name in SPEEDS if name in now]
        known = any_of(0.0, *(present(now[name]) for name in speeds))
        fast = any_of(0.0, *(both(absolute(now[name]) > self.moving, before[name].stuck < 0.5) for name in speeds))
        forces = [name for name in self.all_names if not is_moved(name) and not is_ordered(name)]
        forces = [name for name in forces if name not in SPEEDS]
        changing = {
            name: where(both(present(now[name]), before[name].seconds < self.jitter), 1.0, 0.0) for name in forces
        }
        there = sum((where(present(now[name]), 1.0, 0.0) for name in forces), 0.0)
        moves = {}
        for name in self.all_names:
            others = sum((changing[other] for other in forces if other != name), 0.0)
            # At least two and half of those present must change, since a single one may be faulty.
            most = both(others > 1.5, others > 0.5 * (there - 1.0)) if name in forces else 0.0
            moves[name] = where(known, fast, most)
        return moves

    def _rests_alone(self, run: EqualValues, moves: Scalar, name: str) -> Scalar:
        if is_ordered(name):
            return 0.0
        residue = residue_of(name)
        resting = either(absolute(run.value) > residue, run.rests_at_zero < 0.5)
        return all_of(
            moves,
            run.moving_seconds > maximum(self.shortest, self.longer * run.longest),
            run.longest < self.jitter,
            run.driven > self.learning,
            run.low + residue < run.value,
            run.value < run.high - residue,
            resting,
        )

    def _offset(self, offset: Scalar, rate: Scalar, angle: Scalar, angle_before: Scalar) -> Scalar:
        """Offset of a rate: low-pass filtered difference between the rate and the derivative of its angle."""
        known = all_of(present(rate), present(angle), present(angle_before))
        error = rate - (angle - where(known, angle_before, 0.0)) / self.sample_time - offset
        share = share_reached(self.sample_time / self.offset_time)
        return where(known, offset + share * where(known, error, 0.0), offset)

    def _turn(self, residual: Scalar, now: dict[str, Scalar]) -> Scalar:
        """Inconsistency of a turn: low-pass filtered lateral acceleration less speed times yaw rate [m/s^2]."""
        if not self.turns:
            return 0.0
        acceleration, yaw, speed = (now[name] for name in TURN)
        error = acceleration - yaw * speed - residual
        known = present(error)
        share = share_reached(self.sample_time / self.smoothing)
        return residual + where(known, share * where(known, error, 0.0), 0.0)

    def _misfit(self, turn: Scalar, runs: dict[str, EqualValues]) -> Scalar:
        """Sampling interval if a turn is inconsistent though all its signals change, else 0 [s]."""
        if not self.turns:
            return 0.0
        alive = all_of(*(runs[name].seconds < self.delay for name in TURN))
        return where(both(alive, absolute(turn) > self.turn), self.sample_time, 0.0)

    def _contradicted(
        self, state: State, seen: Seen, offsets: tuple[Scalar, ...], turn: Scalar
    ) -> tuple[tuple[Contradiction, ...], dict[str, Scalar]]:
        """States of all comparisons after one sample, and whether each signal is contradicted."""
        now, runs = seen
        pairs: list[tuple[str, Contradiction, Scalar, Scalar]] = []
        old = iter(state.contradictions)
        for offset, (rate, angle) in zip(offsets, self.rates, strict=True):
            pairs.append((rate, *self._rate_beside_angle(next(old), seen, rate, angle, offset), 0.0))
            pairs.append((angle, *self._angle_beside_rate(next(old), seen, rate, angle, offset), 0.0))
        for name in self.turns:
            trusted = state.misfit_seconds < self.misfit * runs[name].seen
            shows = absolute(now["yaw_rate"]) > self.yaw_rate if name == "vehicle_speed" else 1.0
            memory = _agreed(next(old), runs[name], turn)
            apart = both(absolute(turn) > self.turn, memory.start < AGREED * self.turn)
            pairs.append((name, memory, all_of(runs[name].seconds > self.delay, apart, both(trusted, shows)), 0.0))
        for name, others in self.speeds:
            pairs.append((name, *self._speed_beside_others(next(old), seen, name, others), 0.0))
        for name, other, share in self.followers:
            followed = self._beside_followed(next(old), seen, name, other, share)
            pairs.append((name, *followed, 3.0 * runs[name].longest))
        for name in self.steered:
            pairs.append(
                (name, *self._angle_beside_bends(next(old), runs[name], _bend(*(now[each] for each in TURN))), 0.0)
            )
        after: list[Contradiction] = []
        found: dict[str, Scalar] = {}
        for name, memory, violated, least in pairs:
            seconds = where(violated, minimum(memory.seconds + self.sample_time, 2.0 * self.delay), 0.0)
            after.append(memory._replace(seconds=seconds))
            enough = both(runs[name].seconds > maximum(self.shortest, least), seconds > self.delay)
            found[name] = either(found.get(name, 0.0), enough)
        return tuple(after), found

    def _rate_beside_angle(
        self, old: Contradiction, seen: Seen, rate: str, angle: str, offset: Scalar
    ) -> tuple[Contradiction, Scalar]:
        """Test of a constant rate: its angle changes by something else than the integral of the rate."""
        run, now = seen.runs[rate], seen.now[angle]
        since = run.seconds - self.delay
        start = where(both(present(now), since < 0.0), now, old.start)
        apart = absolute(now - start - (run.value - offset) * since)
        return Contradiction(start, 0.0, old.seconds), self._beyond(apart, since, seen, rate, angle, other=angle)

    def _angle_beside_rate(
        self, old: Contradiction, seen: Seen, rate: str, angle: str, offset: Scalar
    ) -> tuple[Contradiction, Scalar]:
        """Test of a constant angle: the integral of its rate departs from zero."""
        since, there = seen.runs[angle].seconds - self.delay, both(present(seen.now[rate]), present(seen.now[angle]))
        way = where(since < 0.0, 0.0, old.far + where(there, self.sample_time * (seen.now[rate] - offset), 0.0))
        beyond = self._beyond(absolute(way), since, seen, rate, angle, other=rate)
        return Contradiction(0.0, way, old.seconds), beyond

    def _beyond(self, apart: Scalar, since: Scalar, seen: Seen, rate: str, angle: str, other: str) -> Scalar:
        """Whether rate and angle differ by more than their steps and offsets explain; `other` is not the one tested."""
        runs = seen.runs
        # The error of a coarse rate grows with time, that of a coarse angle does not.
        allowed = self.angle + STEPS * runs[angle].step + (self.drift + STEPS * runs[rate].step) * since
        return all_of(since > 0.0, runs[other].stuck < 0.5, apart > allowed)

    def _angle_beside_bends(self, old: Contradiction, run: EqualValues, bend: Scalar) -> tuple[Contradiction, Scalar]:
        """Test of a constant steering angle: the car turns to one side and then to the other; `bend` [m/s^2]."""
        early = run.seconds < self.delay
        least, most = where(early, bend, minimum(old.start, bend)), where(early, bend, maximum(old.far, bend))
        passed = all_of(negated(early), least < -self.turn, most > self.turn)
        return Contradiction(least, most, old.seconds), passed

    def _speed_beside_others(
        self, old: Contradiction, seen: Seen, name: str, others: tuple[str, ...]
    ) -> tuple[Contradiction, Scalar]:
        """Test of a constant speed: all others differ from it; a wheel at zero is excluded, since it may be locked."""
        run, nearest = seen.runs[name], math.inf
        for other in others:
            apart = where(seen.runs[other].stuck < 0.5, run.value - seen.now[other], math.inf)
            nearest = where(absolute(apart) < absolute(nearest), apart, nearest)
        known = present(nearest)
        memory = _agreed(old, run, where(known, nearest, old.far))
        most = self.speed + self.slip * absolute(run.value - where(known, nearest, 0.0))
        free = 1.0 if name == "vehicle_speed" else absolute(run.value) > 0.0
        parted = all_of(known, absolute(nearest) > most, memory.start < AGREED * most)
        return memory, all_of(run.seconds > self.delay, parted, free)

    def _beside_followed(
        self, old: Contradiction, seen: Seen, name: str, followed: str, share: float
    ) -> tuple[Contradiction, Scalar]:
        """Test of a constant signal: a signal that it follows passes over a large share of its own range."""
        other, beside = seen.now[followed], seen.runs[followed]
        early, there = seen.runs[name].seconds < self.delay, present(other)
        least = where(there, where(early, other, minimum(old.start, other)), old.start)
        most = where(there, where(early, other, maximum(old.far, other)), old.far)
        ranged = most - least > share * (beside.high - beside.low)
        passed = all_of(negated(early), beside.stuck < 0.5, beside.seen > self.learning, ranged)
        return Contradiction(least, most, old.seconds), passed


def _bend(acceleration: Scalar, yaw: Scalar, speed: Scalar) -> Scalar:
    """Lateral acceleration on which both signals of a turn agree; 0 if they disagree or one is missing [m/s^2].

    It keeps its sign when the car rolls backwards, and ignores a spike of one signal.
    """
    turned = yaw * speed
    agree = all_of(present(acceleration), present(turned), acceleration * turned > 0.0)
    size = minimum(absolute(acceleration), absolute(turned))
    return where(agree, where(acceleration > 0.0, size, -size), 0.0)


def _agreed(old: Contradiction, run: EqualValues, residual: Scalar) -> Contradiction:
    """State with the residual before the run: signals that disagreed then have another defect."""
    return Contradiction(where(run.seconds > 0.0, old.start, absolute(old.far)), residual, old.seconds)


@lru_cache
def _sample(names: tuple[str, ...]) -> type:
    return named_tuple("Signals", [(name, float) for name in names])


@dataclass(frozen=True)
class Stuck:
    """Span of time over which a signal was stuck."""

    name: str  # name of the signal
    start: float  # start of the equal values, in the time of the recording [s]
    found: float  # time of the detection [s]
    end: float | None  # time of the next change [s]; None if there is none
    value: float  # value of the stuck signal [unit of the signal]
