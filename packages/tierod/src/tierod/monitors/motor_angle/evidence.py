"""Results over a drive of the motor: shape of its sensor's error, noise of its readings, learnt parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tierod.core.facts import ESTIMATE
from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.core.statuses import STATUSES, code_of
from tierod.methods.analysis.consistency import DEVIATION_OF_MEDIAN, differences
from tierod.methods.running import Moments
from tierod.models.stator_frame_motor import CommandedMotorParameters
from tierod.monitors.motor_angle.alarms import CODES
from tierod.monitors.motor_angle.balance import CLEAN, LEAST_WINDOWS, Departure, InducedVoltage, VoltageBalance, misread
from tierod.monitors.motor_angle.observer import VARIANTS, MotorAngleObserver
from tierod.monitors.motor_angle.plausibility import NOT_MOTOR
from tierod.monitors.session import StatusChange
from tierod.physics.motor import StatorVector, phase_signs

MOST_SAMPLES = 100_000  # largest number of stored residuals, some minutes of turning; beyond, every second one is kept
LEAST_SAMPLES = 20  # least number of residuals for a shape
# Scatter up to which an error is an offset; five times that of a fault-free sensor.
QUIET: Annotated[float, "rad"] = 0.03
BETTER = 0.5  # share of the variance about an offset that another shape must leave at most
# Standard deviations of a single residual by which drift, gain or ripple must differ from none [-]; as for every other
# sensor, 3 in 1000 chance errors exceed it.
SURE = 3.0
# Blocks of residuals whose powers give the standard deviation of a scatter; neighbouring residuals are correlated.
BLOCKS = 10
ORDERS = range(1, 17)  # periods of a ripple per turn of the shaft that are tried; four per pole pair of a usual motor

OFFSET, DRIFT, GAIN, RIPPLE, SCATTER, NOISE = "offset", "drift", "gain", "ripple", "scatter", "noise"

READINGS = 200  # readings in a window of the noise; the median of as many third differences is known to some 12 %
# Noise of the readings over that which the observer assumes, from which it is named; the increments of a slow motor
# contradict currents and voltages now and then from 5 times as much on, and without an end from 7 times.
NOISY = 5.0
SATURATED: Annotated[float, "rad"] = 0.5  # noise beyond which wrapped readings hardly show how large it is


class Shape(NamedTuple):
    """An error of the sensor."""

    kind: str  # one of OFFSET, DRIFT, GAIN, RIPPLE, SCATTER, NOISE
    # Offset, amplitude or root mean square, electrical [rad]; drift, electrical [rad/s]; gain of the sensor; noise of
    # its readings, mechanical [rad].
    size: float
    deviation: float  # standard deviation of the size, in its unit
    left: float  # root mean square of what the shape leaves, electrical [rad]
    mean: float = 0.0  # mean error, electrical [rad]
    order: int = 0  # periods of a ripple per turn of the shaft
    zero: float = math.nan  # time at which a drift was zero [s]

    @property
    def known(self) -> bool:
        """Whether its interval excludes that there is no such error."""
        return abs(self.size - (1.0 if self.kind == GAIN else 0.0)) > SURE * self.deviation

    def in_words(self, step: bool) -> str:
        """The error as the end of a sentence: "differs ... by"; `step` where it began at once."""
        about = f", about a mean of {math.degrees(self.mean):+.1f}°" if abs(self.mean) > QUIET else ""
        noise = ESTIMATE if self.size < SATURATED else f"more than {math.degrees(SATURATED):.0f}°"
        return {
            OFFSET: f"by {'a step of ' if step else ''}{ESTIMATE} electrical",
            DRIFT: f"by a drift of {ESTIMATE} electrical",
            GAIN: f"by a gain of {ESTIMATE}, so that its error grows with the angle",
            RIPPLE: f"by a ripple of {ESTIMATE} electrical, {self.order} per turn of the shaft{about}",
            SCATTER: f"by {ESTIMATE} electrical rms",
            NOISE: f"of {noise} mechanical",
        }[self.kind]


class _Kept:
    """Rows over a drive, of which every second one goes where they become too many, whatever the pieces."""

    def __init__(self, columns: int):
        self._kept, self._stride, self._seen = np.zeros((0, columns)), 1, 0

    def keep(self, rows: np.ndarray) -> None:
        self._kept = np.vstack([self._kept, rows[-self._seen % self._stride :: self._stride]])
        self._seen += len(rows)
        while len(self._kept) > MOST_SAMPLES:
            self._kept, self._stride = self._kept[::2], 2 * self._stride


class NoiseCourse(_Kept):
    """Noise of the sensor's readings over a drive, in windows.

    Third differences hold none of a motion that is smooth over some readings, and their median none of single leaps.
    """

    def __init__(self) -> None:
        super().__init__(2)
        self._rest = np.zeros((0, 2))

    def add(self, time: np.ndarray, angle: np.ndarray) -> None:
        there = np.isfinite(angle)
        rest = np.vstack([self._rest, np.column_stack([time[there], angle[there]])])
        count = max(len(rest) - 3, 0) // READINGS
        self._rest = rest[count * READINGS :]
        if not count:
            return
        rest = rest[: count * READINGS + 3]
        turns = np.remainder(np.diff(rest[:, 1]) + np.pi, 2.0 * np.pi) - np.pi
        noise = DEVIATION_OF_MEDIAN * np.median(np.abs(differences(turns, taken=1)).reshape(count, READINGS), axis=1)
        self.keep(np.column_stack([rest[:-3:READINGS, 0], noise]))

    def between(self, since: float, until: float) -> tuple[float, float]:
        """Noise of a reading and its standard deviation, mechanical [rad], between two times [s]; NaN if unknown."""
        first, last = np.searchsorted(self._kept[:, 0], (since, until), side="right")
        found = self._kept[max(first - 1, 0) : max(last, first), 1]
        if not len(found):
            return math.nan, math.nan
        return float(np.median(found)), float(found.std()) / math.sqrt(len(found))

    def span(self, limit: float) -> tuple[float, float]:
        """First and last time [s] at which the noise exceeds a limit [rad]; NaN where it never does."""
        above = self._kept[self._kept[:, 1] > limit, 0]
        return (float(above[0]), float(above[-1])) if len(above) else (math.nan, math.nan)


class ResidualCourse(_Kept):
    """Residuals that counted over a drive: time, residual, angle of the observer, and sum of the decision."""

    def __init__(self, pole_pairs: float):
        super().__init__(4)
        self._pole_pairs = pole_pairs

    def onset(self, declared: float) -> tuple[float, bool]:
        """When the error of an alarm began [s], and whether fault-free residuals came before."""
        before = self._kept[self._kept[:, 0] <= declared]
        # The sum leaves zero where the change happened (E. S. Page, Biometrika 41 (1954) 100).
        quiet = np.flatnonzero(before[:, 3] <= 0.0)
        if not len(before) or not len(quiet):
            return declared if not len(before) else float(before[0, 0]), False
        following = before[int(quiet[-1]) + 1 :]
        settled = int(np.count_nonzero(np.abs(before[quiet, 1]) < QUIET)) >= LEAST_SAMPLES
        return float(following[0, 0]) if len(following) else declared, settled

    def end(self, last: float) -> float:
        """When the error of an alarm ended [s]: the last time at which its sum grew, before its last sample [s]."""
        before = self._kept[self._kept[:, 0] <= last]
        grew = np.flatnonzero((np.diff(before[:, 3], prepend=0.0) >= 0.0) & (before[:, 3] > 0.0))
        return float(before[grew[-1], 0]) if len(grew) else last

    def root_mean_square(self, since: float) -> float:
        """Of the residuals from a time [s] on; NaN with fewer than a thousand, a second of turning."""
        after = self._kept[self._kept[:, 0] > since, 1]
        return float(np.sqrt(np.mean(after**2))) if len(after) * self._stride >= 1000 else math.nan

    def shape(self, since: float, until: float) -> Shape | None:
        """The shape that explains the residuals between two times [s] best; None with too few of them."""
        time, residual, angle, _ = self._kept[(self._kept[:, 0] >= since) & (self._kept[:, 0] <= until)].T
        if len(time) < LEAST_SAMPLES:
            return None
        mean = math.atan2(float(np.mean(np.sin(residual))), float(np.mean(np.cos(residual))))
        left = float(np.sqrt(np.mean((np.remainder(residual - mean + np.pi, 2.0 * np.pi) - np.pi) ** 2)))
        if left < QUIET:
            return Shape(OFFSET, mean, left, left, mean)
        error = np.unwrap(residual)
        fits = [self._line(DRIFT, error, time), self._line(GAIN, error, angle)]
        # Over less than a period a ripple cannot be separated from a gain.
        fits += [_ripple(error, angle, order) for order in ORDERS if order * np.ptp(angle) > 2.0 * math.pi]
        best = min((each for each in fits if each.known), key=lambda each: each.left, default=None)
        if best is not None and best.left < math.sqrt(BETTER) * left:
            return best
        if left < 0.5 * abs(mean):
            return Shape(OFFSET, mean, left, left, mean)
        powers = np.array([float(np.mean(each**2)) for each in np.array_split(residual, BLOCKS)])
        size = math.sqrt(float(np.mean(residual**2)))
        return Shape(SCATTER, size, float(powers.std()) / math.sqrt(BLOCKS) / (2.0 * size), left, mean)

    def _line(self, kind: str, error: np.ndarray, along: np.ndarray) -> Shape:
        away = along - along.mean()
        slope = float(away @ error) / max(float(away @ away), 1e-12)
        mean = float(error.mean())
        left = math.sqrt(float(np.mean((error - mean - slope * away) ** 2)))
        deviation = left / max(float(np.std(along)), 1e-9)
        if kind == GAIN:
            return Shape(kind, 1.0 + slope / self._pole_pairs, deviation / self._pole_pairs, left, mean)
        return Shape(kind, slope, deviation, left, mean, zero=float(along.mean()) - mean / slope if slope else math.nan)


def _ripple(error: np.ndarray, angle: np.ndarray, order: int) -> Shape:
    columns = np.column_stack([np.ones(len(error)), np.cos(order * angle), np.sin(order * angle)])
    found, *_ = np.linalg.lstsq(columns, error, rcond=None)
    left = math.sqrt(float(np.mean((error - columns @ found) ** 2)))
    return Shape(RIPPLE, math.hypot(float(found[1]), float(found[2])), left, left, float(found[0]), order)


# NIS above which a sample is surprising; chance exceeds it in one of 6000 samples: three measurements have a mean of
# three.
SURPRISING = 20.0
KNEE_REACHED = 0.95  # share of the range in which the knee is learnt, from which the true knee may lie outside
COMPARED = ("angle", "speed")  # alarms of the comparison of the sensor with the observer
BY_OBSERVER = ("model", *COMPARED)  # alarms after which currents and voltages are compared without the sensor


class Spell(NamedTuple):
    """Activity of an alarm over a drive: number of samples, and time of the last one [s]."""

    samples: int
    last: float


class InverterLoss(NamedTuple):
    """Voltage loss of the inverter, estimated against its command."""

    voltage_loss: Annotated[float, "V"]  # loss of a phase far above the knee
    knee_current: Annotated[float, "A"]  # current below which the loss falls
    knee_deviation: float  # standard deviation of its logarithm
    nominal_knee: Annotated[float, "A"]  # knee current of the vehicle file
    widest: float  # bound of the logarithm of the knee over the nominal one

    @property
    def apart(self) -> float:
        """Logarithm of the knee over that of the vehicle file."""
        return math.log(max(self.knee_current, 1e-9) / self.nominal_knee)

    @property
    def beyond(self) -> bool:
        """Whether the knee may lie outside the range that is learnt."""
        return abs(self.apart) > KNEE_REACHED * self.widest


KEPT = 0.25  # least duration for which an alarm counts [s]; longer than the sampling interval of a fault memory


class AlarmCourses:
    """Collector of first times and activity of alarms, and of the courses of trouble codes, over all pieces."""

    def __init__(self, rate: float):
        self._kept = round(KEPT * rate)
        self.starts: dict[str, float] = {}
        self.spells: dict[str, Spell] = {}
        self.course: list[StatusChange] = []
        self.codes: dict[str, list[StatusChange]] = {name: [] for name in CODES}
        self._since = dict.fromkeys((*CODES, ""), self._kept + 1)

    def add(self, time: np.ndarray, result: Result) -> None:
        stated = result["statement.status"]
        fault = stated == code_of(Status.FAULT)
        # While another code is in fault, a code without an alarm counts as fault-free.
        otherwise = np.where(fault, code_of(Status.HEALTHY), stated)
        self._follow(self.course, "", time, fault, otherwise)
        for code, names in CODES.items():
            flags = [result[f"alarms.{name}"] > 0.5 for name in names]
            for name, each in zip(names, flags, strict=True):
                if not each.any():
                    continue
                self.starts.setdefault(name, float(time[np.argmax(each)]))
                last = float(time[len(each) - 1 - int(np.argmax(each[::-1]))])
                before = self.spells.get(name, Spell(0, last))
                self.spells[name] = Spell(before.samples + int(np.count_nonzero(each)), last)
            self._follow(self.codes[code], code, time, np.any(flags, axis=0), otherwise)

    def of_code(self, name: str, mute: bool = False) -> tuple[StatusChange, ...]:
        """The course of one trouble code."""
        if not mute:
            return tuple(self.codes[name])
        not_judged = Status.NOT_ENABLED
        course = self.codes[name]
        return tuple(each._replace(status=not_judged) if each.status is Status.FAULT else each for each in course)

    def _follow(
        self, course: list[StatusChange], name: str, time: np.ndarray, flags: np.ndarray, otherwise: np.ndarray
    ) -> None:
        place = np.arange(len(flags))
        # The negative start carries the time since the last alarm over from the previous piece.
        last = np.maximum.accumulate(np.where(flags, place, -1 - self._since[name]))
        self._since[name] = min(int(place[-1] - last[-1]), self._kept + 1)
        code = np.where(place - last <= self._kept, code_of(Status.FAULT), otherwise)
        for at in np.flatnonzero(np.diff(code, prepend=np.nan) != 0.0).tolist():
            status = STATUSES[round(code[at])]
            if not course or course[-1].status is not status:
                course.append(StatusChange(float(time[at]), status))


class Drive:
    """Results over a drive, accumulated piece by piece; `close` ends it.

    Angles are electrical but for the noise of a reading, which is mechanical [rad].
    """

    def __init__(self, observer: MotorAngleObserver, voltages: str, superposed: bool, rate: float) -> None:
        p = observer.parameters
        self._observer, self._superposed, self._rate = observer, superposed, rate
        self.voltages, self.courses = voltages, AlarmCourses(rate)
        across = p.inductance_across
        apart = p.motor_inductance - across
        self._balance, self._contradicting = (
            VoltageBalance(p.motor_pole_pairs, p.sample_time, apart / (p.motor_inductance + across)) for _ in range(2)
        )
        self._induced = InducedVoltage(p.motor_resistance, across, p.motor_flux, p.sample_time, apart)
        self._seen = self._known = self._since_model = self._surprised = 0
        self._nis = self.mismatch = self.until = 0.0
        self._residuals = Moments(1)
        self._course, self._noise = ResidualCourse(p.motor_pole_pairs), NoiseCourse()
        self._alarmed = self._pinion = self._torque = False
        self._gains = np.zeros(4)  # windows, and products of the gains: both, the observer's, the sensor's
        self._suspected = np.zeros(round(NOT_MOTOR) + 1, dtype=int)
        self.resistance = self.flux = np.nan
        self._inverter = (0.0, 0.0, 0.0)

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        self.courses.add(time, result)
        self._add_voltages(signals, result)
        self._pinion |= bool(np.isfinite(signals["pinion_angle"]).any())
        self._torque |= bool(np.isfinite(signals["driver_torque"]).any())
        counts, complete, known = (result[f"compared.{name}"] > 0.5 for name in ("counts", "complete", "known"))
        residual, nis = result["estimate.angle_residual_electrical"], result["estimate.nis"]
        self._seen += len(residual)
        self._known += int(known.sum())
        self._residuals.add(residual[counts])
        angle, total = (result[f"{name}"][counts] for name in ("estimate.motor_angle", "compared.angle_sum"))
        self._course.keep(np.column_stack([time[counts], residual[counts], angle, total]))
        self._noise.add(time, signals["motor_angle_mechanical"])
        self.until = float(time[-1])
        sensor, observer = (result[f"compared.{name}_gain"][complete] for name in ("sensor", "observer"))
        self._gains += (len(sensor), sensor @ observer, observer @ observer, sensor @ sensor)
        self._nis += float(nis.sum())
        model = result["alarms.model"] > 0.5
        if self._since_model or model.any():
            after = nis[0 if self._since_model else int(np.argmax(model)) :]
            self._since_model += len(after)
            self._surprised += int(np.count_nonzero(after > SURPRISING))
        apart = result["alarms.plausibility"] > 0.5
        self.mismatch = max(self.mismatch, float(np.abs(result["plausible.mismatch"][apart]).max(initial=0.0)))
        self._suspected += np.bincount(result["plausible.suspect"].astype(int), minlength=len(self._suspected))
        if known.any():
            parameters = self._observer.parameters
            resistance, flux = (result[f"estimate.motor_{name}"][known][-1] for name in ("resistance", "flux"))
            self.resistance, self.flux = resistance / parameters.motor_resistance, flux / parameters.motor_flux
        loss, knee, deviation = (float(result[f"estimate.inverter_{name}"][-1]) for name in InverterLoss._fields[:3])
        self._inverter = (loss, knee, deviation)

    def _add_voltages(self, signals: Mapping[str, np.ndarray], result: Result) -> None:
        current = StatorVector(signals["motor_current_alpha"], signals["motor_current_beta"])
        parameters = self._observer.parameters
        taken = StatorVector(np.zeros(len(current.alpha)), np.zeros(len(current.alpha)))
        if isinstance(parameters, CommandedMotorParameters):
            taken = phase_signs(current, parameters.inverter_knee_current)
        voltage = result["voltage.alpha"] + 1j * result["voltage.beta"]
        flags = np.logical_or.reduce([result[f"alarms.{name}"] > 0.5 for name in BY_OBSERVER])
        alarmed = np.maximum.accumulate(flags) | self._alarmed
        self._alarmed = bool(alarmed[-1])
        self._induced.add(_complex(current)[alarmed], voltage[alarmed])
        columns = (_complex(current), voltage, signals["motor_angle_mechanical"], _complex(taken))
        self._balance.add(*columns)
        self._contradicting.add(*(each[alarmed] for each in columns))

    def close(self) -> None:
        """Compute what rests on the whole drive."""
        observer, starts, spells = self._observer, self.courses.starts, self.courses.spells
        p, residuals = observer.parameters, self._residuals
        self.starts, self.spells = starts, spells  # first times of alarms; their samples and last times
        self.seconds, self.known = (
            self._seen / self._rate,
            self._known / self._rate,
        )  # time; that with a known angle [s]
        self.counted = residuals.count  # residuals that counted, with their mean, deviation and root mean square
        self.offset, self.offset_deviation = float(residuals.means[0]), residuals.deviation() if self.counted else 0.0
        self.rms = math.hypot(self.offset, self.offset_deviation)
        # Windows, increment of the sensor over the observer's, and their correlation.
        windows, together, observed, sensed = self._gains.tolist()
        self.windows, self.slope = int(windows), together / observed if observed else np.nan
        energy = (observed * sensed) ** 0.5
        self.agreement = abs(together) / energy if energy else 0.0
        # Mean NIS, and share of surprising samples since `model` alarmed.
        self.nis, self.surprised = self._nis / max(self._seen, 1), self._surprised / max(self._since_model, 1)
        self.suspect = float(np.argmax(self._suspected[1:]) + 1) if self._suspected[1:].any() else 0.0
        self.untwisted = self._superposed and self._pinion and not self._torque
        self.lost: InverterLoss | None = None  # voltage loss of the inverter; None where the voltages were measured
        if isinstance(p, CommandedMotorParameters):
            self.lost = InverterLoss(*self._inverter, p.inverter_knee_current, observer.tuning.widest_knee)
        self._find_error()
        model = spells.get("model")
        self.rms_since_model = math.nan if model is None else self._course.root_mean_square(model.last)
        # Cause and action, where the whole recording is consistent after another reading.
        self.misread = misread(self._balance, p, observer.tuning.current_noise)
        # Share of the induced voltage that contradicts its rotation since the first of `BY_OBSERVER`; else NaN.
        self.contradicting = self._induced.share()
        # Whether currents, voltages and angle since then are those of some motor, what differs from the vehicle file in
        # words, and the direction of its flux relative to the sensor's.
        self.closes, self.departure, self.turned = False, "", 0.0
        axes = self._contradicting.axes()
        if axes is not None and axes.windows >= LEAST_WINDOWS and axes.unexplained <= CLEAN:
            departure = Departure.of(axes, p, observer.tuning.current_noise).in_words()
            self.closes, self.departure, self.turned = True, departure, axes.flux_direction

    def _find_error(self) -> None:
        """Find begin, end and shape of the error behind an alarm of the comparison, or noise of the readings."""
        starts, spells = self.starts, self.spells
        # `settled`: whether the sensor agreed before.
        self.onset, self.settled, self.end = math.nan, False, math.nan
        self.shape: Shape | None = None
        declared = min((starts[name] for name in COMPARED if name in starts), default=None)
        if declared is not None:
            self.onset, self.settled = self._course.onset(declared)
            self.end = self._course.end(max(spells[name].last for name in COMPARED if name in spells))
            self.shape = self._course.shape(declared, self.end)
        last = max((each.last for each in spells.values()), default=self.until)
        self.noise, deviation = self._noise.between(min(starts.values(), default=0.0), last)
        self.noise_limit = NOISY * self._observer.tuning.sensor_noise
        if self.noise > self.noise_limit:
            self.shape = Shape(NOISE, self.noise, deviation, 0.0)
            self.onset, self.end = self._noise.span(self.noise_limit)

    @property
    def monitor(self) -> str:
        """Name of the monitor and its variant."""
        return f"motor-angle, {VARIANTS[self.voltages]}"


def _complex(vector: StatorVector[NDArray[np.float64]]) -> NDArray[np.complex128]:
    return vector.alpha + 1j * vector.beta
