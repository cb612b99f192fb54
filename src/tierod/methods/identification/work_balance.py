"""The work balance over a closed loop of a steering wheel (Mohtat et al., eqs 15 to 17)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.identification.closed_loop import Loop


class Motion(NamedTuple):
    """Signals of a test on one time grid, shape (n,) each; the motor torque referred to the steering wheel axis.

    Angle and rate are those of the column below the torsion bar, on which the driver's torque, measured there, works.
    """

    time: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    driver_torque: np.ndarray
    motor_torque: np.ndarray


@dataclass(frozen=True)
class WorkBalance:
    """The terms of eq (16) over one closed loop, and eq (17) for the loop and for each direction.

    Args:
        start, stop: times of the loop [s]
        driver_work, motor_work, kinetic_energy, viscous_work: terms of eq (15) [J]
        path: integral of |d angle| [rad]
        friction_torque: eq (17) [N m]
        friction_towards_left, friction_towards_right: mean resisting torque of the strokes in one direction [N m];
            they differ by twice the offset of the torque sensor where the locks lie symmetrically about the middle
        mean_rate: viscous work over path and damping, the rate that the damping acts at [rad/s]
        gap: angle by which the loop fails to close [rad]
        torque_range: largest less smallest torque [N m]
    """

    start: float
    stop: float
    driver_work: float
    motor_work: float
    kinetic_energy: float
    viscous_work: float
    path: float
    friction_torque: float
    friction_towards_left: float
    friction_towards_right: float
    mean_rate: float
    gap: float
    torque_range: float


def work_balance(loop: Loop, motion: Motion, inertia: float, damping: float) -> WorkBalance:
    """The terms of eqs (15) to (17), stroke by stroke, so that noise on the angle adds nothing to the path.

    Args:
        loop: the stretch of samples that is balanced
        motion: signals, without NaN
        inertia: J_eq at the steering wheel axis, below the bar [kg m^2]
        damping: B_eq at the steering wheel axis, below the bar [N m s/rad]

    Raises:
        InputError: the work is negative, so that a sign is wrong
    """
    time, angle, rate, driver, motor = motion
    total = driver + motor - damping * rate
    kinetic = 0.5 * inertia * rate**2
    sides: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
    for begin, end in pairwise(loop.corners):
        stroke = slice(begin, end + 1)
        work = integral(total[stroke], angle[stroke]) - float(kinetic[end] - kinetic[begin])
        sides[bool(angle[end] > angle[begin])].append((work, abs(float(angle[end] - angle[begin]))))
    left, right = (np.sum(sides[side], axis=0) for side in (True, False))
    whole = slice(loop.first, loop.last + 1)
    path = float(left[1] + right[1])
    speed_integral = integral(rate[whole], angle[whole])
    friction = float(left[0] + right[0]) / path
    if friction <= 0.0:
        raise InputError(
            f"the work done on the steering over the loop is negative ({friction * path:.1f} J), but friction only "
            "takes work; turn the sign of the torques or of the angle (left is positive for all)"
        )
    return WorkBalance(
        start=float(time[loop.first]),
        stop=float(time[loop.last]),
        driver_work=integral(driver[whole], angle[whole]),
        motor_work=integral(motor[whole], angle[whole]),
        kinetic_energy=float(kinetic[loop.last] - kinetic[loop.first]),
        viscous_work=damping * speed_integral,
        path=path,
        friction_torque=friction,
        friction_towards_left=float(left[0] / left[1]),
        friction_towards_right=float(right[0] / right[1]),
        mean_rate=speed_integral / path,
        gap=loop.gap,
        torque_range=float(np.ptp(total[whole])),
    )


def half_width(angle: np.ndarray, torque: np.ndarray, corners: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Half of the distance between the branches of both directions, over 41 parts of the angle."""
    edges = np.linspace(float(np.min(angle)), float(np.max(angle)), 42)
    sums = {True: np.zeros(41), False: np.zeros(41)}
    counts = {True: np.zeros(41), False: np.zeros(41)}
    for begin, end in pairwise(corners):
        side = bool(angle[end] > angle[begin])
        place = np.clip(np.digitize(angle[begin:end], edges) - 1, 0, 40)
        np.add.at(sums[side], place, torque[begin:end])
        np.add.at(counts[side], place, 1.0)
    branch = {
        side: np.divide(sums[side], counts[side], out=np.full(41, np.nan), where=counts[side] > 0.0) for side in sums
    }
    return 0.5 * (edges[1:] + edges[:-1]), 0.5 * (branch[True] - branch[False])


def integral(values: np.ndarray, over: np.ndarray) -> float:
    """Trapezoidal integral of sampled values over a sampled variable."""
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(over)))


def slope(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Derivative by a local parabola over 11 samples, without lag."""
    from scipy.signal import savgol_filter

    count = min(11, len(values) - 1 + len(values) % 2)
    if count < 3:
        return np.zeros_like(values)
    return savgol_filter(values, count, 2, deriv=1, delta=(time[-1] - time[0]) / (len(time) - 1))
