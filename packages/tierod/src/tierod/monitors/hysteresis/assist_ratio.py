"""Comparison of the torques of a lock-to-lock test with the assist characteristic of the vehicle file."""

from __future__ import annotations

import numpy as np

from tierod.core.findings import Defect
from tierod.methods.identification.lock_to_lock import noise_left, noise_of, smoothed
from tierod.monitors.friction.torque_gains import BOTH, AssistCharacteristic, GainLimits
from tierod.physics.assist import assist_torque
from tierod.physics.steering_ratio import column_torque_of_motor
from tierod.vehicles import Vehicle

LEAST_SAMPLES = 300
"""Least number of samples, three seconds of the test."""

NOISY = 0.25
"""Noise of the driver's torque over its own variation above which the torques are not compared; it moves the ratio by
6 % of the quadratic part."""


def torque_defects(
    time: np.ndarray,
    driver_torque: np.ndarray,
    motor_torque: np.ndarray,
    vehicle: Vehicle,
    limits: GainLimits | None = None,
) -> tuple[Defect, ...]:
    """Defects where the motor does not assist as in this car type at standstill; none where the file has no map.

    Args:
        time: times of the torques [s], (n,)
        driver_torque, motor_torque: torques of a standing car [N*m], (n,); NaN where missing
        vehicle: vehicle with the assist characteristic
        limits: limits of the ratio of the torques; virtual cars on hoist and ground give 0.97 to 1.00, with 2 to
            12 N*m of friction
    """
    limits = limits or GainLimits()
    p = AssistCharacteristic.of(vehicle)
    used = np.isfinite(driver_torque) & np.isfinite(motor_torque)
    if p is None or np.count_nonzero(used) < LEAST_SAMPLES:
        return ()
    time = time[used]
    driver, motor = (smoothed(each[used], time) for each in (driver_torque, motor_torque))
    # The assist is quadratic: with noise of the driver's torque the motor would seem to give too little.
    if noise_left(noise_of(driver_torque[used], time), time) > NOISY * float(np.std(driver)):
        return ()
    motor = column_torque_of_motor(motor, p.motor_ratio)
    usual = assist_torque(driver, 0.0, p.assist_linear_gain, p.assist_quadratic_gain, 0.0, p.assist_half_speed, np.inf)
    power = float(usual @ usual)
    if not max(power, float(motor @ motor)) > limits.smallest**2 * len(usual):
        return ()
    ratio = float(usual @ motor) / power if power > 0.0 else np.inf
    if 1.0 / limits.ratio < ratio < limits.ratio:
        return ()
    sentence = (
        "driver_torque or motor_torque has a wrong gain, or the assist map of the vehicle file is that of another car: "
        f"the motor gives {ratio:.2f} times what the map gives at rest"
    )
    return (Defect(BOTH, sentence),)
