"""Session of the monitor of the driver's hands over one recording: its course, and its finding at the end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from tierod.core.findings import Status
from tierod.core.graph import Result
from tierod.core.recording import Aligned
from tierod.monitors.driver_torque.decisions import FitRules
from tierod.monitors.driver_torque.drive import TRUTH, DriveFigures
from tierod.monitors.driver_torque.finding import judge
from tierod.monitors.driver_torque.misfits import distances
from tierod.monitors.driver_torque.monitor import DriverTorqueMonitor
from tierod.monitors.driver_torque.sensor_noise import SensorNoise, measured_noise
from tierod.monitors.harness.session import BlockSession, Conclusion
from tierod.vehicles import Vehicle

WITHHELD = (
    "The torque of the hands, and whether they are on the wheel, are withheld, since the vehicle file does not fit the "
    "recording; the normalised innovations show where it fits least."
)
SIZED = (
    "NIS is given per measurement, here and in the chart: 1 where the observer knows its own uncertainty, more where "
    "it claims to know more than it does. It expects a quarter more noise than was measured, so that two thirds are "
    "usual."
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
"""The noise of the sensors is measured on so much of a recording [s]."""

Builder = Callable[[SensorNoise, bool], DriverTorqueMonitor]
"""Makes the block for sensors with this noise, with the motor's angle or without it."""


class DriverTorqueSession(BlockSession):
    """Runs the block, and collects hold of the wheel and deviation of the column from the vehicle file.

    Args:
        build: makes the block
        usual: noise of the sensors, for recordings too short to measure it
        vehicle: whose column it is
        rate: of the samples [Hz]
        name: of monitor and variant
        lacking: outputs that the observer does not have
        delay: by which the torque of the observer is late; the truth is compared as late [samples]
        remark: on the observer, for the report
    """

    listens = MEASURED
    """Time that its first piece needs, so that the noise does not depend on how the recording is cut [s]."""

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
        super().__init__(build(usual, True), shown)
        self._build, self._usual, self.vehicle, self.rate, self.name = build, usual, vehicle, rate, name
        self.traces = {**self.traces, "true_hand_torque": "N*m"}
        self.signals = (*self.signals, TRUTH)
        self._figures, self._remark, self.rules = DriveFigures(vehicle, rate, "nis" not in lacking), remark, FitRules()
        self._truth, self._nis = np.full(delay, np.nan), np.empty(0)

    def prepared(self, aligned: Aligned) -> Aligned:
        """The next piece with the truth as late as the observer; the first one shows the noise of the sensors."""
        columns = aligned.columns
        if not self._figures.seen:
            self.refit(self._suited(columns))
        if not len(self._truth):
            return aligned
        truth = np.concatenate([self._truth, columns[TRUTH]])
        kept = len(truth) - len(self._truth)
        values, at = aligned.values.copy(), aligned.names.index(TRUTH)
        values[:, at], self._truth = truth[:kept], truth[kept:]
        return replace(aligned, values=values)

    def taken(self, aligned: Aligned, result: Result) -> Mapping[str, np.ndarray]:
        """Keep what the block gave over a piece, and give the traces over it, (n,) each."""
        shown = {**super().taken(aligned, result), "true_hand_torque": aligned.columns[TRUTH]}
        return {name: self._nis if name == "nis" else trace for name, trace in shown.items()}

    def refit(self, fitted: tuple[SensorNoise, bool]) -> None:
        """Make the block for the noise of a recording's sensors, with the motor's angle or without it."""
        self.fitted, self.block = fitted, self._build(*fitted)

    def _suited(self, columns: Mapping[str, np.ndarray]) -> tuple[SensorNoise, bool]:
        """Noise of the sensors of a recording, and whether it brings the motor's angle, from its first piece."""
        first = slice(round(MEASURED * self.rate))
        pair = columns["steering_wheel_angle"][first], columns["driver_torque"][first]
        noise = measured_noise(*pair, self.rate, self._usual)
        return noise, bool(np.isfinite(columns["motor_angle_mechanical"]).any())

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Torques, states of the hands and innovations of one piece."""
        self._nis = result["nis"] / np.where(result["present"] > 0.0, result["present"], np.nan)
        self._figures.add(time, signals, result)

    def conclude(self) -> Conclusion:
        """The finding, and how consistent the observer was."""
        drive, found = self._figures.drive(), self._figures.consistency()
        finding = judge(drive, self.vehicle, self.name, self.rules)
        fits = finding.status is Status.HEALTHY
        unfit = finding.status is Status.SUSPECT
        withheld = (TRUTH,) if fits else (TRUTH, *(name for name in self.traces if not (unfit and name == "nis")))
        remarks = {"estimate": WITHHELD if unfit else self._remark if fits else "", "consistency": SIZED * bool(found)}
        return Conclusion(
            finding,
            consistency={"enabled_samples": float(found.samples), "nis_mean": found.nis} if found else {},
            remarks={part: remark for part, remark in remarks.items() if remark},
            withheld=withheld,
            distances=distances(drive, self.vehicle) if fits or unfit else {},
        )
