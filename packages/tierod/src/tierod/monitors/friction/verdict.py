"""The verdict on friction, sample by sample: against the vehicle's nominal friction and against its own baseline."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.findings import Status
from tierod.core.graph.maths import all_of, any_of, both, either, maximum, minimum, negated, sqrt, where
from tierod.core.statuses import Statement, code_of
from tierod.methods.detectors import Cusum
from tierod.monitors.decision import decides, declared
from tierod.monitors.friction.signals import SAMPLE_TIME
from tierod.monitors.friction.thresholds import ABSOLUTE, BASELINE, AlarmTuning
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import torque_gain_deviation


class VerdictSample(NamedTuple):
    """Input of the verdict from a friction estimate; an estimator without a quantity gives its neutral value."""

    friction_torque: Annotated[Scalar, "N*m"]  # estimated friction torque
    friction_deviation: Annotated[Scalar, "N*m"]  # its standard deviation
    # factor by which the deviation was widened because the torque balance fits badly; 1 is neutral
    misfit: Annotated[Scalar, ""]
    enabled: Annotated[Scalar, ""]  # 1 where the sample was used
    # hands_on, same_direction, moving, rolling, settled: conditions of the gate, one by one; 1 is neutral
    hands_on: Annotated[Scalar, ""]
    same_direction: Annotated[Scalar, ""]
    moving: Annotated[Scalar, ""]
    rolling: Annotated[Scalar, ""]
    settled: Annotated[Scalar, ""]
    build_up: Annotated[Scalar, ""]  # share of friction that has built up, with the sign of the motion
    excitation: Annotated[Scalar, ""]  # mean magnitude of the build-up over the enabled time; 1 is neutral
    # root mean square residual of the torque balance over the last enabled time; 0 is neutral
    residual: Annotated[Scalar, "N*m"]
    damping: Annotated[Scalar, "N*m*s/rad"]  # learnt viscous damping; 0 is neutral
    aligning_gain: Annotated[Scalar, ""]  # learnt factor on the self-aligning torque of the vehicle file; 1 is neutral


class LearntBaseline(NamedTuple):
    """Baseline: friction of this car while it was judged fault-free."""

    level: Annotated[Scalar, "N*m"]  # mean of the estimate over the learning time
    deviation: Annotated[Scalar, "N*m"]  # mean standard deviation of the estimate
    seconds: Annotated[Scalar, "s"]  # enabled time used for learning


class Onset(NamedTuple):
    """Last times without suspicion, and the grounds of the present alarm."""

    relative: Annotated[Scalar, "s"]  # last time at which friction was near the baseline, -1 if never
    absolute: Annotated[Scalar, "s"]  # last time at which friction was below the limit of rising friction, -1 if never
    # 0 without alarm, 1 where the baseline alarms, 2 where only the absolute limits do; the reported onset is that of
    # the baseline where it alarms, since it is the sharper one
    kind: Annotated[Scalar, ""]
    # 0 without alarm, 1 where the baseline gives the present status, 2 where only an absolute limit does
    decisive: Annotated[Scalar, ""]


class FrictionFigures(NamedTuple):
    """Counters of a run, on which its statement rests."""

    seconds: Annotated[Scalar, "s"]  # number of samples times sample time
    settled_seconds: Annotated[Scalar, "s"]  # time with all signals present for the settling time
    enabled_seconds: Annotated[Scalar, "s"]  # time in which the estimator learnt
    left_seconds: Annotated[Scalar, "s"]  # part of the enabled time with a turn to the left
    hands_off_seconds: Annotated[Scalar, "s"]  # settled time with a small driver's torque
    still_seconds: Annotated[Scalar, "s"]  # settled time with a steering wheel that hardly turned
    slow_seconds: Annotated[Scalar, "s"]  # settled time with a vehicle at rest or crawling
    # settled time with a rolling vehicle and a steering wheel turned under the driver's torque
    worked_seconds: Annotated[Scalar, "s"]
    opposed_seconds: Annotated[Scalar, "s"]  # part of the worked time with driver and motor torque of opposite sign
    alarm_seconds: Annotated[Scalar, "s"]  # judged time under alarm
    worst_alarm: Annotated[Scalar, ""]  # 0 none, 1 rising, 2 fault
    # enabled time without interruption for which the torque balance has not fitted
    unfit_seconds: Annotated[Scalar, "s"]


class Obstacles(NamedTuple):
    """Obstacles to a verdict, 1 where one holds; the first that holds decides the status."""

    # all signals were never present together for the settling time; no other obstacle is then reported
    no_signals: Annotated[Scalar, ""]
    raw_counts: Annotated[Scalar, ""]  # torques are not in N*m
    opposed: Annotated[Scalar, ""]  # driver and motor torque have opposite signs for too long
    # less enabled time than a verdict needs; the obstacles below are tested only after that time
    too_little_time: Annotated[Scalar, ""]
    negative: Annotated[Scalar, ""]  # friction or self-aligning torque is negative
    damping: Annotated[Scalar, ""]  # damping is below that of any steering
    aligning: Annotated[Scalar, ""]  # self-aligning torque is far from the value expected by the vehicle file
    unfit: Annotated[Scalar, ""]  # the torque balance has not fitted for too long
    short_strokes: Annotated[Scalar, ""]  # strokes of the steering wheel are shorter than friction needs to build up
    uncertain: Annotated[Scalar, ""]  # standard deviation is too large


class BalanceFit(NamedTuple):
    """Estimate of the torque balance and quality of its fit, see `VerdictSample`.

    `friction_deviation` is that of the estimate for exact gains of the torques; the statement's includes the gains.
    """

    friction_deviation: Annotated[Scalar, "N*m"]
    misfit: Annotated[Scalar, ""]
    residual: Annotated[Scalar, "N*m"]
    excitation: Annotated[Scalar, ""]
    damping: Annotated[Scalar, "N*m*s/rad"]
    aligning_gain: Annotated[Scalar, ""]


class JudgedFriction(NamedTuple):
    """The verdict after a sample, with its grounds."""

    # verdict on the drive so far: suspect where an alarm has ended, or friction exceeds a limit for too short a time;
    # its kind is `verdict.BY_BASELINE` or `verdict.BY_LIMIT`, its evidence that for rising friction
    statement: Statement
    running: Annotated[Scalar, ""]  # status of this sample alone, which a fault memory debounces
    obstacles: Obstacles  # why the verdict is withheld
    implausible: Annotated[Scalar, ""]  # 1 where friction is below that of any steering
    pending: Annotated[Scalar, ""]  # 1 where friction exceeds a limit
    figures: FrictionFigures  # counters of the run
    baseline: LearntBaseline  # baseline of this car
    fit: BalanceFit  # fit of the torque balance
    known_level: Annotated[Scalar, "N*m"]  # level of the baseline, 0 until it is known
    ratio: Annotated[Scalar, ""]  # friction over that level; 1 until it is known
    fault_sum: Annotated[Scalar, ""]  # evidence for a fault, scaled as that of the statement


HEALTHY = code_of(Status.HEALTHY)

BY_BASELINE, BY_LIMIT = 1.0, 2.0
"""Kinds of a friction statement: above the car's own baseline, or above a limit of the vehicle file alone."""

REACH = 2.0
"""Standard deviations within which friction may be that of a fault-free car, and its level is learnt [-]: the ends of a
95 % band, as for the spread of parameters. A verdict above the limit is then suspect at most."""

OPPOSED_SHARE = 0.3
"""Share of worked time with opposed driver and motor torques above which lane keeping is assumed to be active [-].
Fault-free driving stays below 0.01 (simulated); a recorded minute under lane keeping has 0.47."""


@dataclass(frozen=True)
class FrictionLimits:
    """Limits of a car's friction, named as in a vehicle file."""

    nominal_friction: Annotated[float, "N*m"]  # friction of the fault-free steering [N*m]
    rising_friction: Annotated[float, "N*m"]  # friction from which it is reported as rising [N*m]
    fault_friction: Annotated[float, "N*m"]  # friction from which it is reported as a fault [N*m]

    def __post_init__(self) -> None:
        if not 0.0 < self.nominal_friction < self.rising_friction < self.fault_friction:
            raise ParameterError(
                f"friction limits must rise: 0 < nominal_friction < rising_friction < fault_friction; given "
                f"{self.nominal_friction}, {self.rising_friction}, {self.fault_friction} N*m"
            )


@dataclass(frozen=True)
class FrictionVerdict:
    """Running verdict on the estimate of any friction estimator.

    The excess over a limit is the ratio of friction to it, less one, in standard deviations of the estimate's wander.
    An alarm is the sum of the excess over time (Page's CUSUM with the limit itself as drift) for four limits: rising
    and fault, absolute and relative. The relative limits detect a change of this car whatever the gain of its torque
    sensors; the absolute limits detect a car that was faulty from the start.

    Args:
        limits: limits of the vehicle; None where its torques are not in N*m, so that only the ratio to the baseline
            alarms
        learnt_level: baseline from earlier drives [N*m]; None learns it in this recording
        rising_deviation, fault_deviation: standard deviation of each limit in the vehicle file [N*m]

    The estimate wanders slowly, so that the run length for white noise does not apply; it was measured on fault-free
    drives, see `tierod.monitors.friction.thresholds`.
    """

    limits: FrictionLimits | None
    tuning: AlarmTuning = field(default_factory=AlarmTuning, metadata=decides(*ABSOLUTE))  # tuning of the alarms
    sample_time: Annotated[float, "s"] = SAMPLE_TIME  # time between two samples [s]
    learnt_level: Annotated[float | None, "N*m"] = None
    learnt_deviation: Annotated[float, "N*m"] = 0.0  # standard deviation of that baseline [N*m]
    rising_deviation: Annotated[float, "N*m"] = 0.0
    fault_deviation: Annotated[float, "N*m"] = 0.0
    gain_given: bool = False  # whether the vehicle file states the deviation of the torques' gain
    alarm: Cusum = field(init=False, repr=False, metadata=decides(*BASELINE))

    Sample = VerdictSample

    class State(NamedTuple):
        """Learnt baseline, sums of excess, onset of the change, and counters of the run."""

        own: LearntBaseline
        sums: tuple[Cusum.State, Cusum.State, Cusum.State, Cusum.State]
        onset: Onset
        figures: FrictionFigures

    def __post_init__(self) -> None:
        if self.learnt_level is not None and not self.learnt_level > 0.0:
            raise ParameterError(f"learnt_level is {self.learnt_level} N*m; expected a positive torque, or None")
        object.__setattr__(self, "alarm", self.tuning.alarm)

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float, learnt_level: float | None = None, learnt_deviation: float = 0.0
    ) -> FrictionVerdict:
        """The verdict for a vehicle; without calibrated torques no absolute limit is used.

        The deviation of the torques' gain is that of the vehicle file, where it gives one.
        """
        limits = vehicle.parameters_for(FrictionLimits) if vehicle.calibrated else None
        gain = torque_gain_deviation(vehicle)
        tuning = AlarmTuning(gain_deviation=gain.value)
        rising, fault = 0.0, 0.0
        if limits is not None:
            rising = vehicle.parameters["rising_friction"].standard_deviation or 0.0
            fault = vehicle.parameters["fault_friction"].standard_deviation or 0.0
        return cls(limits, tuning, sample_time, learnt_level, learnt_deviation, rising, fault, gain.given)

    def init(self) -> State:
        own = LearntBaseline(0.0, 0.0, 0.0)
        if self.learnt_level is not None:
            own = LearntBaseline(self.learnt_level, self.learnt_deviation, self.tuning.learning_time)
        zeros = FrictionFigures(*[0.0] * len(FrictionFigures._fields))
        # Counts as unfit from the start: the balance must have fitted once before the first verdict.
        figures = zeros._replace(unfit_seconds=self.tuning.unfit_time)
        start = self.alarm.init()
        return self.State(own, (start, start, start, start), Onset(-1.0, -1.0, 0.0, 0.0), figures)

    def step(self, state: State, sample: VerdictSample) -> tuple[State, JudgedFriction]:
        friction, deviation = sample.friction_torque, sample.friction_deviation / sample.misfit
        figures = self._count(state.figures, sample)
        obstacles = self._obstacles(figures, sample)
        ready = figures.enabled_seconds > self.tuning.ready_time
        # The deviation counts without the misfit here: a step of friction misfits and must not suppress its own alarm.
        identifiable = both(negated(any_of(*obstacles[4:9])), deviation < self.tuning.largest_deviation * friction)
        judged = all_of(sample.enabled > 0.5, ready, identifiable)
        spreads = [self.spread_in_margin(each) for each in (Status.RISING, Status.FAULT)]
        least = [self._less_margin(friction, deviation, self.margin, each) for each in spreads]
        below, perhaps_below = 1.0, 1.0
        if self.limits is not None:
            below = least[0] < self.limits.rising_friction
            surely = self._less_margin(friction, deviation, REACH, self.rising_deviation)
            perhaps_below = surely < self.limits.rising_friction
        own = self._learn(state.own, friction, deviation, both(judged, perhaps_below))
        known = own.seconds > self.tuning.shortest_learning - 0.5 * self.sample_time
        ratio = where(known, friction / where(known, own.level, 1.0), 1.0)
        sums, relative, absolute = self._alarms(state.sums, own, where(known, friction, 0.0), least, judged)
        alarm = maximum(relative, absolute)
        onset = self._onset(state.onset, ratio, below, relative, absolute, judged, figures.seconds)
        figures = figures._replace(
            alarm_seconds=figures.alarm_seconds + where(both(judged, alarm > 0.0), self.sample_time, 0.0),
            worst_alarm=maximum(figures.worst_alarm, alarm),
        )
        risen = where(alarm > 1.5, code_of(Status.FAULT), where(alarm > 0.5, code_of(Status.RISING), HEALTHY))
        doubted = where(identifiable, risen, code_of(Status.NOT_IDENTIFIABLE))
        above_own = both(known, friction > self.tuning.rising_ratio * self.relative_level(own.level))
        pending = either(above_own, negated(below))
        implausible = 0.0
        if self.limits is not None:
            implausible = friction < self.tuning.smallest_friction * self.limits.nominal_friction
        suspect = either(implausible, both(alarm < 0.5, either(figures.worst_alarm > 0.0, pending)))
        status = _withheld_status(obstacles, figures, where(suspect, code_of(Status.SUSPECT), risen))
        alarmed = both(status > HEALTHY, status <= code_of(Status.FAULT))
        since = where(onset.kind > 1.5, onset.absolute, where(onset.kind > 0.5, onset.relative, -1.0))
        rising, fault = (maximum(sums[k].up, sums[k + 2].up) / self.alarm.threshold for k in (0, 1))
        statement = Statement(
            status=status,
            since=where(both(alarmed, negated(suspect)), since, -1.0),
            kind=onset.decisive,
            magnitude=friction,
            deviation=self._with_gain(friction, sample.friction_deviation),
            evidence=rising,
        )
        return self.State(own, sums, onset, figures), JudgedFriction(
            statement=statement,
            running=where(ready, doubted, code_of(Status.NOT_READY)),
            obstacles=obstacles,
            implausible=where(implausible, 1.0, 0.0),
            pending=where(pending, 1.0, 0.0),
            figures=figures,
            baseline=own,
            fit=BalanceFit(*(getattr(sample, name) for name in BalanceFit._fields)),
            known_level=where(known, own.level, 0.0),
            ratio=ratio,
            fault_sum=fault,
        )

    def _obstacles(self, figures: FrictionFigures, sample: VerdictSample) -> Obstacles:
        """Obstacles to a verdict after this sample."""
        tuning, friction, gain = self.tuning, sample.friction_torque, sample.aligning_gain
        settled, enough = figures.settled_seconds > 0.0, figures.enabled_seconds >= tuning.ready_time
        positive, factor = both(friction > 0.0, gain > 0.0), tuning.largest_aligning_factor
        usual = both(gain * factor > 1.0, gain < factor)
        early = (
            negated(settled),
            where(settled, 1.0 if self.limits is None else 0.0, 0.0),
            both(settled, figures.opposed_seconds > OPPOSED_SHARE * figures.worked_seconds),
            both(settled, negated(enough)),
        )
        late = (
            negated(positive),
            negated(sample.damping > minimum(tuning.smallest_damping, -tuning.falling_share * friction)),
            both(gain > 0.0, negated(usual)),
            figures.unfit_seconds > tuning.unfit_time - 0.5 * self.sample_time,
            negated(sample.excitation > tuning.smallest_excitation),
            both(friction > 0.0, sample.friction_deviation > tuning.largest_deviation * friction),
        )
        return Obstacles(*(where(each, 1.0, 0.0) for each in (*early, *(both(enough, each) for each in late))))

    def _count(self, figures: FrictionFigures, sample: VerdictSample) -> FrictionFigures:
        """The counters after one more sample."""
        settled = sample.settled > 0.5
        hands_on, moving, rolling = sample.hands_on > 0.5, sample.moving > 0.5, sample.rolling > 0.5
        enabled = sample.enabled > 0.5
        worked = all_of(settled, hands_on, moving, rolling)
        now = {
            "seconds": 1.0,
            "settled_seconds": settled,
            "enabled_seconds": enabled,
            "left_seconds": both(enabled, sample.build_up > 0.0),
            "hands_off_seconds": both(settled, negated(hands_on)),
            "still_seconds": both(settled, negated(moving)),
            "slow_seconds": both(settled, negated(rolling)),
            "worked_seconds": worked,
            "opposed_seconds": both(worked, negated(sample.same_direction > 0.5)),
        }
        counted = {name: getattr(figures, name) + where(held, self.sample_time, 0.0) for name, held in now.items()}
        misfits = both(
            sample.misfit > self.tuning.fitting_misfit,
            sample.residual > self.tuning.largest_residual * sample.friction_torque,
        )
        ready = counted["enabled_seconds"] > self.tuning.ready_time
        unfit = where(
            misfits,
            minimum(figures.unfit_seconds + self.sample_time, self.tuning.unfit_time),
            where(ready, 0.0, figures.unfit_seconds),
        )
        return figures._replace(**counted, unfit_seconds=where(enabled, unfit, figures.unfit_seconds))

    @property
    def margin(self) -> float:
        """Standard deviations of gain and estimate by which friction must exceed an absolute limit [-].

        Beside a given baseline, whose ratio contains no gain, only what surely exceeds a limit counts.
        """
        return self.tuning.confidence if self.learnt_level is None else REACH

    def spread_in_margin(self, status: Status) -> float:
        """Standard deviation of an absolute limit that is part of its margin [N*m]; only beside a given baseline."""
        if self.learnt_level is None:
            return 0.0
        return self.rising_deviation if status is Status.RISING else self.fault_deviation

    def _less_margin(self, friction: Scalar, deviation: Scalar, reach: float, limit_spread: float) -> Scalar:
        """Friction less its margin: errors of torque gain and estimate, and of the limit."""
        spread = self._with_gain(friction, deviation)
        return friction - reach * sqrt(spread * spread + limit_spread * limit_spread)

    def _with_gain(self, friction: Scalar, deviation: Scalar) -> Scalar:
        """Standard deviation of friction with the error of the torques' common gain, which scales it."""
        gain = self.tuning.gain_deviation * friction
        return sqrt(deviation * deviation + gain * gain)

    def acts_from(self, limit: float, deviation: float, spread: float = 0.0) -> float:
        """Friction from which an absolute limit acts: the limit plus its margin.

        Args:
            limit: absolute limit of friction [N*m]
            deviation: standard deviation of the estimate, without misfit [N*m]
            spread: standard deviation of the limit in its margin [N*m]
        """
        share = 1.0 - (self.margin * self.tuning.gain_deviation) ** 2
        # Solves friction - margin(friction) = limit, a quadratic since the gain error scales with friction.
        own = self.margin**2 * (deviation * deviation + spread**2)
        return (limit + math.sqrt(limit * limit - share * (limit * limit - own))) / share

    def relative_level(self, level: Scalar) -> Scalar:
        """The level that the ratio limits multiply: a given baseline is raised by its standard deviation."""
        return level if self.learnt_level is None else level + self.tuning.confidence * self.learnt_deviation

    def _learn(self, own: LearntBaseline, friction: Scalar, deviation: Scalar, fault_free: Scalar) -> LearntBaseline:
        """Update the baseline: a mean, frozen while friction is suspicious and once enough is learnt."""
        tuning = self.tuning
        unsuspicious = either(
            own.seconds < tuning.shortest_learning, friction < (1.0 + tuning.learning_tolerance) * own.level
        )
        learning = all_of(fault_free, unsuspicious, own.seconds < tuning.learning_time)
        seconds = own.seconds + where(learning, self.sample_time, 0.0)
        share = where(learning, self.sample_time / maximum(seconds, self.sample_time), 0.0)
        return LearntBaseline(
            own.level + where(learning, share * (friction - own.level), 0.0),
            own.deviation + where(learning, share * (deviation - own.deviation), 0.0),
            seconds,
        )

    def _alarms(
        self,
        sums: tuple[Cusum.State, ...],
        own: LearntBaseline,
        friction: Scalar,
        least: Sequence[Scalar],
        judged: Scalar,
    ) -> tuple[tuple[Cusum.State, Cusum.State, Cusum.State, Cusum.State], Scalar, Scalar]:
        """Sums of excess, and the alarms by baseline and by absolute limits: 0 none, 1 rising, 2 fault."""
        tuning, level = self.tuning, self.relative_level(own.level)
        absolute_excesses = (0.0, 0.0)
        if self.limits is not None:
            absolute_excesses = least[0] / self.limits.rising_friction, least[1] / self.limits.fault_friction
        excesses = (
            friction / where(level > 0.0, tuning.rising_ratio * level, 1.0),
            friction / where(level > 0.0, tuning.fault_ratio * level, 1.0),
            *absolute_excesses,
        )
        after, raised = [], []
        for total, excess in zip(sums, excesses, strict=True):
            total, output = self.alarm.step(total, (excess - 1.0) / tuning.wander * self.sample_time, judged)
            after.append(total)
            raised.append(output.alarm)
        relative = where(raised[1] > 0.5, 2.0, raised[0])
        absolute = where(raised[3] > 0.5, 2.0, raised[2])
        return (after[0], after[1], after[2], after[3]), relative, absolute

    def _onset(
        self,
        onset: Onset,
        ratio: Scalar,
        below: Scalar,
        relative: Scalar,
        absolute: Scalar,
        judged: Scalar,
        now: Scalar,
    ) -> Onset:
        """Times at which friction was last unsuspicious by either measure, and which of them alarms."""
        near = both(judged, ratio < self.tuning.onset_ratio)
        return Onset(
            where(near, now, onset.relative),
            where(both(judged, below), now, onset.absolute),
            where(relative > 0.0, 1.0, where(absolute > 0.0, 2.0, 0.0)),
            where(relative >= absolute, where(relative > 0.0, 1.0, 0.0), 2.0),
        )


def _withheld_status(obstacles: Obstacles, figures: FrictionFigures, otherwise: Scalar) -> Scalar:
    """Status code of the first obstacle; `otherwise` where there is none."""
    not_enabled, not_ready = code_of(Status.NOT_ENABLED), code_of(Status.NOT_READY)
    early = {
        "no_signals": code_of(Status.NOT_AVAILABLE),
        "too_little_time": where(figures.enabled_seconds > 0.0, not_ready, not_enabled),
    }
    status = otherwise
    for name, there in reversed(list(zip(Obstacles._fields, obstacles, strict=True))):
        status = where(there > 0.5, early.get(name, code_of(Status.NOT_IDENTIFIABLE)), status)
    return status


DECISIONS = declared(FrictionVerdict, "block.verdict")
"""Decisions of every variant with the running verdict: rising and fault, by vehicle file and by baseline."""
