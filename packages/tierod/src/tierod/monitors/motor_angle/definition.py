"""The monitor of the motor's angle sensor: its block, its session over one recording, and its variants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, NamedTuple, TypeVar

import numpy as np

from tierod.core.block import Scalar, leaves
from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Status
from tierod.core.graph import Result, scan
from tierod.core.graph.maths import absolute, both, greatest_of, maximum, present, where
from tierod.core.recording import Aligned
from tierod.core.statuses import Statement, code_of
from tierod.methods.detectors.control_charts import Cusum
from tierod.monitors.baseline import Baseline
from tierod.monitors.motor_angle.alarms import ALARMS, BY_NAME, MODEL_DRIFT, MODEL_THRESHOLD
from tierod.monitors.motor_angle.comparison import (
    ElectricalAlarms,
    ElectricalChecks,
    ElectricalFigures,
    NotFollowing,
    SensorBesideObserver,
    SensorComparison,
)
from tierod.monitors.motor_angle.evidence import NOISE, Drive
from tierod.monitors.motor_angle.facts import DISTURBING, LEAST_KNOWN, PASSING, isolated_by, judge, root_of
from tierod.monitors.motor_angle.observer import (
    COMMANDED,
    DUTY_CYCLES,
    MEASURED,
    SIGNALS,
    VARIANTS,
    MotorAngleObserver,
    MotorAngleSample,
    MotorVoltages,
)
from tierod.monitors.motor_angle.plausibility import AnglePlausibility, Superposition, VariableGain, WhichAngle
from tierod.monitors.registry import variants_with_plugins
from tierod.monitors.session import BlockSession, Conclusion, Monitor, Variant
from tierod.vehicles import Vehicle

# Electrical residual within which the observer confirms the sensor; fault-free ones stay below 0.05 rad.
CONFIRMED: Annotated[float, "rad"] = 0.1


class Alarms(NamedTuple):
    """1 while a test of the angle alarms."""

    angle: Annotated[Scalar, ""]  # CUSUM of the difference from the observer
    speed: Annotated[Scalar, ""]  # CUSUM of the difference of the increments
    backwards: Annotated[Scalar, ""]  # the sensor turns against the observer
    stuck: Annotated[Scalar, ""]  # the observer turns, the sensor stands still
    model: Annotated[Scalar, ""]  # currents and voltages are not those of one motor
    not_following: Annotated[Scalar, ""]  # the sensor stays away from its target
    plausibility: Annotated[Scalar, ""]  # pinion, motor and steering wheel disagree
    electrical: ElectricalAlarms  # see `ElectricalAlarms`

    def in_order(self) -> list[Scalar]:
        """All alarms, in the order of `ALARMS`."""
        flags = dict(leaves(self))
        return [flags[each.name] for each in ALARMS]


class Tested(NamedTuple):
    """Test statistics that no other output contains."""

    model_sum: Annotated[Scalar, ""]  # CUSUM of the innovations
    backwards_sum: Annotated[Scalar, ""]  # windows in which the sensor turned against the observer, less those with it
    turned_meanwhile: Annotated[Scalar, "rad"]  # turn of the observer while the sensor stood still
    following_error: Annotated[Scalar, "rad"]  # target less sensor; 0 without a target
    electrical: ElectricalFigures  # see `ElectricalFigures`


@dataclass(frozen=True)
class MotorAngleMonitor:
    """Observer of the motor's angle, with every test of its sensor."""

    observer: MotorAngleObserver  # observer from currents and voltages
    comparison: SensorComparison  # comparison of the sensor with the observer
    electrical: ElectricalChecks  # checks of the sensor's own signals, currents and supply
    not_following: NotFollowing  # test of the sensor against its target
    # test of the three angles of a superposition; None for a motor on a bench
    plausibility: AnglePlausibility | None = None
    voltages: MotorVoltages = field(default_factory=MotorVoltages)  # source of the observer's voltages
    # CUSUM of the innovations
    model: Cusum = field(
        default_factory=lambda: Cusum(MODEL_DRIFT, MODEL_THRESHOLD, 2.0 * MODEL_THRESHOLD, sides="upper")
    )

    Sample = MotorAngleSample

    class State(NamedTuple):
        observer: MotorAngleObserver.State
        comparison: SensorComparison.State
        electrical: ElectricalChecks.State
        not_following: NotFollowing.State
        plausibility: AnglePlausibility.State | tuple[()]
        model: Cusum.State
        voltages: MotorVoltages.State
        time: Annotated[Scalar, "s"]
        since: Annotated[Scalar, "s"]

    class Output(NamedTuple):
        """Estimate of the observer, test statistics, alarms, statement, and the voltage that the observer used.

        The kind of the statement is the position of the alarm in `ALARMS`, its magnitude the electrical difference of
        the sensor from the observer.
        """

        estimate: MotorAngleObserver.Output
        compared: SensorComparison.Output
        plausible: AnglePlausibility.Output
        alarms: Alarms
        statement: Statement
        voltage: MotorVoltages.Output
        tested: Tested

    @classmethod
    def of_vehicle(
        cls,
        vehicle: Vehicle,
        sample_time: float,
        plausibility: AnglePlausibility | None = None,
        voltages: MotorVoltages | None = None,
    ) -> MotorAngleMonitor:
        """The monitor for a vehicle's motor.

        Args:
            voltages: source of the observer's voltages; measured ones where None
        """
        voltages = voltages or MotorVoltages()
        observer = MotorAngleObserver.of_vehicle(vehicle, sample_time, commanded=voltages.source != MEASURED)
        p = observer.parameters
        return cls(
            observer,
            SensorComparison(p.motor_pole_pairs, p.motor_flux, sample_time),
            ElectricalChecks(p.motor_pole_pairs, sample_time),
            NotFollowing(sample_time),
            plausibility,
            voltages,
        )

    def init(self) -> State:
        return self.State(
            observer=self.observer.init(),
            comparison=self.comparison.init(),
            electrical=self.electrical.init(),
            not_following=self.not_following.init(),
            plausibility=() if self.plausibility is None else self.plausibility.init(),
            model=self.model.init(),
            voltages=self.voltages.init(),
            time=0.0,
            since=-1.0,
        )

    def step(self, state: State, sample: MotorAngleSample) -> tuple[State, Output]:
        voltages, voltage = self.voltages.step(state.voltages, sample)
        sensor = sample.motor_angle_mechanical
        fed = self.observer.Sample(sample.motor_current_alpha, sample.motor_current_beta, *voltage, sensor)
        observer, estimate = self.observer.step(state.observer, fed)
        comparison, compared = self.comparison.step(state.comparison, SensorBesideObserver(estimate, sensor))
        agrees = absolute(estimate.angle_residual_electrical) < CONFIRMED
        confirmed = both(compared.known > 0.5, agrees)
        following, behind = self.not_following.step(state.not_following, sample, confirmed)
        model, fitting = self.model.step(state.model, estimate.nis)
        electrical, checks = self.electrical.step(state.electrical, sample)
        plausibility, fits = self._plausible(state, sample, estimate.angle_residual_electrical, compared.counts)
        alarms = Alarms(
            compared.angle_alarm,
            compared.speed_alarm,
            compared.backwards_alarm,
            compared.stuck_alarm,
            fitting.alarm,
            behind.alarm,
            fits.alarm,
            checks.alarms,
        )
        tested = Tested(fitting.up, compared.backwards_sum, compared.turned_meanwhile, behind.error, checks.figures)
        statement = self._stated(state, estimate, compared, alarms, tested)
        after = self.State(
            observer,
            comparison,
            electrical,
            following,
            plausibility,
            model,
            voltages,
            state.time + self.observer.parameters.sample_time,
            statement.since,
        )
        return after, self.Output(estimate, compared, fits, alarms, statement, voltage, tested)

    def _plausible(
        self, state: State, sample: MotorAngleSample, residual: Scalar, counts: Scalar
    ) -> tuple[AnglePlausibility.State | tuple[()], AnglePlausibility.Output]:
        if self.plausibility is None or not isinstance(state.plausibility, AnglePlausibility.State):
            return (), AnglePlausibility.Output(0.0, 0.0, 0.0, 0.0, 0.0)
        return self.plausibility.step(state.plausibility, sample, residual, counts)

    def _stated(
        self,
        state: State,
        estimate: MotorAngleObserver.Output,
        compared: SensorComparison.Output,
        alarms: Alarms,
        tested: Tested,
    ) -> Statement:
        flags = alarms.in_order()
        fault = greatest_of(*flags) > 0.5
        running = where(compared.known, code_of(Status.HEALTHY), code_of(Status.NOT_ENABLED))
        running = where(compared.early, code_of(Status.NOT_READY), running)
        known = both(compared.known > 0.5, present(estimate.angle_residual_electrical))
        pole_pairs = self.observer.parameters.motor_pole_pairs
        kind: Scalar = 0.0
        # Backwards, so that of several alarms the first in the order of causes is stated.
        for place in range(len(flags), 0, -1):
            kind = where(flags[place - 1] > 0.5, float(place), kind)
        sums = (
            compared.angle_sum / self.comparison.angle.threshold,
            compared.speed_sum / self.comparison.speed.threshold,
            tested.model_sum / self.model.threshold,
        )
        return Statement(
            status=where(fault, code_of(Status.FAULT), running),
            since=where(fault, where(state.since < 0.0, state.time, state.since), -1.0),
            kind=kind,
            magnitude=where(known, estimate.angle_residual_electrical, 0.0),
            deviation=where(known, pole_pairs * estimate.motor_angle_standard_deviation, 0.0),
            evidence=maximum(greatest_of(*sums), where(fault, 1.0, 0.0)),
        )


LEAST_SHARE = 0.8  # least share of the samples with currents and voltages
SLICE = 200_000  # samples processed at once, so that the outputs of a long piece are not in memory together

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

# Traces that are defined at readings only; 0 stands for no value in between.
AT_READINGS = ("leap_of_angle", "change_of_resolver_amplitude", "resolver_mismatch_electrical", "sum_of_phase_currents")

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
        self._drive = Drive(block.observer, block.voltages.source, block.plausibility is not None, rate)

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
        window = round(self.monitor.comparison.window * self.rate)
        for name in AT_READINGS:
            shown[name] = np.where(shown[name] == 0.0, np.nan, shown[name])
        shown["motor_speed_residual"] = _stood(shown["motor_speed_residual"], windows, window)
        return shown

    def collect(self, time: np.ndarray, signals: Mapping[str, np.ndarray], result: Result) -> None:
        self._drive.add(time, signals, result)

    def conclude(self) -> Conclusion:
        drive, courses = self._drive, self._drive.courses
        drive.close()
        verdict = judge(drive, self.vehicle)
        # A wrong recording is no fault of the sensor and must not enter the fault memory.
        if verdict.status is Status.NOT_TESTABLE:
            return Conclusion(verdict)
        root = root_of(drive)
        disturbed = root in DISTURBING or (root == "angle" and "model" in drive.starts and drive.surprised < PASSING)
        mute = "motor-angle-stuck" if root == "model" else "motor-currents" if disturbed else ""
        codes = {name: courses.of_code(name, mute=name == mute) for name in courses.codes}
        isolated = None if root is None else isolated_by(root, drive)
        isolated = "angle" if isolated == NOISE else isolated
        if root is not None and isolated in BY_NAME and BY_NAME[isolated].code != BY_NAME[root].code:
            codes[BY_NAME[isolated].code] = courses.of_code(BY_NAME[root].code)
            codes[BY_NAME[root].code] = courses.of_code(BY_NAME[root].code, mute=True)
        return Conclusion(verdict, course=tuple(courses.course), code_courses=codes)


def _stood(values: np.ndarray, fresh: np.ndarray, samples: int) -> np.ndarray:
    place = np.arange(len(values))
    last = np.maximum.accumulate(np.where(fresh, place, -1))
    return np.where((last >= 0) & (place - last <= samples), values[last], np.nan)


DECISIONS = tuple(each.decision for each in ALARMS)

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


def required(voltages: str) -> tuple[str, ...]:
    """Signals without which a variant of a voltage source cannot run."""
    return ("motor_current_alpha", "motor_current_beta", *SIGNALS[voltages], "motor_angle_mechanical")


def _variant(voltages: str, summary: str) -> Variant:
    source = f"beyond {PAPER}; docs/explanation/motor-angle.md"
    opener = partial(_open, voltages)
    return Variant(VARIANTS[voltages], summary, source, opener, DECISIONS, required=required(voltages))


LOSS = "the voltage loss of the inverter is estimated too."
OF_MEASURED = _variant(MEASURED, "Kalman filter in stator coordinates without the sensor, cumulative sums.")
OF_COMMANDED = _variant(COMMANDED, f"The same with the commanded voltages; {LOSS}")
OF_DUTY_CYCLES = _variant(DUTY_CYCLES, f"The same with duty cycles and supply voltage; {LOSS}")

MOTOR_ANGLE = Monitor(
    name="motor-angle",
    title="Sensor of the motor's angle",
    subject="Motor angle",
    summary="Compares a motor's angle sensor with the angle that its currents and voltages give, and names its faults.",
    source=PAPER,
    drive=f"Steering that turns the motor faster than about 10 rad/s, for at least {LEAST_KNOWN:g} s in all.",
    required=required(MEASURED),
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
    variants=variants_with_plugins(
        "motor-angle", {name: f"{__name__}:OF_{source.replace(' ', '_').upper()}" for source, name in VARIANTS.items()}
    ),
    default=VARIANTS[MEASURED],
    # A stuck angle sensor is a fault that this monitor detects itself.
    subjects=("motor_angle_mechanical", "resolver_sine", "resolver_cosine"),
)
