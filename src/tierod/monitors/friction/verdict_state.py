"""What the verdict on friction reads, remembers and counts."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from tierod.core.findings import Status

STATUSES = (Status.NOT_READY, Status.NOT_IDENTIFIABLE, Status.HEALTHY, Status.RISING, Status.FAULT)
"""Status of each code that the running verdict gives out."""

NOT_READY, NOT_IDENTIFIABLE, HEALTHY = 0.0, 1.0, 2.0


class VerdictSample(NamedTuple):
    """What the verdict reads of a friction estimate; an estimator without a figure gives the neutral value.

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

    friction_torque: Annotated[Any, "N*m"]
    friction_deviation: Annotated[Any, "N*m"]
    misfit: Annotated[Any, ""]
    enabled: Annotated[Any, ""]
    hands_on: Annotated[Any, ""]
    same_direction: Annotated[Any, ""]
    moving: Annotated[Any, ""]
    rolling: Annotated[Any, ""]
    settled: Annotated[Any, ""]
    build_up: Annotated[Any, ""]
    excitation: Annotated[Any, ""]
    residual: Annotated[Any, "N*m"]
    damping: Annotated[Any, "N*m*s/rad"]
    aligning_gain: Annotated[Any, ""]


class LearntLevel(NamedTuple):
    """Friction of this very car when it was judged sound.

    Args:
        level: mean of the estimate over the learning time
        deviation: mean standard deviation of the estimate
        seconds: enabled time that went into it
    """

    level: Annotated[Any, "N*m"]
    deviation: Annotated[Any, "N*m"]
    seconds: Annotated[Any, "s"]


class Onset(NamedTuple):
    """When friction was last unsuspicious, and what the present alarm rests on.

    Args:
        relative: last time near the own level, -1 if never
        absolute: last time below the limit of rising friction, -1 if never
        kind: 0 without alarm, 1 where the own level alarms, 2 where only the absolute limits do; the time given out is
            that of the own level where it can be, which is the sharper one
        decisive: 0 without alarm, 1 where the own level gives the present status, 2 where only an absolute limit does
    """

    relative: Annotated[Any, "s"]
    absolute: Annotated[Any, "s"]
    kind: Annotated[Any, ""]
    decisive: Annotated[Any, ""]


class FrictionFigures(NamedTuple):
    """Figures of a run, for the final judgement.

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

    seconds: Annotated[Any, "s"]
    settled_seconds: Annotated[Any, "s"]
    enabled_seconds: Annotated[Any, "s"]
    left_seconds: Annotated[Any, "s"]
    hands_off_seconds: Annotated[Any, "s"]
    still_seconds: Annotated[Any, "s"]
    slow_seconds: Annotated[Any, "s"]
    worked_seconds: Annotated[Any, "s"]
    opposed_seconds: Annotated[Any, "s"]
    alarm_seconds: Annotated[Any, "s"]
    worst_alarm: Annotated[Any, ""]
    unfit_seconds: Annotated[Any, "s"]
