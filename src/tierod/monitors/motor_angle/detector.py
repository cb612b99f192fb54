"""The motor's angle sensor watched from all sides: observer, stopping rules, second tests, electrical checks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.graph.maths import any_of, where
from tierod.methods.detectors.control_charts import Cusum
from tierod.monitors.motor_angle.comparison import SensorComparison
from tierod.monitors.motor_angle.electrical import (
    ElectricalAlarms,
    ElectricalChecks,
    ElectricalFigures,
    ElectricalSample,
)
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.monitors.motor_angle.plausibility import AnglePlausibility, Angles
from tierod.monitors.motor_angle.residual import Observed, ResidualGate
from tierod.monitors.motor_angle.second_tests import Following, Increments, NotFollowing
from tierod.monitors.motor_angle.signals import MotorAngleSample
from tierod.monitors.motor_angle.voltages import MEASURED, MotorVoltages, VoltageSignals
from tierod.monitors.motor_angle.which_angle import Opinions
from tierod.vehicles import Vehicle

NOT_READY, NOT_ENABLED, HEALTHY, FAULT = 0.0, 1.0, 2.0, 3.0
"""Codes of the running verdict."""

MODEL_DRIFT, MODEL_THRESHOLD = 8.0, 400.0
"""Of the innovations' sum, one value a sample: three measurements have a mean of three; sound drives stay below 20."""


class Alarms(NamedTuple):
    """1 while a test of the angle alarms.

    Args:
        angle: the sum of the difference from the observer
        speed: that of what both gain
        backwards: the sensor turns against the observer
        stuck: the observer turns on, the sensor does not
        model: currents and voltages are not those of one motor
        not_following: the sensor stays away from its target
        plausibility: pinion, motor and steering wheel do not fit each other
        electrical: see `ElectricalAlarms`
    """

    angle: Annotated[float, ""]
    speed: Annotated[float, ""]
    backwards: Annotated[float, ""]
    stuck: Annotated[float, ""]
    model: Annotated[float, ""]
    not_following: Annotated[float, ""]
    plausibility: Annotated[float, ""]
    electrical: ElectricalAlarms


class Tested(NamedTuple):
    """What the tests compare with their thresholds and other outputs do not hold.

    Args:
        model_sum: of the innovations
        backwards_sum: windows in which the sensor turned against the observer, less those with it
        turned_meanwhile: by the observer, while the sensor stood still
        following_error: target less sensor; 0 without a target
        electrical: see `ElectricalFigures`
    """

    model_sum: Annotated[float, ""]
    backwards_sum: Annotated[float, ""]
    turned_meanwhile: Annotated[float, "rad"]
    following_error: Annotated[float, "rad"]
    electrical: ElectricalFigures


@dataclass(frozen=True)
class MotorAngleMonitor:
    """Observer of the motor's angle, and every test that its sensor has to pass.

    Args:
        observer: from currents and voltages
        comparison: of the sensor with it
        electrical: checks of the sensor's own signals, currents and supply
        not_following: of the sensor beside its target
        plausibility: of the three angles of a superposition; None for a motor on a bench
        voltages: that the observer is fed with
        model: sum of the innovations
    """

    observer: MotorAngleObserver
    comparison: SensorComparison
    electrical: ElectricalChecks
    not_following: NotFollowing
    plausibility: AnglePlausibility | None = None
    voltages: MotorVoltages = field(default_factory=MotorVoltages)
    model: Cusum = field(
        default_factory=lambda: Cusum(MODEL_DRIFT, MODEL_THRESHOLD, 2.0 * MODEL_THRESHOLD, sides="upper")
    )

    Sample = MotorAngleSample

    class State(NamedTuple):
        """Of the parts, in order."""

        observer: Any
        comparison: Any
        electrical: Any
        not_following: Any
        plausibility: Any
        model: Any
        voltages: Any
        which: Any

    class Output(NamedTuple):
        """The estimate, differences and sums, alarms, the running verdict, and the voltage that all this rests on."""

        motor_angle: Annotated[float, "rad"]
        motor_angle_standard_deviation: Annotated[float, "rad"]
        estimated_motor_speed: Annotated[float, "rad/s"]
        motor_resistance: Annotated[float, "ohm"]
        motor_flux: Annotated[float, "V*s"]
        inverter_voltage_loss: Annotated[float, "V"]
        inverter_knee_current: Annotated[float, "A"]
        inverter_knee_deviation: Annotated[float, ""]
        nis: Annotated[float, ""]
        residual: Annotated[float, "rad"]
        known: Annotated[float, ""]
        counts: Annotated[float, ""]
        angle_sum: Annotated[float, "rad"]
        speed_residual: Annotated[float, "rad/s"]
        speed_sum: Annotated[float, "rad/s"]
        sensor_gain: Annotated[float, "rad"]
        observer_gain: Annotated[float, "rad"]
        tells: Annotated[float, ""]
        mismatch: Annotated[float, "rad"]
        suspect: Annotated[float, ""]
        alarms: Alarms
        verdict: Annotated[float, ""]
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
        """The monitor of a vehicle's motor.

        Args:
            vehicle: with the motor's parameters
            sample_time: [s]
            plausibility: where the vehicle has a superposition
            voltages: that the observer is fed with; measured ones where None

        Raises:
            ParameterError: a parameter is missing or cannot be
        """
        voltages = voltages or MotorVoltages()
        observer = MotorAngleObserver.of_vehicle(vehicle, sample_time, commanded=voltages.source != MEASURED)
        p = observer.parameters
        return cls(
            observer,
            SensorComparison(ResidualGate(p.motor_pole_pairs, p.motor_flux, sample_time), Increments(sample_time)),
            ElectricalChecks(p.motor_pole_pairs, sample_time),
            NotFollowing(sample_time),
            plausibility,
            voltages,
        )

    def init(self) -> State:
        """Nothing seen."""
        return self.State(
            observer=self.observer.init(),
            comparison=self.comparison.init(),
            electrical=self.electrical.init(),
            not_following=self.not_following.init(),
            plausibility=() if self.plausibility is None else self.plausibility.init(),
            model=self.model.init(),
            voltages=self.voltages.init(),
            which=() if self.plausibility is None else self.plausibility.which.init(),
        )

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on."""
        voltages, voltage = self.voltages.step(
            state.voltages, VoltageSignals(*(getattr(sample, name) for name in VoltageSignals._fields))
        )
        sensor = sample.motor_angle_mechanical
        seen = self.observer.Sample(sample.motor_current_alpha, sample.motor_current_beta, *voltage, sensor)
        observer, estimate = self.observer.step(state.observer, seen)
        comparison, compared = self.comparison.step(state.comparison, self._observed(estimate, sensor))
        following, behind = self.not_following.step(
            state.not_following, Following(sample.target_motor_angle_mechanical, sensor)
        )
        model, fitting = self.model.step(state.model, estimate.nis)
        electrical, checks = self.electrical.step(state.electrical, self._electrical(sample))
        plausible, fits = self._plausible(state.plausibility, sample)
        which, suspect = self._which(state.which, fits, estimate.angle_residual_electrical, compared.counts)
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
        after = self.State(observer, comparison, electrical, following, plausible, model, voltages, which)
        return after, self._told(estimate, compared, fits.mismatch, suspect, alarms, voltage, tested)

    def _observed(self, estimate: Any, sensor: Any) -> SensorComparison.Sample:
        """What the comparison wants of the observer."""
        observed = Observed(
            estimate.angle_residual_electrical,
            sensor,
            estimate.motor_speed,
            estimate.motor_angle_standard_deviation,
            estimate.motor_flux,
            estimate.standing,
        )
        return SensorComparison.Sample(observed, estimate.motor_angle)

    def _told(
        self,
        estimate: Any,
        compared: SensorComparison.Output,
        mismatch: Any,
        suspect: Any,
        alarms: Alarms,
        voltage: Any,
        tested: Tested,
    ) -> Output:
        """All that is said of one sample."""
        return self.Output(
            estimate.motor_angle,
            estimate.motor_angle_standard_deviation,
            estimate.motor_speed,
            estimate.motor_resistance,
            estimate.motor_flux,
            estimate.inverter_voltage_loss,
            estimate.inverter_knee_current,
            estimate.inverter_knee_deviation,
            estimate.nis,
            estimate.angle_residual_electrical,
            compared.known,
            compared.counts,
            compared.angle_sum,
            compared.speed_residual,
            compared.speed_sum,
            compared.sensor_gain,
            compared.observer_gain,
            compared.tells,
            mismatch,
            suspect,
            alarms,
            self._verdict(compared, alarms),
            voltage,
            tested,
        )

    def _electrical(self, sample: Any) -> ElectricalSample:
        return ElectricalSample(*(getattr(sample, name) for name in ElectricalSample._fields))

    def _plausible(self, state: Any, sample: Any) -> tuple[Any, AnglePlausibility.Output]:
        if self.plausibility is None:
            return (), AnglePlausibility.Output(0.0, 0.0, 0.0, 0.0)
        return self.plausibility.step(state, Angles(*(getattr(sample, name) for name in Angles._fields)))

    def _which(self, state: Any, fits: AnglePlausibility.Output, residual: Any, counts: Any) -> tuple[Any, Any]:
        """Which of the three angles is wrong (code)."""
        if self.plausibility is None:
            return (), 0.0
        after, told = self.plausibility.which.step(state, Opinions(*fits, residual, counts))
        return after, told.suspect

    def _verdict(self, compared: SensorComparison.Output, alarms: Alarms) -> Any:
        fault = any_of(*(each > 0.5 for each in (*alarms[:-1], *alarms.electrical)))
        running = where(compared.early, NOT_READY, where(compared.known, HEALTHY, NOT_ENABLED))
        return where(fault, FAULT, running)
