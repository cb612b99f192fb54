"""Position control of a column that lets go when a driver takes the wheel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.papers.column.control.flat_column import motion_for
from tierod.papers.column.control.intervention import DriverIntervention
from tierod.papers.column.control.position_control import ObservedColumn, PositionControl
from tierod.papers.column.control.reference import Reference


@dataclass(frozen=True)
class SteeringController:
    """Follow a reference until hands are found on the wheel, then let go.

    Args:
        position: the control
        intervention: when it ends, and when it comes back
    """

    position: PositionControl
    intervention: DriverIntervention

    class Sample(NamedTuple):
        """What is observed of the column and the hands, what is wanted, and whether it is asked for (1.0 or 0.0)."""

        observed: ObservedColumn
        hand_torque: Annotated[float, "N*m"]
        reference: Reference
        request: Annotated[float, ""]

    class State(NamedTuple):
        """Of both parts."""

        position: PositionControl.State
        intervention: DriverIntervention.State

    class Output(NamedTuple):
        """What both parts say; `control.motor_torque` is to be asked of the motor."""

        control: PositionControl.Output
        driver: DriverIntervention.Output

    def init(self) -> State:
        """Let go."""
        return self.State(self.position.init(), self.intervention.init())

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on."""
        position = self.position
        planned = motion_for(sample.reference, position.column, position.output_stiffness)
        judged = self.intervention.Sample(sample.hand_torque, planned.steering_wheel_acceleration, sample.request)
        intervention, driver = self.intervention.step(state.intervention, judged)
        asked = position.Sample(sample.observed, sample.reference, driver.allowed)
        after, control = position.step(state.position, asked)
        return self.State(after, intervention), self.Output(control, driver)
