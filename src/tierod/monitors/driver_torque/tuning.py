"""Tuning of the column observers: noises of bench and road, and values derived from rate and sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

from tierod.models.steering_column import ColumnOutput
from tierod.monitors.driver_torque.sensor_noise import MOTOR_NOISE, SensorNoise
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class ColumnTuning:
    """Noises of a column and its sensors; random walks are per square root of a second.

    The defaults are for a bench with 0.1 N·m of friction at the motor, tuned on simulated runs: two with hands that
    jump and two with hands that pull within 100 ms; reported results come from other runs.

    Args:
        steering_wheel_angle_noise, motor_angle_noise, driver_torque_noise: standard deviation of a sample
        hand_torque_rate_walk: walk of the rate of the hands' torque, while they move smoothly
        hand_torque_walk: walk of the torque itself while it jumps; 0 for hands that never do, which leaves one filter
        calm_time, jump_time: mean time between two jumps of the hands, and mean duration of one
        disturbance_torque_walk: walk of the disturbance torque at the motor's shaft
        reversal_walk: walk of the disturbance torque while friction reverses; 0 for none, which leaves out one filter
        reversal_time, reversing_time: mean time between two reversals, and mean duration of one
        pinion_torque_noise: white unknown torque at the gear, of road and rack, per sample of 1 ms
        offset_walk: walk of the offset, as torque of the bar; learnt within 4 s to 0.002 N·m
        offset: sensor with an offset that is learnt: "motor_angle_mechanical" where the angles are not set to zero
            on the unloaded bar, "driver_torque" on a bench where they are, None for neither. The two offsets are not
            separable: both appear as a twist of the bar that its torque does not confirm
        outputs: measured outputs
    """

    steering_wheel_angle_noise: Annotated[float, "rad"] = math.radians(0.05)
    motor_angle_noise: Annotated[float, "rad"] = math.radians(0.2)
    driver_torque_noise: Annotated[float, "N*m"] = 0.02
    hand_torque_rate_walk: Annotated[float, "N*m/s**1.5"] = 5.0
    hand_torque_walk: Annotated[float, "N*m/s**0.5"] = 7.0
    calm_time: Annotated[float, "s"] = 10.0
    jump_time: Annotated[float, "s"] = 0.01
    disturbance_torque_walk: Annotated[float, "N*m/s**0.5"] = 0.1
    reversal_walk: Annotated[float, "N*m/s**0.5"] = 1.0
    reversal_time: Annotated[float, "s"] = 0.3
    reversing_time: Annotated[float, "s"] = 0.05
    pinion_torque_noise: Annotated[float, "N*m"] = 0.0
    offset_walk: Annotated[float, "N*m/s**0.5"] = 1e-3
    offset: str | None = None
    outputs: tuple[str, ...] = ColumnOutput._fields

    def variances(self) -> tuple[float, ...]:
        """Variances of the measured outputs."""
        noises = {
            "steering_wheel_angle": self.steering_wheel_angle_noise,
            "motor_angle_mechanical": self.motor_angle_noise,
            "driver_torque": self.driver_torque_noise,
        }
        return tuple(noises[name] ** 2 for name in self.outputs)


ROAD = replace(ColumnTuning(), disturbance_torque_walk=0.5, pinion_torque_noise=1.0, offset="motor_angle_mechanical")
"""Noises of a car on the road: unmeasured torques of rack and road act on the pinion, and the angles are not zeroed."""

LONGEST_JUMP = 3.0
"""Least duration of a jump of the hands' torque, in samples."""


def usual_tuning(vehicle: Vehicle) -> ColumnTuning:
    """Tuning of the road for a vehicle file with `column_inertia`, else that of a bench."""
    return ROAD if "column_inertia" in vehicle else ColumnTuning()


def tuning_at(rate: float, usual: ColumnTuning, noise: SensorNoise, with_motor: bool) -> ColumnTuning:
    """The tuning of the observer for a sampling rate and the noise of the sensors.

    Args:
        rate: sampling rate [Hz]
        usual: tuning of the vehicle
        noise: noise of the sensors at the wheel
        with_motor: whether the motor's angle is measured
    """
    outputs = ColumnOutput._fields if with_motor else ("steering_wheel_angle", "driver_torque")
    offset = usual.offset if with_motor or usual.offset != "motor_angle_mechanical" else None
    jump = max(usual.jump_time, LONGEST_JUMP / rate)
    return replace(
        usual,
        steering_wheel_angle_noise=noise.angle,
        motor_angle_noise=MOTOR_NOISE,
        driver_torque_noise=noise.torque,
        jump_time=jump,
        outputs=outputs,
        offset=offset,
    )
