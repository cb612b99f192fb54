"""The filter behind every hypothesis: all sensors and actuators, or all but the suspected ones.

All hypotheses are one compiled structure with different floats: a sensor that is left out has an infinite variance, an
actuator that is suspected may have lost any share of its torque.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, NamedTuple

from tierod.block import skeleton
from tierod.estimators.kernels import predict_covariance
from tierod.estimators.linear_algebra import diagonal, dot, from_diagonal, pack, plus, unpack
from tierod.graph.derivatives import jacobian
from tierod.graph.maths import absolute, both, exp, limit, log, maximum, minimum, present, sqrt, where
from tierod.models.automated_vehicle import AutomatedVehicle, Torques
from tierod.monitors.condition.signals import ACTUATORS, SENSORS, ConditionSample, Hypothesis
from tierod.monitors.condition.tuning import ModelError, PlausibleRange, SensorNoise, widened
from tierod.monitors.condition.updates import Correction, logarithm, spread_of, update
from tierod.vehicles import Vehicle

LIMITS = AutomatedVehicle.State(
    *(80.0, 30.0, 10.0, 1.0, 1.0, 20.0, 80.0, 1.0),
    *(600.0, 600.0, 500.0, 1.5, 0.03, 0.15, 1.7, 1.2, 0.03),
)
"""Beyond which no state goes, whatever a faulty sensor says. The filter stays finite; and a hypothesis that is wrong
cannot explain readings by a bank of thirty degrees or tyres of another size, however long it is given."""


SHORTEST_LAG = 1e-4
"""Of an actuator [s]: keeps a lag of zero from being divided by."""


class Readings(NamedTuple):
    """One number per sensor, in its unit or about it."""

    wheel_speed_rear_left: Annotated[float, "m/s"]
    wheel_speed_rear_right: Annotated[float, "m/s"]
    yaw_rate: Annotated[float, "rad/s"]
    steering_wheel_angle: Annotated[float, "rad"]
    steering_shaft_torque: Annotated[float, "N*m"]
    tie_rod_force: Annotated[float, "N"]


class Surprise(NamedTuple):
    """Squared innovation over its variance of every sensor, before any reading of the sample; 0 where missing."""

    wheel_speed_rear_left: Annotated[float, ""]
    wheel_speed_rear_right: Annotated[float, ""]
    yaw_rate: Annotated[float, ""]
    steering_wheel_angle: Annotated[float, ""]
    steering_shaft_torque: Annotated[float, ""]
    tie_rod_force: Annotated[float, ""]


class Memory(NamedTuple):
    """Torques that were asked for, that the motors give, and the last changes of both steering torques [N*m]."""

    asked: Torques
    given: Torques
    change_1: Any
    change_2: Any


class Seen(NamedTuple):
    """What one sample said.

    Args:
        expected: readings, before any of the sample
        rows: their derivatives by the state
        innovations: readings less the expected ones
        used: whether they count
        spread: variance of the first six innovations
        correction: by all that count
    """

    expected: Any
    rows: Any
    innovations: tuple[Any, ...]
    used: Any
    spread: tuple[Any, ...]
    correction: Correction


@dataclass(frozen=True)
class LeaveOutFilter:
    """Extended Kalman filter of the whole vehicle that leaves out what a hypothesis suspects.

    Its step: torques from targets, prediction by the model with automatic Jacobians, one scalar update per sensor on a
    symmetric covariance. A missing reading (NaN) corrects nothing; a missing target is held.

    Args:
        vehicle: parameters of the model
        sensor_noise, model_error: standard deviations
        plausible: ranges of failed sensors
        influence: standard deviations beyond which a reading neither moves the state further nor counts more against
            the hypothesis: far more than healthy readings reach; a fault does not throw the filter about
        slowest: speed from which the vehicle counts as moving; wheel speed sensors see nothing much slower
        braking: deceleration beyond what the drives give from which something else must brake; steep slopes give less
        use_wheel_speed_rear_left ... use_tie_rod_force: 1, or 0 for a sensor that is left out
        trust_steering_motor_1 ... trust_drive_right: 1, or 0 for an actuator that may have lost torque;
            suspect one at a time, since all suspected ones share one loss
    """

    vehicle: Any
    sensor_noise: SensorNoise = field(default_factory=SensorNoise)
    model_error: ModelError = field(default_factory=ModelError)
    plausible: PlausibleRange = field(default_factory=PlausibleRange)
    influence: Annotated[float, ""] = 8.0
    slowest: Annotated[float, "m/s"] = 0.5
    braking: Annotated[float, "m/s**2"] = 1.5
    use_wheel_speed_rear_left: Annotated[float, ""] = 1.0
    use_wheel_speed_rear_right: Annotated[float, ""] = 1.0
    use_yaw_rate: Annotated[float, ""] = 1.0
    use_steering_wheel_angle: Annotated[float, ""] = 1.0
    use_steering_shaft_torque: Annotated[float, ""] = 1.0
    use_tie_rod_force: Annotated[float, ""] = 1.0
    trust_steering_motor_1: Annotated[float, ""] = 1.0
    trust_steering_motor_2: Annotated[float, ""] = 1.0
    trust_drive_left: Annotated[float, ""] = 1.0
    trust_drive_right: Annotated[float, ""] = 1.0

    Sample = ConditionSample

    class State(NamedTuple):
        """The belief, and what came before."""

        mean: Any
        covariance: tuple[Any, ...]
        torques: Memory

    class Output(NamedTuple):
        """What one hypothesis says about one sample.

        Args:
            log_likelihood: of all readings of this sample, given the past; a failed sensor's reading has the density of
                its plausible range, so that all hypotheses speak of the same readings
            prediction: of every sensor, used or not, before any reading of the sample
            deviation: standard deviation of reading less prediction
            estimate: of every sensor's reading without its noise, after the readings that are used: what replaces a
                sensor that is left out
            surprise: squared innovation over its variance
            torque_loss, loss_deviation: lost share of the suspected actuator's torque; a large deviation means that the
                actuator has had nothing to do
            speed, lateral_speed: of the centre of gravity
            moving: 1 where the vehicle moves forward, else 0: wheels that stand or roll back tell nothing
            driven: 1 where the deceleration is what drives and slopes give, else 0: brakes may lock the wheels
        """

        log_likelihood: Annotated[float, ""]
        prediction: Readings
        deviation: Readings
        estimate: Readings
        surprise: Surprise
        torque_loss: Annotated[float, ""]
        loss_deviation: Annotated[float, ""]
        speed: Annotated[float, "m/s"]
        lateral_speed: Annotated[float, "m/s"]
        moving: Annotated[float, ""]
        driven: Annotated[float, ""]

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sample_time: float = 0.01) -> LeaveOutFilter:
        """The filter that suspects nobody; the less is known of the vehicle, the wider are its noises.

        Args:
            vehicle: with the parameters of `AutomatedVehicle`
            sample_time: [s]
        """
        parameters = replace(vehicle.parameters_for(AutomatedVehicle.Parameters), sample_time=sample_time)
        return cls(parameters, *widened(vehicle))

    def init(self) -> State:
        """Anywhere at any speed, wheels about straight ahead."""
        error, mean = self.model_error, skeleton(AutomatedVehicle.State)
        start = AutomatedVehicle.State(
            *(20.0, 0.5, 0.5, 0.02, 0.02, 4.0, 2.0, 0.7, error.force, error.force, error.tie_rod + error.standing),
            *(error.loss, error.yaw_rate_offset, error.angle_offset, error.road, error.road),
            error.wheel_speed_difference,
        )
        still = Torques(0.0, 0.0, 0.0, 0.0)
        covariance = from_diagonal([value * value for value in start])
        return self.State(mean, tuple(value + 0.0 for value in covariance), Memory(still, still, 0.0, 0.0))

    def step(self, state: Any, sample: Any) -> tuple[Any, Any]:
        """One sample on."""
        after, seen = self.corrected(state, sample)
        judged, correction, mean = len(SENSORS), seen.correction, after.mean
        pairs = zip(seen.expected[:judged], seen.rows[:judged], strict=True)
        surprise = [
            where(present(innovation), innovation * innovation, 0.0) / variance
            for innovation, variance in zip(seen.innovations, seen.spread, strict=False)
        ]
        loss = AutomatedVehicle.State._fields.index("torque_loss")
        return after, self.Output(
            self._log_likelihood(seen),
            Readings(*seen.expected[:judged]),
            Readings(*(sqrt(value) for value in seen.spread)),
            Readings(*(plus(value, dot(row, correction.shift)) for value, row in pairs)),
            Surprise(*surprise),
            mean.torque_loss,
            sqrt(maximum(diagonal(after.covariance)[loss], 0.0)),
            mean.speed,
            mean.lateral_speed,
            where(mean.speed > self.slowest, 1.0, 0.0),
            where(seen.innovations[judged] < -self.braking, 0.0, 1.0),
        )

    def corrected(self, state: Any, sample: Any) -> tuple[Any, Seen]:
        """The belief after a sample, and what the sample said."""
        torques, inputs, jump = self._torques(state.torques, sample)
        mean, covariance = self._predicted(state, inputs, jump)
        expected = AutomatedVehicle.output(mean, inputs, self.vehicle)
        rows = jacobian(lambda at: AutomatedVehicle.output(at, inputs, self._coarse), mean)
        readings, noise = sample[: len(expected)], self._noise(jump)
        innovations = tuple(reading - value for reading, value in zip(readings, expected, strict=True))
        judged = len(SENSORS)
        spread = [spread_of(covariance, row) + r for row, r in zip(rows[:judged], noise[:judged], strict=True)]
        used = [both(present(each), use > 0.5) for each, use in zip(innovations, self._uses(), strict=True)]
        correction = update(covariance, rows, innovations, noise, self._noise(0.0), used, self.influence)
        moved = [value + shift for value, shift in zip(mean, correction.shift, strict=True)]
        bounded = AutomatedVehicle.State(*(limit(v, -most, most) for v, most in zip(moved, LIMITS, strict=True)))
        seen = Seen(expected, rows, innovations, used, tuple(spread), correction)
        return self.State(bounded, correction.covariance, torques), seen

    @property
    def _coarse(self) -> Any:
        """The vehicle for the derivatives: what is small there would fill them with entries, to no gain."""
        return replace(self.vehicle, turn_slip_stiffness=0.0, steering_motor_inertia=0.0)

    def _uses(self) -> tuple[Any, ...]:
        """Whether each reading is used; accelerations always are."""
        return (*(getattr(self, f"use_{name}") for name in SENSORS), 1.0, 1.0)

    def _noise(self, jump: Any) -> tuple[Any, ...]:
        """Variance of each reading; of the torque more where it has jumped between two samples."""
        noise = self.sensor_noise
        deviations = (
            *(noise.wheel_speed, noise.wheel_speed, noise.yaw_rate, noise.steering_wheel_angle),
            *(noise.steering_shaft_torque, noise.tie_rod_force),
            *(noise.longitudinal_acceleration, noise.lateral_acceleration),
        )
        variances = [value * value for value in deviations]
        torque = SENSORS.index("steering_shaft_torque")
        variances[torque] = plus(variances[torque], jump)
        return tuple(variances)

    def _torques(self, memory: Any, sample: Any) -> tuple[Any, Any, Any]:
        """Next memory, inputs of the model, and the variance of the steering torque between the samples [N^2*m^2].

        Targets change on a straight line from sample to sample, actuators follow with their lag: exact for that.
        """
        vehicle = self.vehicle
        targets = (
            sample.steering_motor_1_target_torque,
            sample.steering_motor_2_target_torque,
            sample.target_drive_torque_left,
            sample.target_drive_torque_right,
        )
        asked = Torques(*(where(present(new), new, old) for new, old in zip(targets, memory.asked, strict=True)))
        lags = (vehicle.steering_motor_lag, vehicle.steering_motor_lag, vehicle.drive_lag, vehicle.drive_lag)
        step, mean, now = vehicle.sample_time, [], []
        for new, old, given, lag in zip(asked, memory.asked, memory.given, lags, strict=True):
            lag = maximum(lag, SHORTEST_LAG)
            behind = (new - old) * (lag / step)
            after = new - behind + (given - old + behind) * exp(-step / lag)
            mean.append(0.5 * (old + new) - lag / step * (after - given))
            now.append(after)
        change_1, change_2 = asked[0] - memory.asked[0], asked[1] - memory.asked[1]
        suspected = [1.0 - getattr(self, f"trust_{name}") for name in ACTUATORS]
        whole = _jump(change_1 + change_2, memory.change_1 + memory.change_2)
        swing = suspected[0] * _jump(change_1, memory.change_1) + suspected[1] * _jump(change_2, memory.change_2)
        unknown = self.sensor_noise.jump * self.sensor_noise.jump * (whole + swing)
        inputs = AutomatedVehicle.Input(*mean, *now, *suspected)
        return Memory(asked, Torques(*now), change_1, change_2), inputs, unknown

    def _predicted(self, state: Any, inputs: Any, jump: Any) -> tuple[Any, Any]:
        """Mean and packed covariance before the readings."""

        rows = jacobian(lambda at: AutomatedVehicle.transition(at, inputs, self._coarse), state.mean)
        process = self._process_noise(state.mean, inputs)
        covariance = predict_covariance(rows, state.covariance, process)
        mean = AutomatedVehicle.transition(state.mean, inputs, self.vehicle)
        return mean, self._with_torque(covariance, jump)

    def _process_noise(self, mean: Any, inputs: Any) -> Any:
        """Variance that each state gains per sample; that of the forces grows with the forces."""
        vehicle, error, fading = self.vehicle, self.model_error, self.vehicle.fading
        step, forces = vehicle.sample_time, AutomatedVehicle.forces(mean, inputs, self.vehicle)
        standing = error.standing / (1.0 + mean.speed * mean.speed)
        rod = vehicle.steering_ratio / vehicle.rack_ratio * absolute(forces.kingpin)

        def gained(deviation: Any, time: Any) -> Any:
            return deviation * deviation * (1.0 - exp(-2.0 * step / time))

        def white(deviation: Any) -> Any:
            return deviation * deviation

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
        )

    def _with_torque(self, covariance: Any, jump: Any) -> Any:
        """The covariance with the steering torque's error in the mean of the step, which moves angle and rate."""
        vehicle, full = self.vehicle, unpack(covariance)
        damping = vehicle.rack_ratio * vehicle.rack_ratio * vehicle.rack_damping
        left = exp(-damping * vehicle.sample_time / vehicle.column_inertia)
        path = vehicle.column_inertia / damping * (1.0 - left)
        angle = AutomatedVehicle.State._fields.index("column_angle")
        gain = {angle: (vehicle.sample_time - path) / damping, angle + 1: (1.0 - left) / damping}
        variance = self.model_error.steering_torque * self.model_error.steering_torque + jump
        for i, first in gain.items():
            for j, second in gain.items():
                full[i][j] = full[i][j] + first * second * variance
        return pack(full)

    def _log_likelihood(self, seen: Seen) -> Any:
        """Of the readings that there are: as innovations where used, as anything plausible where not."""
        plausible = self.plausible
        widths = (
            *(plausible.wheel_speed, plausible.wheel_speed, plausible.yaw_rate, plausible.steering_wheel_angle),
            *(plausible.steering_shaft_torque, plausible.tie_rod_force, 1.0, 1.0),
        )
        squares: Any = 0.0
        widening: Any = 1.0
        for over, wide in zip(seen.correction.whitened, seen.correction.widening, strict=True):
            squares = squares + minimum(over * over, self.influence * self.influence)
            widening = widening * wide
        total = -0.5 * (squares + logarithm(widening))
        for reading, counts, variance, width in zip(seen.innovations, seen.used, self._noise(0.0), widths, strict=True):
            left_out = where(present(reading), -log(width), 0.0)
            total = total + where(counts, -0.5 * log(2.0 * math.pi * variance), left_out)
        return total


def leaving_out(hypothesis: Hypothesis, base: LeaveOutFilter) -> LeaveOutFilter:
    """The filter of one hypothesis.

    Args:
        hypothesis: whom it suspects
        base: the filter that suspects nobody
    """
    changes: dict[str, Any] = {f"use_{name}": 0.0 for name in hypothesis.sensors}
    changes |= {f"trust_{name}": 0.0 for name in hypothesis.actuators}
    return replace(base, **changes)


def _jump(change: Any, before: Any) -> Any:
    """Square of what a torque has jumped by, beyond going on as it went [N^2*m^2]."""
    return absolute(change * (change - before))
