"""Statistics over a drive of the motor: time with a known angle, residuals, increments, learnt parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tierod.core.graph import Result
from tierod.models.stator_frame_motor import CommandedMotorParameters
from tierod.monitors.motor_angle.alarms import AlarmCourses, Spell
from tierod.monitors.motor_angle.misread import CLEAN, LEAST_WINDOWS, Departure, misread
from tierod.monitors.motor_angle.monitor import MotorAngleMonitor
from tierod.monitors.motor_angle.residual_shape import NOISE, NOISY, NoiseCourse, ResidualCourse, Shape
from tierod.monitors.motor_angle.signals import MEASURED, VARIANTS
from tierod.monitors.motor_angle.voltage_balance import InducedVoltage, VoltageBalance
from tierod.monitors.motor_angle.which_angle import NOT_MOTOR
from tierod.physics.clarke_park import StatorVector
from tierod.physics.inverter import phase_signs

SURPRISING = 20.0
"""NIS above which a sample is surprising; chance exceeds it in one of 6000 samples: three measurements have a mean of
three."""

KNEE_REACHED = 0.95
"""Share of the range in which the knee is learnt, from which the true knee may lie outside."""


COMPARED = ("angle", "speed")
"""Alarms of the comparison of the sensor with the observer."""

BY_OBSERVER = ("model", *COMPARED)
"""Alarms after which currents and voltages are compared without the sensor."""


class InverterLoss(NamedTuple):
    """Voltage loss of the inverter, estimated against its command.

    Args:
        voltage_loss: loss of a phase far above the knee
        knee_current: current below which the loss falls
        knee_deviation: standard deviation of its logarithm
        nominal_knee: knee current of the vehicle file
        widest: bound of the logarithm of the knee over the nominal one
    """

    voltage_loss: Annotated[float, "V"]
    knee_current: Annotated[float, "A"]
    knee_deviation: float
    nominal_knee: Annotated[float, "A"]
    widest: float

    @property
    def apart(self) -> float:
        """Logarithm of the knee over that of the vehicle file."""
        return math.log(max(self.knee_current, 1e-9) / self.nominal_knee)

    @property
    def beyond(self) -> bool:
        """Whether the knee may lie outside the range that is learnt."""
        return abs(self.apart) > KNEE_REACHED * self.widest


class Drive(NamedTuple):
    """Results over a drive.

    Args:
        seconds, known: duration of the drive, and time with a known angle
        counted: number of residuals that counted
        offset, offset_deviation: mean and standard deviation of all electrical residuals that counted
        rms: root mean square of all residuals that counted
        windows, slope, agreement: number of windows, increment of the sensor over the observer's, their correlation
        nis, surprised: mean NIS, and share of surprising samples since `model` alarmed
        resistance, flux: estimates over the values of the vehicle file
        suspect: code of the angle that the plausibility test suspects
        starts: first times of alarms
        spells: number of samples and last time of each alarm
        until: end of the drive [s]
        onset, settled, end: begin of the error behind the alarm of `angle` or `speed`, whether the sensor agreed
            before, and end
        shape: error of the sensor from then to the end of the alarm, or noise; None without such an alarm
        noise, noise_limit: noise of a reading since the first alarm, or over the drive without one, and that from which
            it is named, mechanical
        rms_since_model: root mean square of the residuals since the last alarm of `model`; NaN with too few of them
        voltages: source of the observer's voltages
        lost: voltage loss of the inverter; None where the voltages were measured
        misread: cause and action, where the whole recording is consistent after another reading
        contradicting: share of the induced voltage that contradicts its rotation since the first of `BY_OBSERVER`; else
            NaN
        closes: whether currents, voltages and angle since then are those of some motor
        departure: parameters of that motor that differ from the vehicle file, in words
        turned: direction of its flux relative to the sensor's, electrical
        mismatch: largest mismatch of the three angles during its alarm, at the pinion
        untwisted: whether the three angles were not compared for lack of the driver's torque
    """

    seconds: Annotated[float, "s"]
    known: Annotated[float, "s"]
    counted: int
    offset: Annotated[float, "rad"]
    offset_deviation: Annotated[float, "rad"]
    rms: Annotated[float, "rad"]
    windows: int
    slope: float
    agreement: float
    nis: float
    surprised: float
    resistance: float
    flux: float
    suspect: float
    starts: dict[str, float]
    spells: dict[str, Spell]
    until: Annotated[float, "s"]
    onset: Annotated[float, "s"] = math.nan
    settled: bool = False
    end: Annotated[float, "s"] = math.nan
    shape: Shape | None = None
    noise: Annotated[float, "rad"] = math.nan
    noise_limit: Annotated[float, "rad"] = math.nan
    rms_since_model: Annotated[float, "rad"] = math.nan
    voltages: str = MEASURED
    lost: InverterLoss | None = None
    misread: tuple[str, str] | None = None
    contradicting: float = math.nan
    closes: bool = False
    departure: str = ""
    turned: Annotated[float, "rad"] = 0.0
    mismatch: Annotated[float, "rad"] = 0.0
    untwisted: bool = False

    @property
    def monitor(self) -> str:
        """Name of the monitor and its variant."""
        return f"motor-angle, {VARIANTS[self.voltages]}"


class DriveFigures:
    """Accumulated statistics over the pieces of a recording.

    Args:
        monitor: monitor that gives the outputs
        rate: sampling rate [Hz]
    """

    def __init__(self, monitor: MotorAngleMonitor, rate: float) -> None:
        p = monitor.observer.parameters
        self._monitor, self._rate, self.courses = monitor, rate, AlarmCourses(rate)
        across = p.inductance_across
        apart = p.motor_inductance - across
        self._balance = VoltageBalance(p.motor_pole_pairs, p.sample_time, apart / (p.motor_inductance + across))
        self._contradicting = VoltageBalance(p.motor_pole_pairs, p.sample_time, apart / (p.motor_inductance + across))
        self._induced = InducedVoltage(p.motor_resistance, across, p.motor_flux, p.sample_time, apart)
        self.seen = self.known = self.since_model = self.surprised = 0
        self.nis = self.mismatch = 0.0
        self.residuals = np.zeros(3)  # count, sum and sum of squares
        self._course, self._noise, self._until = ResidualCourse(p.motor_pole_pairs), NoiseCourse(), 0.0
        self._alarmed = False
        self.gains = np.zeros(4)  # windows, and products of the gains: both, the observer's, the sensor's
        self.suspected = np.zeros(round(NOT_MOTOR) + 1, dtype=int)
        self.resistance = self.flux = np.nan
        self.inverter = (0.0, 0.0, 0.0)
        self.pinion = self.torque = False

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Add the next piece: time [s], signals and outputs by name, (n,) each."""
        self.courses.add(time, result)
        self._add_voltages(signals, result)
        self.pinion |= bool(np.isfinite(signals["pinion_angle"]).any())
        self.torque |= bool(np.isfinite(signals["driver_torque"]).any())
        counts, complete, known = (result[f"compared.{name}"] > 0.5 for name in ("counts", "complete", "known"))
        residual, nis = result["estimate.angle_residual_electrical"], result["estimate.nis"]
        self.seen += len(residual)
        self.known += int(known.sum())
        self.residuals += _powers(residual[counts])
        angle, total = (result[f"{name}"][counts] for name in ("estimate.motor_angle", "compared.angle_sum"))
        self._course.add(time[counts], residual[counts], angle, total)
        self._noise.add(time, signals["motor_angle_mechanical"])
        self._until = float(time[-1])
        sensor, observer = (result[f"compared.{name}_gain"][complete] for name in ("sensor", "observer"))
        self.gains += (len(sensor), sensor @ observer, observer @ observer, sensor @ sensor)
        self.nis += float(nis.sum())
        model = result["alarms.model"] > 0.5
        if self.since_model or model.any():
            after = nis[0 if self.since_model else int(np.argmax(model)) :]
            self.since_model += len(after)
            self.surprised += int(np.count_nonzero(after > SURPRISING))
        apart = result["alarms.plausibility"] > 0.5
        self.mismatch = max(self.mismatch, float(np.abs(result["plausible.mismatch"][apart]).max(initial=0.0)))
        self.suspected += np.bincount(result["plausible.suspect"].astype(int), minlength=len(self.suspected))
        if known.any():
            self.resistance, self.flux = (
                float(result[f"estimate.motor_{name}"][known][-1]) for name in ("resistance", "flux")
            )
        loss, knee, deviation = (float(result[f"estimate.inverter_{name}"][-1]) for name in InverterLoss._fields[:3])
        self.inverter = (loss, knee, deviation)

    def _add_voltages(self, signals: Mapping[str, np.ndarray], result: Result) -> None:
        current = StatorVector(signals["motor_current_alpha"], signals["motor_current_beta"])
        parameters = self._monitor.observer.parameters
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

    def drive(self) -> Drive:
        """The results so far."""
        monitor, rate = self._monitor, self._rate
        count, total, squares = self.residuals
        mean = float(total) / max(count, 1.0)
        windows, together, observed, sensed = self.gains.tolist()
        energy = (observed * sensed) ** 0.5
        parameters, lost = monitor.observer.parameters, None
        if isinstance(parameters, CommandedMotorParameters):
            widest = monitor.observer.tuning.widest_knee
            lost = InverterLoss(*self.inverter, parameters.inverter_knee_current, widest)
        courses = self.courses
        declared = min((courses.starts[name] for name in COMPARED if name in courses.starts), default=None)
        onset, settled, end, shape = math.nan, False, math.nan, None
        if declared is not None:
            onset, settled = self._course.onset(declared)
            last = max(courses.spells[name].last for name in COMPARED if name in courses.spells)
            end = self._course.end(last)
            shape = self._course.shape(declared, end)
        last = max((each.last for each in courses.spells.values()), default=self._until)
        noise, deviation = self._noise.between(min(courses.starts.values(), default=0.0), last)
        limit = NOISY * monitor.observer.tuning.sensor_noise
        if noise > limit:
            shape, (onset, end) = Shape(NOISE, noise, deviation, 0.0), self._noise.span(limit)
        model = courses.spells.get("model")
        closes, departure, turned = self._departure()
        return Drive(
            seconds=self.seen / rate,
            known=self.known / rate,
            counted=int(self.residuals[0]),
            offset=mean,
            offset_deviation=max(float(squares) / max(count, 1.0) - mean * mean, 0.0) ** 0.5,
            rms=(float(self.residuals[2]) / max(self.residuals[0], 1.0)) ** 0.5,
            windows=int(windows),
            slope=together / observed if observed else np.nan,
            agreement=abs(together) / energy if energy else 0.0,
            nis=self.nis / max(self.seen, 1),
            surprised=self.surprised / max(self.since_model, 1),
            resistance=self.resistance / parameters.motor_resistance,
            flux=self.flux / parameters.motor_flux,
            suspect=float(np.argmax(self.suspected[1:]) + 1) if self.suspected[1:].any() else 0.0,
            starts=dict(self.courses.starts),
            spells=dict(self.courses.spells),
            until=self._until,
            voltages=monitor.voltages.source,
            lost=lost,
            misread=misread(self._balance, parameters, monitor.observer.tuning.current_noise),
            contradicting=self._induced.share(),
            closes=closes,
            departure=departure,
            turned=turned,
            mismatch=self.mismatch,
            onset=onset,
            settled=settled,
            end=end,
            shape=shape,
            noise=noise,
            noise_limit=limit,
            rms_since_model=math.nan if model is None else self._course.root_mean_square(model.last),
            untwisted=monitor.plausibility is not None and self.pinion and not self.torque,
        )

    def _departure(self) -> tuple[bool, str, float]:
        """Whether there is a motor that fits since the observer alarmed, what differs of it, and its flux direction."""
        axes, observer = self._contradicting.axes(), self._monitor.observer
        if axes is None or axes.windows < LEAST_WINDOWS or axes.unexplained > CLEAN:
            return False, "", 0.0
        departure = Departure.of(axes, observer.parameters, observer.tuning.current_noise).in_words()
        return True, departure, axes.flux_direction


def _complex(vector: StatorVector[NDArray[np.float64]]) -> NDArray[np.complex128]:
    return vector.alpha + 1j * vector.beta


def _powers(values: np.ndarray) -> tuple[float, float, float]:
    """Count, sum and sum of squares."""
    return len(values), float(values.sum()), float((values**2).sum())
