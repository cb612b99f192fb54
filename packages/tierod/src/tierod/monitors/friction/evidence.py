"""What the friction monitor collects over a drive: estimates, strokes and signals, and gains of the torques."""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.facts import Fact, defect
from tierod.core.series import Rows, Stride
from tierod.methods.identification.hysteresis_presence import HysteresisPresence, HysteresisPresenceTest
from tierod.monitors.friction.sentences import DEFECTS, NOTES
from tierod.physics.steering import assist_speed_factor, column_torque_of_motor
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import is_guess

STRETCHES = 4  # Number of parts into which a drive without a change is divided, each with a histogram

BINS = 60

STROKES, STROKE_SECONDS, STROKE_RATE = 12, 8.0, 25.0
"""Number of strokes in a hysteresis view, their length [s] and points per second: enough to show the loop width."""

STROKES_OF = 600.0  # Length of the stretches whose busiest strokes are kept [s]


class EstimateOverDrive:
    """Friction estimates, one per second, for histograms per stretch of the drive."""

    def __init__(self, rate: float):
        self._stride = Stride(max(round(rate), 1))
        self._rows = Rows(2)

    def add(self, time: np.ndarray, estimate: np.ndarray, ready: np.ndarray) -> None:
        """Add estimates that follow those already added; only those of the ready monitor count."""
        chosen = self._stride.indices(len(time))
        chosen = chosen[ready[chosen] & np.isfinite(estimate[chosen])]
        self._rows.add(np.column_stack([time[chosen], estimate[chosen]]))

    def histograms(self, change: float | None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Name of a stretch -> (edges, counts)."""
        time, values = self._rows.values.T
        if not len(values):
            return {}
        # A quantile, so that a few outliers do not stretch the bins; they are clipped into the last one.
        high = float(np.quantile(values, 0.999)) * 1.1
        edges = np.linspace(min(0.0, float(values.min())), max(high, 1e-6), BINS + 1)
        found = {}
        for name, inside in _stretches(time, change).items():
            if inside.any():
                found[name] = (edges, np.histogram(np.clip(values[inside], edges[0], edges[-1]), edges)[0])
        return found


class HysteresisOverDrive:
    """Strokes of the steering wheel with the friction that acted in them: the busiest few seconds of every ten minutes.

    Strokes follow one another from the first sample on, however the drive is cut into pieces.

    Args:
        rate: sampling rate [Hz]
    """

    def __init__(self, rate: float):
        step = max(round(rate / STROKE_RATE), 1)
        self._stride, self._length = Stride(step), max(round(STROKE_SECONDS * rate / step), 2)
        self._open = np.empty((0, 3))
        self._strokes: list[Stroke] = []
        self._closed: list[Stroke] = []

    def add(self, time: np.ndarray, angle: np.ndarray, friction: np.ndarray, used: np.ndarray) -> None:
        """Add a piece: angle [rad], acting friction [N*m], and whether the estimator used the sample."""
        acting = np.where(used & np.isfinite(angle), friction, np.nan)
        rows = np.column_stack([time, angle, acting])[self._stride.over(len(time))]
        rows = np.vstack([self._open, rows])
        whole = len(rows) // self._length * self._length
        for stroke in rows[:whole].reshape(-1, self._length, 3):
            busy = float(np.mean(np.isfinite(stroke[:, 2])))
            if busy > 0.0:
                self._keep(Stroke(busy, float(stroke[0, 0]), stroke[:, 1:].copy()))
        self._open = rows[whole:].copy()

    def _keep(self, stroke: Stroke) -> None:
        """Keep the busiest strokes of every ten minutes."""
        if self._strokes and stroke.start - self._strokes[0].start > STROKES_OF:
            self._closed += _busiest(self._strokes)
            self._strokes = []
        self._strokes.append(stroke)

    def views(self, change: float | None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Name of a stretch -> (angle, acting friction), with a NaN row after every stroke."""
        strokes = [*self._closed, *_busiest(self._strokes)]
        times = np.array([stroke.start for stroke in strokes])
        gap = np.full((1, 2), np.nan)
        found = {}
        for name, inside in _stretches(times, change, parts=2).items():
            chosen = [strokes[at] for at in np.flatnonzero(inside)[-STROKES:]]
            if chosen:
                points = np.vstack([part for stroke in chosen for part in (stroke.points, gap)])
                found[name] = (points[:, 0], points[:, 1])
        return found


class Stroke(NamedTuple):
    """A few seconds of steering: share of the samples used, time of the first, and (n, 2) of angle [rad]
    and acting friction [N*m].
    """

    busy: float
    start: Annotated[float, "s"]
    points: np.ndarray


def _busiest(strokes: list[Stroke]) -> list[Stroke]:
    """The busiest strokes in order of time; of equally busy ones the latest."""
    chosen = sorted(strokes, key=lambda stroke: (stroke.busy, stroke.start))[-STROKES:]
    return sorted(chosen, key=lambda stroke: stroke.start)


class SignalsOverDrive:
    """Signals of the first ten minutes at half the rate, for tests that need a stretch as a whole."""

    SIGNALS = ("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque", "lateral_acceleration")
    LONGEST = 600.0

    def __init__(self) -> None:
        self._rows = Rows(1 + len(self.SIGNALS))
        self._start: float | None = None
        self._stride = Stride(2)

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """Add signals that follow those already added."""
        self._start = float(time[0]) if self._start is None else self._start
        rows = self._stride.indices(len(time))
        rows = rows[time[rows] < self._start + self.LONGEST]
        self._rows.add(np.column_stack([time[rows], *(signals[name][rows] for name in self.SIGNALS)]))

    def presence(self) -> HysteresisPresence | None:
        """Result of the test for hysteresis in the driver's torque; None where it cannot be tested."""
        time, *signals = self._rows.values.T
        try:
            return HysteresisPresenceTest().test(time, **dict(zip(self.SIGNALS, signals, strict=True)))
        except InputError:
            return None


def _stretches(time: np.ndarray, change: float | None, parts: int = STRETCHES) -> dict[str, np.ndarray]:
    if not len(time):
        return {}
    if change is not None and time[0] < change < time[-1]:
        return {"before the change": time < change, "after the change": time >= change}
    if time[-1] - time[0] < parts:
        return {"the whole drive": np.ones(len(time), bool)}
    edges = np.linspace(time[0], time[-1], parts + 1)
    inner = np.concatenate([edges[:-1], [np.inf]])
    return {
        _stretch(*ends): (time >= low) & (time < high)
        for ends, (low, high) in zip(itertools.pairwise(edges), itertools.pairwise(inner), strict=True)
    }


def _stretch(low: float, high: float) -> str:
    """The name of a stretch from `low` to `high` [s], fine enough that no two neighbours share one."""
    if high - low < 60.0:
        return f"{low:.0f} to {high:.0f} s"
    decimals = 1 if high - low < 600.0 else 0
    first, last = (f"{each / 60.0:.{decimals}f}".removesuffix(".0") for each in (low, high))
    return f"{first} to {last} min"


STRIDE = 5  # Decimation: every fifth sample is used, since assist changes more slowly than 10 Hz

BLOCK = 1000  # Samples per partial sum, so that the sums do not depend on how the recording is cut

BOTH = ("driver_torque", "motor_torque")

WIDEST = 0.2
"""Relative standard deviation of the assist map up to which it can reveal a wrong sensor gain [-]. Values typical of a
class have 0.3, and give 1.6 times the right gain on other cars of it."""

SPEED_BAND: Annotated[float, "m/s"] = 1.5
"""Width of the speed bands within which the assist is compared; a step of the gain falls into one band of many."""

WINDOW = 2  # Blocks per window of 100 s of driving; every later window is compared with the first one of the drive

_TERMS = 10  # Number of terms of the regression, see `GainsOverDrive`

_COMPARED = (0, 1, 5, 8, _TERMS)
"""Columns of its rows that are compared by speed and by time: assist, offset, damping and the motor's torque."""


@dataclass(frozen=True)
class AssistCharacteristic:
    """The assist map of the car type, in the form of `tierod.physics.steering`, named as in a vehicle file."""

    assist_linear_gain: Annotated[float, ""]
    assist_quadratic_gain: Annotated[float, "1/(N*m)"]
    assist_half_speed: Annotated[float, "m/s"]
    motor_ratio: Annotated[float, ""]

    @classmethod
    def of(cls, vehicle: Vehicle, widest: float = WIDEST) -> AssistCharacteristic | None:
        """Characteristic of a vehicle; None where its file has none or a guess, or its torques are raw counts."""
        known = vehicle.calibrated and all(_known(vehicle, field.name, widest) for field in fields(cls))
        return vehicle.parameters_for(cls) if known else None


def _known(vehicle: Vehicle, name: str, widest: float) -> bool:
    """Whether the file gives a value that is not a guess."""
    parameter = vehicle.parameters.get(name)
    return parameter is not None and not is_guess(parameter, widest)


@dataclass(frozen=True)
class GainLimits:
    """Limits beyond which the gain of a torque is reported as wrong."""

    # speed from which assist is compared [m/s]; a standing car is parked against its stops
    slowest: Annotated[float, "m/s"] = 3.0
    smallest: Annotated[float, "N*m"] = 0.3  # driver's torque above which a sample holds information on assist [N*m]
    seconds: Annotated[float, "s"] = 60.0  # driving time with such samples that is needed [s]
    # largest relative residual of the assist map, rms [-]; fault-free drives leave 0.04 to 0.17
    deviation: Annotated[float, ""] = 0.25
    # factor by which the motor's torque over the driver's may be wrong [-]; 0.85 to 1.06 in 12 fault-free drives, 0.58
    # with worn sensors whose gains differ by 30 %
    ratio: Annotated[float, ""] = 1.75
    # factor by which one torque may be wrong where the ratio of the two fits [-]; 0.71 to 1.18 in those drives
    single: Annotated[float, ""] = 1.6
    # largest factor, and reciprocal of the smallest one, that is a gain of a sensor [-]; the map of another car gives
    # any
    plausible: Annotated[float, ""] = 4.0
    # share of the motor's torque by which its relation to the driver's may change within a drive [-]; 0.01 to 0.07 in
    # 15 fault-free drives of 8 virtual cars, 0.14 with little assist; a gain that grows to 2 gives 0.44 and 1.6, a zero
    # that drifts 0.8 and 2.6
    change: Annotated[float, ""] = 0.2
    # beyond_speed, with_speed: residual of the map over that of relations by speed [-], and what these explain in
    # addition as a share of the motor's torque [-], rms, from which the map depends on speed as that of another car;
    # steps of speed give 1.6 to 3.9 and 0.13 to 0.24, cars of the map up to 1.04 and 0.02
    beyond_speed: Annotated[float, ""] = 1.3
    with_speed: Annotated[float, ""] = 0.07
    # smallest such change as a multiple of the residual of the first window [-]; the error of the map changes with the
    # road
    unlike: Annotated[float, ""] = 1.5


@dataclass(frozen=True)
class TorqueGains:
    """Gain of each torque over a drive, relative to the assist map, and that of the motor over that of the driver."""

    driver: float
    motor: float
    ratio: float


class _SpeedOrTime:
    """Residuals of the relation of the torques, fitted in bands of speed and in stretches of time.

    An assist of any dependence on speed has one relation in each narrow band of speed, at all times; a gain or zero
    that changes with time has one relation with the map's speed factor in each stretch.
    """

    def __init__(self) -> None:
        self._bands: dict[int, np.ndarray] = {}
        self._by_time = self._power = 0.0

    def add(self, speed: np.ndarray, share: np.ndarray, rows: np.ndarray) -> None:
        """Add a stretch: speed [m/s] and speed factor, (n,), terms (the first two with that factor) and torque."""
        self._power += float(rows[:, -1] @ rows[:, -1])
        self._by_time += _unexplained(rows.T @ rows)
        free = np.column_stack([rows[:, :2] / share[:, None], rows[:, 2:]])
        bands = (speed // SPEED_BAND).astype(int)
        for band in np.unique(bands).tolist():
            part = free[bands == band]
            self._bands[band] = self._bands.get(band, 0.0) + part.T @ part

    @property
    def by_speed(self) -> float:
        """Share of the motor's torque that relations by speed leave unexplained, root mean square."""
        return math.sqrt(sum(_unexplained(each) for each in self._bands.values()) / max(self._power, 1e-12))

    @property
    def by_time(self) -> float:
        """The same of relations by time."""
        return math.sqrt(self._by_time / max(self._power, 1e-12))


def _unexplained(products: np.ndarray) -> float:
    """Power of the last column that the others leave unexplained, from the products of all."""
    terms = np.linalg.pinv(products[:-1, :-1], rcond=1e-12, hermitian=True) @ products[:-1, -1]
    return max(float(products[-1, -1] - terms @ products[:-1, -1]), 0.0)


class GainsOverDrive:
    """Regression of the motor's torque on the terms of the assist map, which separates the gains of both torques.

    With s the speed factor, T the driver's torque times its gain, u its offset:

        n Tm = s (a (T - u) + b |T - u| (T - u)) + return and damping

    A gain of the driver's torque acts once on the linear term and twice on the quadratic one, a gain of the motor's
    once on both, so that both gains are identifiable. The terms of the offset are s, s |T| and s sgn(T).
    """

    def __init__(self, vehicle: Vehicle, rate: float, limits: GainLimits | None = None):
        self.limits, self._rate = limits or GainLimits(), rate
        self._known = AssistCharacteristic.of(vehicle) is not None
        # A change within the drive shows with any map; a guessed speed factor is good enough.
        self._map = AssistCharacteristic.of(vehicle, math.inf)
        self._stride = Stride(STRIDE)
        self._rows: list[np.ndarray] = []
        self._sums = np.zeros((_TERMS + 1, _TERMS + 1))
        self._count = 0
        self._first: list[np.ndarray] = []
        self._last: deque[np.ndarray] = deque(maxlen=WINDOW)
        self._changed = 0.0
        self._speed_or_time = _SpeedOrTime()

    def add(self, signals: Mapping[str, np.ndarray]) -> None:
        """Add the next piece: signals by name, (n,) each, NaN where missing."""
        if self._map is None or "vehicle_speed" not in signals:
            return
        kept = self._stride.over(len(signals["driver_torque"]))
        rows = self._terms({name: values[kept] for name, values in signals.items()})
        self._rows = [np.vstack([*self._rows, rows])]
        while len(self._rows[0]) >= BLOCK:
            block, self._rows[0] = self._rows[0][:BLOCK], self._rows[0][BLOCK:]
            speed = block[:, -1]
            share = assist_speed_factor(speed, self._map.assist_half_speed)
            self._speed_or_time.add(speed, share, block[:, _COMPARED])
            products = block[:, :-1].T @ block[:, :-1]
            self._sums += products
            self._count += len(block)
            self._compare(products)

    @property
    def _changes_with_time(self) -> bool:
        """Whether the relation of the torques changes within the drive, and time explains it better than speed."""
        return self._changed > 0.0 and self._speed_or_time.by_time < self._speed_or_time.by_speed

    def _map_fits(self, terms: np.ndarray) -> bool:
        """Whether relations by speed explain hardly more of the motor's torque than the map does."""
        residual, free = _residual(self._sums, terms), self._speed_or_time.by_speed
        more = math.sqrt(max(residual**2 - free**2, 0.0))
        return residual <= self.limits.beyond_speed * free or more <= self.limits.with_speed

    def _compare(self, products: np.ndarray) -> None:
        """Update the largest change of the relation between the torques from the first window to any later one."""
        if len(self._first) < WINDOW:
            self._first.append(products)
            return
        self._last.append(products)
        first, last = sum(self._first[1:], self._first[0]), sum(self._last, np.zeros_like(products))
        usual, now = _terms_of(first), _terms_of(last)
        if len(self._last) < WINDOW or usual is None or now is None:
            return
        off = usual - now
        # The mixed products vanish at the least-squares solution: this is the extra residual of the first terms.
        change = math.sqrt(max(float(off @ last[:-1, :-1] @ off), 0.0) / float(last[-1, -1]))
        residual = _residual(first, usual)
        if residual <= self.limits.deviation and change > max(self.limits.change, self.limits.unlike * residual):
            self._changed = max(self._changed, change)

    def _terms(self, signals: Mapping[str, np.ndarray]) -> np.ndarray:
        """Rows of the regression: its terms, then the motor's torque at the column, then the speed."""
        assert self._map is not None
        torque, speed = signals["driver_torque"], signals["vehicle_speed"]
        rate, angle = signals["steering_wheel_rate"], signals["steering_wheel_angle"]
        share = assist_speed_factor(speed, self._map.assist_half_speed)
        returning = share * (1.0 - share) / (1.0 + torque * torque)
        rows = np.column_stack(
            [
                share * torque * self._map.assist_linear_gain,
                share * np.abs(torque) * torque * self._map.assist_quadratic_gain,
                share,
                share * np.abs(torque),
                share * np.sign(torque),
                np.ones(len(torque)),
                returning * angle,
                returning * rate,
                rate,
                share * rate,
                column_torque_of_motor(signals["motor_torque"], self._map.motor_ratio),
                speed,
            ]
        )
        used = (speed > self.limits.slowest) & (np.abs(torque) > self.limits.smallest)
        kept: np.ndarray = rows[used & np.isfinite(rows).all(axis=1)]
        return kept

    def found(self) -> TorqueGains | None:
        """The gains; None where the drive or the vehicle file lack the data for them, or the assist is another one."""
        if not self._known or self._count * STRIDE / self._rate < self.limits.seconds:
            return None
        terms = _terms_of(self._sums)
        if terms is None:
            return None
        linear, quadratic = float(terms[0]), float(terms[1])
        if not (linear > 0.0 and quadratic > 0.0) or _residual(self._sums, terms) > self.limits.deviation:
            return None
        if not self._map_fits(terms):
            return None
        return TorqueGains(linear / quadratic, linear * linear / quadratic, linear)

    def defects(self) -> tuple[Fact, ...]:
        """Defects of torques with a wrong gain, or with a gain or zero that changes within the drive."""
        if self._changes_with_time:
            return (_defect("changed", (*BOTH, "vehicle_speed", "steering_wheel_angle"), changed=self._changed),)
        found = self.found()
        return () if found is None else tuple(self._against_map(found))

    def _against_map(self, found: TorqueGains) -> Iterator[Fact]:
        """Contradiction between the torques and the assist map; a gain only where it explains it, and never surely."""
        limits = self.limits
        driver, motor, ratio = (abs(math.log(each)) for each in (found.driver, found.motor, found.ratio))
        right, wrong = math.log(limits.single), math.log(limits.plausible)
        if ratio > math.log(limits.ratio):
            alone = ((BOTH[0], found.driver, driver, motor), (BOTH[1], found.motor, motor, driver))
            fitting = [each for each in alone if each[3] < right < each[2] < wrong and each[2] > 2.0 * each[3]]
            if fitting:
                name, gain, *_ = fitting[0]
                yield _defect("gain", (name,), name=name, gain=gain, ratio=found.ratio)
            else:
                yield _defect("gains", BOTH, ratio=found.ratio)
        elif min(driver, motor) > right:
            yield _defect("bend", BOTH, driver=found.driver, motor=found.motor)

    def notes(self) -> tuple[Fact, ...]:
        """That the assist depends on speed otherwise than the map, so that the gains are not checked by it."""
        terms = _terms_of(self._sums) if self._count else None
        if not self._known or terms is None or self._changes_with_time or self._map_fits(terms):
            return ()
        return (Fact("other_assist", NOTES["other_assist"]),)


def _defect(case: str, names: tuple[str, ...], /, **figures: object) -> Fact:
    words = DEFECTS[case]
    return defect(names, words.cause.format(**figures), words.reason.format(**figures))


def _terms_of(products: np.ndarray) -> np.ndarray | None:
    """Least-squares terms from the products of terms and motor's torque; None where they cannot be separated."""
    matrix = products[:-1, :-1]
    size = np.sqrt(np.diag(matrix))
    # A term that is zero throughout leaves nothing to scale; its gain is unknown.
    if not size.all() or np.linalg.cond(matrix / np.outer(size, size)) > 1e10:
        return None
    return np.asarray(np.linalg.solve(matrix, products[:-1, -1]))


def _residual(products: np.ndarray, terms: np.ndarray) -> float:
    """Share of the motor's torque that the terms leave unexplained, root mean square."""
    power = float(products[-1, -1])
    return math.sqrt(max(power - float(terms @ products[:-1, -1]), 0.0) / power)
