"""Inertia and damping of a steering wheel with hands off, from its angle and the torque in the torsion bar."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.methods.analysis.noise import white_noise
from tierod.methods.identification.regression import instrumental

SMOOTHING = 0.03
"""Standard deviation of the Gaussian smoothing in time [s]. It passes motion up to about 5 Hz, which separates inertia
from damping, and limits the noise of the second derivative, which falls with its power of -2.5. With a noise of 0.05
degrees the inertia from 16 s of motion scatters by 0.3 % at 8 ms and by 0.04 % from 24 ms on."""


class WheelMotion(NamedTuple):
    """One recording with a free wheel, on a uniform grid.

    Args:
        steering_wheel_angle: [rad]
        motor_angle: divided by the ratio of the gear [rad]; the instrument
        bar_torque: [N m], positive towards left
        sample_time: sampling interval [s]
    """

    steering_wheel_angle: np.ndarray
    motor_angle: np.ndarray
    bar_torque: np.ndarray
    sample_time: float


class WheelSide(NamedTuple):
    """Estimate of the wheel's inertia and damping; the inertia is NaN if it was given.

    Args:
        inertia: J_sw [kg m^2]
        damping: beta_sw [N m s/rad]
        residual: root mean square residual torque after smoothing [N m]
    """

    inertia: float
    damping: float
    inertia_deviation: float
    damping_deviation: float
    residual: float
    strength: float


def wheel_side(recordings: Sequence[WheelMotion], inertia: float | None = None) -> WheelSide:
    """Fit of J w' + beta w + bar torque = constant, smoothed, with derivatives of the motor's angle as instruments.

    Smoothing and differentiation are weightings with a Gaussian curve and its derivatives, the same for all signals, so
    that no noisy signal is differentiated. The noise of the wheel's angle in the regressors would bias the coefficients
    towards zero; the motor's angle follows the wheel, but has independent noise.

    Args:
        inertia: known inertia [kg m^2]; None to estimate it

    Raises:
        InputError: the wheel hardly moves

    The standard deviations are the larger of two: the estimate for autocorrelated residuals, which is inaccurate after
    a few slow oscillations, and the one from the white noise of both sensors, propagated through the smoothing.

    Source: Raffone, eq (1) with T_driver = 0.
    """
    targets, regressors, instruments = [], [], []
    for each in recordings:
        weights = _weights(each.sample_time)
        torque = -_weighted(each.bar_torque, weights[0])
        known, seen = (
            [_weighted(angle - angle[0], weight) for weight in weights[1:]]
            for angle in (each.steering_wheel_angle, each.motor_angle)
        )
        if inertia is not None:
            torque = torque - inertia * known[1]
            known, seen = known[:1], seen[:1]
        constant = np.ones(len(torque))
        targets.append(torque)
        regressors.append(np.column_stack([*known, constant]))
        instruments.append(np.column_stack([*seen, constant]))
    found = instrumental(targets, regressors, instruments)
    both = inertia is None
    moments = float(found.values[1]) if inertia is None else inertia
    noises = [_noise(each, z, moments, found.values[0]) for each, z in zip(recordings, instruments, strict=True)]
    white = np.sum(noises, axis=0)
    sensors = found.inverse @ white @ found.inverse.T
    spread = np.sqrt(np.maximum(np.diag(found.covariance), np.diag(sensors)))
    return WheelSide(
        float(found.values[1]) if both else math.nan,
        float(found.values[0]),
        float(spread[1]) if both else math.nan,
        float(spread[0]),
        found.residual,
        found.strength,
    )


def _noise(motion: WheelMotion, instruments: np.ndarray, inertia: float, damping: float) -> np.ndarray:
    curve, first, second = (weight[::-1] for weight in _weights(motion.sample_time))
    torque = np.array([np.convolve(z, curve) for z in instruments.T]) * white_noise(motion.bar_torque)
    through = inertia * second + damping * first
    angle = np.array([np.convolve(z, through) for z in instruments.T]) * white_noise(motion.steering_wheel_angle)
    return torque @ torque.T + angle @ angle.T


def _weights(sample_time: float) -> list[np.ndarray]:
    reach = math.ceil(6.0 * SMOOTHING / sample_time)
    time = np.arange(-reach, reach + 1) * sample_time
    curve = np.exp(-0.5 * (time / SMOOTHING) ** 2) * sample_time / (SMOOTHING * math.sqrt(2.0 * math.pi))
    first = -time / SMOOTHING**2 * curve
    second = (time**2 / SMOOTHING**4 - 1.0 / SMOOTHING**2) * curve
    return [curve, first, second]


def _weighted(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.convolve(values, weights, mode="valid")
