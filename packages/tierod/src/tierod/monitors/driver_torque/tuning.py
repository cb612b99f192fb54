"""Noise of the sensors of a column, and the tuning of its observers: values of bench and road, or measured ones."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tierod.core.residues import residue_of
from tierod.methods.analysis.noise import differences
from tierod.methods.trends.robust import usual_deviation
from tierod.models.steering_column import ColumnOutput
from tierod.vehicles import Vehicle

FEWEST = 500
"""Least number of samples for a measurement of the noise."""
MARGIN = 1.25
"""Noise assumed by a filter over the measured one; motion hides some of the noise, and none is quite white."""
LONGEST_STEP = 0.01
"""Longest time for which a rounding error stays the same while a wheel turns [s]; a wheel at rest shows none."""
SMALLER = 0.01
"""Share of a signal's changes that may be smaller than a step of its sensor; an export interpolates single values."""


@dataclass(frozen=True)
class SensorNoise:
    """Noise of both sensors, one standard deviation per sample, rounding included.

    The defaults are those of good transducers read every millisecond.

    Args:
        angle: noise of the steering wheel angle
        torque: noise of the torque of the torsion bar
    """

    angle: Annotated[float, "rad"] = math.radians(0.008)
    torque: Annotated[float, "N*m"] = 0.012


FINE = SensorNoise()
"""Sensors of a test bench."""

PRODUCTION = SensorNoise(angle=math.radians(0.04), torque=0.05)
"""Sensors of production cars, as transmitted on their bus."""

MOTOR_NOISE = math.radians(0.06)
"""Noise of the motor's angle sensor, rounding included [rad]; bench and production car have the same one."""


def measured_noise(angle: np.ndarray, torque: np.ndarray, rate: float, usual: SensorNoise) -> SensorNoise:
    """Noise of both sensors per sample.

    Second differences contain the white noise, and hardly the motion of a wheel; steps of equal size reveal rounding,
    whose error lasts for several samples while the wheel turns slowly and then counts as correspondingly more noise.

    Args:
        angle: steering wheel angle [rad], (n,)
        torque: torque of the torsion bar [N*m], (n,)
        rate: sampling rate [Hz]
        usual: noise for a signal that is too short to measure
    """
    return SensorNoise(
        max(_noise("steering_wheel_angle", angle, rate, usual.angle), 0.5 * FINE.angle),
        max(_noise("driver_torque", torque, rate, usual.torque), 0.5 * FINE.torque),
    )


def _noise(name: str, values: np.ndarray, rate: float, usual: float) -> float:
    second, first = differences(values, 2), np.diff(values)
    second, first = second[np.isfinite(second)], np.abs(first[np.isfinite(first)])
    changed = first[first > residue_of(name)]
    if len(second) < FEWEST or len(changed) < FEWEST // 10:
        return usual
    rounding = float(np.quantile(changed, SMALLER, method="lower")) / math.sqrt(12.0)
    lasting = min(len(first) / len(changed), max(LONGEST_STEP * rate, 1.0))
    return MARGIN * max(usual_deviation(second), rounding * math.sqrt(lasting))


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
