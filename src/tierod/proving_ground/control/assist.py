"""The control unit of the assist motor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.physics.assist import assist_torque
from tierod.ranges import NOT_NEGATIVE, POSITIVE


class AssistMemory(NamedTuple):
    """What the unit keeps from step to step.

    Args:
        driver_torque: of the step before [N*m]
        filtered_torque: driver's torque behind the lead filter [N*m]
    """

    driver_torque: Any
    filtered_torque: Any


@dataclass(frozen=True)
class AssistUnit:
    """Assist by characteristic and speed, behind a lead filter that keeps the loop with the torsion bar stable.

    Args:
        linear_gain, quadratic_gain, dead_band, half_speed, maximum_torque: see `tierod.physics.assist`
        lead_time, lag_time: of the filter (1 + lead s) / (1 + lag s) on the driver's torque
        motor_gear: turn of the motor per turn of the column, as the unit believes
        step_time: of the unit
    """

    linear_gain: Annotated[float, "", NOT_NEGATIVE] = 2.0
    quadratic_gain: Annotated[float, "1/(N*m)", NOT_NEGATIVE] = 1.5
    dead_band: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    half_speed: Annotated[float, "m/s", POSITIVE] = 15.0
    maximum_torque: Annotated[float, "N*m", POSITIVE] = 60.0
    lead_time: Annotated[float, "s", NOT_NEGATIVE] = 0.015
    lag_time: Annotated[float, "s", NOT_NEGATIVE] = 0.001
    motor_gear: Annotated[float, "", POSITIVE] = 20.0
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    def remembered(self) -> AssistMemory:
        """At rest."""
        return AssistMemory(0.0, 0.0)

    def decide(
        self, memory: AssistMemory, driver_torque: Any, speed: Any, angle: Any, rate: Any
    ) -> tuple[AssistMemory, Any]:
        """Requested torque at the motor shaft [N*m], once a step.

        Args:
            memory: from the step before
            driver_torque: in the torsion bar [N*m]
            speed: [m/s]
            angle, rate: of the steering wheel [rad], [rad/s]
        """
        step = self.step_time
        inertia = 2.0 * self.lag_time
        filtered = (
            (inertia - step) * memory.filtered_torque
            + (step + 2.0 * self.lead_time) * driver_torque
            + (step - 2.0 * self.lead_time) * memory.driver_torque
        ) / (inertia + step)
        torque = assist_torque(
            filtered,
            speed,
            self.linear_gain,
            self.quadratic_gain,
            self.dead_band,
            self.half_speed,
            self.maximum_torque,
        )
        return AssistMemory(driver_torque, filtered), torque / self.motor_gear
