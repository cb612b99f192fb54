"""Verdict on friction: its inputs, its state, its counters and its statement."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.statement import Statement


class VerdictSample(NamedTuple):
    """Input of the verdict from a friction estimate; an estimator without a figure gives the neutral value.

    Args:
        friction_torque: estimated
        friction_deviation: its standard deviation
        misfit: factor by which that was widened because the torque balance fits badly; 1 is neutral
        enabled: 1 where the sample was used
        hands_on, same_direction, moving, rolling, settled: conditions of the gate, one by one; 1 is neutral
        build_up: share of friction that has built up, with the sign of the motion
        excitation: its mean magnitude over the enabled time; 1 is neutral
        residual: root mean square of what the torque balance leaves open over the last enabled time; 0 is neutral
        damping: learnt viscous damping; 0 is neutral
        aligning_gain: learnt factor on the self-aligning torque of the vehicle file; 1 is neutral
    """

    friction_torque: Annotated[Scalar, "N*m"]
    friction_deviation: Annotated[Scalar, "N*m"]
    misfit: Annotated[Scalar, ""]
    enabled: Annotated[Scalar, ""]
    hands_on: Annotated[Scalar, ""]
    same_direction: Annotated[Scalar, ""]
    moving: Annotated[Scalar, ""]
    rolling: Annotated[Scalar, ""]
    settled: Annotated[Scalar, ""]
    build_up: Annotated[Scalar, ""]
    excitation: Annotated[Scalar, ""]
    residual: Annotated[Scalar, "N*m"]
    damping: Annotated[Scalar, "N*m*s/rad"]
    aligning_gain: Annotated[Scalar, ""]


class LearntBaseline(NamedTuple):
    """Friction of this very car when it was judged fault-free.

    Args:
        level: mean of the estimate over the learning time
        deviation: mean standard deviation of the estimate
        seconds: enabled time that went into it
    """

    level: Annotated[Scalar, "N*m"]
    deviation: Annotated[Scalar, "N*m"]
    seconds: Annotated[Scalar, "s"]


class Onset(NamedTuple):
    """Times at which friction was last unsuspicious, and the grounds of the present alarm.

    Args:
        relative: last time near the baseline, -1 if never
        absolute: last time below the limit of rising friction, -1 if never
        kind: 0 without alarm, 1 where the baseline alarms, 2 where only the absolute limits do; the time given out is
            that of the baseline where it can be, which is the sharper one
        decisive: 0 without alarm, 1 where the baseline gives the present status, 2 where only an absolute limit does
    """

    relative: Annotated[Scalar, "s"]
    absolute: Annotated[Scalar, "s"]
    kind: Annotated[Scalar, ""]
    decisive: Annotated[Scalar, ""]


class FrictionFigures(NamedTuple):
    """Figures of a run, that its statement rests on.

    Args:
        seconds: samples times sample time
        settled_seconds: with all signals present long enough
        enabled_seconds: that the estimator learnt from
        left_seconds: of these, turning left
        hands_off_seconds: settled, but the driver's torque was small
        still_seconds: settled, but the steering wheel hardly turned
        slow_seconds: settled, but the vehicle stood or crept
        worked_seconds: settled, rolling, the wheel turning with the driver's torque on it
        opposed_seconds: of these, driver and motor against each other
        alarm_seconds: judged time under alarm
        worst_alarm: 0 none, 1 rising, 2 fault
        unfit_seconds: enabled time for which the torque balance has not fitted without a break
    """

    seconds: Annotated[Scalar, "s"]
    settled_seconds: Annotated[Scalar, "s"]
    enabled_seconds: Annotated[Scalar, "s"]
    left_seconds: Annotated[Scalar, "s"]
    hands_off_seconds: Annotated[Scalar, "s"]
    still_seconds: Annotated[Scalar, "s"]
    slow_seconds: Annotated[Scalar, "s"]
    worked_seconds: Annotated[Scalar, "s"]
    opposed_seconds: Annotated[Scalar, "s"]
    alarm_seconds: Annotated[Scalar, "s"]
    worst_alarm: Annotated[Scalar, ""]
    unfit_seconds: Annotated[Scalar, "s"]


class Obstacles(NamedTuple):
    """Reasons to withhold the verdict, 1 where one holds; the first that holds decides the status.

    Args:
        no_signals: never were all signals present together for the settling time; the only one that is then stated
        raw_counts: torques are not in N*m
        opposed: driver and motor against each other for too long
        too_little_time: less enabled time than a verdict needs; those below are not looked at before
        negative: friction or self-aligning torque
        damping: below what any steering has
        aligning: self-aligning torque far from what the vehicle file expects
        unfit: the torque balance has not fitted for too long
        short_strokes: shorter than friction needs to build up
        uncertain: standard deviation too large
    """

    no_signals: Annotated[Scalar, ""]
    raw_counts: Annotated[Scalar, ""]
    opposed: Annotated[Scalar, ""]
    too_little_time: Annotated[Scalar, ""]
    negative: Annotated[Scalar, ""]
    damping: Annotated[Scalar, ""]
    aligning: Annotated[Scalar, ""]
    unfit: Annotated[Scalar, ""]
    short_strokes: Annotated[Scalar, ""]
    uncertain: Annotated[Scalar, ""]


class BalanceFit(NamedTuple):
    """Quality of the torque balance's fit, see `VerdictSample`."""

    misfit: Annotated[Scalar, ""]
    residual: Annotated[Scalar, "N*m"]
    excitation: Annotated[Scalar, ""]
    damping: Annotated[Scalar, "N*m*s/rad"]
    aligning_gain: Annotated[Scalar, ""]


class JudgedFriction(NamedTuple):
    """The verdict after a sample, and its grounds.

    Args:
        statement: on the drive so far: suspect where an alarm came and went, or friction is above a limit for too short
            a time; its kind is `verdict.BY_BASELINE` or `verdict.BY_LIMIT`, its evidence that for rising friction
        running: status of this moment alone, which a fault memory debounces
        obstacles: why the verdict is withheld
        implausible: 1 where friction is below what any steering has
        pending: 1 where friction is above a limit that acts
        figures: of the run
        baseline: of this very car
        fit: of the torque balance
        known_level: level of the baseline, 0 until it is known
        ratio: friction to that level; 1 until it is known
        fault_sum: evidence for a fault, as that of the statement
    """

    statement: Statement
    running: Annotated[Scalar, ""]
    obstacles: Obstacles
    implausible: Annotated[Scalar, ""]
    pending: Annotated[Scalar, ""]
    figures: FrictionFigures
    baseline: LearntBaseline
    fit: BalanceFit
    known_level: Annotated[Scalar, "N*m"]
    ratio: Annotated[Scalar, ""]
    fault_sum: Annotated[Scalar, ""]
