"""Session of the motor angle monitor over one recording: alarms and statistics piece by piece, and the finding."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tierod.core.errors import InputError
from tierod.core.findings import Status
from tierod.core.graph import Result, scan
from tierod.core.recording import Aligned
from tierod.monitors.harness.session import BlockSession, Conclusion
from tierod.monitors.motor_angle.courses import DriveFigures
from tierod.monitors.motor_angle.drive import (
    NOISE,
)
from tierod.monitors.motor_angle.finding import DISTURBING, PASSING, isolated_by, judge, root_of
from tierod.monitors.motor_angle.monitor import BY_NAME, MotorAngleMonitor
from tierod.monitors.motor_angle.signals import DUTY_CYCLES, SIGNALS
from tierod.vehicles import Vehicle

LEAST_SHARE = 0.8
"""Least share of the samples with currents and voltages."""

SLICE = 200_000
"""Samples processed at once, so that the outputs of a long piece are not in memory together."""

TRACES = {
    "estimate.angle_residual_electrical": ("angle_residual_electrical", "rad"),
    "estimate.motor_angle_standard_deviation": ("angle_residual_electrical_standard_deviation", "rad"),
    "compared.angle_sum": ("angle_residual_sum", "rad"),
    "estimate.motor_angle": ("estimated_motor_angle", "rad"),
    "estimate.motor_speed": ("estimated_motor_speed", "rad/s"),
    "compared.speed_residual": ("motor_speed_residual", "rad/s"),
    "estimate.motor_resistance": ("estimated_motor_resistance", "ohm"),
    "estimate.motor_flux": ("estimated_motor_flux", "V*s"),
    "plausible.mismatch": ("pinion_angle_mismatch", "rad"),
    "compared.known": ("angle_known", ""),
    "estimate.nis": ("nis", ""),
    "compared.speed_sum": ("speed_residual_sum", "rad/s"),
    "tested.model_sum": ("innovation_sum", ""),
    "tested.backwards_sum": ("turned_backwards", ""),
    "tested.turned_meanwhile": ("turned_while_sensor_stood", "rad"),
    "tested.following_error": ("following_error", "rad"),
    "tested.electrical.angle_age": ("age_of_angle", "s"),
    "tested.electrical.angle_step": ("leap_of_angle", ""),
    "tested.electrical.resolver_amplitude": ("change_of_resolver_amplitude", ""),
    "tested.electrical.resolver_mismatch": ("resolver_mismatch_electrical", "rad"),
    "tested.electrical.current_sum": ("sum_of_phase_currents", "A"),
    "tested.electrical.same_current": ("samples_of_a_still_current", ""),
    "tested.electrical.same_voltage": ("samples_of_a_still_voltage", ""),
}
"""Outputs of the block that a report shows."""

AT_READINGS = (
    "leap_of_angle",
    "change_of_resolver_amplitude",
    "resolver_mismatch_electrical",
    "sum_of_phase_currents",
)
"""Traces that are defined at readings only; 0 stands for no value in between."""

INVERTER_TRACES = {
    "estimate.inverter_voltage_loss": ("estimated_inverter_voltage_loss", "V"),
    "estimate.inverter_knee_current": ("estimated_inverter_knee_current", "A"),
}
"""Additional traces where the voltage is commanded."""


class MotorAngleSession(BlockSession):
    """Run the block over a recording, and collect the grounds of the finding on the motor's angle sensor.

    Args:
        block: the monitor
        vehicle: vehicle of the motor
        rate: sampling rate [Hz]
    """

    def __init__(self, block: MotorAngleMonitor, vehicle: Vehicle, rate: float):
        bare = () if block.plausibility is not None else ("plausible.mismatch",)
        shown = TRACES | (INVERTER_TRACES if block.observer.commanded else {})
        super().__init__(block, {output: name for output, name in shown.items() if output not in bare})
        self.monitor, self.vehicle, self.rate = block, vehicle, rate
        self._figures = DriveFigures(block, rate)

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        """Process one more piece and return the traces over it, (n,) each."""
        parts = [self._slice(aligned, start) for start in range(0, len(aligned.time), SLICE)]
        return {name: np.concatenate([part[name] for part in parts]) for name in self.traces}

    def refuse(self, aligned: Aligned) -> None:
        """Refuse currents and voltages at too low a rate, and duty cycles without a supply voltage."""
        self._refuse_slow(aligned)
        self._refuse_without_supply(aligned)

    def _refuse_slow(self, aligned: Aligned) -> None:
        """Refuse slow currents and voltages: held values would look like signals that stand still."""
        for name in ("motor_current_alpha", "motor_current_beta", *SIGNALS[self.monitor.voltages.source]):
            there = np.isfinite(aligned.values[:, aligned.names.index(name)])
            share = float(there.mean()) if there.any() else 1.0
            if share < LEAST_SHARE:
                raise InputError(
                    f"{name} has only about {share * self.rate:.0f} Hz, or lost samples; the observer of the motor's "
                    f"angle needs {self.rate:g} Hz: record the motor's signals at the rate of its modulation, and "
                    "check the unit of time"
                )

    def _refuse_without_supply(self, aligned: Aligned) -> None:
        supply = aligned.values[:, aligned.names.index("supply_voltage")]
        if self.monitor.voltages.source == DUTY_CYCLES and not np.isfinite(supply).any():
            raise InputError(
                "duty cycles give a voltage only with supply_voltage, and the recording begins without one; record it, "
                "or name it in a channel map, or record motor_target_voltage_alpha and motor_target_voltage_beta"
            )

    def _slice(self, aligned: Aligned, start: int) -> dict[str, np.ndarray]:
        """The traces of one slice; residuals are shown where they count."""
        time, values = aligned.time[start : start + SLICE], aligned.values[start : start + SLICE]
        result = scan(self.block, Aligned(time, values, aligned.names), self.memory)
        self.memory = result.state
        signals = dict(zip(aligned.names, values.T, strict=True))
        self.collect(time, signals, result)
        shown = {name: result[output] for name, output in self._outputs.items()}
        known, windows = result["compared.known"] > 0.5, result["compared.complete"] > 0.5
        residual, deviation = "angle_residual_electrical", "angle_residual_electrical_standard_deviation"
        shown[residual] = np.where(known, shown[residual], np.nan)
        pole_pairs = self.monitor.observer.parameters.motor_pole_pairs
        shown[deviation] = np.where(known, pole_pairs * shown[deviation], np.nan)
        window = round(self.monitor.comparison.increments.window * self.rate)
        for name in AT_READINGS:
            shown[name] = np.where(shown[name] == 0.0, np.nan, shown[name])
        shown["motor_speed_residual"] = _stood(shown["motor_speed_residual"], windows, window)
        return shown

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        """Collect alarms and statistics of one piece."""
        self._figures.add(time, signals, result)

    def conclude(self) -> Conclusion:
        """The finding, and the course of every trouble code."""
        drive, courses = self._figures.drive(), self._figures.courses
        finding = judge(drive, self.vehicle)
        # A wrong recording is no fault of the sensor and must not enter the fault memory.
        if finding.status is Status.NOT_TESTABLE:
            return Conclusion(finding)
        root = root_of(drive)
        disturbed = root in DISTURBING or (root == "angle" and "model" in drive.starts and drive.surprised < PASSING)
        mute = "motor-angle-stuck" if root == "model" else "motor-currents" if disturbed else ""
        codes = {name: courses.of_code(name, mute=name == mute) for name in courses.codes}
        isolated = None if root is None else isolated_by(root, drive)
        isolated = "angle" if isolated == NOISE else isolated
        if root is not None and isolated in BY_NAME and BY_NAME[isolated].code != BY_NAME[root].code:
            codes[BY_NAME[isolated].code] = courses.of_code(BY_NAME[root].code)
            codes[BY_NAME[root].code] = courses.of_code(BY_NAME[root].code, mute=True)
        return Conclusion(finding, course=tuple(courses.course), code_courses=codes)


def _stood(values: np.ndarray, fresh: np.ndarray, samples: int) -> np.ndarray:
    """Values held for so many samples from where they are fresh, else NaN, since single points draw no line."""
    place = np.arange(len(values))
    last = np.maximum.accumulate(np.where(fresh, place, -1))
    return np.where((last >= 0) & (place - last <= samples), values[last], np.nan)
