"""A linear column under position control, its state known: what the tests of the controller turn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.models.linear import zero_order_hold
from tierod.models.steering_column import ColumnInput, ColumnParameters, SteeringColumn, without_gear
from tierod_lab.papers.column.control.position_control import ObservedColumn, PositionControl
from tierod_lab.papers.column.control.reference import Reference

STEP = 1e-3
COLUMN = ColumnParameters(0.035, 0.2286, 140.0, 18.0, 7.26, 5.517e-3, 1.4486e-4, 1.484e-3)
PLANT = zero_order_hold(SteeringColumn, COLUMN, STEP, (0.0,) * 6, (0.0,) * 3)
CONTROL = PositionControl.design(without_gear(COLUMN), COLUMN.torsion_bar_stiffness)


class Turned(NamedTuple):
    """State and torque."""

    column: Any
    torque: Any


class Seen(NamedTuple):
    """What the tests look at."""

    gear_angle: Annotated[float, "rad"]
    steering_wheel_angle: Annotated[float, "rad"]
    control: PositionControl.Output


class Driven(NamedTuple):
    """Reference, whether control is on, and a torque that disturbs the motor."""

    reference: Reference
    enabled: Annotated[float, ""]
    disturbance_torque: Annotated[float, "N*m"]


@dataclass(frozen=True)
class Rig:
    """The torque found from one state acts from the next sample on."""

    control: PositionControl = CONTROL
    parameters: Any = PLANT.parameters

    Sample = Driven

    def init(self) -> Any:
        """At rest."""
        return Turned(SteeringColumn.State(*[0.0] * 6), 0.0), self.control.init()

    def step(self, state: Any, sample: Driven) -> Any:
        """One sample on."""
        (column, torque), memory = state
        observed = ObservedColumn(
            column.steering_wheel_rate, column.motor_speed, column.steering_wheel_angle, column.motor_angle, 0.0
        )
        memory, output = self.control.step(memory, PositionControl.Sample(observed, sample.reference, sample.enabled))
        acting = ColumnInput(torque, 0.0, sample.disturbance_torque)
        after = PLANT.model.transition(column, acting, self.parameters)
        return (Turned(after, output.motor_torque), memory), Seen(
            column.gear_angle, column.steering_wheel_angle, output
        )


def turn(source, seconds, enabled=1.0, disturbance=0.0, **changes):
    """Signals of a run; `changes` are fields of the control."""
    time = np.arange(round(seconds / STEP)) * STEP
    columns = [*source.at(time), np.broadcast_to(enabled, time.shape), np.broadcast_to(disturbance, time.shape)]
    return time, scan(Rig(replace(CONTROL, **changes)), np.column_stack(columns))
