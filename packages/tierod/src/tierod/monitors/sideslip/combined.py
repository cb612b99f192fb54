"""The combined sideslip estimator: one extended Kalman filter over all measurements of a car.

It uses yaw rate, lateral acceleration and, in a car steered by wire, angle and torque of the road wheels, and estimates
unknown parameters of the car together with the motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple, Self

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import absolute, both, either, limit, maximum, present, select, sqrt, where
from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import correct
from tierod.methods.estimators.linear_algebra import diagonal
from tierod.methods.estimators.shapes import Belief
from tierod.methods.filters.jump_gate import JumpGate
from tierod.models.lateral_parameters import LateralParameters
from tierod.monitors.sideslip.combined_estimate import CombinedEstimate, CombinedSample, derived_fields
from tierod.monitors.sideslip.combined_filter import GATE, bounded, combined_filter, held_growth
from tierod.monitors.sideslip.combined_tuning import CombinedTuning, per_sample, tuning_of
from tierod.monitors.sideslip.grip_limit import GripLimit
from tierod.monitors.sideslip.noise_scale import NoiseScale, ScaleState
from tierod.physics.gravity import GRAVITY
from tierod.vehicles.vehicle import Vehicle

STEERING_RATE = 0.3
"""Standard deviation of the road wheels' rate in the gate against jumps of their angle [rad/s]; three of them are the
1 rad/s of a driver who turns the wheel by 800 degrees per second."""

SMOOTHING = 0.2
"""Time constant of the lateral acceleration that bounds friction from below [s]; longer than vibration, shorter than a
turn."""

PATIENCE = 1.0
"""Time constant over which the innovations must be too large before the filter restarts [s]."""

SLOWEST_ANGLE = 0.05
"""Sampling interval of the slowest steering angle that the monitor accepts [s]; 20 Hz."""

MOST_SIDESLIP = 0.6
"""Tangent of the sideslip angle (31 degrees) above which a filter with raised noises counts as lost: no car on the road
slips so far, but a filter that follows a wrong yaw rate does at once."""

SLOW = 3.0
"""Least speed to which the lateral speed is compared in that test [m/s]: a short car on full lock turns about its rear
axle."""

USUAL_SLIP = 0.1
"""Standard deviation of a pseudo measurement of zero rear slip angle over `SLIP_TIME` [rad]; six degrees. It is used
while a noise is raised: innovations then contradict nothing, and tyres without grip would keep any lateral speed."""

SLIP_TIME = 1.0
"""Time for which a slip angle lasts [s]."""

WIND_SPEED = 25.0
"""Speed at which the tuning's wind applies [m/s]; the force of a gust grows with the speed of the car."""

FARTHEST_SHOWN = 10.0
"""Bound of the reported distance from the limit, in standard deviations; larger values carry no more information."""


class CombinedState(NamedTuple):
    """State of the combined estimator: filter, last inputs, and monitoring of both.

    Args:
        belief: estimate of the filter with its covariance
        vehicle_speed, road_wheel_angle: last valid values [m/s], [rad]
        angle_gate: state of the gate on the road-wheel angle
        lateral_acceleration: low-passed [m/s**2]
        misfit: low-passed squared innovation over its variance, per reading
        yaw_noise, acceleration_noise: noise scales of the yaw rate's equation and of the accelerometer
    """

    belief: Belief
    vehicle_speed: Annotated[Scalar, "m/s"]
    road_wheel_angle: Annotated[Scalar, "rad"]
    angle_gate: Tree
    lateral_acceleration: Annotated[Scalar, "m/s**2"]
    misfit: Annotated[Scalar, ""]
    yaw_noise: ScaleState
    acceleration_noise: ScaleState


class SteeringAngle(NamedTuple):
    """Signal that the gate against jumps checks."""

    road_wheel_angle: Annotated[float, "rad"]


@dataclass(frozen=True)
class CombinedSideslip:
    """Sideslip from yaw rate, lateral acceleration and steering, with estimated stiffness, friction, bank and wind.

    Extended Kalman filter in velocity form, valid from walking pace to the limit of grip. Below `slowest` and without
    speed it holds its last estimate, whose variance grows up to the initial one; after reversing it begins anew.
    `of_vehicle` builds it.

    Args:
        filter: Kalman filter of `tierod.models.lateral_motion`; its gate reduces the weight of outlying readings
        angle_gate: gate against jumps of a steering angle that is taken as known
        yaw_noise: adapts the noise of the yaw rate's equation: unmodelled forces and moments
        acceleration_noise: adapts the noise of the accelerometer: vibration, lean and bank that no state describes
        growth: variance per sample of every state while the estimate is held
        most: variance up to which it grows
        angle_deviation: stationary standard deviation of the steering angle's offset, where it is estimated
        ratio_error, slip_error, constant_error: see `CombinedTuning`
        free_rate: variance per sample of the road wheels' rate while the actuator's torque is unknown
        slowest: speed below which the last estimate is held
        limit: what shows that the front axle nears its largest force, beside its slip
        limit_share: share of the greatest front force from which the limit of grip is announced
        limit_rule: standard deviations by which the share must exceed it
        most_misfit: mean squared innovation over its variance above which the filter is lost and restarts

    Source: Yih, Ryu, Gerdes (2003), whose two observers it joins; tyres, unknowns and low speed are tierod's own.
    """

    filter: KalmanFilter
    angle_gate: JumpGate
    yaw_noise: NoiseScale
    acceleration_noise: NoiseScale
    growth: tuple[float, ...]
    most: tuple[float, ...]
    angle_deviation: Annotated[float, "rad", POSITIVE] = 1.0
    ratio_error: Annotated[float, "", NOT_NEGATIVE] = 0.0
    slip_error: Annotated[float, "", NOT_NEGATIVE] = 0.0
    constant_error: Annotated[float, "rad", NOT_NEGATIVE] = 0.0
    free_rate: Annotated[float, "rad**2/s**2", NOT_NEGATIVE] = 0.0
    slowest: Annotated[float, "m/s", POSITIVE] = 0.5
    limit_share: Annotated[float, "", POSITIVE] = 0.7
    limit_rule: HeldThreshold = field(default_factory=lambda: HeldThreshold(1.0, 1, "upper"))
    limit: GripLimit = field(default_factory=GripLimit)
    most_misfit: Annotated[float, "", POSITIVE] = 4.0

    Sample = CombinedSample

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float, tuning: CombinedTuning | None = None, steering: bool | None = None
    ) -> Self:
        """The estimator for a vehicle file.

        Args:
            vehicle: vehicle with mass, yaw inertia, distances and cornering stiffnesses at least, see
                `LateralParameters`
            sample_time: sampling interval [s]
            tuning: tuning; the default with the noises of the vehicle file where None
            steering: whether the road wheels' motion is estimated from the actuator's torque; where None, if the
                vehicle file gives `road_wheel_inertia`

        Raises:
            ParameterError: the vehicle file lacks a parameter, or the sample time is not positive
        """
        steering = "road_wheel_inertia" in vehicle if steering is None else steering
        tuning = tuning_of(vehicle) if tuning is None else tuning
        return cls.of_parameters(vehicle.parameters_for(LateralParameters), sample_time, tuning, steering)

    @classmethod
    def of_parameters(
        cls, car: LateralParameters, sample_time: float, tuning: CombinedTuning | None = None, steering: bool = False
    ) -> Self:
        """The estimator from given parameters; arguments as in `of_vehicle`.

        Raises:
            ParameterError: the sample time is not positive
        """
        if not 0.0 < sample_time <= 0.05:
            raise ParameterError(
                f"the sample time of the sideslip estimator is {sample_time} s; it needs more than 0 and at most 0.05 s"
            )
        tuning = CombinedTuning() if tuning is None else tuning
        filter = combined_filter(car, sample_time, tuning, steering)
        return cls(
            filter,
            JumpGate(SteeringAngle, sample_time, 0.0, STEERING_RATE, SLOWEST_ANGLE, GATE),
            NoiseScale(sample_time, greatest=tuning.yaw_adaptation),
            NoiseScale(sample_time, greatest=tuning.acceleration_adaptation),
            growth=held_growth(filter.model, tuning.noises, sample_time),
            most=filter.initial_variance,
            angle_deviation=tuning.road_wheel_angle_offset.deviation if tuning.road_wheel_angle_offset else 1.0,
            ratio_error=tuning.ratio_error,
            slip_error=tuning.slip_error,
            constant_error=tuning.constant_error,
            free_rate=per_sample(tuning.noises.free_road_wheel_rate, sample_time),
            slowest=tuning.slowest,
            limit_share=tuning.limit_share,
            limit_rule=HeldThreshold(tuning.limit_certainty, 1, "upper"),
            limit=tuning.limit,
            most_misfit=tuning.most_misfit,
        )

    def init(self) -> CombinedState:
        """State before the first sample: straight ahead, parameters as in the vehicle file."""
        return CombinedState(self.filter.init(), self.slowest, 0.0, self.angle_gate.init(), 0.0, 1.0, *self._usual())

    def _adapts(self, state: CombinedState) -> Scalar:
        """Whether a noise is raised, which keeps the innovations small even for a wrong estimate."""
        return state.yaw_noise.logarithm + state.acceleration_noise.logarithm > 0.0

    def _within_usual_slip(self, belief: Belief, speed: Scalar, counted: Scalar) -> Belief:
        """The estimate after a pseudo measurement of zero rear slip angle, which bounds sideslip without grip."""
        sampled, mean = self.filter.parameters, belief.mean
        slopes = {"lateral_speed": 1.0 / speed, "yaw_rate": -sampled.car.rear_distance / speed}
        slip = sum(slope * getattr(mean, name) for name, slope in slopes.items())
        row = [slopes.get(name, 0.0) for name in mean._fields]
        # A white noise per sample that is worth one reading per SLIP_TIME.
        noise = USUAL_SLIP * USUAL_SLIP * SLIP_TIME / sampled.sample_time
        correction = correct(belief.covariance, [row], [where(counted, -slip, math.inf)], [noise], mean)
        return Belief(type(mean)(*correction.shift), correction.covariance)

    def _fresh(self, scale: ScaleState, lost: Scalar) -> ScaleState:
        return ScaleState(*(where(lost, 0.0, each) for each in scale))

    def _usual(self) -> tuple[ScaleState, ScaleState]:
        return self.yaw_noise.init(), self.acceleration_noise.init()

    def step(self, state: CombinedState, sample: CombinedSample) -> tuple[CombinedState, CombinedEstimate]:
        """Process one sample."""
        angle_gate, gated = self.angle_gate.step(state.angle_gate, SteeringAngle(sample.road_wheel_angle))
        moving = both(present(sample.vehicle_speed), sample.vehicle_speed > self.slowest)
        if self.filter.model.steering:
            running = moving
        else:
            sample = sample._replace(road_wheel_angle=gated.road_wheel_angle)
            running = both(moving, present(sample.road_wheel_angle))
        inputs, free = self._inputs(sample)
        belief, estimate = self._filtered(state, sample, inputs, running, free)
        lateral = self._smoothed(state.lateral_acceleration, sample.lateral_acceleration, SMOOTHING)
        belief = self._within_usual_slip(belief, inputs.vehicle_speed, both(running, self._adapts(state)))
        # With raised noises the innovations no longer reveal a lost filter; only an impossible sideslip does.
        per_reading = where(estimate.present > 0.5, estimate.nis / maximum(estimate.present, 1.0), math.inf)
        misfit = self._smoothed(state.misfit, per_reading, PATIENCE)
        skids = absolute(belief.mean.lateral_speed) > MOST_SIDESLIP * maximum(inputs.vehicle_speed, SLOW)
        lost = either(misfit > self.most_misfit, both(self._adapts(state), skids))
        # A car with unsigned speeds is known to reverse only after some turning, which has taught the filter errors.
        anew = either(lost, both(present(sample.vehicle_speed), sample.vehicle_speed < -self.slowest))
        belief = select(anew, self.filter.init(), belief._replace(mean=bounded(self.filter, belief.mean, lateral)))
        known = both(running, present(sample.road_wheel_angle))
        after = CombinedState(
            belief,
            where(running, inputs.vehicle_speed, state.vehicle_speed),
            where(known, sample.road_wheel_angle, state.road_wheel_angle),
            angle_gate,
            lateral,
            where(anew, 1.0, misfit),
            *(self._fresh(now, anew) for now in self._scales(state, estimate, running)),
        )
        return after, self._estimate(after, inputs, estimate, running, lost)

    def _filtered(
        self, state: CombinedState, sample: CombinedSample, inputs: Tree, running: Scalar, free: Scalar
    ) -> tuple[Belief, Tree]:
        """Filter step, held where nothing runs; a steering angle used as input is its mean over the sample."""
        # Infinity marks a missing input, for which the filter holds its estimate.
        given = inputs._replace(vehicle_speed=where(running, inputs.vehicle_speed, math.inf))
        if not self.filter.model.steering:
            given = given._replace(road_wheel_angle=0.5 * (state.road_wheel_angle + inputs.road_wheel_angle))
        noise = self._process_noise(state, inputs, running, free)
        scale = self.acceleration_noise.scale(state.acceleration_noise)
        reading = tuple(
            scale * each if name == "lateral_acceleration" else each
            for name, each in zip(self.filter.model.Output._fields, self.filter.measurement_noise, strict=True)
        )
        measured = self.filter.Sample(given, self._measured(sample))
        return self.filter.step(state.belief, measured, process_noise=noise, measurement_noise=reading)

    def _scales(self, state: CombinedState, estimate: Tree, running: Scalar) -> tuple[ScaleState, ScaleState]:
        """The noise scales after one sample."""
        seen, expected = estimate.innovation, estimate.innovation_variance
        return (
            self.yaw_noise.after(state.yaw_noise, seen.yaw_rate, expected.yaw_rate, running),
            self.acceleration_noise.after(
                state.acceleration_noise, seen.lateral_acceleration, expected.lateral_acceleration, running
            ),
        )

    def _estimate(
        self, after: CombinedState, inputs: Tree, estimate: Tree, running: Scalar, lost: Scalar
    ) -> CombinedEstimate:
        """The output, computed with speed and angle of the last sample that was used."""
        seen = inputs._replace(vehicle_speed=after.vehicle_speed)
        if not self.filter.model.steering:
            seen = seen._replace(road_wheel_angle=after.road_wheel_angle)
        fields = derived_fields(self.filter, after.belief, seen, self.limit_share)
        missing = self.slip_error * fields["rear_slip_angle"]
        known = fields["sideslip_angle_deviation"]
        unseen = self.constant_error * self.constant_error + missing * missing
        fields["sideslip_angle_deviation"] = sqrt(known * known + unseen)
        distance = fields.pop("limit_distance")
        steer = after.belief.mean.road_wheel_angle if self.filter.model.steering else seen.road_wheel_angle
        usual = self.filter.parameters.car.tyre_friction * GRAVITY
        yaw_noise = self.yaw_noise.scale(after.yaw_noise)
        forced = both(running, self.limit.shown(fields, after.vehicle_speed, steer, usual, yaw_noise))
        _, near = self.limit_rule.step(self.limit_rule.init(), distance, forced)
        return CombinedEstimate(
            **fields,
            limit_ahead=near.alarm,
            limit_distance=limit(distance, -FARTHEST_SHOWN, FARTHEST_SHOWN),
            nis=estimate.nis,
            readings=estimate.present,
            held=where(running, 0.0, 1.0),
            restarted=where(lost, 1.0, 0.0),
            yaw_noise_scale=yaw_noise,
            acceleration_noise_scale=self.acceleration_noise.scale(after.acceleration_noise),
        )

    def _inputs(self, sample: CombinedSample) -> tuple[Tree, Scalar]:
        """Inputs of the model, finite values throughout, and whether the road wheels turn without known torque."""
        along = where(present(sample.longitudinal_acceleration), sample.longitudinal_acceleration, 0.0)
        speed = where(present(sample.vehicle_speed), maximum(sample.vehicle_speed, self.slowest), self.slowest)
        if not self.filter.model.steering:
            angle = where(present(sample.road_wheel_angle), sample.road_wheel_angle, 0.0)
            return self.filter.model.Input(speed, along, angle), 0.0
        known = present(sample.road_wheel_torque)
        torque = where(known, sample.road_wheel_torque, 0.0)
        return self.filter.model.Input(speed, along, torque, where(known, 1.0, 0.0)), where(known, 0.0, 1.0)

    def _measured(self, sample: CombinedSample) -> Tree:
        return self.filter.model.Output(*(getattr(sample, name) for name in self.filter.model.Output._fields))

    def _process_noise(self, state: CombinedState, inputs: Tree, running: Scalar, free: Scalar) -> tuple[Scalar, ...]:
        """Variance that each state gains in this sample; while the estimate is held only that of the motion grows."""
        factors = self._factors(state, inputs)
        noise = []
        for name, usual, growth, most, now in zip(
            self.filter.model.State._fields,
            self.filter.process_noise,
            self.growth,
            self.most,
            diagonal(state.belief.covariance),
            strict=True,
        ):
            usual = where(free > 0.5, self.free_rate, usual) if name == "road_wheel_rate" else usual
            moving = factors[name] * usual if name in factors else usual
            noise.append(where(running, moving, where(now < most, growth, 0.0)))
        return tuple(noise)

    def _factors(self, state: CombinedState, inputs: Tree) -> dict[str, Scalar]:
        """Factors of the process noise, from innovations, speed (wind) and steering angle (steering ratio)."""
        speed = inputs.vehicle_speed / WIND_SPEED
        factors: dict[str, Scalar] = {
            "yaw_rate": self.yaw_noise.scale(state.yaw_noise),
            "side_force": speed * speed,
            "side_moment": speed * speed,
        }
        if not self.filter.model.steering:
            part = self.ratio_error * inputs.road_wheel_angle / self.angle_deviation
            factors["road_wheel_angle_offset"] = 1.0 + part * part
        return factors

    def _smoothed(self, before: Scalar, value: Scalar, time: float) -> Scalar:
        """First-order low-pass; holds where the value is missing."""
        sample_time: Scalar = self.filter.parameters.sample_time
        share = sample_time / (time + sample_time)
        return where(present(value), before + share * (where(present(value), value, before) - before), before)
