"""The combined sideslip estimator: one extended Kalman filter over all measurements of a car."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple, Self

import numpy as np

from tierod.core.block import Scalar, Tree, rebuild
from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph import Memory
from tierod.core.graph.maths import (
    absolute,
    arctan,
    both,
    cos,
    either,
    exp,
    limit,
    maximum,
    present,
    select,
    sin,
    sqrt,
    where,
)
from tierod.core.graph.trace import jacobian
from tierod.methods.detectors.control_charts import HeldThreshold
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.kernels import congruence, correct, diagonal, unpack
from tierod.methods.estimators.shapes import Belief
from tierod.methods.filters import JumpGate
from tierod.models.lateral_motion import LateralParameters
from tierod.monitors.sideslip.tuning import (
    GATE,
    CombinedTuning,
    GripLimit,
    NoiseScale,
    ScaleState,
    bounded,
    combined_filter,
    held_growth,
    per_sample,
    tuning_of,
)
from tierod.physics.motion import GRAVITY
from tierod.physics.tyre import scaled_slip_of
from tierod.vehicles.vehicle import Vehicle

# Floor of the sideslip angle's standard deviation [rad], for errors that no state of the model describes. Measured on
# drives of the virtual car, where with it 95 % bands contain about 95 %.
UNSEEN = 5e-4

FIELDS = {
    "log_front_stiffness": "front_stiffness",
    "log_rear_stiffness": "rear_stiffness",
    "log_friction": "friction",
    "bank_angle": "bank_angle",
    "side_force": "side_force",
    "lateral_acceleration_bias": "lateral_acceleration_bias",
    "yaw_rate_bias": "yaw_rate_bias",
    "road_wheel_angle_offset": "road_wheel_angle_offset",
}
"""Unknown of the model -> field of the estimate."""


class CombinedSample(NamedTuple):
    """Input sample, NaN where the car lacks a signal."""

    # forward speed; without it, and below walking pace, the last estimate is held
    vehicle_speed: Annotated[Scalar, "m/s"]
    road_wheel_angle: Annotated[Scalar, "rad"]  # mean of both front wheels
    # yaw_rate, lateral_acceleration, longitudinal_acceleration: readings of the inertial unit
    yaw_rate: Annotated[Scalar, "rad/s"]
    lateral_acceleration: Annotated[Scalar, "m/s**2"]
    longitudinal_acceleration: Annotated[Scalar, "m/s**2"]
    road_wheel_torque: Annotated[Scalar, "N*m"]  # torque of the actuator about the kingpins, for a car steered by wire


class CombinedEstimate(NamedTuple):
    """Estimate after a sample; a `_deviation` is one standard deviation."""

    sideslip_angle: Annotated[Scalar, "rad"]
    sideslip_angle_deviation: Annotated[Scalar, "rad"]
    # lateral_speed, corrected_yaw_rate: motion of the centre of gravity, without the gyroscope's bias
    lateral_speed: Annotated[Scalar, "m/s"]
    corrected_yaw_rate: Annotated[Scalar, "rad/s"]
    # slip angle of the front axle, positive where the force is to the left
    front_slip_angle: Annotated[Scalar, "rad"]
    front_lateral_force: Annotated[Scalar, "N"]
    rear_lateral_force: Annotated[Scalar, "N"]
    self_aligning_torque: Annotated[Scalar, "N*m"]  # torque of the front axle, opposing positive steer
    self_aligning_torque_deviation: Annotated[Scalar, "N*m"]
    # lateral force over the greatest that the front axle can produce now
    front_friction_used: Annotated[Scalar, ""]
    front_friction_used_deviation: Annotated[Scalar, ""]
    # 1 where front slip exceeds the slip at the tuning's share of the greatest force by the required standard
    # deviations, and the estimate is not held
    limit_ahead: Annotated[Scalar, ""]
    limit_distance: Annotated[Scalar, ""]
    front_stiffness: Annotated[Scalar, ""]
    front_stiffness_deviation: Annotated[Scalar, ""]
    rear_stiffness: Annotated[Scalar, ""]
    rear_stiffness_deviation: Annotated[Scalar, ""]
    friction: Annotated[Scalar, ""]
    friction_deviation: Annotated[Scalar, ""]
    bank_angle: Annotated[Scalar, "rad"]
    bank_angle_deviation: Annotated[Scalar, "rad"]
    side_force: Annotated[Scalar, "N"]
    lateral_acceleration_bias: Annotated[Scalar, "m/s**2"]
    yaw_rate_bias: Annotated[Scalar, "rad/s"]
    road_wheel_angle_offset: Annotated[Scalar, "rad"]
    nis: Annotated[Scalar, ""]  # nis, readings: normalised innovation squared of the sample, and its number of readings
    readings: Annotated[Scalar, ""]
    held: Annotated[Scalar, ""]  # 1 where nothing could be estimated and the last estimate is held
    restarted: Annotated[Scalar, ""]  # 1 where the filter was lost and restarted


class Derived(NamedTuple):
    """Quantities derived from the states, each with its own standard deviation."""

    sideslip_angle: Annotated[Scalar, "rad"]
    self_aligning_torque: Annotated[Scalar, "N*m"]
    front_friction_used: Annotated[Scalar, ""]
    front_scaled_slip: Annotated[Scalar, ""]


def derived_fields(filter: KalmanFilter, belief: Belief, inputs: Tree, limit_share: Scalar) -> dict[str, Scalar]:
    """Fields of `CombinedEstimate` that follow from a belief.

    The limit is tested on the scaled slip, which keeps growing where the force no longer does: near the peak an
    uncertain slip would give a force that appears certain.
    """
    parameters = filter.parameters

    def derived(mean: Tree) -> Derived:
        forces = filter.model.forces(mean, inputs, parameters)
        return Derived(
            arctan(mean.lateral_speed / inputs.vehicle_speed),
            forces.self_aligning_torque,
            absolute(forces.front.lateral) / forces.front.greatest,
            absolute(sin(forces.front.angle) / cos(forces.front.angle)),
        )

    variance = Derived(*diagonal(congruence(jacobian(derived, belief.mean), belief.covariance)))
    at, forces = derived(belief.mean), filter.model.forces(belief.mean, inputs, parameters)
    beyond = at.front_scaled_slip - scaled_slip_of(limit_share, parameters.car.front_force_shape)
    return {
        "sideslip_angle": at.sideslip_angle,
        "sideslip_angle_deviation": sqrt(variance.sideslip_angle + UNSEEN * UNSEEN),
        "lateral_speed": belief.mean.lateral_speed,
        "corrected_yaw_rate": belief.mean.yaw_rate,
        "front_slip_angle": arctan(forces.front_slip),
        "rear_slip_angle": arctan(forces.rear_slip),
        "front_lateral_force": forces.front.lateral,
        "rear_lateral_force": forces.rear.lateral,
        "self_aligning_torque": at.self_aligning_torque,
        "self_aligning_torque_deviation": sqrt(variance.self_aligning_torque),
        "front_friction_used": at.front_friction_used,
        "front_friction_used_deviation": sqrt(variance.front_friction_used),
        "limit_distance": beyond / maximum(sqrt(variance.front_scaled_slip), 1e-9),
        **_unknowns(filter, belief),
    }


def _unknowns(filter: KalmanFilter, belief: Belief) -> dict[str, Scalar]:
    variances = dict(zip(filter.model.State._fields, diagonal(belief.covariance), strict=True))
    known: dict[str, Scalar] = {}
    for name, given in FIELDS.items():
        value = getattr(belief.mean, name) if name in variances else 0.0
        scale = exp(value) if name.startswith("log_") else 1.0
        known[given] = scale if name.startswith("log_") else value
        known[f"{given}_deviation"] = scale * sqrt(variances.get(name, 0.0))
    return {name: value for name, value in known.items() if name in CombinedEstimate._fields}


# Standard deviation of the road wheels' rate in the gate against jumps of their angle [rad/s]; three of them are the 1
# rad/s of a driver who turns the wheel by 800 degrees per second.
STEERING_RATE = 0.3
# Time constant of the lateral acceleration that bounds friction from below [s]; longer than vibration, shorter than a
# turn.
SMOOTHING = 0.2
PATIENCE = 1.0  # time constant over which the innovations must be too large before the filter restarts [s]
SLOWEST_ANGLE = 0.05  # sampling interval of the slowest steering angle that the monitor accepts [s]; 20 Hz
# Tangent of the sideslip angle (31 degrees) above which a filter with raised noises counts as lost: no car on the road
# slips so far, but a filter that follows a wrong yaw rate does at once.
MOST_SIDESLIP = 0.6
# Least speed to which the lateral speed is compared in that test [m/s]: a short car on full lock turns about its rear
# axle.
SLOW = 3.0
# Standard deviation of a pseudo measurement of zero rear slip angle over `SLIP_TIME` [rad]; six degrees. It is used
# while a noise is raised: innovations then contradict nothing, and tyres without grip would keep any lateral speed.
USUAL_SLIP = 0.1
SLIP_TIME = 1.0  # time for which a slip angle lasts [s]
WIND_SPEED = 25.0  # speed at which the tuning's wind applies [m/s]; the force of a gust grows with the speed of the car
# Bound of the reported distance from the limit, in standard deviations; larger values carry no more information.
FARTHEST_SHOWN = 10.0


class CombinedState(NamedTuple):
    """State of the combined estimator: filter, last inputs, and monitoring of both."""

    belief: Belief  # estimate of the filter with its covariance
    vehicle_speed: Annotated[Scalar, "m/s"]  # vehicle_speed, road_wheel_angle: last valid values [m/s], [rad]
    road_wheel_angle: Annotated[Scalar, "rad"]
    angle_gate: Tree  # state of the gate on the road-wheel angle
    lateral_acceleration: Annotated[Scalar, "m/s**2"]  # low-passed [m/s**2]
    misfit: Annotated[Scalar, ""]  # low-passed squared innovation over its variance, per reading
    # yaw_noise, acceleration_noise: noise scales of the yaw rate's equation and of the accelerometer
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
            tuning: tuning; the default with the noises of the vehicle file where None
            steering: whether the road wheels' motion is estimated from the actuator's torque; where None,
                if the vehicle file gives `road_wheel_inertia`
        """
        steering = "road_wheel_inertia" in vehicle if steering is None else steering
        tuning = tuning_of(vehicle) if tuning is None else tuning
        return cls.of_parameters(vehicle.parameters_for(LateralParameters), sample_time, tuning, steering)

    @classmethod
    def of_parameters(
        cls, car: LateralParameters, sample_time: float, tuning: CombinedTuning | None = None, steering: bool = False
    ) -> Self:
        """The estimator from given parameters; arguments as in `of_vehicle`."""
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
        usual = self.yaw_noise.init(), self.acceleration_noise.init()
        return CombinedState(self.filter.init(), self.slowest, 0.0, self.angle_gate.init(), 0.0, 1.0, *usual)

    def _adapts(self, state: CombinedState) -> Scalar:
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

    def step(self, state: CombinedState, sample: CombinedSample) -> tuple[CombinedState, CombinedEstimate]:
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
            *(ScaleState(*(where(anew, 0.0, each) for each in now)) for now in self._scales(state, estimate, running)),
        )
        return after, self._estimate(after, inputs, estimate, running, lost)

    def _filtered(
        self, state: CombinedState, sample: CombinedSample, inputs: Tree, running: Scalar, free: Scalar
    ) -> tuple[Belief, Tree]:
        # Infinity marks a missing input, for which the filter holds its estimate.
        given = inputs._replace(vehicle_speed=where(running, inputs.vehicle_speed, math.inf))
        if not self.filter.model.steering:
            given = given._replace(road_wheel_angle=0.5 * (state.road_wheel_angle + inputs.road_wheel_angle))
        noise = self._process_noise(state, inputs, running, free)
        scale, output = self.acceleration_noise.scale(state.acceleration_noise), self.filter.model.Output
        reading = tuple(
            scale * each if name == "lateral_acceleration" else each
            for name, each in zip(output._fields, self.filter.measurement_noise, strict=True)
        )
        measured = self.filter.Sample(given, output(*(getattr(sample, name) for name in output._fields)))
        return self.filter.step(state.belief, measured, process_noise=noise, measurement_noise=reading)

    def _scales(self, state: CombinedState, estimate: Tree, running: Scalar) -> tuple[ScaleState, ScaleState]:
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
        seen = inputs._replace(vehicle_speed=after.vehicle_speed)
        if not self.filter.model.steering:
            seen = seen._replace(road_wheel_angle=after.road_wheel_angle)
        fields = derived_fields(self.filter, after.belief, seen, self.limit_share)
        missing = self.slip_error * fields.pop("rear_slip_angle")
        known = fields["sideslip_angle_deviation"]
        unseen = self.constant_error * self.constant_error + missing * missing
        fields["sideslip_angle_deviation"] = sqrt(known * known + unseen)
        distance = fields.pop("limit_distance")
        steer = after.belief.mean.road_wheel_angle if self.filter.model.steering else seen.road_wheel_angle
        usual = self.filter.parameters.car.tyre_friction * GRAVITY
        scale = self.yaw_noise.scale(after.yaw_noise)
        forced = both(running, self.limit.shown(fields, after.vehicle_speed, steer, usual, scale))
        _, near = self.limit_rule.step(self.limit_rule.init(), distance, forced)
        return CombinedEstimate(
            **fields,
            limit_ahead=near.alarm,
            limit_distance=limit(distance, -FARTHEST_SHOWN, FARTHEST_SHOWN),
            nis=estimate.nis,
            readings=estimate.present,
            held=where(running, 0.0, 1.0),
            restarted=where(lost, 1.0, 0.0),
        )

    def _inputs(self, sample: CombinedSample) -> tuple[Tree, Scalar]:
        along = where(present(sample.longitudinal_acceleration), sample.longitudinal_acceleration, 0.0)
        speed = where(present(sample.vehicle_speed), maximum(sample.vehicle_speed, self.slowest), self.slowest)
        if not self.filter.model.steering:
            angle = where(present(sample.road_wheel_angle), sample.road_wheel_angle, 0.0)
            return self.filter.model.Input(speed, along, angle), 0.0
        known = present(sample.road_wheel_torque)
        torque = where(known, sample.road_wheel_torque, 0.0)
        return self.filter.model.Input(speed, along, torque, where(known, 1.0, 0.0)), where(known, 0.0, 1.0)

    def _process_noise(self, state: CombinedState, inputs: Tree, running: Scalar, free: Scalar) -> tuple[Scalar, ...]:
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
        sample_time: Scalar = self.filter.parameters.sample_time
        share = sample_time / (time + sample_time)
        return where(present(value), before + share * (where(present(value), value, before) - before), before)


# Share by which the data must have reduced the prior variance of an unknown for it to count as identified [-]; its
# standard deviation is then half of the prior one, or less.
IDENTIFIED = 0.75
NAMED = 0.35  # component of an unknown in a unit direction from which the direction is named after it [-]

WORDS = {
    "log_front_stiffness": "front stiffness",
    "log_rear_stiffness": "rear stiffness",
    "log_friction": "friction of the tyres",
    "bank_angle": "bank",
    "side_force": "side force",
    "side_moment": "yaw moment of the wind",
    "lateral_acceleration_bias": "bias of the lateral acceleration",
    "yaw_rate_bias": "bias of the yaw rate",
    "road_wheel_angle_offset": "offset of the road-wheel angle",
    "log_steering_friction": "friction of the steering",
    "log_trail": "pneumatic trail",
}
"""Names of the unknowns in findings."""


@dataclass(frozen=True)
class Identifiability:
    """Identifiability of the unknowns from the data of a drive."""

    shares: Mapping[str, float]  # share by which the data reduced the prior variance, by unknown, 0 to 1
    direction: Mapping[str, float]  # components of the least identified direction, each unknown scaled by its prior
    left: float  # share of the prior variance that remains in that direction

    @property
    def identified(self) -> tuple[str, ...]:
        """Unknowns that the data identify."""
        return tuple(name for name, share in self.shares.items() if share >= IDENTIFIED)

    @property
    def least(self) -> str:
        """The least identified direction, in words: "side force - yaw moment of the wind"."""
        parts = {name: part for name, part in self.direction.items() if abs(part) >= NAMED}
        first = next(iter(parts.values()))
        named = [f"{'+' if part * first > 0.0 else '-'} {WORDS[name]}" for name, part in parts.items()]
        return " ".join(named).removeprefix("+ ")

    def __str__(self) -> str:
        known = [f"{WORDS[name]} ({share:.0%})" for name, share in self.shares.items() if name in self.identified]
        text = f"The drive identifies {', '.join(known)}." if known else "The drive identifies none of the unknowns."
        if self.left <= 1.0 - IDENTIFIED:
            return text
        return f"{text} It identifies least: {self.least} ({self.left:.0%} of the prior variance is left)."


def identifiability(estimator: CombinedSideslip, state: CombinedState | Memory) -> Identifiability:
    """Identifiability of the unknowns up to a state.

    An eigenvalue near one of the covariance, scaled by the priors, belongs to a direction that the data do not
    identify; parameters may each be identified and yet not be separable, or be separable and yet not identified.
    """
    reached: CombinedState = rebuild(estimator.init(), state.values.tolist()) if isinstance(state, Memory) else state
    count = len(estimator.filter.model.unknowns)
    covariance = np.asarray(unpack(reached.belief.covariance))[-count:, -count:]
    prior = np.sqrt(np.asarray(estimator.filter.initial_variance[-count:]))
    scaled = covariance / np.outer(prior, prior)
    values, vectors = np.linalg.eigh(scaled)
    names = estimator.filter.model.unknowns
    shares = np.clip(1.0 - np.diag(scaled), 0.0, 1.0)
    return Identifiability(
        dict(zip(names, shares.tolist(), strict=True)),
        dict(zip(names, vectors[:, -1].tolist(), strict=True)),
        float(min(values[-1], 1.0)),
    )
