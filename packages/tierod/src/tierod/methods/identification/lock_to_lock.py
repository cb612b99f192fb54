"""Loops of a lock-to-lock test: their work, friction and pre-sliding."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.analysis.consistency import differences, fresh

# Time over which a parabola follows the turning wheel; hands turn it at some 2 Hz at most
SMOOTHING: Annotated[float, "s"] = 0.25
# Least number of readings from which the noise of a part of a recording is taken; it is then known to 10 %
LEAST_READINGS = 50


@dataclass(frozen=True)
class Loop:
    """A stretch of samples over which the steering wheel returns to its initial angle."""

    first: int
    last: int  # index of its last sample (inclusive)
    turning_points: tuple[int, ...]  # indices where the direction changes, between first and last (both excluded)
    gap: float  # angle at the last sample less angle at the first one [rad]

    @property
    def corners(self) -> tuple[int, ...]:
        """First sample, turning points, last sample: the ends of the strokes."""
        return (self.first, *self.turning_points, self.last)

    def shifted(self, by: int) -> Loop:
        """The same loop where every index is moved by `by`."""
        return Loop(self.first + by, self.last + by, tuple(turn + by for turn in self.turning_points), self.gap)


def path_over(angle: np.ndarray, loops: Iterable[Loop]) -> float:
    """Sum of the strokes of all loops [rad], of an angle of shape (n,)."""
    return float(sum(abs(angle[end] - angle[begin]) for each in loops for begin, end in pairwise(each.corners)))


def path_deviation(course: np.ndarray, loops: Sequence[Loop], noise: float, sure_reversal: float) -> float:
    """Standard deviation of the path by noise at the ends of the strokes, and by reversals that may be noise [rad].

    Args: course: smoothed angle, shape (n,) [rad]; noise: standard deviation of the noise that it still contains [rad];
    sure_reversal: return that is a reversal for certain [rad].
    """
    sure = set(turning_points(course, sure_reversal))
    at_ends = 4.0 * noise * sum(len(each.turning_points) for each in loops)
    certain = [replace(each, turning_points=tuple(sorted(sure & {*each.turning_points}))) for each in loops]
    return math.hypot(at_ends, path_over(course, loops) - path_over(course, certain))


def turning_points(angle: np.ndarray, least_return: float) -> list[int]:
    """Indices of the extremes of an angle, each followed by a return of at least `least_return`.

    Args: angle: shape (n,), without NaN [rad]; least_return: smallest return that is not noise [rad].
    """
    found: list[int] = []
    lowest = highest = 0
    direction = 0
    for index, value in enumerate(angle):
        if value > angle[highest]:
            highest = index
        if value < angle[lowest]:
            lowest = index
        if direction >= 0 and value < angle[highest] - least_return:
            found += [highest] * (direction > 0)
            direction, lowest = -1, index
        elif direction <= 0 and value > angle[lowest] + least_return:
            found += [lowest] * (direction < 0)
            direction, highest = 1, index
    return found


def closed_loops(angle: np.ndarray, minimum_stroke: float, tolerance: float, least_return: float) -> list[Loop]:
    """All successive loops that visit both locks and close within a tolerance.

    A loop starts where the wheel starts to move (or where the last loop ended), visits both locks, and ends where it
    is closest to its start. Samples after the last closed loop are left out.

    Args: angle: steering wheel angle, shape (n,), without NaN [rad]; minimum_stroke: smallest distance between the
    locks [rad]; tolerance: largest difference of the angles at both ends, and of lock visits [rad]; least_return:
    smallest motion that is not noise [rad].
    """
    lowest, highest = float(np.min(angle)), float(np.max(angle))
    if highest - lowest < minimum_stroke:
        raise InputError(
            f"the steering wheel moves over {math.degrees(highest - lowest):.0f} deg, but a lock-to-lock loop needs at "
            f"least {math.degrees(minimum_stroke):.0f} deg; record a turn to one lock, to the other and back"
        )
    turns = np.array(turning_points(angle, least_return), dtype=int)
    loops: list[Loop] = []
    first = _motion_begins(angle, least_return)
    while True:
        last = _where_it_closes(angle, first, lowest + tolerance, highest - tolerance, tolerance)
        if last is None:
            break
        within = tuple(int(turn) for turn in turns if first < turn < last)
        loops.append(Loop(first, last, within, float(angle[last] - angle[first])))
        first = last
    if not loops:
        raise InputError(
            f"the loop does not close: it begins at {math.degrees(angle[first]):.1f} deg and ends at "
            f"{math.degrees(angle[-1]):.1f} deg (locks at {math.degrees(lowest):.0f} and "
            f"{math.degrees(highest):.0f} deg, tolerance {math.degrees(tolerance):.1f} deg); "
            "turn to both locks and back to where the turn began"
        )
    return loops


def _motion_begins(angle: np.ndarray, least_return: float) -> int:
    moved = np.flatnonzero(np.abs(angle - angle[0]) > 0.5 * least_return)
    return max(int(moved[0]) - 1, 0)


def _where_it_closes(angle: np.ndarray, first: int, low: float, high: float, tolerance: float) -> int | None:
    """Index of the first return to angle[first] after visits of both locks, or None."""
    rest = angle[first:]
    at_low, at_high = np.flatnonzero(rest <= low), np.flatnonzero(rest >= high)
    if not len(at_low) or not len(at_high):
        return None
    both_visited = max(int(at_low[0]), int(at_high[0]))
    distance = np.abs(rest[both_visited:] - rest[0])
    near = distance <= tolerance
    if not near.any():
        return None
    begin = int(np.argmax(near))
    leaves = np.flatnonzero(~near[begin:])
    end = begin + int(leaves[0]) if len(leaves) else len(distance)
    return first + both_visited + begin + int(np.argmin(distance[begin:end]))


class Motion(NamedTuple):
    """Signals of a test on one time grid, shape (n,) each; the motor torque referred to the steering wheel axis.

    Angle and rate are those of the column below the torsion bar, on which the measured torque of the driver acts;
    `course` is the angle without the noise of its readings.
    """

    time: np.ndarray
    angle: np.ndarray
    course: np.ndarray
    rate: np.ndarray
    driver_torque: np.ndarray
    motor_torque: np.ndarray


@dataclass(frozen=True)
class WorkBalance:
    """Friction over one closed loop, eq (17)."""

    path: float  # integral of |d angle| [rad]
    friction_torque: float  # eq (17) [N m]
    mean_rate: float  # viscous work over path and damping, the mean rate for damping [rad/s]
    gap: float  # difference of the angles at both ends [rad]
    torque_range: float  # largest less smallest torque [N m]


def work_balance(loop: Loop, motion: Motion, inertia: float, damping: float) -> WorkBalance:
    """Eqs (15) to (17), by strokes, so that noise of the angle does not lengthen the path.

    Noise of the angle is independent of the torques and leaves their work unbiased. A rate derived from the angle
    shares its noise, so the viscous work is taken over the smoothed angle. Inertia [kg m^2] and damping [N m s/rad] are
    those below the bar, at the steering wheel axis.
    """
    _, angle, course, rate, driver, motor = motion
    kinetic = 0.5 * inertia * rate**2
    work = path = 0.0
    for begin, end in pairwise(loop.corners):
        stroke = slice(begin, end + 1)
        work += integral((driver + motor)[stroke], angle[stroke]) - float(kinetic[end] - kinetic[begin])
        work -= damping * integral(rate[stroke], course[stroke])
        path += abs(float(course[end] - course[begin]))
    if work <= 0.0:
        raise InputError(
            f"the work done on the steering over the loop is negative ({work:.1f} J), but friction only takes work; "
            "turn the sign of the torques or of the angle (left is positive for all)"
        )
    whole = slice(loop.first, loop.last + 1)
    return WorkBalance(
        path=path,
        friction_torque=work / path,
        mean_rate=integral(rate[whole], course[whole]) / path,
        gap=loop.gap,
        torque_range=float(np.ptp((driver + motor - damping * rate)[whole])),
    )


def integral(values: np.ndarray, over: np.ndarray) -> float:
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(over)))


class Noise(NamedTuple):
    """Noise of the readings of a signal about its local course."""

    deviation: float  # standard deviation of a reading [its unit]
    jitter: float  # standard deviation of the time stamps that explains a noise of moving readings alone; else 0 [s]
    readings: np.ndarray  # indices of the samples that hold a new reading


def noise_of(values: np.ndarray, time: np.ndarray) -> Noise:
    """Noise of the readings of a signal, and the jitter of their time stamps.

    Args: values: readings on a grid, shape (n,), without NaN; time: of the grid [s], shape (n,).
    """
    readings = fresh(values)
    if len(readings) < 2 * LEAST_READINGS:
        return Noise(0.0, 0.0, readings)
    squares = differences(values[readings]) ** 2
    pace = np.abs(np.gradient(smoothed(values, time), time))[readings][1:-2]
    fast = pace > 0.5 * float(pace.max())
    slow = pace < 0.25 * float(pace.max())
    jitter = 0.0
    if min(np.count_nonzero(fast), np.count_nonzero(slow)) >= LEAST_READINGS:
        moving, still = float(np.mean(squares[fast])), float(np.mean(squares[slow]))
        share = float(np.mean(pace[slow] ** 2) / np.mean(pace[fast] ** 2))
        # Noise that grows with the pace as its square: at least half of it is not that of a still signal.
        jitter = math.sqrt(moving / float(np.mean(pace[fast] ** 2))) if still < 0.5 * (1.0 + share) * moving else 0.0
    return Noise(math.sqrt(float(np.mean(squares))), jitter, readings)


def smoothed(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """The local course of a signal: a parabola over `SMOOTHING`, without delay."""
    count = _smoothing_samples(time)
    return _local_parabola(values, count)[0] if 3 < count <= len(values) else values


def noise_left(noise: Noise, time: np.ndarray) -> float:
    """Standard deviation of the noise that `smoothed` leaves [unit of the signal]."""
    readings = _smoothing_samples(time) * len(noise.readings) / max(len(time), 1)
    # Variance at the centre of a parabola over n points: 9 / (4 n) for large n.
    return noise.deviation * min(1.5 / math.sqrt(max(readings, 1.0)), 1.0)


def _smoothing_samples(time: np.ndarray) -> int:
    return 2 * round(0.5 * SMOOTHING * (len(time) - 1) / max(float(time[-1] - time[0]), 1e-9)) + 1


def slope(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Derivative by a local parabola over 11 samples (Savitzky-Golay), without delay."""
    count = min(11, len(values) - 1 + len(values) % 2)
    if count < 3:
        return np.zeros_like(values)
    return np.asarray(_local_parabola(values, count)[1] / ((time[-1] - time[0]) / (len(time) - 1)))


def _local_parabola(values: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Value and slope [per sample] of the parabola over `count` samples around each one, at the ends over the last.

    It gives what `scipy.signal.savgol_filter` does, whose import takes longer than most recordings.
    """
    half = count // 2
    places = np.arange(-half, half + 1.0)
    fit = np.linalg.pinv(np.vander(places / half, 3, increasing=True)) / float(half) ** np.arange(3.0)[:, None]
    first, last = fit @ values[:count], fit @ values[-count:]
    before, after = places[:half], places[half + 1 :]
    # Pairs beside the centre, so that equal readings give equal values whatever their place in memory.
    size = len(values) - 2 * half
    inner = [values[half : half + size] * fit[0, half], np.zeros(size)]
    for k in range(half):
        early, late = values[k : k + size], values[2 * half - k : 2 * half - k + size]
        inner[0] = inner[0] + (early + late) * fit[0, k]
        inner[1] = inner[1] + (early - late) * fit[1, k]

    def joined(middle: np.ndarray, at: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
        return np.concatenate([at(first, before), middle, at(last, after)])

    return (
        joined(inner[0], lambda of, place: of[0] + of[1] * place + of[2] * place**2),
        joined(inner[1], lambda of, place: of[1] + 2.0 * of[2] * place),
    )


@dataclass(frozen=True)
class PreSliding:
    """The Dahl angle from the reversals of a loop."""

    angle: float  # motion after which the reversal of friction has reached 1 - 1/e [rad]
    standard_deviation: float  # of the mean over the reversals [rad]


def pre_sliding(
    angle: np.ndarray,
    torque: np.ndarray,
    corners: list[int],
    friction_torque: float,
    window: float = math.radians(30.0),
    smallest: float = math.radians(0.1),
    largest: float = math.radians(10.0),
) -> PreSliding | None:
    """Fit torque = c0 + c1*d - sign*2*F*exp(-d/s) to the motion d after each reversal.

    A reversal counts if the fitted jump is 2 F within 30 % (otherwise an end stop or tyre torsion interferes) and the
    angle is within its bounds.

    Source: Dahl's law with exponent 1 at constant direction: F*(1 - 2*exp(-d/s)) after a reversal from full friction.

    Args: angle: steering wheel angle [rad], shape (n,); torque: without inertial and viscous torque [N m], shape (n,);
    friction_torque: from the work balance [N m]; window: motion after a reversal that the fit uses [rad]; smallest,
    largest: bounds of the Dahl angle [rad].

    Returns:
        the angle, or None if no reversal counts
    """
    if len(angle) < 11:
        return None
    smooth, _ = _local_parabola(angle, 11)
    found: list[_Fit] = []
    for begin, end in pairwise(corners[1:]):
        direction = 1.0 if angle[end] > angle[begin] else -1.0
        around = slice(max(begin - 15, 0), begin + 15)
        begin = around.start + int(np.argmin(direction * smooth[around]))
        motion = np.maximum.accumulate(direction * (smooth[begin : end + 1] - smooth[begin]))
        count = int(np.searchsorted(motion, window))
        if count < 12 or motion[count - 1] < 0.5 * window:
            continue
        fitted = _fit(motion[:count], direction * torque[begin : begin + count], smallest, largest)
        if fitted is not None and abs(fitted.jump / (2.0 * friction_torque) - 1.0) < 0.3:
            found.append(fitted)
    if not found:
        return None
    angles = [fit.angle for fit in found]
    spread = float(np.std(angles, ddof=1)) if len(found) > 1 else 0.0
    within = float(np.sqrt(np.mean([fit.deviation**2 for fit in found])))
    return PreSliding(float(np.mean(angles)), max(spread, within) / math.sqrt(len(found)))


class _Fit(NamedTuple):
    angle: float
    deviation: float
    jump: float


def _fit(motion: np.ndarray, torque: np.ndarray, smallest: float, largest: float) -> _Fit | None:
    """The least-squares fit; None if the angle is at a bound."""
    candidates = np.geomspace(smallest, largest, 60)
    errors = [_at(motion, torque, candidate)[0] for candidate in candidates]
    best = int(np.argmin(errors))
    if best in (0, len(candidates) - 1):
        return None
    finer = np.geomspace(candidates[best - 1], candidates[best + 1], 41)
    angle = float(finer[int(np.argmin([_at(motion, torque, candidate)[0] for candidate in finer]))])
    error, jump = _at(motion, torque, angle)
    slope = -jump * np.exp(-motion / angle) * motion / angle**2
    columns = np.column_stack([_columns(motion, angle), slope])
    inverse = np.linalg.pinv(columns.T @ columns)
    return _Fit(angle, math.sqrt(error / max(len(motion) - 4, 1) * float(inverse[3, 3])), jump)


def _columns(motion: np.ndarray, angle: float) -> np.ndarray:
    return np.column_stack([np.ones_like(motion), motion, -np.exp(-motion / angle)])


def _at(motion: np.ndarray, torque: np.ndarray, angle: float) -> tuple[float, float]:
    columns = _columns(motion, angle)
    solution, *_ = np.linalg.lstsq(columns, torque, rcond=None)
    return float(np.sum((columns @ solution - torque) ** 2)), float(solution[2])
