"""The filter of every hypothesis, made from the one that suspects nobody."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.signals import DRIVES, SENSORS, Hypothesis

COMMON_LOSS_TIME = 20.0
"""Over which a share that two actuators lose together changes [s]; one that follows the split of the torque within
0.1 s would explain the loss of either alone."""
TURNING = SENSORS[:3]
"""Sensors that tell together how fast the wheels' readings are beside the vehicle."""


def leaving_out(hypothesis: Hypothesis, base: LeaveOutFilter) -> LeaveOutFilter:
    """The filter of one hypothesis.

    Args:
        hypothesis: whom it suspects
        base: the filter that suspects nobody
    """
    changes: dict[str, Any] = {f"use_{name}": 0.0 for name in hypothesis.sensors}
    changes |= {f"trust_{name}": 0.0 for name in hypothesis.actuators}
    error = base.model_error
    if not {*TURNING}.isdisjoint(hypothesis.sensors):
        error = replace(error, wheel_speed_scale=error.wheel_speed_scale_alone)
    if not {*DRIVES}.isdisjoint(hypothesis.actuators):
        error = replace(error, drive_excess=error.drive_excess_alone)
    changes["model_error"] = error
    if len(hypothesis.actuators) > 1:
        changes["vehicle"] = replace(base.vehicle, fading=replace(base.vehicle.fading, loss=COMMON_LOSS_TIME))
    return replace(base, **changes)
