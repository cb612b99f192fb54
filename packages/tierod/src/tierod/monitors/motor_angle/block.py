"""Monitor of the motor's angle sensor: observer, CUSUMs, further tests, electrical checks, and its alarms."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, leaves
from tierod.core.findings import Status
from tierod.core.graph.maths import absolute, both, greatest_of, maximum, present, where
from tierod.core.statement import Statement, code_of
from tierod.methods.detectors.control_charts import Cusum
from tierod.monitors.motor_angle.comparison import (
    ElectricalAlarms,
    ElectricalChecks,
    ElectricalFigures,
    Increments,
    NotFollowing,
    ResidualGate,
    SensorBesideObserver,
    SensorComparison,
)
from tierod.monitors.motor_angle.observer import MEASURED, MotorAngleObserver, MotorAngleSample, MotorVoltages
from tierod.monitors.motor_angle.plausibility import AnglePlausibility
from tierod.vehicles import Vehicle

MODEL_DRIFT, MODEL_THRESHOLD = 8.0, 400.0
"""CUSUM of the NIS, one value per sample; three measurements have a mean of three, and the sum stays below 20 without a
fault."""


CONFIRMED: Annotated[float, "rad"] = 0.1
"""Electrical residual within which the observer confirms the sensor; fault-free ones stay below 0.05 rad."""


class Alarm(NamedTuple):
    """An alarm with its meaning.

    Args:
        name: name of its output
        decision: decision that raises it
        code: its trouble code
        cause: its meaning
        action: the remedy
    """

    name: str
    decision: str
    code: str
    cause: str
    action: str


ALARMS = (
    Alarm(
        "electrical.supply_low",
        "supply low",
        "motor-supply-low",
        "the supply of the controller is too low",
        "check battery, wiring and generator",
    ),
    Alarm(
        "electrical.angle_timeout",
        "angle lost",
        "motor-angle-lost",
        "no readings of the motor's angle arrive",
        "check the sensor and its line",
    ),
    Alarm(
        "electrical.resolver_amplitude",
        "resolver amplitude",
        "motor-angle-amplitude",
        "the amplitude of the angle sensor's sine and cosine has changed",
        "check sensor, magnet and wiring: one of the two has lost amplitude or gained an offset",
    ),
    Alarm(
        "electrical.current_sum",
        "current sum",
        "motor-currents",
        "the phase currents do not add up to zero",
        "check the current sensors for an offset or a wrong gain, and the phases for a leak to ground",
    ),
    Alarm(
        "electrical.current_saturated",
        "current saturated",
        "motor-currents",
        "a current stays constant at its peak while the motor turns: its measurement is saturated",
        "widen the range of the current measurement",
    ),
    Alarm(
        "electrical.voltage_saturated",
        "voltage saturated",
        "motor-currents",
        "a voltage stays constant at its peak while the motor turns: its measurement is saturated",
        "widen the range of the voltage measurement",
    ),
    Alarm(
        "model",
        "model",
        "motor-currents",
        "currents and voltages contradict the model of the motor",
        "check sign and order of the phases of currents and voltages, the sampling time, and the motor's parameters",
    ),
    Alarm(
        "stuck",
        "stuck",
        "motor-angle-stuck",
        "the motor turns, but its angle sensor stands still",
        "replace the sensor",
    ),
    Alarm(
        "backwards",
        "backwards",
        "motor-angle-backwards",
        "the angle sensor turns in the direction opposite to the motor: sine and cosine, or two phases, are swapped",
        "check wiring and channel map",
    ),
    Alarm(
        "electrical.resolver_mismatch",
        "resolver mismatch",
        "motor-angle-mismatch",
        "the motor's angle differs from the angle of its sensor's sine and cosine",
        "check the zero of the angle, its calibration, and the software between sensor and control",
    ),
    Alarm(
        "angle",
        "angle",
        "motor-angle-offset",
        "the angle sensor differs from the angle that currents and voltages give",
        "check the sensor's magnet and its zero",
    ),
    Alarm(
        "speed",
        "speed",
        "motor-angle-offset",
        "the angle sensor turns at another speed than currents and voltages give",
        "check the sensor: its gain, and whether it has lost readings",
    ),
    Alarm(
        "electrical.angle_gradient",
        "angle leaps",
        "motor-angle-offset",
        "the motor's angle jumps further than the motor can turn between two readings",
        "check sensor and line",
    ),
    Alarm(
        "not_following",
        "not following",
        "motor-angle-stuck",
        "the motor's angle stays away from its target: the sensor is stuck, its zero far off or a phase wrong, the "
        "motor itself stands still, or target_motor_angle_mechanical is not the one that it follows",
        "check whether the motor turns; if it does, check the sensor, its zero, sine and cosine, and the target in the "
        "channel map with its time stamps",
    ),
    Alarm(
        "plausibility",
        "plausibility",
        "steering-angles-implausible",
        "the angles of motor, steering wheel and pinion do not fit each other",
        "check the sensors of these angles, and the gear's ratios in the vehicle file",
    ),
)
"""Alarms from root cause to consequence; the kind of a statement is the position here, counted from 1."""

BY_NAME = {each.name: each for each in ALARMS}

CODES = {code: [each.name for each in ALARMS if each.code == code] for code in {each.code: None for each in ALARMS}}
"""Alarms behind each trouble code."""


class Alarms(NamedTuple):
    """1 while a test of the angle alarms.

    Args:
        angle: CUSUM of the difference from the observer
        speed: CUSUM of the difference of the increments
        backwards: the sensor turns against the observer
        stuck: the observer turns, the sensor stands still
        model: currents and voltages are not those of one motor
        not_following: the sensor stays away from its target
        plausibility: pinion, motor and steering wheel disagree
        electrical: see `ElectricalAlarms`
    """

    angle: Annotated[Scalar, ""]
    speed: Annotated[Scalar, ""]
    backwards: Annotated[Scalar, ""]
    stuck: Annotated[Scalar, ""]
    model: Annotated[Scalar, ""]
    not_following: Annotated[Scalar, ""]
    plausibility: Annotated[Scalar, ""]
    electrical: ElectricalAlarms

    def in_order(self) -> list[Scalar]:
        """All alarms, in the order of `ALARMS`."""
        flags = dict(leaves(self))
        return [flags[each.name] for each in ALARMS]


class Tested(NamedTuple):
    """Test statistics that no other output contains.

    Args:
        model_sum: CUSUM of the innovations
        backwards_sum: windows in which the sensor turned against the observer, less those with it
        turned_meanwhile: turn of the observer while the sensor stood still
        following_error: target less sensor; 0 without a target
        electrical: see `ElectricalFigures`
    """

    model_sum: Annotated[Scalar, ""]
    backwards_sum: Annotated[Scalar, ""]
    turned_meanwhile: Annotated[Scalar, "rad"]
    following_error: Annotated[Scalar, "rad"]
    electrical: ElectricalFigures


@dataclass(frozen=True)
class MotorAngleMonitor:
    """Observer of the motor's angle, with every test of its sensor.

    Args:
        observer: observer from currents and voltages
        comparison: comparison of the sensor with the observer
        electrical: checks of the sensor's own signals, currents and supply
        not_following: test of the sensor against its target
        plausibility: test of the three angles of a superposition; None for a motor on a bench
        voltages: source of the observer's voltages
        model: CUSUM of the innovations
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

        Raises:
            ParameterError: a parameter is missing or invalid
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
