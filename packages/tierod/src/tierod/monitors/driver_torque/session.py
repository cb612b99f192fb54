"""Session of the driver's hands monitor over one recording: its course, and its finding at the end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.graph import Result
from tierod.core.recording import Aligned
from tierod.monitors.driver_torque.contradicting import SIGNALS
from tierod.monitors.driver_torque.decisions import FitRules
from tierod.monitors.driver_torque.drive import TRUTH, Drive, DriveFigures
from tierod.monitors.driver_torque.finding import judge
from tierod.monitors.driver_torque.guessed_ratio import (
    ratio_fits,
    ratio_is_guessed,
    ratio_of_angles,
    ratio_remark,
    with_ratio,
)
from tierod.monitors.driver_torque.misfits import distances
from tierod.monitors.driver_torque.monitor import DriverTorqueMonitor
from tierod.monitors.driver_torque.tuning import SensorNoise, measured_noise
from tierod.monitors.harness.session import BlockSession, Conclusion
from tierod.monitors.harness.verdict import nis_figures
from tierod.vehicles import Vehicle

WITHHELD = (
    "The torque of the hands, and whether they are on the wheel, are withheld, since the vehicle file does not fit the "
    "recording; the normalised innovations show where it fits least."
)
SIZED = (
    "NIS is given per measurement, here and in the chart: 1 where the observer's variances are right, more where they "
    "are too small. The observer assumes a quarter more noise than was measured, so two thirds are usual."
)

TRACES = {
    "statement.magnitude": ("hand_torque", "N*m"),
    "statement.deviation": ("hand_torque_standard_deviation", "N*m"),
    "hands": ("hands_on", ""),
    "disturbance_torque": ("disturbance_torque", "N*m"),
    "disturbance_torque_deviation": ("disturbance_torque_standard_deviation", "N*m"),
    "statement.evidence": ("evidence_for_hands", ""),
    "nis": ("nis", ""),
}
"""Outputs of the block that a report shows."""

MEASURED = 60.0
"""Initial part of a recording on which sensor noise and a guessed motor ratio are measured [s]."""


class Fitted(NamedTuple):
    """Properties of a recording that the block is adapted to.

    Args:
        noise: noise of the sensors
        with_motor: whether the observer uses the motor's angle
        motor_ratio: ratio of the angles, in place of a guess of the vehicle file; None where the file's is used
        hidden: whether the motor's angle is present but not used, since its ratio is a guess and cannot be identified
    """

    noise: SensorNoise
    with_motor: bool
    motor_ratio: float | None = None
    hidden: bool = False


Builder = Callable[[Vehicle, SensorNoise, bool], DriverTorqueMonitor]
"""Builder of the block from vehicle, sensor noise, and whether the motor's angle is used."""


class DriverTorqueSession(BlockSession):
    """Run the block over a recording, and collect the state of the hands and deviations of the column from its file.

    Args:
        build: builder of the block
        usual: noise of the sensors, for recordings too short to measure it
        vehicle: vehicle of the column
        rate: sampling rate [Hz]
        name: name of monitor and variant
        lacking: outputs that the observer does not have
        delay: delay of the observer's torque; the truth is delayed equally [samples]
        remark: remark on the observer, for the report
    """

    listens = MEASURED
    """Length of the first piece, so that the noise does not depend on how the recording is cut [s]."""

    def __init__(
        self,
        build: Builder,
        usual: SensorNoise,
        vehicle: Vehicle,
        rate: float,
        name: str,
        lacking: tuple[str, ...] = (),
        delay: int = 0,
        remark: str = "",
    ):
        shown = {key: each for key, each in TRACES.items() if key not in lacking}
        super().__init__(build(vehicle, usual, True), shown)
        self._build, self._usual, self.rate, self.name = build, usual, rate, name
        self.vehicle = self._given = vehicle
        self._fitted = Fitted(usual, True)
        self.traces = {**self.traces, "true_hand_torque": "N*m"}
        self.signals = (*self.signals, TRUTH)
        self._has_nis, self._remark, self.rules = "nis" not in lacking, remark, FitRules()
        self._figures = DriveFigures(vehicle, rate, self._has_nis)
        self._truth, self._nis = np.full(delay, np.nan), np.empty(0)

    def prepared(self, aligned: Aligned) -> Aligned:
        """The next piece with the truth delayed as the observer; the first one determines the adaptation."""
        columns = aligned.columns
        if self.fitted is None:
            self.refit(self._suited(columns))
        if not self._fitted.hidden and not len(self._truth):
            return aligned
        values = aligned.values.copy()
        if self._fitted.hidden:
            values[:, aligned.names.index("motor_angle_mechanical")] = np.nan
        if len(self._truth):
            truth = np.concatenate([self._truth, columns[TRUTH]])
            kept = len(truth) - len(self._truth)
            values[:, aligned.names.index(TRUTH)], self._truth = truth[:kept], truth[kept:]
        return replace(aligned, values=values)

    def taken(self, aligned: Aligned, result: Result) -> Mapping[str, np.ndarray]:
        """Collect the block's outputs of a piece, and return the traces over it, (n,) each."""
        shown = {**super().taken(aligned, result), "true_hand_torque": aligned.columns[TRUTH]}
        return {name: self._nis if name == "nis" else trace for name, trace in shown.items()}

    def refit(self, fitted: Fitted) -> None:
        """Rebuild the block for the sensor noise of a recording, with the motor's angle or without it."""
        self.fitted = self._fitted = fitted
        if fitted.motor_ratio is not None:
            self.vehicle = with_ratio(self._given, fitted.motor_ratio)
            self._figures = DriveFigures(self.vehicle, self.rate, self._has_nis)
        self.block = self._build(self.vehicle, fitted.noise, fitted.with_motor)

    def _suited(self, columns: Mapping[str, np.ndarray]) -> Fitted:
        """Sensor noise and use of the motor's angle, from the first piece of a recording."""
        first = slice(round(MEASURED * self.rate))
        wheel, motor, torque = (columns[name][first] for name in SIGNALS)
        noise = measured_noise(wheel, torque, self.rate, self._usual)
        if not np.isfinite(columns["motor_angle_mechanical"]).any():
            return Fitted(noise, False)
        if not ratio_is_guessed(self._given):
            return Fitted(noise, True)
        ratio = ratio_of_angles(self._given, wheel, motor, torque, self.rate)
        if ratio is None:
            return Fitted(noise, False, hidden=True)
        return Fitted(noise, True, ratio if ratio_fits(self._given, ratio, self.rules) else None)

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Collect torques, states of the hands and innovations of one piece."""
        self._nis = result["nis"] / np.where(result["present"] > 0.0, result["present"], np.nan)
        self._figures.add(time, signals, result)

    def _remarks(self, drive: Drive) -> tuple[str, ...]:
        """Notices on a motor ratio that the vehicle file guesses."""
        seen = self._fitted.motor_ratio
        if seen is None and not self._fitted.hidden:
            return ()
        over_drive = seen if seen is None or drive.geometry is None else drive.geometry.ratio
        return (ratio_remark(self._given, over_drive),)

    def conclude(self) -> Conclusion:
        """The finding, with the consistency of the observer."""
        drive, found = self._figures.drive(), self._figures.consistency()
        finding = judge(drive, self.vehicle, self.name, self.rules, self._remarks(drive))
        fits, unfit = finding.status.quiet, finding.status.alarm
        withheld = (TRUTH,) if fits else (TRUTH, *(name for name in self.traces if not (unfit and name == "nis")))
        remarks = {"estimate": WITHHELD if unfit else self._remark if fits else "", "consistency": SIZED * bool(found)}
        return Conclusion(
            finding,
            consistency=nis_figures(found, wide=True) if found else {},
            remarks={part: remark for part, remark in remarks.items() if remark},
            withheld=withheld,
            distances=distances(drive, self.vehicle) if fits or unfit else {},
        )
