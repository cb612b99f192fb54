"""What the condition monitor reads, what it suspects, and the hypotheses that it weighs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product
from typing import Annotated, NamedTuple

SENSORS = (
    "wheel_speed_rear_left",
    "wheel_speed_rear_right",
    "yaw_rate",
    "steering_wheel_angle",
    "steering_shaft_torque",
    "tie_rod_force",
)
"""The sensors that are judged, in the order of all outputs."""

WHEELS = SENSORS[:2]
"""The sensors of the speed."""

ACCELERATIONS = ("longitudinal_acceleration", "lateral_acceleration")
"""Sensors that help and are replaced by nothing; those beside them tell whether they can be believed."""

ACTUATORS = ("steering_motor_1", "steering_motor_2", "drive_left", "drive_right")
"""The actuators that are judged, in the order of all outputs."""

MOTORS, DRIVES = ACTUATORS[:2], ACTUATORS[2:]
"""Actuators that turn the column together, and that push the vehicle together. Where what feeds or enables them fails,
both lose the same share."""

ELEMENTS = SENSORS + ACTUATORS
"""Everything that is judged, in the order of all outputs."""

HEALTHY = "healthy"
"""Name of the hypothesis that suspects nothing."""


class ConditionSample(NamedTuple):
    """One sample of the vehicle; NaN where a signal is missing.

    Args:
        wheel_speed_rear_left, wheel_speed_rear_right: circumferential speeds of the rear wheels, as sensed
        yaw_rate: as sensed
        steering_wheel_angle: of the column, as sensed
        steering_shaft_torque: below both steering motors, as sensed
        tie_rod_force: sum of both sides, positive where it opposes a turn to the left, as sensed
        longitudinal_acceleration, lateral_acceleration: specific forces at the sensor, not judged
        steering_motor_1_target_torque, steering_motor_2_target_torque: asked of the motors, at their shafts
        target_drive_torque_left, target_drive_torque_right: asked of the drives, at the wheels
        target_steering_wheel_angle, target_vehicle_speed: what the control wants
    """

    wheel_speed_rear_left: Annotated[float, "m/s"]
    wheel_speed_rear_right: Annotated[float, "m/s"]
    yaw_rate: Annotated[float, "rad/s"]
    steering_wheel_angle: Annotated[float, "rad"]
    steering_shaft_torque: Annotated[float, "N*m"]
    tie_rod_force: Annotated[float, "N"]
    longitudinal_acceleration: Annotated[float, "m/s**2"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    steering_motor_1_target_torque: Annotated[float, "N*m"]
    steering_motor_2_target_torque: Annotated[float, "N*m"]
    target_drive_torque_left: Annotated[float, "N*m"]
    target_drive_torque_right: Annotated[float, "N*m"]
    target_steering_wheel_angle: Annotated[float, "rad"]
    target_vehicle_speed: Annotated[float, "m/s"]


@dataclass(frozen=True)
class Hypothesis:
    """One explanation: what is at fault, all else being sound.

    Args:
        name: "healthy", or the names of the suspects joined by " + "
        sensors: at fault, names from `SENSORS`
        actuators: at fault, names from `ACTUATORS`
    """

    name: str
    sensors: tuple[str, ...] = ()
    actuators: tuple[str, ...] = ()

    @property
    def suspects(self) -> tuple[str, ...]:
        """Everything at fault, sensors first."""
        return self.sensors + self.actuators

    def agrees(self, other: Hypothesis) -> bool:
        """Whether both suspect the same actuators, as far as both suspect any: what two lose together is another loss.

        Args:
            other: hypothesis
        """
        return not self.actuators or not other.actuators or self.actuators == other.actuators


def hypotheses() -> tuple[Hypothesis, ...]:
    """All explanations that are weighed, 52 in a fixed order.

    Healthy; one sensor (6); one actuator (4); two sensors (15); a sensor and an actuator (24); two actuators that share
    a supply and lose the same share (2).
    """
    singles = [((name,), ()) for name in SENSORS]
    motors = [((), (name,)) for name in ACTUATORS]
    pairs = [(pair, ()) for pair in combinations(SENSORS, 2)]
    mixed = [((sensor,), (actuator,)) for sensor, actuator in product(SENSORS, ACTUATORS)]
    shared = [((), MOTORS), ((), DRIVES)]
    return tuple(
        Hypothesis(" + ".join((*sensors, *actuators)) or HEALTHY, sensors, actuators)
        for sensors, actuators in [((), ()), *singles, *motors, *pairs, *mixed, *shared]
    )


SLIDING = Hypothesis("sliding tyres")
"""That tyres slide, and nobody is at fault; no diagnosis, but a reason for none."""
