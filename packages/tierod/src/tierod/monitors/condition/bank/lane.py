"""Filter of a fault hypothesis: it uses all sensors and actuators but the suspected ones.

All hypotheses are one compiled structure with different floats: a sensor that is left out has an infinite variance, and
a suspected actuator may have lost any share of its torque.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, skeleton
from tierod.core.graph.derivatives import jacobian
from tierod.core.graph.maths import absolute, maximum, minimum, sqrt, where
from tierod.methods.estimators.kernels import predict_covariance
from tierod.methods.estimators.linear_algebra import (
    Vector,
    congruence,
    diagonal,
    from_diagonal,
    plus,
)
from tierod.models.automated_forces import Torques, drive_force
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.bank.asked_torques import AskedTorques, no_torques, torques_of
from tierod.monitors.condition.bank.process import LIMITS, process_noise, start_deviations, with_torque_noise
from tierod.monitors.condition.bank.tuning import PLAUSIBLE, SENSOR_NOISE, TORQUE_JUMP, ModelError, widened
from tierod.monitors.condition.bank.updates import Seen, observed
from tierod.monitors.condition.hypotheses import Hypothesis
from tierod.monitors.condition.signals import (
    ACCELERATIONS,
    DRIVES,
    ELEMENTS,
    OF_AUTOMATED,
    SENSORS,
    SHAFT_TORQUE,
    WHEELS,
    ConditionSample,
    Elements,
    Measured,
    Readings,
)
from tierod.physics.single_track import front_axle_load
from tierod.vehicles import Vehicle

TRUSTED = Elements(*(1.0,) * len(ELEMENTS))
"""Flags that trust every sensor and actuator."""

COMMON_LOSS_TIME = 20.0
"""Time constant of a share of torque that two actuators lose together [s]; one that could follow the split of the
torque, which changes within 0.1 s, would also explain the loss of either alone."""

SCALED = (*WHEELS, "yaw_rate")
"""Sensors that together make the common scale of the wheel speeds observable."""


@dataclass(frozen=True)
class LeaveOutFilter:
    """Extended Kalman filter of the whole vehicle that leaves out the suspects of a hypothesis.

    Its step: torques from targets, prediction by the model with automatic Jacobians, one scalar update per sensor on a
    symmetric covariance. A missing reading (NaN) corrects nothing; a missing target is held.

    Args:
        vehicle: parameters of the model
        sensor_noise, model_error: standard deviations of the readings, and of the model
        plausible: widths of the ranges in which failed sensors may read
        torque_jump: unknown share of a jump of the steering torque, since the jump occurs between two samples
        influence: bound of a normalised innovation, in standard deviations, for the correction and for the likelihood,
            so that a fault does not disturb the filter; far more than fault-free readings reach
        settling: duration of the transient after the start, in which readings do not count for hypotheses
        slowest: speed from which the vehicle counts as moving; wheel speed sensors detect hardly any slower motion
        largest_force_error: bound of the error of an axle force; for all other states see `process.LIMITS`
        bending: lateral acceleration from which the vehicle is in a bend
        braking: deceleration beyond that of the drives from which the vehicle is braked otherwise; slopes give less
        trusted: 1, or 0 for a sensor that is left out and for an actuator that may have lost torque; all such actuators
            share one loss
    """

    vehicle: AutomatedVehicle.Parameters
    sensor_noise: Measured = SENSOR_NOISE
    model_error: ModelError = field(default_factory=ModelError)
    plausible: Readings = PLAUSIBLE
    torque_jump: Annotated[float, ""] = TORQUE_JUMP
    influence: Annotated[float, ""] = 8.0
    settling: Annotated[float, "s"] = 0.5
    slowest: Annotated[float, "m/s"] = 0.5
    largest_force_error: Annotated[float, "N"] = LIMITS.front_force_error
    bending: Annotated[float, "m/s**2"] = 1.0
    braking: Annotated[float, "m/s**2"] = 1.5
    trusted: Elements = TRUSTED

    Sample = ConditionSample

    class State(NamedTuple):
        """Mean, packed covariance, torques of the previous sample, and time since the start, `settling` at most [s]."""

        mean: AutomatedVehicle.State
        covariance: tuple[Scalar, ...]
        torques: AskedTorques
        age: Scalar

    class Output(NamedTuple):
        """Output of the filter of one hypothesis for one sample.

        Args:
            log_likelihood: log-likelihood of all readings of this sample, given the past [nat]; readings that are left
                out have the density of their plausible range, so that all hypotheses explain the same readings; 0 while
                settling
            prediction: prediction of every sensor, used or not, before any reading of the sample
            deviation: standard deviation of reading less prediction
            estimate: estimate of every sensor's reading without noise, after the correction; the substitute of a sensor
                that is left out
            torque_loss, loss_deviation: lost share of the suspected actuators' torque, the same for two, and its
                standard deviation, which is large while little torque is requested
            speed, lateral_speed: speed components of the centre of gravity
            moving: 1 if the vehicle moves forward, else 0: wheels that stand or roll backwards are no evidence
            driven: 1 if drives and slopes explain the deceleration, else 0: brakes may lock the wheels
            lack: lateral force that an axle lacks in a bend over its load, the larger of both; 0 outside bends; for a
                car without known torques see `skidding.lacking`
            lack_along, given_along: force of the suspected drives that the front axle lacks, and has, over its load
            turning: lateral acceleration as speed times yaw rate, if the filter gives it, else 0
        """

        log_likelihood: Annotated[float, ""]
        prediction: Readings
        deviation: Readings
        estimate: Readings
        torque_loss: Annotated[float, ""]
        loss_deviation: Annotated[float, ""]
        speed: Annotated[float, "m/s"]
        lateral_speed: Annotated[float, "m/s"]
        moving: Annotated[float, ""]
        driven: Annotated[float, ""]
        lack: Annotated[float, ""] = 0.0
        lack_along: Annotated[float, ""] = 0.0
        given_along: Annotated[float, ""] = 0.0
        turning: Annotated[float, "m/s**2"] = 0.0

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sample_time: float = 0.01) -> LeaveOutFilter:
        """Filter of the fault-free hypothesis; the spread of the vehicle's parameters widens its noises.

        Args:
            vehicle: vehicle with the parameters of `AutomatedVehicle`
            sample_time: sampling interval [s]
        """
        parameters = replace(vehicle.parameters_for(AutomatedVehicle.Parameters), sample_time=sample_time)
        return cls(parameters, *widened(vehicle))

    def init(self) -> State:
        """State before the first sample: unknown speed, wheels approximately straight ahead."""
        deviations = start_deviations(self.model_error)
        covariance = from_diagonal([value * value for value in deviations])
        mean = skeleton(AutomatedVehicle.State)
        return self.State(mean, tuple(value + 0.0 for value in covariance), no_torques(), 0.0)

    def step(self, state: State, sample: ConditionSample) -> tuple[State, Output]:
        """Process one sample."""
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

    def corrected(self, state: State, sample: ConditionSample) -> tuple[State, Seen]:
        """State after a sample, and the innovations of the sample."""
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
        """Mean and packed covariance before the readings."""
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
        """Filter of a hypothesis, derived from that of the fault-free hypothesis.

        Args:
            hypothesis: hypothesis with the suspected elements
        """
        error, vehicle = self.model_error, self.vehicle
        if not {*SCALED}.isdisjoint(hypothesis.sensors):
            error = replace(error, wheel_speed_scale=error.wheel_speed_scale_alone)
        if not {*DRIVES}.isdisjoint(hypothesis.actuators):
            error = replace(error, drive_excess=error.drive_excess_alone)
        if len(hypothesis.actuators) > 1:
            vehicle = replace(vehicle, fading=replace(vehicle.fading, loss=COMMON_LOSS_TIME))
        trusted = self.trusted._replace(**dict.fromkeys(hypothesis.suspects, 0.0))
        return replace(self, vehicle=vehicle, model_error=error, trusted=trusted)
