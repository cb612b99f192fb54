"""The loop of a column, its observer and its position control, cut at the motor's torque."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tierod.core.block import leaves, rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.core.graph.derivatives import jacobian
from tierod.models.linear import LinearSystem
from tierod.papers.column.control.position_control import ObservedColumn, PositionControl
from tierod.papers.column.control.reference import Reference

Reading = Callable[[Any], tuple[ObservedColumn, Any]]
"""Finds the observed column and the torque of the hands in what an observer puts out."""


SETTLED = 1000
"""Samples at rest after which an observer counts as settled."""


def read_estimate(estimate: Any) -> tuple[ObservedColumn, Any]:
    """State and torque of the hands from an estimate, or its mean, that names them."""
    named = getattr(estimate, "mean", estimate)
    motor_angle = named.motor_angle if hasattr(named, "motor_angle") else named.motor_angle_mechanical
    column = ObservedColumn(
        named.steering_wheel_rate, named.motor_speed, named.steering_wheel_angle, motor_angle, named.disturbance_torque
    )
    return column, named.hand_torque


def open_loop(
    plant: LinearSystem, observer: Any, control: PositionControl, read: Reading = read_estimate
) -> LinearSystem:
    """What the controller asks of the motor for a torque that acts on the column, sign turned; for `margins`.

    Args:
        plant: discrete, from the motor's torque to what the observer measures, in its order
        observer: block whose sample is the motor's torque, asked for, that acted in the sample before, and what is
            measured; linearised after `SETTLED` samples at rest
        control: in full hold, its limits not reached, following a reference at rest
        read: finds in the observer's output what the controller takes

    Raises:
        ParameterError: a plant whose outputs are not those that the observer measures
    """
    sample = skeleton(observer.Sample)
    names = [name for name, _ in leaves(sample)][1:]
    count = len(names)
    if plant.C.shape[0] != count or plant.B.shape[1] != 1:
        raise ParameterError(
            f"the plant has the outputs {', '.join(plant.outputs)} and {plant.B.shape[1]} inputs; "
            f"expected {count} outputs, {', '.join(names)}, and one input"
        )
    start = (_settled(observer, count + 1), 0.0, 0.0, 0.0, tuple([0.0] * count))

    def compensator(now: Any) -> Any:
        """(observer, integral, torque asked for in the sample before, and in that before it, measured)."""
        observed, integral, asked, before, measured = now
        observed, estimate = observer.step(observed, rebuild(sample, [before, *measured]))
        column, _ = read(estimate)
        state = control.State(asked, integral, 1.0)
        after, output = control.step(state, control.Sample(column, Reference(*[0.0] * 5), 1.0))
        return observed, after.integral, output.motor_torque, asked

    whole = np.array(jacobian(compensator, start), float)
    n, m = len(plant.A), len(whole)
    told = whole[:, m:]
    A = np.block([[plant.A, np.zeros((n, m))], [told @ plant.C, whole[:, :m]]])
    asked = np.zeros((1, n + m))
    asked[0, -2] = -1.0
    return LinearSystem.of(A, asked, np.concatenate([plant.B, told @ plant.D]))


def _settled(observer: Any, samples: int) -> Any:
    return rebuild(observer.init(), scan(observer, np.zeros((SETTLED, samples))).state.values.tolist())
