"""The running verdict on friction: against the vehicle's nominal friction and against its own learnt level."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.errors import ParameterError
from tierod.core.graph.maths import all_of, both, either, maximum, minimum, negated, sqrt, where
from tierod.methods.detectors import Cusum
from tierod.monitors.friction.conditioning import SAMPLE_TIME
from tierod.monitors.friction.verdict_state import (
    HEALTHY,
    NOT_IDENTIFIABLE,
    NOT_READY,
    FrictionFigures,
    LearntLevel,
    Onset,
    VerdictSample,
)
from tierod.monitors.friction.verdict_tuning import AlarmTuning
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class FrictionLimits:
    """What a car's friction is judged against, named as in a vehicle file.

    Args:
        nominal_friction: of the sound steering [N*m]
        rising_friction: from here on friction is reported as rising [N*m]
        fault_friction: from here on as a fault [N*m]
    """

    nominal_friction: Annotated[float, "N*m"]
    rising_friction: Annotated[float, "N*m"]
    fault_friction: Annotated[float, "N*m"]

    def __post_init__(self) -> None:
        if not 0.0 < self.nominal_friction < self.rising_friction < self.fault_friction:
            raise ParameterError(
                f"friction limits must rise: 0 < nominal_friction < rising_friction < fault_friction; given "
                f"{self.nominal_friction}, {self.rising_friction}, {self.fault_friction} N*m"
            )


UNKNOWN_LIMITS = FrictionLimits(1e6, 2e6, 3e6)
"""For a car whose torques are not in N*m: no absolute limit is ever reached, the ratio alone speaks."""


class VerdictOutput(NamedTuple):
    """The verdict after a sample; code 0 not ready, 1 not identifiable, 2 healthy, 3 rising, 4 fault.

    Args:
        code: index into `tierod.monitors.friction.verdict_state.STATUSES`
        ratio: friction to the own learnt level; 1 until that is known
        level: own learnt level, 0 until known
        since: time at which the present alarm's change began, -1 without alarm or where it was there from the start
        enabled_seconds: enabled time so far
        rising_sum, fault_sum: the larger of the sums of excess over a limit of each kind, over the sum that alarms
    """

    code: Annotated[Any, ""]
    ratio: Annotated[Any, ""]
    level: Annotated[Any, "N*m"]
    since: Annotated[Any, "s"]
    enabled_seconds: Annotated[Any, "s"]
    rising_sum: Annotated[Any, ""]
    fault_sum: Annotated[Any, ""]


@dataclass(frozen=True)
class FrictionVerdict:
    """Judge a friction estimate while it runs; works for every friction estimator.

    The distance from a limit is friction over it, less one, in standard deviations of the estimate's wander. An alarm
    is a sum of that over time (Page's CUSUM with the limit itself as drift) on four limits: rising and fault, absolute
    and relative. The relative ones see a change of this car whatever the gain of its torque sensors; the absolute ones
    see a car that was bad from the start.

    Args:
        limits: the vehicle's
        tuning: of the alarms
        sample_time: time between two samples [s]
        learnt_level: own level from earlier drives [N*m]; None learns it in this recording
        learnt_deviation: its standard deviation [N*m]

    The estimate wanders slowly, so the run length of white noise does not apply: it was measured on healthy drives, see
    `tierod.monitors.friction.decisions`.
    """

    limits: FrictionLimits
    tuning: AlarmTuning = field(default_factory=AlarmTuning)
    sample_time: Annotated[float, "s"] = SAMPLE_TIME
    learnt_level: Annotated[float | None, "N*m"] = None
    learnt_deviation: Annotated[float, "N*m"] = 0.0
    alarm: Cusum = field(init=False, repr=False)

    Sample = VerdictSample

    class State(NamedTuple):
        """Learnt level, the sums of excess, when the change began, and figures of the run."""

        own: LearntLevel
        sums: tuple[Any, Any, Any, Any]
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
        """The judge for a car; without calibrated torques no absolute limit is used.

        Raises:
            ParameterError: the vehicle file lacks a limit; the message names it
        """
        limits = vehicle.parameters_for(FrictionLimits) if vehicle.calibrated else UNKNOWN_LIMITS
        return cls(limits, sample_time=sample_time, learnt_level=learnt_level, learnt_deviation=learnt_deviation)

    def init(self) -> State:
        """Nothing seen, nothing learnt but what was handed in."""
        own = LearntLevel(0.0, 0.0, 0.0)
        if self.learnt_level is not None:
            own = LearntLevel(self.learnt_level, self.learnt_deviation, self.tuning.learning_time)
        zeros = FrictionFigures(*[0.0] * len(FrictionFigures._fields))
        figures = zeros._replace(unfit_seconds=self.tuning.unfit_time)
        return self.State(own, (self.alarm.init(),) * 4, Onset(-1.0, -1.0, 0.0, 0.0), figures)

    def step(self, state: State, sample: VerdictSample) -> tuple[State, VerdictOutput]:
        """One sample on."""
        tuning, friction = self.tuning, sample.friction_torque
        figures = self._count(state.figures, sample)
        ready = figures.enabled_seconds > tuning.ready_time
        deviation = sample.friction_deviation / sample.misfit
        identifiable = all_of(
            friction > 0.0,
            deviation < tuning.largest_deviation * friction,
            sample.excitation > tuning.smallest_excitation,
            figures.unfit_seconds < tuning.unfit_time - 0.5 * self.sample_time,
            sample.damping > tuning.smallest_damping,
            sample.aligning_gain * tuning.largest_aligning_factor > 1.0,
            sample.aligning_gain < tuning.largest_aligning_factor,
        )
        judged = all_of(sample.enabled > 0.5, ready, identifiable)
        cautious = self._cautious(friction, deviation)
        own = self._learn(state.own, friction, deviation, both(judged, cautious < self.limits.rising_friction))
        known = own.seconds > tuning.shortest_learning - 0.5 * self.sample_time
        ratio = where(known, friction / where(known, own.level, 1.0), 1.0)
        sums, relative, absolute = self._alarms(state.sums, own, where(known, friction, 0.0), cautious, judged)
        alarm = maximum(relative, absolute)
        onset = self._onset(state.onset, ratio, cautious, relative, absolute, judged, figures.seconds)
        figures = figures._replace(
            alarm_seconds=figures.alarm_seconds + where(both(judged, alarm > 0.0), self.sample_time, 0.0),
            worst_alarm=maximum(figures.worst_alarm, alarm),
        )
        code = where(ready, where(identifiable, HEALTHY + alarm, NOT_IDENTIFIABLE), NOT_READY)
        since = where(onset.kind > 1.5, onset.absolute, where(onset.kind > 0.5, onset.relative, -1.0))
        level = where(known, own.level, 0.0)
        rising, fault = (maximum(sums[k].up, sums[k + 2].up) / self.alarm.threshold for k in (0, 1))
        return self.State(own, sums, onset, figures), VerdictOutput(
            code, ratio, level, since, figures.enabled_seconds, rising, fault
        )

    def _count(self, figures: FrictionFigures, sample: VerdictSample) -> FrictionFigures:
        """The figures one sample on."""
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

    def _cautious(self, friction: Any, deviation: Any) -> Any:
        """Friction less what the torques' gain and the estimate may be off: it is held against absolute limits."""
        gain = self.tuning.gain_deviation * friction
        return friction - self.tuning.confidence * sqrt(deviation * deviation + gain * gain)

    def acts_from(self, limit: float, deviation: float) -> float:
        """Friction from which an absolute limit acts: the limit and its margin.

        Args:
            limit: absolute limit of friction [N*m]
            deviation: standard deviation of the estimate, without misfit [N*m]

        Returns:
            the friction [N*m] at which friction less its margin is the limit
        """
        share = 1.0 - (self.tuning.confidence * self.tuning.gain_deviation) ** 2
        own = (self.tuning.confidence * deviation) ** 2
        return (limit + math.sqrt(limit * limit - share * (limit * limit - own))) / share

    def relative_level(self, level: Any) -> Any:
        """The own level that the ratios are taken of: one handed in is raised by its standard deviation."""
        return level if self.learnt_level is None else level + self.tuning.confidence * self.learnt_deviation

    def _learn(self, own: LearntLevel, friction: Any, deviation: Any, sound: Any) -> LearntLevel:
        """The own level one sample on: a mean, frozen while friction is suspicious and once enough is learnt.

        Args:
            own: so far
            friction, deviation: of this sample [N*m]
            sound: whether friction is judged, and below the absolute limit
        """
        tuning = self.tuning
        unsuspicious = either(
            own.seconds < tuning.shortest_learning, friction < (1.0 + tuning.learning_tolerance) * own.level
        )
        learning = all_of(sound, unsuspicious, own.seconds < tuning.learning_time)
        seconds = own.seconds + where(learning, self.sample_time, 0.0)
        share = where(learning, self.sample_time / maximum(seconds, self.sample_time), 0.0)
        return LearntLevel(
            own.level + where(learning, share * (friction - own.level), 0.0),
            own.deviation + where(learning, share * (deviation - own.deviation), 0.0),
            seconds,
        )

    def _alarms(
        self, sums: tuple[Any, ...], own: LearntLevel, friction: Any, cautious: Any, judged: Any
    ) -> tuple[tuple[Any, ...], Any, Any]:
        """Sums of excess, and the alarms by the own level and by the absolute limits: 0 none, 1 rising, 2 fault."""
        tuning, limits = self.tuning, self.limits
        level = self.relative_level(own.level)
        excesses = (
            friction / where(level > 0.0, tuning.rising_ratio * level, 1.0),
            friction / where(level > 0.0, tuning.fault_ratio * level, 1.0),
            cautious / limits.rising_friction,
            cautious / limits.fault_friction,
        )
        after, raised = [], []
        for total, excess in zip(sums, excesses, strict=True):
            total, output = self.alarm.step(total, (excess - 1.0) / tuning.wander * self.sample_time, judged)
            after.append(total)
            raised.append(output.alarm)
        relative = where(raised[1] > 0.5, 2.0, raised[0])
        absolute = where(raised[3] > 0.5, 2.0, raised[2])
        return tuple(after), relative, absolute

    def _onset(
        self, onset: Onset, ratio: Any, cautious: Any, relative: Any, absolute: Any, judged: Any, now: Any
    ) -> Onset:
        """When friction was last unsuspicious by either measure, and which of them alarms."""
        near = both(judged, ratio < self.tuning.onset_ratio)
        below = both(judged, cautious < self.limits.rising_friction)
        return Onset(
            where(near, now, onset.relative),
            where(below, now, onset.absolute),
            where(relative > 0.0, 1.0, where(absolute > 0.0, 2.0, 0.0)),
            where(relative >= absolute, where(relative > 0.0, 1.0, 0.0), 2.0),
        )
