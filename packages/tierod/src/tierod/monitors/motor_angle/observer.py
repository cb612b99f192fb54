"""Signals of the motor angle monitor, the choice of the voltages for its observer, and what it assumes of both."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal, NamedTuple, get_type_hints

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, both, exp, hypot, limit, maximum, minimum, present, sqrt, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.shapes import Belief
from tierod.models.stator_frame_motor import (
    CommandedMotor,
    CommandedMotorParameters,
    SampledMotorParameters,
    StatorFrameMotor,
)
from tierod.physics.friction import share_reached
from tierod.physics.motor import LONGEST_SIGN, PhaseValues, back_emf_constant, commanded_voltage, wrapped
from tierod.vehicles import Vehicle

MEASURED, COMMANDED, DUTY_CYCLES = "measured", "commanded", "duty cycles"

SIGNALS = {
    MEASURED: ("motor_voltage_alpha", "motor_voltage_beta"),
    COMMANDED: ("motor_target_voltage_alpha", "motor_target_voltage_beta"),
    DUTY_CYCLES: ("motor_duty_cycle_a", "motor_duty_cycle_b", "motor_duty_cycle_c"),
}
"""Signals that each voltage source needs in every sample; duty cycles also need a supply voltage, however seldom."""

# Names of the monitor's variants.
VARIANTS = {MEASURED: "stator-frame", COMMANDED: "commanded-voltage", DUTY_CYCLES: "duty-cycles"}

IN_WORDS = {
    COMMANDED: "the commanded ones, less the estimated voltage loss of the inverter",
    DUTY_CYCLES: "duty cycles times the supply, less the estimated voltage loss of the inverter",
}
"""Voltage sources other than measurement, in words."""


class MotorAngleSample(NamedTuple):
    """Currents, mean voltages over the sample that ends, and the angle; then all further signals, or NaN.

    Targets and duty cycles are those of the period that ends with the sample.
    """

    motor_current_alpha: Annotated[Scalar, "A"]
    motor_current_beta: Annotated[Scalar, "A"]
    motor_voltage_alpha: Annotated[Scalar, "V"]
    motor_voltage_beta: Annotated[Scalar, "V"]
    motor_angle_mechanical: Annotated[Scalar, "rad"]
    target_motor_angle_mechanical: Annotated[Scalar, "rad"]
    motor_current_a: Annotated[Scalar, "A"]
    motor_current_b: Annotated[Scalar, "A"]
    motor_current_c: Annotated[Scalar, "A"]
    resolver_sine: Annotated[Scalar, "V"]
    resolver_cosine: Annotated[Scalar, "V"]
    supply_voltage: Annotated[Scalar, "V"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    pinion_angle: Annotated[Scalar, "rad"]
    driver_torque: Annotated[Scalar, "N*m"]
    motor_target_voltage_alpha: Annotated[Scalar, "V"]
    motor_target_voltage_beta: Annotated[Scalar, "V"]
    motor_duty_cycle_a: Annotated[Scalar, ""]
    motor_duty_cycle_b: Annotated[Scalar, ""]
    motor_duty_cycle_c: Annotated[Scalar, ""]
    vehicle_speed: Annotated[Scalar, "m/s"]


@dataclass(frozen=True)
class MotorVoltages:
    """Voltage in stator coordinates, from the chosen source; a supply voltage at a low rate is held."""

    source: Literal["measured", "commanded", "duty cycles"] = "measured"  # "measured", "commanded", or "duty cycles"

    Sample = MotorAngleSample

    class State(NamedTuple):
        supply_voltage: Annotated[Scalar, "V"]
        known: Annotated[Scalar, ""]

    class Output(NamedTuple):
        alpha: Annotated[Scalar, "V"]
        beta: Annotated[Scalar, "V"]

    def __post_init__(self) -> None:
        if self.source not in SIGNALS:
            raise ParameterError(f"the voltages are '{self.source}'; expected one of {', '.join(SIGNALS)}")

    def init(self) -> State:
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: MotorAngleSample) -> tuple[State, Output]:
        if self.source == MEASURED:
            return state, self.Output(sample.motor_voltage_alpha, sample.motor_voltage_beta)
        if self.source == COMMANDED:
            return state, self.Output(sample.motor_target_voltage_alpha, sample.motor_target_voltage_beta)
        fresh = present(sample.supply_voltage)
        supply = where(fresh, sample.supply_voltage, state.supply_voltage)
        known = where(fresh, 1.0, state.known)
        # Before the first supply reading the NaN itself makes the voltage missing.
        voltage = where(known, supply, sample.supply_voltage)
        duty = PhaseValues(sample.motor_duty_cycle_a, sample.motor_duty_cycle_b, sample.motor_duty_cycle_c)
        return self.State(supply, known), self.Output(*commanded_voltage(duty, voltage))


@dataclass(frozen=True)
class MotorAngleTuning:
    """Assumptions of the observer on its measurements, the motor and the inverter."""

    # standard deviation of a measured current; shunts and converters of such a drive
    current_noise: Annotated[float, "A", POSITIVE] = 0.2
    # standard deviation of the mean voltage over a sample, with unmodelled effects
    voltage_noise: Annotated[float, "V", POSITIVE] = 0.05
    # standard deviation of one reading of the angle sensor, used for increments only
    sensor_noise: Annotated[float, "rad", POSITIVE] = 5e-4
    # standard deviation of the unmodelled change of speed per sample
    speed_wander: Annotated[float, "rad/s", POSITIVE] = 0.1
    # random walk of the load torque per sample; it may reverse within some 10 ms
    load_wander: Annotated[float, "N*m", POSITIVE] = 0.02
    # NIS above which the load has stepped; noise of two currents exceeds it once in 22 000 samples, with increments
    # once in 6 000
    surprising: Annotated[float, "", POSITIVE] = 20.0
    # stepped_speed, stepped_load: standard deviations of both after a step: a load at its limit within one sample
    stepped_speed: Annotated[float, "rad/s", POSITIVE] = 5.0
    stepped_load: Annotated[float, "N*m", POSITIVE] = 1.0
    # most_surprises, step_memory: number of surprises within that time up to which they are steps; more show a wrong
    # model
    most_surprises: Annotated[float, "", POSITIVE] = 12.0
    step_memory: Annotated[float, "s", POSITIVE] = 0.05
    # random walk of its logarithm; a winding heats over seconds
    resistance_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 0.01
    # random walk of the logarithm of the flux; magnets warm over minutes
    flux_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 2e-4
    # random walk of the inverter's voltage loss; its semiconductors warm over seconds
    loss_wander: Annotated[float, "V/s**0.5", NOT_NEGATIVE] = 0.01
    knee_wander: Annotated[float, "1/s**0.5", NOT_NEGATIVE] = 0.0  # random walk of the logarithm of its knee
    # random walk of the angle at standstill, the possible error of the sensor's increments
    standing_wander: Annotated[float, "rad/s**0.5", POSITIVE] = 0.02
    # first_angle, first_speed, first_load: initial standard deviations
    first_angle: Annotated[float, "rad", POSITIVE] = 0.07
    first_speed: Annotated[float, "rad/s", POSITIVE] = 20.0
    first_load: Annotated[float, "N*m", POSITIVE] = 0.3
    # first_resistance, first_flux: initial standard deviations of their logarithms; temperatures from -40 to 120
    # degrees
    first_resistance: Annotated[float, "", POSITIVE] = 0.2
    first_flux: Annotated[float, "", POSITIVE] = 0.05
    # initial standard deviation of the inverter's voltage loss; the accuracy of its data sheet
    first_loss: Annotated[float, "V", POSITIVE] = 0.3
    # initial standard deviation of the logarithm of its knee, which no data sheet gives; 0 takes it as known
    first_knee: Annotated[float, "", NOT_NEGATIVE] = 0.5
    # standard deviation of that logarithm below which a surprise is attributed to the load
    learnt_knee: Annotated[float, "", POSITIVE] = 0.1
    # current below which the resistance is not estimated, since noise alone would make it drift
    least_current: Annotated[float, "A", POSITIVE] = 3.0
    # speed below which the back-EMF does not determine the angle
    standing_speed: Annotated[float, "rad/s", POSITIVE] = 1.0
    standing_time: Annotated[float, "s", POSITIVE] = 0.02  # time for which the speed must be below
    # speed below which increments of the sensor serve as speed measurements
    slow_speed: Annotated[float, "rad/s", POSITIVE] = 8.0
    # time over which they are summed: their noise does not add up, and the motor hardly accelerates
    increment_time: Annotated[float, "s", POSITIVE] = 1e-3
    lag: Annotated[float, "s", POSITIVE] = 0.005  # time constant of the speed that selects the mode
    widest: Annotated[float, "", POSITIVE] = 0.7  # bound of the logarithms of resistance and flux
    widest_knee: Annotated[float, "", POSITIVE] = 1.6  # bound of that of the knee; from a fifth to five times its value

    def __post_init__(self) -> None:
        check_ranges(self)


# Variance that the angle gains per sample besides that of the speed [rad^2]; keeps the covariance positive.
_TINY = 1e-14


def stator_filter(p: SampledMotorParameters, t: MotorAngleTuning) -> KalmanFilter:
    """The filter of a motor with measured voltages, or with commanded ones where its parameters include an inverter."""
    voltage = (t.voltage_noise * p.sample_time / _least_inductance(p)) ** 2
    first: tuple[float, ...] = (
        t.current_noise,
        t.current_noise,
        t.first_speed,
        t.first_angle,
        t.first_load,
        t.first_resistance,
        t.first_flux,
    )
    wander: tuple[float, ...] = (t.resistance_wander**2 * p.sample_time, t.flux_wander**2 * p.sample_time)
    # Two readings bound an increment, and both have noise.
    reading = 2.0 * (t.sensor_noise / max(t.increment_time, p.sample_time)) ** 2
    model: Any = StatorFrameMotor
    mean: tuple[float, ...] = (0.0,) * 7
    if isinstance(p, CommandedMotorParameters):
        model, mean = CommandedMotor, (*mean, p.inverter_voltage_loss, 0.0)
        first += (t.first_loss, t.first_knee)
        wander += (t.loss_wander**2 * p.sample_time, t.knee_wander**2 * p.sample_time)
    return KalmanFilter(
        model,
        p,
        model.State(*mean),
        tuple(deviation**2 for deviation in first),
        (voltage, voltage, t.speed_wander**2, _TINY, t.load_wander**2, *wander),
        (t.current_noise**2, t.current_noise**2, reading),
        maskable=("angle", "log_resistance", "log_flux") + (("log_knee",) if model is CommandedMotor else ()),
    )


def _least_inductance(p: SampledMotorParameters) -> float:
    return minimum(p.motor_inductance, p.inductance_across)


def angle_variance_place(states: int) -> int:
    """Index of the angle's variance in a packed covariance of so many states, after the first three rows."""
    return 3 * states - 3


class Pace(NamedTuple):
    """Whether the motor turns fast enough for its currents to determine the angle."""

    speed: Annotated[Scalar, "rad/s"]  # smoothed speed [rad/s]
    standing: Annotated[Scalar, ""]  # 1 while the back-EMF does not determine the angle
    slow: Annotated[Scalar, ""]  # 1 while increments of the sensor serve as speed measurements
    against: Annotated[Scalar, ""]  # number of samples for which the speed has contradicted `standing`


class Surprise(NamedTuple):
    """NIS, and the recent number of samples with a surprising one."""

    last: Annotated[Scalar, ""]  # NIS of the previous sample
    often: Annotated[Scalar, ""]  # number of surprising samples, decaying with `MotorAngleTuning.step_memory`


_LONGEST_WAIT = 1e6  # upper bound of the sample count between readings


@dataclass(frozen=True)
class MotorAngleObserver:
    """Extended Kalman filter in stator coordinates: angle, speed, load torque, resistance and flux from the currents.

    The sensor initialises it, and supports it at low speed by its *increments*; the sensor's value is never used
    afterwards, so that an offset or a slipped magnet appears in the residual. At standstill the currents hold no
    information on the angle: it then follows the increments with a growing variance, and does not drift.

    Args:
        parameters: parameters of the motor, from a vehicle file. `CommandedMotorParameters` state that the samples
            contain the voltages commanded to the inverter instead of measured ones

    With commanded voltages, the voltage loss of the inverter and the knee of that loss are states too; the knee is
    learnt only above `slow_speed`, since at low speed it cannot be separated from the back-EMF.

    Missing currents cause no correction, a missing voltage holds the estimate; neither enters the state.

    Source: Reinelt et al., eqs (17), (18), (34) to (45) in stator coordinates, with load, resistance, flux and angle as
    states: the paper uses the measured angle in Park's transform, and finds an additional state poor at standstill.
    """

    parameters: SampledMotorParameters
    tuning: MotorAngleTuning = field(default_factory=MotorAngleTuning)
    filter: KalmanFilter = field(init=False, repr=False)

    class Sample(NamedTuple):
        motor_current_alpha: Annotated[Scalar, "A"]
        motor_current_beta: Annotated[Scalar, "A"]
        motor_voltage_alpha: Annotated[Scalar, "V"]
        motor_voltage_beta: Annotated[Scalar, "V"]
        motor_angle_mechanical: Annotated[Scalar, "rad"]

    class State(NamedTuple):
        belief: Belief
        begun: Annotated[Scalar, ""]
        sensed: Annotated[Scalar, "rad"]
        gained: Annotated[Scalar, "rad"]
        waited: Annotated[Scalar, ""]
        pace: Pace
        surprise: Surprise

    class Output(NamedTuple):
        """The estimate, and the electrical residual of the sensor, within half a turn; zero until it has begun.

        The deviation of the knee is that of its logarithm; the inverter's loss is zero for measured voltages.
        """

        motor_angle: Annotated[Scalar, "rad"]
        motor_angle_standard_deviation: Annotated[Scalar, "rad"]
        motor_speed: Annotated[Scalar, "rad/s"]
        motor_load_torque: Annotated[Scalar, "N*m"]
        motor_resistance: Annotated[Scalar, "ohm"]
        motor_flux: Annotated[Scalar, "V*s"]
        angle_residual_electrical: Annotated[Scalar, "rad"]
        inverter_voltage_loss: Annotated[Scalar, "V"]
        inverter_knee_current: Annotated[Scalar, "A"]
        inverter_knee_deviation: Annotated[Scalar, ""]
        standing: Annotated[Scalar, ""]
        nis: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        for name in ("motor_resistance", "motor_inductance", "motor_flux", "motor_inertia", "sample_time"):
            if not getattr(self.parameters, name) > 0.0:
                raise ParameterError(f"{name} is {getattr(self.parameters, name)}; expected a number above zero")
        stiffness = self.parameters.sample_time * self.parameters.motor_resistance / self.parameters.motor_inductance
        if stiffness > 0.5:
            raise ParameterError(
                f"the current settles at {stiffness / self.parameters.sample_time:.3g} 1/s, too fast for samples every "
                f"{self.parameters.sample_time:g} s; record faster, and check motor_inductance"
            )
        object.__setattr__(self, "filter", stator_filter(self.parameters, self.tuning))

    @property
    def commanded(self) -> bool:
        """Whether the voltages are those commanded to the inverter."""
        return isinstance(self.parameters, CommandedMotorParameters)

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float, tuning: MotorAngleTuning | None = None, commanded: bool = False
    ) -> MotorAngleObserver:
        """The observer of a vehicle's motor.

        Args:
            tuning: tuning; the default where None
        """
        kind = CommandedMotorParameters if commanded else SampledMotorParameters
        parameters = replace(vehicle.parameters_for(kind), sample_time=sample_time)
        return cls(parameters, tuning or MotorAngleTuning())

    def init(self) -> State:
        # Starts as standing: errors of resistance and voltage would otherwise turn a motor that stands, as most do.
        return self.State(self.filter.init(), 0.0, 0.0, 0.0, 0.0, Pace(0.0, 1.0, 1.0, 0.0), Surprise(0.0, 0.0))

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        filter_ = self.filter
        belief, begun = self._begun(state, sample)
        pace = state.pace
        increment = self._increment(state, sample)
        known = present(increment)
        standing = both(pace.standing, begun)
        given = StatorFrameMotor.Input(
            sample.motor_voltage_alpha, sample.motor_voltage_beta, where(known, increment, 0.0), standing
        )
        rate, gained, waited = self._rate(state, increment)
        measured = StatorFrameMotor.Output(sample.motor_current_alpha, sample.motor_current_beta, rate)
        free = where(standing, 0.0, 1.0)
        current = hypot(sample.motor_current_alpha, sample.motor_current_beta)
        # A small current holds no information on the resistance; its noise would make the estimate drift.
        masks: tuple[Scalar, ...] = (free, where(current > self.tuning.least_current, 1.0, 0.0), free)
        masks = (*masks, where(pace.slow, 0.0, 1.0)) if self.commanded else masks
        enabled = get_type_hints(filter_.Sample)["enabled"](*masks)
        after, estimate = filter_.step(
            belief,
            filter_.Sample(given, measured, enabled),
            process_noise=self._process_noise(filter_, standing, sample, state.surprise),
        )
        after = self._kept(belief, after, begun)
        sensed = where(present(sample.motor_angle_mechanical), sample.motor_angle_mechanical, state.sensed)
        advanced = self._pace(pace, after, estimate)
        output = self._output(after, sample, standing, begun, estimate.nis)
        surprise = self._surprise(state.surprise, estimate, begun)
        return self.State(after, begun, sensed, gained, waited, advanced, surprise), output

    def _begun(self, state: State, sample: Sample) -> tuple[Belief, Scalar]:
        whole = all_of(
            present(sample.motor_current_alpha),
            present(sample.motor_current_beta),
            present(sample.motor_angle_mechanical),
        )
        fresh = both(whole, state.begun < 0.5)
        mean = state.belief.mean._replace(
            current_alpha=where(fresh, sample.motor_current_alpha, state.belief.mean.current_alpha),
            current_beta=where(fresh, sample.motor_current_beta, state.belief.mean.current_beta),
            angle=where(fresh, sample.motor_angle_mechanical, state.belief.mean.angle),
        )
        return Belief(mean, state.belief.covariance), where(whole, 1.0, state.begun)

    def _increment(self, state: State, sample: Sample) -> Scalar:
        gained = sample.motor_angle_mechanical - state.sensed
        return where(state.begun, wrapped(gained), 0.0 * gained)

    def _rate(self, state: State, increment: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """Speed from increments while the motor is slow; sum of the increments; number of its samples."""
        known, time = present(increment), self.parameters.sample_time
        gained, waited = state.gained + where(known, increment, 0.0), minimum(state.waited + 1.0, _LONGEST_WAIT)
        window = maximum(self.tuning.increment_time / time, 1.0)
        due = both(known, waited > window - 0.5)
        # After a gap the sum still moves the angle at standstill, but is no measurement of the present speed.
        recent = all_of(due, waited < 2.0 * window + 0.5, state.pace.slow, state.begun)
        return where(recent, gained / (waited * time), math.inf), where(due, 0.0, gained), where(due, 0.0, waited)

    def _process_noise(
        self, filter_: KalmanFilter, standing: Scalar, sample: Sample, surprise: Surprise
    ) -> tuple[Scalar, ...]:
        """Variances of this sample; after a surprise the load, and with it the speed, may have stepped.

        With a wrong model the surprises persist, and a step is no explanation.
        """
        noise, t = list(filter_.process_noise), self.tuning
        stepped = both(surprise.last > t.surprising, surprise.often < t.most_surprises)
        noise[2] = where(stepped, t.stepped_speed**2, noise[2])
        noise[4] = where(stepped, t.stepped_load**2, noise[4])
        walk = self.tuning.standing_wander**2 * self.parameters.sample_time
        noise[3] = where(standing, walk, noise[3])
        current = hypot(sample.motor_current_alpha, sample.motor_current_beta)
        noise[5] = where(current > self.tuning.least_current, noise[5], 0.0)
        return tuple(noise)

    def _surprise(self, before: Surprise, estimate: Tree, begun: Scalar) -> Surprise:
        last = where(begun, estimate.nis, 0.0)
        if self.commanded:
            # A knee that is not learnt yet causes surprises as a load step does, and more often.
            last = where(estimate.variance.log_knee < self.tuning.learnt_knee**2, last, 0.0)
        keep = 1.0 - share_reached(self.parameters.sample_time / self.tuning.step_memory)
        return Surprise(last, keep * before.often + where(last > self.tuning.surprising, 1.0, 0.0))

    def _kept(self, before: Belief, after: Belief, begun: Scalar) -> Belief:
        widest = {"log_knee": self.tuning.widest_knee}
        logarithms = [name for name in after.mean._fields if name.startswith("log_")]
        bounds = {name: widest.get(name, self.tuning.widest) for name in logarithms}
        mean = after.mean._replace(
            **{name: limit(getattr(after.mean, name), -bound, bound) for name, bound in bounds.items()}
        )
        pairs = zip((*mean, *after.covariance), (*before.mean, *before.covariance), strict=True)
        kept = [where(begun, new, old) for new, old in pairs]
        size = len(mean)
        return Belief(type(mean)(*kept[:size]), tuple(kept[size:]))

    def _pace(self, pace: Pace, after: Belief, estimate: Tree) -> Pace:
        """Mode of the motor: standing below the speed at which the resistance error matches the back-EMF."""
        t, p = self.tuning, self.parameters
        share = share_reached(p.sample_time / t.lag)
        speed = pace.speed + share * (after.mean.speed - pace.speed)
        current = hypot(after.mean.current_alpha, after.mean.current_beta)
        drop = p.motor_resistance * sqrt(maximum(estimate.variance.log_resistance, 0.0)) * current
        if self.commanded:
            drop = drop + LONGEST_SIGN * sqrt(maximum(estimate.variance.voltage_loss, 0.0))
        least = t.standing_speed + 2.0 * drop / back_emf_constant(p.motor_pole_pairs, p.motor_flux)
        size = absolute(speed)
        differs = where(pace.standing, size > 1.5 * least, size < least)
        against = where(differs, pace.against + 1.0, 0.0)
        needed = where(pace.standing, 0.5, t.standing_time / p.sample_time - 0.5)
        # Leaving standstill takes one sample, entering it `standing_time`: a reversal only passes through zero speed.
        turns = against > needed
        standing = where(turns, 1.0 - pace.standing, pace.standing)
        slow = where(where(pace.slow, size < 1.5 * t.slow_speed, size < t.slow_speed), 1.0, 0.0)
        return Pace(speed, standing, slow, where(turns, 0.0, against))

    def _output(self, after: Belief, sample: Sample, standing: Scalar, begun: Scalar, nis: Scalar) -> Output:
        p, mean = self.parameters, after.mean
        residual = wrapped(p.motor_pole_pairs * (sample.motor_angle_mechanical - mean.angle))
        variance = after.covariance[angle_variance_place(len(mean))]
        lost = (0.0, 0.0, 0.0)
        if isinstance(p, CommandedMotorParameters):
            knee = p.inverter_knee_current * exp(mean.log_knee)
            lost = (mean.voltage_loss, knee, sqrt(maximum(after.covariance[-1], 0.0)))
        return self.Output(
            mean.angle,
            sqrt(maximum(variance, 0.0)),
            mean.speed,
            mean.load_torque,
            p.motor_resistance * exp(mean.log_resistance),
            p.motor_flux * exp(mean.log_flux),
            where(begun, residual, 0.0),
            *lost,
            where(standing, 1.0, 0.0),
            nis,
        )
