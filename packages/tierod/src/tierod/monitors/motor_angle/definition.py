"""The monitor of the motor's angle sensor: its session over one recording, its decisions, and its variants."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from string import Formatter
from typing import Annotated, TypeVar

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Status
from tierod.core.graph import Result, scan
from tierod.core.recording import Aligned
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.rule_design import RuleDesign, RunLengthLine
from tierod.methods.detectors.stopping_rules import CusumRule
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.decision import Decision, Demonstrated, OwnRule
from tierod.monitors.harness.session import BlockSession, Conclusion, Monitor, Variant
from tierod.monitors.motor_angle.block import BY_NAME, MODEL_DRIFT, MODEL_THRESHOLD, MotorAngleMonitor
from tierod.monitors.motor_angle.comparison import (
    ANGLE_DRIFT,
    ANGLE_THRESHOLD,
    BACKWARDS,
    SPEED_DRIFT,
    SPEED_THRESHOLD,
    ElectricalChecks,
    NotFollowing,
    Stuck,
)
from tierod.monitors.motor_angle.evidence import NOISE, DriveFigures
from tierod.monitors.motor_angle.facts import (
    DISTURBING,
    FIVE_DEGREES,
    LEAST_KNOWN,
    PASSING,
    isolated_by,
    judge,
    root_of,
)
from tierod.monitors.motor_angle.observer import COMMANDED, DUTY_CYCLES, MEASURED, SIGNALS, VARIANTS, MotorVoltages
from tierod.monitors.motor_angle.plausibility import AnglePlausibility, Superposition, VariableGain, WhichAngle
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

AT_READINGS = ("leap_of_angle", "change_of_resolver_amplitude", "resolver_mismatch_electrical", "sum_of_phase_currents")
"""Traces that are defined at readings only; 0 stands for no value in between."""

INVERTER_TRACES = {
    "estimate.inverter_voltage_loss": ("estimated_inverter_voltage_loss", "V"),
    "estimate.inverter_knee_current": ("estimated_inverter_knee_current", "A"),
}
"""Additional traces where the voltage is commanded."""


class MotorAngleSession(BlockSession):
    """Run the block over a recording, and collect the grounds of the finding on the motor's angle sensor."""

    def __init__(self, block: MotorAngleMonitor, vehicle: Vehicle, rate: float):
        bare = () if block.plausibility is not None else ("plausible.mismatch",)
        shown = TRACES | (INVERTER_TRACES if block.observer.commanded else {})
        super().__init__(block, {output: name for output, name in shown.items() if output not in bare})
        self.monitor, self.vehicle, self.rate = block, vehicle, rate
        self._figures = DriveFigures(block, rate)

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        parts = [self._slice(aligned, start) for start in range(0, len(aligned.time), SLICE)]
        return {name: np.concatenate([part[name] for part in parts]) for name in self.traces}

    def refuse(self, aligned: Aligned) -> None:
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
        self._figures.add(time, signals, result)

    def conclude(self) -> Conclusion:
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
    place = np.arange(len(values))
    last = np.maximum.accumulate(np.where(fresh, place, -1))
    return np.where((last >= 0) & (place - last <= samples), values[last], np.nan)


BORNE: Annotated[float, "rad"] = 2.5 * 0.0066
"""Standard deviation of the residuals that the CUSUM of the angle is designed for; two and a half times the bench's."""

ANGLE_DESIGN = RuleDesign(
    CusumRule(ANGLE_DRIFT / BORNE),
    values=300.0 * 3.6e6,
    shift=FIVE_DEGREES / BORNE,
    spacing=1e-3,
    line=RunLengthLine(start=7.794, slope=14.55 * BORNE, observed=0.69 * 3.6e6),
)
"""Design of the CUSUM of the angle: counted on residuals scaled by two and a half, 239 and 13 alarms at 0.1 and 0.3 rad
in 0.69 h of turning (docs/explanation/motor-angle.md), and extrapolated to 0.9 rad."""

TURNING, DRIVEN = Demonstrated(10.4), Demonstrated(15.0)
"""Hours of 900 fault-free drives with wrong parameters: turning, and in total; docs/explanation/motor-angle.md."""

_SOURCE = (
    "fault-free drives on the bench, voltages measured, with wrong resistance, flux and inductance "
    "(docs/explanation/motor-angle.md); hours of turning"
)


def _numbers(part: type, words: str) -> OwnRule:
    values = {name: float(getattr(part, name)) for _, name, _, _ in Formatter().parse(words) if name}
    return OwnRule(words.format(**values), values)


def _decision(
    name: str,
    distance: str,
    rule: Cusum | OwnRule,
    place: str,
    statistic: str,
    levels: tuple[float, ...],
    demonstrated: Demonstrated | None = TURNING,
    below: bool = False,
) -> Decision:
    source = _SOURCE if demonstrated is TURNING else _SOURCE.replace("hours of turning", "hours driven")
    source = source if demonstrated else "set beyond what fault-free parts show; not demonstrated, because the "
    "bench's drives lack its signals"
    return Decision(
        name, distance, rule, f"block.{place}", None, demonstrated, source, "h", None, statistic, levels, below=below
    )


def _electrical(
    name: str,
    distance: str,
    words: str,
    statistic: str,
    levels: tuple[float, ...],
    demonstrated: Demonstrated | None = None,
    below: bool = False,
) -> Decision:
    rule = _numbers(ElectricalChecks, words)
    return _decision(name, distance, rule, "electrical", statistic, levels, demonstrated, below)


def _either(level: float) -> tuple[float, float]:
    return level, -level


DECISIONS = (
    Decision(
        name="angle",
        distance="sensor less observer, electrical, one value per millisecond [rad]; designed for a standard "
        f"deviation of {BORNE:.4f} rad",
        rule=Cusum(ANGLE_DRIFT, ANGLE_THRESHOLD, 2.0 * ANGLE_THRESHOLD),
        place="block.comparison.angle",
        mean_time_between_false_alarms=300.0,
        demonstrated=TURNING,
        source=f"residuals scaled by 2.5, extrapolated; demonstrated: {_SOURCE}",
        design=ANGLE_DESIGN,
        statistic="angle_residual_sum",
        levels=(ANGLE_THRESHOLD,),
    ),
    _decision(
        "speed",
        "change of the sensor over 10 ms less that of the observer [rad/s]",
        Cusum(SPEED_DRIFT, SPEED_THRESHOLD, 2.0 * SPEED_THRESHOLD),
        "comparison.speed",
        "speed_residual_sum",
        (SPEED_THRESHOLD,),
    ),
    _decision(
        "model",
        "normalised innovation squared of three measurements",
        Cusum(MODEL_DRIFT, MODEL_THRESHOLD, 2.0 * MODEL_THRESHOLD, "upper"),
        "model",
        "innovation_sum",
        (MODEL_THRESHOLD,),
        DRIVEN,
    ),
    _decision(
        "backwards",
        "opposite signs of the changes of sensor and observer over 10 ms",
        Cusum(0.0, BACKWARDS, BACKWARDS, "upper"),
        "comparison.backwards",
        "turned_backwards",
        (BACKWARDS,),
    ),
    _decision(
        "stuck",
        "travel of the observer while the sensor stands still",
        _numbers(Stuck, "more than {travel:g} rad within {still:g} rad of the sensor"),
        "comparison.stuck",
        "turned_while_sensor_stood",
        _either(Stuck.travel),
    ),
    _decision(
        "not following",
        "sensor less its target",
        _numbers(NotFollowing, "more than {widest:g} rad for {hold:g} s"),
        "not_following",
        "following_error",
        _either(NotFollowing.widest),
        DRIVEN,
    ),
    _decision(
        "plausibility",
        "pinion less the angle from motor, steering wheel and torsion bar",
        _numbers(AnglePlausibility, "more than {greatest:g} rad for {hold:g} s"),
        "plausibility",
        "pinion_angle_mismatch",
        _either(AnglePlausibility.greatest),
        None,
    ),
    _electrical(
        "supply low",
        "supply",
        "below {least_supply:g} V for {hold:g} s",
        "supply_voltage",
        (ElectricalChecks.least_supply,),
        below=True,
    ),
    _electrical(
        "angle lost",
        "age of the last reading",
        "above {longest_gap:g} s",
        "age_of_angle",
        (ElectricalChecks.longest_gap,),
        DRIVEN,
    ),
    _electrical(
        "angle leaps",
        "change from one reading to the next",
        "beyond {greatest_speed:g} rad/s and {step_margin:g} rad",
        "leap_of_angle",
        (1.0,),
        DRIVEN,
    ),
    _electrical(
        "resolver amplitude",
        "amplitude of sine and cosine over that of the start, less one",
        "beyond {amplitude_margin:g} for {hold:g} s",
        "change_of_resolver_amplitude",
        _either(ElectricalChecks.amplitude_margin),
    ),
    _electrical(
        "resolver mismatch",
        "angle less that of its own sine and cosine",
        "beyond {greatest_mismatch:g} rad for {hold:g} s",
        "resolver_mismatch_electrical",
        _either(ElectricalChecks.greatest_mismatch),
    ),
    _electrical(
        "current sum",
        "sum of the phases",
        "beyond {greatest_sum:g} A for {hold:g} s",
        "sum_of_phase_currents",
        _either(ElectricalChecks.greatest_sum),
    ),
    *(
        _electrical(
            f"{quantity} saturated",
            f"samples for which a {quantity} stays constant at its peak while the motor turns",
            f"{{same_samples:g}} samples beyond {{least_peak_{quantity}:g}} {unit}",
            f"samples_of_a_still_{quantity}",
            (ElectricalChecks.same_samples,),
            DRIVEN,
        )
        for quantity, unit in (("current", "A"), ("voltage", "V"))
    ),
)
"""Decisions of every variant; those on commanded voltages decide alike, but only measured ones were tested so long."""


PAPER = "Reinelt, Lundquist, Johansson, On-line sensor monitoring in an active front steering system, SAE 2005-01-1271"


Part = TypeVar("Part")


def _open(voltages: str, vehicle: Vehicle, rate: float, baseline: Baseline | None) -> MotorAngleSession:
    plausibility, gear = None, _if_given(vehicle, Superposition)
    if gear is not None:
        gain, which = _if_given(vehicle, VariableGain), WhichAngle(1.0 / rate)
        plausibility = AnglePlausibility(gear, 1.0 / rate, gain=gain, which=which)
    source = MotorVoltages(voltages)  # type: ignore[arg-type]
    return MotorAngleSession(MotorAngleMonitor.of_vehicle(vehicle, 1.0 / rate, plausibility, source), vehicle, rate)


def _if_given(vehicle: Vehicle, kind: type[Part]) -> Part | None:
    try:
        return vehicle.parameters_for(kind)
    except ParameterError:
        return None


def _required(voltages: str) -> tuple[str, ...]:
    return ("motor_current_alpha", "motor_current_beta", *SIGNALS[voltages], "motor_angle_mechanical")


def _variant(voltages: str, summary: str) -> Variant:
    source = f"beyond {PAPER}; docs/explanation/motor-angle.md"
    opener = partial(_open, voltages)
    return Variant(VARIANTS[voltages], summary, source, opener, DECISIONS, required=_required(voltages))


MOTOR_ANGLE = Monitor(
    name="motor-angle",
    title="Sensor of the motor's angle",
    summary="Compares a motor's angle sensor with the angle that its currents and voltages give, and names its faults.",
    source=PAPER,
    drive=f"Steering that turns the motor faster than about 10 rad/s, for at least {LEAST_KNOWN:g} s in all.",
    required=_required(MEASURED),
    optional=(
        "target_motor_angle_mechanical",
        "motor_current_a",
        "motor_current_b",
        "motor_current_c",
        "resolver_sine",
        "resolver_cosine",
        "supply_voltage",
        "steering_wheel_angle",
        "pinion_angle",
        "driver_torque",
        "vehicle_speed",
        *SIGNALS[COMMANDED],
        *SIGNALS[DUTY_CYCLES],
    ),
    rate=10_000.0,
    minimum_rate=500.0,
    # A slow channel is valid at its readings only: a held angle would look like a stuck sensor.
    maximum_age=0.6e-4,
    variants={
        each.name: each
        for each in (
            _variant(
                MEASURED, "Kalman filter in stator coordinates without the sensor, cumulative sums, further tests."
            ),
            _variant(
                COMMANDED, "The same with the commanded voltages; the voltage loss of the inverter is estimated too."
            ),
            _variant(
                DUTY_CYCLES,
                "The same with duty cycles and supply voltage; the voltage loss of the inverter is estimated too.",
            ),
        )
    },
    default=VARIANTS[MEASURED],
    # A stuck angle sensor is a fault that this monitor detects itself.
    subjects=("motor_angle_mechanical", "resolver_sine", "resolver_cosine"),
)
