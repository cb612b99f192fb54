"""Filter of a fault hypothesis: it uses all sensors and actuators but the suspected ones.

All hypotheses are one compiled structure with different floats: a sensor that is left out has an infinite variance, and
a suspected actuator may have lost any share of its torque.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import e, hypot, log, pi
from math import sqrt as root_of
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, skeleton
from tierod.core.graph.maths import absolute, limit, maximum, minimum, present, sqrt, where
from tierod.core.graph.trace import jacobian
from tierod.methods.estimators.kernels import (
    Vector,
    congruence,
    diagonal,
    from_diagonal,
    pack,
    plus,
    predict_covariance,
    unpack,
)
from tierod.models.automated_vehicle import AutomatedVehicle, Torques, drive_force, turning_column
from tierod.models.single_track import RollingCar
from tierod.monitors.condition.filter_updates import Innovations, observed
from tierod.monitors.condition.signals import (
    ACCELERATION_NOISE,
    ACCELERATIONS,
    DRIVES,
    ELEMENTS,
    OF_AUTOMATED,
    OF_CARS,
    SENSOR_TABLE,
    SENSORS,
    SHAFT_TORQUE,
    WHEELS,
    ConditionSample,
    Elements,
    Hypothesis,
    Measured,
    Readings,
)
from tierod.physics.friction import gauss_markov_noise, lagged_ramp
from tierod.physics.motion import front_axle_load
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import held_deviation

SENSOR_NOISE = Measured(
    *(each.noise for each in SENSOR_TABLE if each.name in OF_AUTOMATED), *(ACCELERATION_NOISE,) * len(ACCELERATIONS)
)
"""Standard deviation of one reading of every sensor [unit of the sensor]."""
PLAUSIBLE = Readings(*(each.plausible for each in SENSOR_TABLE))
"""Width of the range in which a failed sensor may read [unit of the sensor], with the uniform density 1 / width."""
TORQUE_JUMP = 0.45
"""Standard deviation of the effect of a jump of the requested steering torque, as a share of the jump [-]; its time
between two samples is unknown."""


@dataclass(frozen=True)
class ModelError:
    """Standard deviations of the model error; since some grow with the forces, all thresholds adapt to the motion."""

    acceleration: Annotated[float, "m/s**2"] = 0.12  # longitudinal acceleration, white, per sample
    lateral_acceleration: Annotated[float, "m/s**2"] = 0.12  # lateral acceleration, white, per sample
    yaw_acceleration: Annotated[float, "rad/s**2"] = 0.08  # yaw acceleration, white, per sample
    slip: Annotated[float, ""] = 1e-4  # deflection of the tyres as a slip, white, per sample
    steering_torque: Annotated[float, "N*m"] = 0.08  # torque of both motors, white, per sample
    friction_share: Annotated[float, ""] = 0.012  # share of the column's friction, white, per sample
    # force, force_share: lasting error of an axle force: at small force, and its growth with the force
    force: Annotated[float, "N"] = 15.0
    force_share: Annotated[float, ""] = 0.035
    # tie_rod, tie_rod_share: lasting error of the tie-rod force: at small force, and its growth with the force
    tie_rod: Annotated[float, "N"] = 6.0
    tie_rod_share: Annotated[float, ""] = 0.035
    # additional error of the tie-rod force at standstill, where the tyres twist on the spot
    standing: Annotated[float, "N"] = 150.0
    loss: Annotated[float, ""] = 0.7  # lost share of a suspected actuator's torque
    # yaw_rate_offset, angle_offset, wheel_speed_difference: deviations from a calibration
    yaw_rate_offset: Annotated[float, "rad/s"] = 0.0007
    angle_offset: Annotated[float, "rad"] = 0.002
    wheel_speed_difference: Annotated[float, ""] = 0.0005
    # wheel_speed_scale, drive_excess: the same as shares, since load and tyres change after a calibration
    wheel_speed_scale: Annotated[float, ""] = 0.05
    # the same without the yaw rate or a wheel: the scale is then observable only by the lateral acceleration, which
    # body roll changes by some percent
    wheel_speed_scale_alone: Annotated[float, ""] = 0.003
    drive_excess: Annotated[float, ""] = 0.06
    # the same with a suspected drive: half the torque lost on one side looks like a quarter on both
    drive_excess_alone: Annotated[float, ""] = 0.01
    road: Annotated[float, "m/s**2"] = 0.25  # acceleration by grade or bank of the road


def prices(noise: Measured | RollingCar.Output, plausible: Readings) -> tuple[float, ...]:
    """Costs of leaving out each sensor, per sample with fault-free readings [nat].

    A cost is the mean log density of a normal innovation less the log density of the plausible range.
    """
    pairs = ((width, getattr(noise, name, None)) for name, width in zip(SENSORS, plausible, strict=True))
    return tuple(0.0 if known is None else log(width / (known * root_of(2.0 * pi * e))) for width, known in pairs)


USUAL_RATE, USUAL_ANGLE, USUAL_ACCELERATION = 1.5, 1.5, 3.0
"""Usual rate [rad/s] and angle [rad] of the column, and lateral acceleration [m/s**2], at which the errors of
parameters are evaluated."""


def widened(vehicle: Vehicle) -> tuple[Measured, ModelError]:
    """Noises of sensors and model for a vehicle, widened by the standard deviations of its parameters."""

    def spread(name: str, relative: bool = False) -> float:
        deviation = held_deviation(vehicle, name) if name in vehicle else 0.0
        return deviation / abs(vehicle[name]) if relative and deviation else deviation

    error, square = ModelError(), vehicle["rack_ratio"] ** 2
    axles = ("front_cornering_stiffness", "rear_cornering_stiffness")
    share = hypot(spread("mass", True), *(spread(name, True) for name in axles))
    steering = hypot(
        spread("nominal_friction"),
        square * spread("rack_damping") * USUAL_RATE,
        square * spread("rack_stiffness") * USUAL_ANGLE,
    )
    scale = spread("wheel_speed_scale") * USUAL_ACCELERATION
    # Offsets of wheels, yaw rate and angle are states of the filter: their spread belongs to the model error instead.
    offsets = [
        *((spread(f"{name}_offset"),) if name not in OF_CARS else () for name in OF_AUTOMATED),
        *((spread(f"{name}_offset"), scale) for name in ACCELERATIONS),
    ]
    return (
        Measured(*(hypot(usual, *more) for usual, more in zip(SENSOR_NOISE, offsets, strict=True))),
        replace(
            error,
            acceleration=hypot(error.acceleration, scale),
            steering_torque=hypot(error.steering_torque, steering),
            force_share=hypot(error.force_share, share),
            tie_rod_share=hypot(error.tie_rod_share, share, spread("pneumatic_trail", True)),
            yaw_rate_offset=hypot(error.yaw_rate_offset, spread("yaw_rate_offset")),
            angle_offset=hypot(error.angle_offset, spread("steering_wheel_angle_offset")),
            wheel_speed_difference=hypot(error.wheel_speed_difference, spread("wheel_speed_difference")),
        ),
    )


LIMITS = AutomatedVehicle.State(
    *(80.0, 30.0, 10.0, 1.0, 1.0, 20.0, 80.0, 1.0),
    *(600.0, 600.0, 500.0, 1.1, 0.03, 0.15, 1.7, 1.2, 0.03, 0.25, 0.25),
)
"""Bounds of the state estimates; a faulty sensor then cannot drive a filter to infinity, and a wrong hypothesis cannot
explain readings by a bank of thirty degrees, tyres of another size or a motor that loses more than its whole torque
(plus a tenth for the error of a calibration), however much time it has."""


def start_deviations(error: ModelError) -> AutomatedVehicle.State:
    """Standard deviations of the initial state: unknown speed, wheels approximately straight ahead."""
    return AutomatedVehicle.State(
        *(20.0, 0.5, 0.5, 0.02, 0.02, 4.0, 2.0, 0.7, error.force, error.force, error.tie_rod + error.standing),
        *(error.loss, error.yaw_rate_offset, error.angle_offset, error.road, error.road),
        *(error.wheel_speed_difference, error.wheel_speed_scale, error.drive_excess),
    )


def process_noise(
    error: ModelError,
    vehicle: AutomatedVehicle.Parameters,
    mean: AutomatedVehicle.State,
    inputs: AutomatedVehicle.Input,
) -> AutomatedVehicle.State:
    """Process noise: variance that each state gains per sample; for the force errors it grows with the forces."""
    fading, step = vehicle.fading, vehicle.sample_time
    forces = AutomatedVehicle.forces(mean, inputs, vehicle)
    standing = error.standing / (1.0 + mean.speed * mean.speed)
    rod = vehicle.steering_ratio / vehicle.rack_ratio * absolute(forces.kingpin)

    def white(deviation: Scalar) -> Scalar:
        return deviation * deviation

    def gained(deviation: Scalar, time: Scalar) -> Scalar:
        return gauss_markov_noise(deviation, time, step)

    return AutomatedVehicle.State(
        speed=white(step * error.acceleration),
        lateral_speed=white(step * error.lateral_acceleration),
        yaw_rate=white(step * error.yaw_acceleration),
        front_slip=white(error.slip),
        rear_slip=white(error.slip),
        column_angle=0.0,
        column_rate=0.0,
        friction_share=white(error.friction_share),
        front_force_error=gained(error.force + error.force_share * absolute(forces.front), fading.force),
        rear_force_error=gained(error.force + error.force_share * absolute(forces.rear), fading.force),
        tie_rod_force_error=gained(error.tie_rod + error.tie_rod_share * rod + standing, fading.tie_rod),
        torque_loss=gained(error.loss, fading.loss),
        yaw_rate_offset=gained(error.yaw_rate_offset, fading.offset),
        angle_offset=gained(error.angle_offset, fading.offset),
        grade_acceleration=gained(error.road, fading.road),
        bank_acceleration=gained(error.road, fading.road),
        wheel_speed_difference=gained(error.wheel_speed_difference, fading.offset),
        wheel_speed_scale=gained(error.wheel_speed_scale, fading.share),
        drive_excess=gained(error.drive_excess, fading.share),
    )


def with_torque_noise(covariance: Vector, vehicle: AutomatedVehicle.Parameters, variance: Scalar) -> Vector:
    """Covariance with the effect of an error of the steering torque on column angle and rate."""
    full = unpack(covariance)
    # The torque error is constant over a sample: its effects on angle and rate are fully correlated.
    turning = turning_column(vehicle)
    angle = AutomatedVehicle.State._fields.index("column_angle")
    gain = {angle: turning.angle_per_torque, angle + 1: turning.rate_per_torque}
    for i, first in gain.items():
        for j, second in gain.items():
            full[i][j] = full[i][j] + first * second * variance
    return pack(full)


class AskedTorques(NamedTuple):
    """Requested torques, actuator torques, and the last changes of both requested steering torques [N*m]."""

    asked: Torques
    given: Torques
    change_1: Scalar
    change_2: Scalar


def no_torques() -> AskedTorques:
    return AskedTorques(Torques(0.0, 0.0, 0.0, 0.0), Torques(0.0, 0.0, 0.0, 0.0), 0.0, 0.0)


def torques_of(
    sample: ConditionSample,
    memory: AskedTorques,
    vehicle: AutomatedVehicle.Parameters,
    suspected: Vector,
    started: Scalar,
) -> tuple[AskedTorques, AutomatedVehicle.Input, Scalar]:
    """Next memory, inputs of the model, and square of the jump of the steering torque [N**2*m**2].

    The targets are interpolated linearly between samples, and the first-order lag of the actuators is integrated
    exactly for that. A missing target is held, and a target beyond the greatest torque of a motor is limited.
    """
    targets = (
        sample.steering_motor_1_target_torque,
        sample.steering_motor_2_target_torque,
        sample.target_drive_torque_left,
        sample.target_drive_torque_right,
    )
    steering, drive = vehicle.greatest_steering_motor_torque, vehicle.greatest_drive_torque
    most = (steering, steering, drive, drive)
    lags = (vehicle.steering_motor_lag, vehicle.steering_motor_lag, vehicle.drive_lag, vehicle.drive_lag)
    asked = Torques(
        *(
            where(present(new), limit(new, -bound, bound), old)
            for new, old, bound in zip(targets, memory.asked, most, strict=True)
        )
    )
    before = [where(started, old, new) for old, new in zip(memory.asked, asked, strict=True)]
    gave = [where(started, old, new) for old, new in zip(memory.given, asked, strict=True)]
    given = [
        lagged_ramp(old, new, at_start, lag, vehicle.sample_time)
        for old, new, at_start, lag in zip(before, asked, gave, lags, strict=True)
    ]
    mean, now = [each.mean for each in given], [each.end for each in given]
    change_1, change_2 = asked[0] - before[0], asked[1] - before[1]
    whole = _jump(change_1 + change_2, memory.change_1 + memory.change_2)
    swing = suspected[0] * _jump(change_1, memory.change_1) + suspected[1] * _jump(change_2, memory.change_2)
    inputs = AutomatedVehicle.Input(*mean, *now, *suspected)
    return AskedTorques(asked, Torques(*now), change_1, change_2), inputs, whole + swing


def _jump(change: Scalar, before: Scalar) -> Scalar:
    """Square of a torque's jump beyond its trend [N**2*m**2].

    It is the product of the change and the change of the change, which is zero on a ramp and in the sample after a
    jump.
    """
    return absolute(change * (change - before))


TRUSTED = Elements(*(1.0,) * len(ELEMENTS))  # flags that trust every sensor and actuator

COMMON_LOSS_TIME = 20.0
"""Time constant of a share of torque that two actuators lose together [s]; one that could follow the split of the
torque, which changes within 0.1 s, would also explain the loss of either alone."""

SCALED = (*WHEELS, "yaw_rate")  # Sensors that together make the common scale of the wheel speeds observable


@dataclass(frozen=True)
class LeaveOutFilter:
    """Extended Kalman filter of the whole vehicle that leaves out the suspects of a hypothesis.

    Its step: torques from targets, prediction by the model with automatic Jacobians, one scalar update per sensor on a
    symmetric covariance. A missing reading (NaN) corrects nothing; a missing target is held.
    """

    vehicle: AutomatedVehicle.Parameters  # parameters of the model
    sensor_noise: Measured = SENSOR_NOISE
    model_error: ModelError = field(default_factory=ModelError)
    plausible: Readings = PLAUSIBLE  # widths of the ranges in which failed sensors may read
    # unknown share of a jump of the steering torque, since the jump occurs between two samples
    torque_jump: Annotated[float, ""] = TORQUE_JUMP
    # bound of a normalised innovation, in standard deviations, for the correction and for the likelihood, so that a
    # fault does not disturb the filter; far more than fault-free readings reach
    influence: Annotated[float, ""] = 8.0
    # duration of the transient after the start, in which readings do not count for hypotheses
    settling: Annotated[float, "s"] = 0.5
    # speed from which the vehicle counts as moving; wheel speed sensors detect hardly any slower motion
    slowest: Annotated[float, "m/s"] = 0.5
    # bound of the error of an axle force; for all other states see `process.LIMITS`
    largest_force_error: Annotated[float, "N"] = LIMITS.front_force_error
    bending: Annotated[float, "m/s**2"] = 1.0  # lateral acceleration from which the vehicle is in a bend
    # deceleration beyond that of the drives from which the vehicle is braked otherwise; slopes give less
    braking: Annotated[float, "m/s**2"] = 1.5
    # 1, or 0 for a sensor that is left out and for an actuator that may have lost torque; all such actuators share one
    # loss
    trusted: Elements = TRUSTED

    Sample = ConditionSample

    class State(NamedTuple):
        """Mean, packed covariance, torques of the previous sample, and time since the start, `settling` at most [s]."""

        mean: AutomatedVehicle.State
        covariance: tuple[Scalar, ...]
        torques: AskedTorques
        age: Scalar

    class Output(NamedTuple):
        """Output of the filter of one hypothesis for one sample."""

        # log-likelihood of all readings of this sample, given the past [nat]; readings that are left out have the
        # density of their plausible range, so that all hypotheses explain the same readings; 0 while settling
        log_likelihood: Annotated[float, ""]
        prediction: Readings  # prediction of every sensor, used or not, before any reading of the sample
        deviation: Readings  # standard deviation of reading less prediction
        # estimate of every sensor's reading without noise, after the correction; the substitute of a sensor that is
        # left out
        estimate: Readings
        # torque_loss, loss_deviation: lost share of the suspected actuators' torque, the same for two, and its standard
        # deviation, which is large while little torque is requested
        torque_loss: Annotated[float, ""]
        loss_deviation: Annotated[float, ""]
        speed: Annotated[float, "m/s"]  # speed, lateral_speed: speed components of the centre of gravity
        lateral_speed: Annotated[float, "m/s"]
        # 1 if the vehicle moves forward, else 0: wheels that stand or roll backwards are no evidence
        moving: Annotated[float, ""]
        # 1 if drives and slopes explain the deceleration, else 0: brakes may lock the wheels
        driven: Annotated[float, ""]
        # lateral force that an axle lacks in a bend over its load, the larger of both; 0 outside bends; for a car
        # without known torques see `skidding.lacking`
        lack: Annotated[float, ""] = 0.0
        # lack_along, given_along: force of the suspected drives that the front axle lacks, and has, over its load
        lack_along: Annotated[float, ""] = 0.0
        given_along: Annotated[float, ""] = 0.0
        # lateral acceleration as speed times yaw rate, if the filter gives it, else 0
        turning: Annotated[float, "m/s**2"] = 0.0

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sample_time: float = 0.01) -> LeaveOutFilter:
        """Filter of the fault-free hypothesis; the spread of the vehicle's parameters widens its noises."""
        parameters = replace(vehicle.parameters_for(AutomatedVehicle.Parameters), sample_time=sample_time)
        return cls(parameters, *widened(vehicle))

    def init(self) -> State:
        deviations = start_deviations(self.model_error)
        covariance = from_diagonal([value * value for value in deviations])
        mean = skeleton(AutomatedVehicle.State)
        return self.State(mean, tuple(value + 0.0 for value in covariance), no_torques(), 0.0)

    def step(self, state: State, sample: ConditionSample) -> tuple[State, Output]:
        after, seen = self.corrected(state, sample)
        # The first innovation after the judged sensors is that of the longitudinal acceleration; NaN is not braking.
        judged, mean = len(OF_AUTOMATED), after.mean
        loss = AutomatedVehicle.State._fields.index("torque_loss")
        # All hypotheses use the accelerations, so that the width of their range does not matter.
        likelihood = seen.log_likelihood(
            (*(getattr(self.plausible, name) for name in OF_AUTOMATED), *(1.0,) * len(ACCELERATIONS)), self.influence
        )
        return after, self.Output(
            where(after.age < self.settling, 0.0, likelihood),
            *seen.of_sensors(OF_AUTOMATED),
            mean.torque_loss,
            sqrt(maximum(diagonal(after.covariance)[loss], 0.0)),
            mean.speed,
            mean.lateral_speed,
            where(mean.speed > self.slowest, 1.0, 0.0),
            where(seen.innovations[judged] < -self.braking, 0.0, 1.0),
            self._lack(mean),
            *self._along(mean, after.torques.given),
        )

    def corrected(self, state: State, sample: ConditionSample) -> tuple[State, Innovations]:
        suspected = [1.0 - each for each in self.trusted[len(SENSORS) :]]
        torques, inputs, jumped = torques_of(sample, state.torques, self.vehicle, suspected, state.age > 0.0)
        jump = self.torque_jump * self.torque_jump * jumped
        mean, covariance = self._predicted(state, inputs, jump)
        expected = AutomatedVehicle.output(mean, inputs, self.vehicle)
        rows = jacobian(lambda at: AutomatedVehicle.output(at, inputs, self._coarse), mean)
        trusted = (*(getattr(self.trusted, name) for name in OF_AUTOMATED), *(1.0,) * len(ACCELERATIONS))
        noise, usual = self._noise(jump), self._noise(0.0)
        readings = [getattr(sample, name) for name in expected._fields]
        seen = observed(covariance, expected, rows, readings, noise, usual, trusted, self.influence)
        limits = LIMITS._replace(front_force_error=self.largest_force_error, rear_force_error=self.largest_force_error)
        age = minimum(state.age + self.vehicle.sample_time, self.settling)
        bounded = AutomatedVehicle.State(*seen.moved(mean, limits))
        return self.State(bounded, seen.correction.covariance, torques, age), seen

    @property
    def _coarse(self) -> AutomatedVehicle.Parameters:
        """Vehicle for the Jacobians, without small terms that would make them denser without any gain."""
        return replace(self.vehicle, turn_slip_stiffness=0.0, steering_motor_inertia=0.0)

    def _lack(self, mean: AutomatedVehicle.State) -> Scalar:
        """Lateral force that an axle lacks in a bend over its load, the larger of both."""
        car, across = self.vehicle, mean.speed * mean.yaw_rate
        side = where(absolute(across) > self.bending, where(across > 0.0, -1.0, 1.0), 0.0)
        front = mean.front_force_error / front_axle_load(car.mass, car.front_distance, car.rear_distance)
        rear = mean.rear_force_error / front_axle_load(car.mass, car.rear_distance, car.front_distance)
        return maximum(side * front, side * rear)

    def _along(self, mean: AutomatedVehicle.State, given: Torques) -> tuple[Scalar, Scalar]:
        """Force of the suspected drives that the front axle lacks, and has, over its load."""
        car = self.vehicle
        left, right = (1.0 - getattr(self.trusted, name) for name in DRIVES)
        torque = left * given.drive_left + right * given.drive_right
        asked = drive_force(torque, car) / front_axle_load(car.mass, car.front_distance, car.rear_distance)
        return mean.torque_loss * asked, (1.0 - mean.torque_loss) * asked

    def _noise(self, jump: Scalar) -> tuple[Scalar, ...]:
        """Variance of each reading; a jump of the requested torque between two samples adds to that of the torque."""
        variances = [value * value for value in self.sensor_noise]
        torque = Measured._fields.index(SHAFT_TORQUE)
        variances[torque] = plus(variances[torque], jump)
        return tuple(variances)

    def _predicted(
        self, state: State, inputs: AutomatedVehicle.Input, jump: Scalar
    ) -> tuple[AutomatedVehicle.State, Vector]:
        deflected = AutomatedVehicle.deflected(state.mean, self.vehicle)
        rolling = jacobian(lambda at: AutomatedVehicle.deflected(at, self._coarse), state.mean)
        rows = jacobian(lambda at: AutomatedVehicle.moved(at, inputs, self._coarse), deflected)
        process = process_noise(self.model_error, self.vehicle, state.mean, inputs)
        # Applied one after the other both Jacobians are sparse; their product is not.
        covariance = predict_covariance(rows, congruence(rolling, state.covariance), process)
        torque = self.model_error.steering_torque * self.model_error.steering_torque + jump
        mean = AutomatedVehicle.moved(deflected, inputs, self.vehicle)
        return mean, with_torque_noise(covariance, self.vehicle, torque)

    def leaving_out(self, hypothesis: Hypothesis) -> LeaveOutFilter:
        error, vehicle = self.model_error, self.vehicle
        if not {*SCALED}.isdisjoint(hypothesis.sensors):
            error = replace(error, wheel_speed_scale=error.wheel_speed_scale_alone)
        if not {*DRIVES}.isdisjoint(hypothesis.actuators):
            error = replace(error, drive_excess=error.drive_excess_alone)
        if len(hypothesis.actuators) > 1:
            vehicle = replace(vehicle, fading=replace(vehicle.fading, loss=COMMON_LOSS_TIME))
        trusted = self.trusted._replace(**dict.fromkeys(hypothesis.suspects, 0.0))
        return replace(self, vehicle=vehicle, model_error=error, trusted=trusted)
