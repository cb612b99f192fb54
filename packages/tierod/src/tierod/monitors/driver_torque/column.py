"""Ratio, bar, lag and inertia of the column over a drive, and which of its three signals contradicts the others."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.series import Rows, Stride
from tierod.core.signals import residue_between
from tierod.methods.identification.experiment import Solution, solved
from tierod.methods.running import Moments

CLEAR = 5.0  # least ratio of an estimate to its standard error
FEWEST = 500  # least number of samples for an estimate
# Half of the time over which rates are differences [s]; short against motion up to 10 Hz, long against the noise.
HALF = 0.01
# Largest lag that is accepted [s]; signals farther apart, or of a wrong scale, are no longer linear in the lag.
LONGEST_LAG = 0.2
# Half of the time over which rates are differences [s]; noise of the motor's angle makes 20 rad/s^2 of it, a sweep
# thousands.
SPAN = 0.02
# Least ratio of the inertia to its standard error; friction that follows the angle is not white noise.
CLEAR_INERTIA = 10.0
LEAST = 50.0  # least standard deviation of the motor's acceleration for an estimate, twice that of its noise [rad/s^2]
SLIDING = 0.5  # speed of the motor over which dry friction changes its sign [rad/s]

_WHEEL, _MOTOR, _BAR, _MOTOR_RATE, _BAR_RATE, _MOTOR_BEND = range(6)


class ColumnGeometry(NamedTuple):
    """Ratio and stiffness identified from a recording, and further disagreement of its three signals."""

    ratio: float  # turns of the motor per turn of the wheel
    stiffness: float  # stiffness of the torsion bar [N m/rad]
    torque_offset: float = 0.0  # offset of the bar's torque, if both angles are zero on the unloaded bar [N m]
    late: str = ""  # the signal that is latest against the other two or the other angle; "" where none stands out
    lag: float = 0.0  # its lag [s]
    # Relative uncertainty of the ratio from errors of the angles that correlate with the motion.
    ratio_uncertainty: float = 0.0


class GeometryOverDrive:
    """Least squares of wheel angle = motor angle / ratio + bar torque / stiffness + constant, piece by piece.

    A late signal is its value less its rate times the lag, to second order: the rates of motor angle and torque as
    further regressors give the lags between the three, and the motor's acceleration absorbs the remainder of a late
    angle.
    """

    def __init__(self, rate: float = 1000.0) -> None:
        self._half, self._rate = max(round(HALF * rate), 1), rate
        self._before = np.empty((0, 3))
        self._moments = Moments(6)

    def add(self, wheel_angle: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray) -> None:
        rows = np.vstack([self._before, np.column_stack([wheel_angle, motor_angle, driver_torque])])
        self._before = rows[-2 * self._half :]
        if len(rows) <= 2 * self._half:
            return
        behind, now, ahead = rows[: -2 * self._half], rows[self._half : -self._half], rows[2 * self._half :]
        span = self._half / self._rate
        rates = (ahead - behind)[:, 1:] / (2.0 * span)
        self._moments.add(now, rates, (ahead - 2.0 * now + behind)[:, 1] / span**2)

    def found(self) -> ColumnGeometry | None:
        """The geometry that the pieces identify; None where it is not clear, or a sign is wrong."""
        if self._moments.count < FEWEST:
            return None
        rates = (_MOTOR, _BAR, _MOTOR_RATE, _BAR_RATE)
        # In a sine, angle and acceleration are linearly dependent; the acceleration is then left out.
        moving = self._shares((*rates, _MOTOR_BEND)) or self._shares(rates)
        shares = moving if moving is not None and _clear(moving) else self._shares((_MOTOR, _BAR))
        if shares is None or not _clear(shares):
            return None
        by_motor, by_bar = shares.values[:2].tolist()
        wheel, motor, bar = self._moments.means[:3].tolist()
        late = ("", 0.0) if moving is None else _latest(moving)
        # Residual over motion, since the residual is not white and may correlate with it.
        left = math.sqrt(max(shares.left, 0.0) / self._moments.products[_MOTOR, _MOTOR])
        offset = (by_motor * motor + by_bar * bar - wheel) / by_bar
        return ColumnGeometry(1.0 / by_motor, 1.0 / by_bar, offset, *late, left / abs(by_motor))

    def _shares(self, signals: tuple[int, ...]) -> Solution | None:
        """Coefficients of these signals in the wheel angle; None where the signals are linearly dependent."""
        products = self._moments.products
        normal, right = products[np.ix_(signals, signals)], products[list(signals), _WHEEL]
        return solved(normal, right, products[_WHEEL, _WHEEL], self._moments.count)


def _clear(shares: Solution) -> bool:
    return bool(np.all(shares.values[:2] > CLEAR * shares.deviations[:2]))


def _latest(shares: Solution) -> tuple[str, float]:
    """The latest signal and its lag [s]; where two of three agree the third, which may also be early.

    Where the lag hides the coefficient of the bar, only the angles are compared, and the later one is named.
    """
    share = shares.values
    apart = {"steering_wheel_angle": 0.0, "motor_angle_mechanical": float(share[2] / share[0])}
    if share[1] > CLEAR * shares.deviations[1]:
        apart["driver_torque"] = float(share[3] / share[1])
    if any(not abs(each) < LONGEST_LAG for each in apart.values()):
        return "", 0.0
    reference = sorted(apart.values())[len(apart) // 2 if len(apart) > 2 else 0]
    name = max(apart, key=lambda each: abs(apart[each] - reference))
    return name, apart[name] - reference


class BelowBarOverDrive:
    """Least squares of motor torque + bar torque / ratio = inertia, damping, dry friction and a constant, piecewise.

    Valid on a bench; in a car rack and road act as well. A few samples are lost at the cuts between pieces.
    """

    def __init__(self, rate: float) -> None:
        self._rate, self._step = rate, max(round(SPAN * rate), 1)
        self._moments = Moments(5)

    def add(self, motor_torque: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray) -> None:
        step, span = self._step, self._step / self._rate
        if len(motor_angle) <= 2 * step:
            return
        behind, now, ahead = motor_angle[: -2 * step], motor_angle[step:-step], motor_angle[2 * step :]
        speed = (ahead - behind) / (2.0 * span)
        torques = (each[step:-step] for each in (motor_torque, driver_torque))
        self._moments.add((ahead - 2.0 * now + behind) / span**2, speed, np.tanh(speed / SLIDING), *torques)

    def inertia(self, ratio: float) -> float | None:
        """Inertia of motor and gear at the motor's shaft [kg m^2]; None where it is not identifiable."""
        together = np.vstack([np.eye(4), [0.0, 0.0, 0.0, 1.0 / ratio]])
        products = together.T @ self._moments.products @ together
        if not self._moments.deviation() > LEAST:
            return None
        found = solved(products[:3, :3], products[:3, 3], products[3, 3], self._moments.count)
        if found is None or not found.values[0] > CLEAR_INERTIA * found.deviations[0]:
            return None
        return float(found.values[0])


# Signals of the torsion bar: wheel angle = motor angle / ratio + torque of the bar / stiffness + constant.
SIGNALS = ("steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
RATE = 50.0  # rate at which they are stored [Hz]; a hand moves a wheel at less than 5 Hz
LONGEST = 3600.0  # longest stored time [s], which bounds the memory
LEAST_ROWS = 250  # least number of samples for a result
# Averaging time before gains and delays are compared [s]; it keeps delays of a tenth of a second and removes noise.
SMOOTHING = 0.2
# Least logarithm of a gain that counts as wrong [-]; a gear in series makes a bar 6 % softer, see `STIFFNESS_SPREAD`.
LEAST_GAIN = 0.15
LATEST = 0.6  # longest delay that is searched [s]
EXPLAINED = 0.1  # share of the variance of the contradiction that may remain after one signal is corrected
SCALED = 0.02  # the same share for a gain; a wrong gain leaves a thousandth, clipping leaves more
NEARLY = 4.0  # multiple of the least remaining variance up to which corrections cannot be distinguished
# Share of the largest correlation with the contradiction from which a signal may be the wrong one as well.
FOLLOWS = 0.7
UNLIKE = 4.0  # ratio of the angles' variances above which one of them hardly moves, and either may be wrong
HELD = 0.9  # share of the contradiction's changes during standstill of a signal, from which that signal is stuck
BENDS = (0.0, 1.0 / 3.0, 2.0 / 3.0)  # shares of a drive at which a slow change may begin or change its slope
# Multiple of a signal's range above which its zero cannot drift; a wheel angle off by a turn is not a torque drift.
DRIFTS = 3.0
FITS = 0.05  # variance of the contradiction, as a share of that of the bar's twist, up to which the three signals agree


class Contradiction(NamedTuple):
    """Signal that contradicts the others."""

    names: tuple[str, ...]  # signals of which one is wrong; empty where the three agree
    gain: Annotated[float, ""] = 1.0  # gain of the single signal, where it explains the contradiction; else 1
    delay: Annotated[float, "s"] = 0.0  # delay of the single signal, where it explains the contradiction; else 0
    # "gain" or "zero" where a slow change of it during the drive explains the contradiction; else empty.
    creeps: str = ""
    # Whether a change of the named signals explains the contradiction; else it only follows them most, as it also
    # follows sound signals where the wrong one is smoothed or held.
    explained: bool = True


class ContradictionOverDrive:
    """Collector of the three signals of a torsion bar over a recording."""

    def __init__(self, rate: float):
        self._stride = Stride(max(round(rate / RATE), 1))
        self._rate = rate / self._stride.step
        self._kept = Rows(3, round(LONGEST * self._rate))

    def add(self, wheel_angle: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray) -> None:
        kept = self._stride.over(len(wheel_angle))
        self._kept.add(np.column_stack([each[kept] for each in (wheel_angle, motor_angle, driver_torque)]))

    def found(self, ratio: float, stiffness: float) -> Contradiction | None:
        """The contradicting signal; None with too few samples.

        A stuck signal takes precedence, then a gain or delay, then a slow change.
        """
        rows = self._kept.values * [1.0, -1.0 / ratio, -1.0 / stiffness]
        there = np.isfinite(rows).all(axis=1)
        if np.count_nonzero(there) < LEAST_ROWS:
            return None
        rows = rows - rows[there].mean(axis=0)
        whole = rows[there]
        fits = not float(np.var(whole.sum(axis=1))) > FITS * float(np.var(whole[:, 2]))
        held = "" if fits else _held(whole)
        smooth = np.column_stack([_averaged(column, max(round(SMOOTHING * self._rate), 1)) for column in rows.T])
        clean = smooth[np.isfinite(smooth).all(axis=1)]
        if len(clean) < LEAST_ROWS:
            clean = whole
        clean = clean - clean.mean(axis=0)
        apart = float(np.var(clean.sum(axis=1)))
        gains = [_gain(clean, column) for column in range(3)]
        delays = [_delay(smooth, column, round(LATEST * self._rate)) for column in range(3)]
        best = min(left for left, _ in (*gains, *delays))
        if held:
            return Contradiction((held,))
        if best > EXPLAINED * apart:
            return _creeping(clean) or (
                Contradiction(()) if fits else Contradiction(_following(whole), explained=False)
            )
        limit = min(NEARLY * best, EXPLAINED * apart)
        left = {name: min(gains[at][0], delays[at][0]) for at, name in enumerate(SIGNALS)}
        names = tuple(name for name, value in left.items() if value <= limit)
        at = SIGNALS.index(min(left, key=lambda name: left[name]))
        if len(names) > 1:
            return Contradiction(names)
        if gains[at][0] <= delays[at][0]:
            return Contradiction(names, gain=gains[at][1])
        return Contradiction(names, delay=delays[at][1] / self._rate)


def _averaged(values: np.ndarray, count: int) -> np.ndarray:
    if len(values) < count:
        return values
    return np.convolve(values, np.full(count, 1.0 / count), mode="valid")


def _gain(rows: np.ndarray, column: int) -> tuple[float, float]:
    others = np.delete(rows, column, axis=1).sum(axis=1)
    signal = rows[:, column]
    power = float(signal @ signal)
    factor = -float(signal @ others) / power if power > 0.0 else 0.0
    if not factor > 0.0:
        return np.inf, 1.0
    left = float(np.var(factor * signal + others))
    known = abs(np.log(factor)) > LEAST_GAIN
    return (left, 1.0 / factor) if known and left <= SCALED * float(np.var(others)) else (np.inf, 1.0)


def _delay(rows: np.ndarray, column: int, most: int) -> tuple[float, int]:
    others, signal = np.delete(rows, column, axis=1).sum(axis=1), rows[:, column].copy()
    found = [(_variance(signal[late:] + others[: max(len(others) - late, 0)]), late) for late in range(1, most + 1)]
    left, late = min(found)
    return (left, late) if left <= EXPLAINED * _variance(others) else (np.inf, 0)


def _variance(values: np.ndarray) -> float:
    there = values[np.isfinite(values)]
    return float(np.var(there)) if len(there) >= LEAST_ROWS else np.inf


def _creeping(rows: np.ndarray) -> Contradiction | None:
    """The signal with a slowly changing gain or zero; None where that leaves much of the contradiction."""
    apart = rows.sum(axis=1)
    time = np.linspace(0.0, 1.0, len(rows))
    slow = np.column_stack([np.maximum(time - start, 0.0) for start in BENDS])
    left = [_left_by(apart, slow), *(_left_by(apart, slow * signal[:, None]) for signal in rows.T)]
    constant = min(_left_by(apart, signal[:, None]) for signal in rows.T)
    if min(left) > EXPLAINED * float(np.var(apart)) or constant <= NEARLY * min(left):
        return None
    if left[0] <= NEARLY * min(left):
        # The drift may belong to any signal, except one whose whole range it would exceed.
        drift = float(np.ptp(apart))
        able = [name for name, spread in zip(SIGNALS, np.ptp(rows, axis=0), strict=True) if drift < DRIFTS * spread]
        return Contradiction(tuple(able) or SIGNALS, creeps="zero")
    names = tuple(name for name, each in zip(SIGNALS, left[1:], strict=True) if each <= NEARLY * min(left))
    return Contradiction(names, creeps="gain")


def _left_by(values: np.ndarray, terms: np.ndarray) -> float:
    terms, values = terms - terms.mean(axis=0), values - values.mean()
    found, *_ = np.linalg.lstsq(terms, values, rcond=None)
    return float(np.var(values - terms @ found))


def _held(rows: np.ndarray) -> str:
    """The signal that stands still while the contradiction changes; "" where there is none."""
    energy = np.diff(rows.sum(axis=1)) ** 2
    still = np.abs(np.diff(rows, axis=0)) <= [residue_between(column.min(), column.max()) for column in rows.T]
    shares = (still * energy[:, None]).sum(axis=0) / max(float(energy.sum()), 1e-300)
    at = int(np.argmax(shares))
    return SIGNALS[at] if shares[at] >= HELD else ""


def _following(rows: np.ndarray) -> tuple[str, ...]:
    """The signals that correlate most with the contradiction: its independent part comes from the wrong signal."""
    apart = rows.sum(axis=1)
    spread = rows.std(axis=0)
    shares = np.divide(np.abs(rows.T @ apart), spread, out=np.zeros(3), where=spread > 0.0)
    found = [share >= FOLLOWS * shares.max() for share in shares]
    unlike = min(spread[:2]) ** 2 * UNLIKE < max(spread[:2]) ** 2
    if unlike and any(found[:2]):
        found[:2] = [True, True]
    return tuple(name for name, follows in zip(SIGNALS, found, strict=True) if follows)


def described(found: Contradiction) -> str:
    """A contradiction as half a sentence."""
    name = found.names[0]
    if found.creeps:
        others = " and ".join(each for each in SIGNALS if each not in found.names) or "the others"
        return f"the {found.creeps} of {' or '.join(found.names)} changes slowly relative to {others}"
    if found.delay > 0.0:
        return f"{name} is late: the signals agree when it is shifted {1e3 * found.delay:.0f} ms earlier"
    if found.gain != 1.0:
        others = " and ".join(each for each in SIGNALS if each != name)
        return (
            f"the signals agree when {name} is divided by {found.gain:.3g}: its gain may be wrong, or that of {others} "
            "together"
        )
    if not found.explained:
        return (
            f"{', '.join(SIGNALS[:-1])} and {SIGNALS[-1]} contradict each other, most likely by an error of "
            f"{' or '.join(found.names)}"
        )
    return f"{' or '.join(found.names)} contradicts the other signals of the torsion bar"
