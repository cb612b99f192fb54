"""The motor's angle sensor watched from all sides: observer, stopping rules, second tests, electrical checks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.detectors.cusum import Cusum
from tierod.graph.maths import any_of, maximum, where
from tierod.monitors.motor_angle.electrical import ElectricalAlarms, ElectricalChecks, ElectricalSample
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.monitors.motor_angle.plausibility import AnglePlausibility, Angles
from tierod.monitors.motor_angle.residual import Observed, ResidualGate
from tierod.monitors.motor_angle.second_tests import Backwards, Following, Increments, NotFollowing, Stuck, Turning
from tierod.monitors.motor_angle.voltages import MEASURED, MotorVoltages, VoltageSignals
from tierod.monitors.motor_angle.which_angle import Opinions
from tierod.vehicles import Vehicle

NOT_READY, NOT_ENABLED, HEALTHY, FAULT = 0.0, 1.0, 2.0, 3.0
"""Codes of the running verdict."""

ANGLE_DRIFT, ANGLE_THRESHOLD = 0.044, 0.9
"""Of the electrical angle's sum, one value a millisecond [rad]: see docs/motor-angle.md, Monitoring."""

SPEED_DRIFT, SPEED_THRESHOLD = 0.5, 2.0
"""Of the speed's sum, one value in 10 ms [rad/s]: see docs/motor-angle.md, Monitoring."""


MODEL_DRIFT, MODEL_THRESHOLD = 8.0, 400.0
"""Of the innovations' sum, one value a sample: three measurements have a mean of three; sound drives stay below 20."""


class MotorAngleSample(NamedTuple):
    """Currents, mean voltages over the sample that ends, and the angle; then whatever else is recorded, or NaN.

    Targets and duty cycles are those of the period that ends with the sample.
    """

    motor_current_alpha: Annotated[float, "A"]
    motor_current_beta: Annotated[float, "A"]
    motor_voltage_alpha: Annotated[float, "V"]
    motor_voltage_beta: Annotated[float, "V"]
    motor_angle_mechanical: Annotated[float, "rad"]
    target_motor_angle_mechanical: Annotated[float, "rad"]
    motor_current_a: Annotated[float, "A"]
    motor_current_b: Annotated[float, "A"]
    motor_current_c: Annotated[float, "A"]
    resolver_sine: Annotated[float, "V"]
    resolver_cosine: Annotated[float, "V"]
    supply_voltage: Annotated[float, "V"]
    steering_wheel_angle: Annotated[float, "rad"]
    pinion_angle: Annotated[float, "rad"]
    driver_torque: Annotated[float, "N*m"]
    motor_target_voltage_alpha: Annotated[float, "V"]
    motor_target_voltage_beta: Annotated[float, "V"]
    motor_duty_cycle_a: Annotated[float, ""]
    motor_duty_cycle_b: Annotated[float, ""]
    motor_duty_cycle_c: Annotated[float, ""]
    vehicle_speed: Annotated[float, "m/s"]


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


@dataclass(frozen=True)
class MotorAngleMonitor:
    """Observer of the motor's angle, and every test that its sensor has to pass.

    Args:
        observer: from currents and voltages
        gate: when its difference from the sensor counts
        voltages: that the observer is fed with
        plausibility: of the three angles of a superposition; None for a motor on a bench
        angle, speed, model: sums of the differences of angle and of speed, and of the innovations
    """

    observer: MotorAngleObserver
    gate: ResidualGate
    electrical: ElectricalChecks
    increments: Increments
    not_following: NotFollowing
    stuck: Stuck = field(default_factory=Stuck)
    backwards: Backwards = field(default_factory=Backwards)
    plausibility: AnglePlausibility | None = None
    voltages: MotorVoltages = field(default_factory=MotorVoltages)
    angle: Cusum = field(default_factory=lambda: Cusum(ANGLE_DRIFT, ANGLE_THRESHOLD, 2.0 * ANGLE_THRESHOLD))
    speed: Cusum = field(default_factory=lambda: Cusum(SPEED_DRIFT, SPEED_THRESHOLD, 2.0 * SPEED_THRESHOLD))
    model: Cusum = field(
        default_factory=lambda: Cusum(MODEL_DRIFT, MODEL_THRESHOLD, 2.0 * MODEL_THRESHOLD, sides="upper")
    )

    Sample = MotorAngleSample

    class State(NamedTuple):
        """Of the parts, in order."""

        observer: Any
        gate: Any
        electrical: Any
        increments: Any
        not_following: Any
        stuck: Any
        backwards: Any
        plausibility: Any
        angle: Any
        speed: Any
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
            ResidualGate(p.motor_pole_pairs, p.motor_flux, sample_time),
            ElectricalChecks(p.motor_pole_pairs, sample_time),
            Increments(sample_time),
            NotFollowing(sample_time),
            plausibility=plausibility,
            voltages=voltages,
        )

    def init(self) -> State:
        """Nothing seen."""
        return self.State(
            observer=self.observer.init(),
            gate=self.gate.init(),
            electrical=self.electrical.init(),
            increments=self.increments.init(),
            not_following=self.not_following.init(),
            stuck=self.stuck.init(),
            backwards=self.backwards.init(),
            plausibility=() if self.plausibility is None else self.plausibility.init(),
            angle=self.angle.init(),
            speed=self.speed.init(),
            model=self.model.init(),
            voltages=self.voltages.init(),
            which=() if self.plausibility is None else self.plausibility.which.init(),
        )

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on."""
        voltages, voltage = self.voltages.step(
            state.voltages, VoltageSignals(*(getattr(sample, name) for name in VoltageSignals._fields))
        )
        seen = self.observer.Sample(
            sample.motor_current_alpha, sample.motor_current_beta, *voltage, sample.motor_angle_mechanical
        )
        observer, estimate = self.observer.step(state.observer, seen)
        sensor, difference = sample.motor_angle_mechanical, estimate.angle_residual_electrical
        gate, gated = self.gate.step(
            state.gate,
            Observed(
                difference,
                sensor,
                estimate.motor_speed,
                estimate.motor_angle_standard_deviation,
                estimate.motor_flux,
                estimate.standing,
            ),
        )
        angle, summed = self.angle.step(state.angle, difference, enabled=gated.counts)
        turning = Turning(sensor, estimate.motor_angle, estimate.motor_speed, estimate.standing)
        increments, gained = self.increments.step(state.increments, turning)
        gained = gained._replace(tells=where(gated.known, gained.tells, 0.0))
        faster = (gained.sensor - gained.observer) / self.increments.window
        speed, speeds = self.speed.step(state.speed, faster, enabled=gained.tells)
        backwards, against = self.backwards.step(state.backwards, gained)
        stuck, still = self.stuck.step(state.stuck, turning._replace(standing=where(gated.known, 0.0, 1.0)))
        following, behind = self.not_following.step(
            state.not_following, Following(sample.target_motor_angle_mechanical, sensor)
        )
        model, fitting = self.model.step(state.model, estimate.nis)
        electrical, checks = self.electrical.step(state.electrical, self._electrical(sample))
        plausible, fits = self._plausible(state.plausibility, sample)
        which, suspect = self._which(state.which, fits, difference, gated.counts)
        alarms = Alarms(
            summed.alarm, speeds.alarm, against.alarm, still.alarm, fitting.alarm, behind.alarm, fits.alarm, checks
        )
        after = self.State(
            observer,
            gate,
            electrical,
            increments,
            following,
            stuck,
            backwards,
            plausible,
            angle,
            speed,
            model,
            voltages,
            which,
        )
        return after, self.Output(
            estimate.motor_angle,
            estimate.motor_angle_standard_deviation,
            estimate.motor_speed,
            estimate.motor_resistance,
            estimate.motor_flux,
            estimate.inverter_voltage_loss,
            estimate.inverter_knee_current,
            estimate.inverter_knee_deviation,
            estimate.nis,
            difference,
            gated.known,
            gated.counts,
            maximum(summed.up, summed.down),
            where(gained.tells, faster, 0.0),
            maximum(speeds.up, speeds.down),
            gained.sensor,
            gained.observer,
            gained.tells,
            fits.mismatch,
            suspect,
            alarms,
            self._verdict(gate, gated.known, alarms),
            voltage,
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

    def _verdict(self, gate: Any, known: Any, alarms: Alarms) -> Any:
        fault = any_of(*(each > 0.5 for each in (*alarms[:-1], *alarms.electrical)))
        early = gate.elapsed < self.gate.start
        return where(fault, FAULT, where(early, NOT_READY, where(known, HEALTHY, NOT_ENABLED)))
