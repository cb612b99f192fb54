"""Actuator torques from the torques that the control requests: mean over a sampling interval, and value at its end."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, limit, present, where
from tierod.methods.estimators.linear_algebra import Vector
from tierod.models.automated_forces import Torques
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.signals import ConditionSample
from tierod.physics.lag import lagged_ramp


class AskedTorques(NamedTuple):
    """Requested torques, actuator torques, and the last changes of both requested steering torques [N*m]."""

    asked: Torques
    given: Torques
    change_1: Scalar
    change_2: Scalar


def no_torques() -> AskedTorques:
    """Torques before the first sample: all zero."""
    return AskedTorques(Torques(0.0, 0.0, 0.0, 0.0), Torques(0.0, 0.0, 0.0, 0.0), 0.0, 0.0)


def torques_of(
    sample: ConditionSample,
    memory: AskedTorques,
    vehicle: AutomatedVehicle.Parameters,
    suspected: Vector,
    started: Scalar,
) -> tuple[AskedTorques, AutomatedVehicle.Input, Scalar]:
    """Next memory, inputs of the model, and square of the jump of the steering torque [N**2*m**2].

    The targets are interpolated linearly between samples, and the first-order lag of the actuators is integrated
    exactly for that. A missing target is held, and a target beyond the greatest torque of a motor is limited.

    Args:
        sample: a `ConditionSample`
        memory: torques of the previous sample
        vehicle: parameters of `AutomatedVehicle`
        suspected: 1 for an actuator that may have lost torque, else 0, in the order of `ACTUATORS`
        started: whether there was a previous sample; if not, the actuators are in steady state at their targets
    """
    targets = (
        sample.steering_motor_1_target_torque,
        sample.steering_motor_2_target_torque,
        sample.target_drive_torque_left,
        sample.target_drive_torque_right,
    )
    steering, drive = vehicle.greatest_steering_motor_torque, vehicle.greatest_drive_torque
    most = (steering, steering, drive, drive)
    lags = (vehicle.steering_motor_lag, vehicle.steering_motor_lag, vehicle.drive_lag, vehicle.drive_lag)
    asked = Torques(
        *(
            where(present(new), limit(new, -bound, bound), old)
            for new, old, bound in zip(targets, memory.asked, most, strict=True)
        )
    )
    before = [where(started, old, new) for old, new in zip(memory.asked, asked, strict=True)]
    gave = [where(started, old, new) for old, new in zip(memory.given, asked, strict=True)]
    given = [
        lagged_ramp(old, new, at_start, lag, vehicle.sample_time)
        for old, new, at_start, lag in zip(before, asked, gave, lags, strict=True)
    ]
    mean, now = [each.mean for each in given], [each.end for each in given]
    change_1, change_2 = asked[0] - before[0], asked[1] - before[1]
    whole = _jump(change_1 + change_2, memory.change_1 + memory.change_2)
    swing = suspected[0] * _jump(change_1, memory.change_1) + suspected[1] * _jump(change_2, memory.change_2)
    inputs = AutomatedVehicle.Input(*mean, *now, *suspected)
    return AskedTorques(asked, Torques(*now), change_1, change_2), inputs, whole + swing


def _jump(change: Scalar, before: Scalar) -> Scalar:
    """Square of a torque's jump beyond its trend [N**2*m**2].

    It is the product of the change and the change of the change, which is zero on a ramp and in the sample after a
    jump.
    """
    return absolute(change * (change - before))
