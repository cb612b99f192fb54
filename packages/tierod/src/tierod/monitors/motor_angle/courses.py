"""Session of the motor angle monitor over one recording: alarms and statistics piece by piece, and the finding."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.core.statement import STATUSES, code_of
from tierod.models.stator_frame_motor import CommandedMotorParameters
from tierod.monitors.harness.session import StatusChange
from tierod.monitors.motor_angle.drive import (
    BY_OBSERVER,
    COMPARED,
    NOISE,
    NOISY,
    SURPRISING,
    Drive,
    InverterLoss,
    NoiseCourse,
    ResidualCourse,
    Shape,
    Spell,
)
from tierod.monitors.motor_angle.misread import CLEAN, LEAST_WINDOWS, Departure, misread
from tierod.monitors.motor_angle.monitor import CODES, MotorAngleMonitor
from tierod.monitors.motor_angle.plausibility import NOT_MOTOR
from tierod.monitors.motor_angle.voltage_balance import InducedVoltage, VoltageBalance
from tierod.physics.clarke_park import StatorVector
from tierod.physics.inverter import phase_signs

KEPT = 0.25
"""Least duration for which an alarm counts [s]; longer than the sampling interval of a fault memory."""


class AlarmCourses:
    """Collector of first times and activity of alarms, and of the courses of trouble codes, over all pieces.

    Args:
        rate: sampling rate [Hz]
    """

    def __init__(self, rate: float):
        self._kept = round(KEPT * rate)
        self.starts: dict[str, float] = {}
        self.spells: dict[str, Spell] = {}
        self.course: list[StatusChange] = []
        self.codes: dict[str, list[StatusChange]] = {name: [] for name in CODES}
        self._since = dict.fromkeys((*CODES, ""), self._kept + 1)

    def add(self, time: np.ndarray, result: Result) -> None:
        """Add the next piece."""
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
        """The course of one trouble code.

        Args:
            name: name of the code
            mute: whether its alarms are consequences of another fault and carry no information
        """
        if not mute:
            return tuple(self.codes[name])
        not_judged = Status.NOT_ENABLED
        course = self.codes[name]
        return tuple(each._replace(status=not_judged) if each.status is Status.FAULT else each for each in course)

    def _follow(
        self, course: list[StatusChange], name: str, time: np.ndarray, flags: np.ndarray, otherwise: np.ndarray
    ) -> None:
        """Append the changes of one course; an alarm is held for `KEPT`."""
        place = np.arange(len(flags))
        # The negative start carries the time since the last alarm over from the previous piece.
        last = np.maximum.accumulate(np.where(flags, place, -1 - self._since[name]))
        self._since[name] = min(int(place[-1] - last[-1]), self._kept + 1)
        code = np.where(place - last <= self._kept, code_of(Status.FAULT), otherwise)
        for at in np.flatnonzero(np.diff(code, prepend=np.nan) != 0.0).tolist():
            status = STATUSES[round(code[at])]
            if not course or course[-1].status is not status:
                course.append(StatusChange(float(time[at]), status))


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
