"""Verdict on friction: its inputs, its state, its counters and its statement."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.statement import Statement


class VerdictSample(NamedTuple):
    """Input of the verdict from a friction estimate; an estimator without a quantity gives its neutral value.

    Args:
        friction_torque: estimated friction torque
        friction_deviation: its standard deviation
        misfit: factor by which the deviation was widened because the torque balance fits badly; 1 is neutral
        enabled: 1 where the sample was used
        hands_on, same_direction, moving, rolling, settled: conditions of the gate, one by one; 1 is neutral
        build_up: share of friction that has built up, with the sign of the motion
        excitation: mean magnitude of the build-up over the enabled time; 1 is neutral
        residual: root mean square residual of the torque balance over the last enabled time; 0 is neutral
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
    """Baseline: friction of this car while it was judged fault-free.

    Args:
        level: mean of the estimate over the learning time
        deviation: mean standard deviation of the estimate
        seconds: enabled time used for learning
    """

    level: Annotated[Scalar, "N*m"]
    deviation: Annotated[Scalar, "N*m"]
    seconds: Annotated[Scalar, "s"]


class Onset(NamedTuple):
    """Last times without suspicion, and the grounds of the present alarm.

    Args:
        relative: last time at which friction was near the baseline, -1 if never
        absolute: last time at which friction was below the limit of rising friction, -1 if never
        kind: 0 without alarm, 1 where the baseline alarms, 2 where only the absolute limits do; the reported onset is
            that of the baseline where it alarms, since it is the sharper one
        decisive: 0 without alarm, 1 where the baseline gives the present status, 2 where only an absolute limit does
    """

    relative: Annotated[Scalar, "s"]
    absolute: Annotated[Scalar, "s"]
    kind: Annotated[Scalar, ""]
    decisive: Annotated[Scalar, ""]


class FrictionFigures(NamedTuple):
    """Counters of a run, on which its statement rests.

    Args:
        seconds: number of samples times sample time
        settled_seconds: time with all signals present for the settling time
        enabled_seconds: time in which the estimator learnt
        left_seconds: part of the enabled time with a turn to the left
        hands_off_seconds: settled time with a small driver's torque
        still_seconds: settled time with a steering wheel that hardly turned
        slow_seconds: settled time with a vehicle at rest or crawling
        worked_seconds: settled time with a rolling vehicle and a steering wheel turned under the driver's torque
        opposed_seconds: part of the worked time with driver and motor torque of opposite sign
        alarm_seconds: judged time under alarm
        worst_alarm: 0 none, 1 rising, 2 fault
        unfit_seconds: enabled time without interruption for which the torque balance has not fitted
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
    """Obstacles to a verdict, 1 where one holds; the first that holds decides the status.

    Args:
        no_signals: all signals were never present together for the settling time; no other obstacle is then reported
        raw_counts: torques are not in N*m
        opposed: driver and motor torque have opposite signs for too long
        too_little_time: less enabled time than a verdict needs; the obstacles below are tested only after that time
        negative: friction or self-aligning torque is negative
        damping: damping is below that of any steering
        aligning: self-aligning torque is far from the value expected by the vehicle file
        unfit: the torque balance has not fitted for too long
        short_strokes: strokes of the steering wheel are shorter than friction needs to build up
        uncertain: standard deviation is too large
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
    """The verdict after a sample, with its grounds.

    Args:
        statement: verdict on the drive so far: suspect where an alarm has ended, or friction exceeds a limit for too
            short a time; its kind is `verdict.BY_BASELINE` or `verdict.BY_LIMIT`, its evidence that for rising friction
        running: status of this sample alone, which a fault memory debounces
        obstacles: why the verdict is withheld
        implausible: 1 where friction is below that of any steering
        pending: 1 where friction exceeds a limit
        figures: counters of the run
        baseline: baseline of this car
        fit: fit of the torque balance
        known_level: level of the baseline, 0 until it is known
        ratio: friction over that level; 1 until it is known
        fault_sum: evidence for a fault, scaled as that of the statement
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
