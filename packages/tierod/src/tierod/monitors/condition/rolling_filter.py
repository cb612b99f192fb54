"""Filter of a fault hypothesis for a car without known torques: it leaves out the suspected sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import hypot, inf
from math import sqrt as sqrt_of
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar, skeleton
from tierod.core.graph.maths import absolute, both, either, maximum, minimum, present, where
from tierod.core.graph.trace import jacobian
from tierod.core.signals import residue_of
from tierod.methods.estimators.kernels import from_diagonal, predict_covariance
from tierod.models.single_track import LEAST_SPEED, RollingCar
from tierod.monitors.condition.filter_updates import observed
from tierod.monitors.condition.signals import (
    ACCELERATIONS,
    ALL_WHEELS,
    OF_CARS,
    ConditionSample,
    Elements,
    Hypothesis,
    Readings,
)
from tierod.monitors.condition.vehicle_filter import PLAUSIBLE, TRUSTED, LeaveOutFilter
from tierod.physics.friction import gauss_markov_noise, share_reached
from tierod.physics.motion import understeer_gradient
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import bound_distance, hold_spread, with_spread

UNIFORM = 1.0 / 12.0  # variance of a rounding error, uniform over one step, over the square of the step


class SmallestSteps(NamedTuple):
    """Last reading of every sensor, and its smallest change so far.

    The steps of a sensor on a bus may be ten times its noise, and a vehicle file need not give them.
    """

    last: tuple[Scalar, ...]  # last readings; a missing reading keeps the previous one
    smallest: tuple[Scalar, ...]  # smallest changes above the rounding residue [units of the readings]

    @classmethod
    def unseen(cls, coarsest: Sequence[float]) -> SmallestSteps:
        return cls((0.0,) * len(coarsest), tuple(coarsest))

    def after(self, readings: Sequence[Scalar], residues: Sequence[float]) -> SmallestSteps:
        here = [present(each) for each in readings]
        changes = [
            absolute(where(there, each, before) - before)
            for there, each, before in zip(here, readings, self.last, strict=True)
        ]
        return SmallestSteps(
            tuple(where(there, each, before) for there, each, before in zip(here, readings, self.last, strict=True)),
            tuple(
                where(both(there, change > residue), minimum(change, least), least)
                for there, change, least, residue in zip(here, changes, self.smallest, residues, strict=True)
            ),
        )

    @property
    def variances(self) -> tuple[Scalar, ...]:
        return tuple(UNIFORM * each * each for each in self.smallest)


SLIPPERIEST = 2.0
"""Lateral acceleration that every road permits [m/s**2], even packed snow; a motion that needs less does not slide."""

GUESSED_SHARE = 0.25
"""Error of the needed lateral acceleration by guessed steering ratio and understeer, as a share of it [-]."""
ACROSS_SHARE, YAW_SHARE = 0.5, 0.3
"""Shares of the rear axle's deviation that count [-]; the rest may come from banked roads, and from the turn-in of slow
cars."""
LAG, FOLLOWS = 0.1, 12.0
"""Lag of a car behind its steering wheel [s], and speed up to which it applies [m/s]; at higher speed, a slide that
changes sides passes through small accelerations for longer."""
QUICK = 2.5  # steering wheel rate from which a car lags behind its steering wheel [rad/s]
FASTEST = 25.0  # steering wheel rate that no driver reaches [rad/s]; a reading that jumps faster is wrong
SMOOTHING = 0.05  # time constant of the low-pass filter of that rate [s]


FORGOTTEN = 5.0
"""Time constant with which a jump of the reading is forgotten [s]; a persistent fault is declared by then."""


class Hands(NamedTuple):
    """Steering angle and rate as the driver's hands produce them, without jumps of the reading."""

    angle: Annotated[Scalar, "rad"]  # last reading; infinite before the first
    rate: Annotated[Scalar, "rad/s"]  # low-pass filtered rate
    jumped: Annotated[Scalar, "rad"]  # sum of recent jumps of the reading, faster than a driver can steer
    waited: Annotated[Scalar, "s"]  # time since the last reading

    def after(self, reading: Scalar, sample_time: float) -> Hands:
        """State after one sample; a missing reading leaves angle and rate as they are."""
        # Before the first reading the angle is infinite, so that the change is not finite and no jump.
        change = reading - self.angle
        waited = self.waited + sample_time
        rate = where(present(change), change / waited, self.rate)
        smooth = self.rate + share_reached(sample_time / SMOOTHING) * (rate - self.rate)
        jumps = both(present(change), absolute(rate) > FASTEST)
        kept = self.jumped * (1.0 - share_reached(sample_time / FORGOTTEN))
        return Hands(
            where(present(reading), reading, self.angle),
            where(jumps, 0.0, smooth),
            kept + where(jumps, change, 0.0),
            where(present(reading), 0.0, waited),
        )


def lacking(state: RollingCar.State, p: RollingCar.Parameters, hands: Hands) -> Scalar:
    """Lateral acceleration by which the motion deviates from that with gripping tyres [m/s**2]; 0 if none slides.

    The front axle slides if the car turns less than it is steered, or in the opposite direction. The rear axle slides
    if the lateral acceleration is not that of the turn, or if the yaw rate changes fast. A car that steadily turns more
    than it is steered has a wrong steering angle instead, and so has one whose angle has jumped.
    """
    wheelbase = p.front_distance + p.rear_distance
    gradient = understeer_gradient(
        p.mass, p.front_distance, p.rear_distance, p.front_cornering_stiffness, p.rear_cornering_stiffness
    )
    speed = maximum(state.speed, LEAST_SPEED)
    per_angle = p.steering_ratio * speed * speed / (wheelbase + maximum(gradient, 0.0) * speed * speed)
    has = speed * state.yaw_rate
    more = per_angle * (state.steering_error - hands.jumped)
    asked = has + more
    needs = maximum(absolute(asked), absolute(has))
    front = where(asked * more > 0.0, absolute(more) - GUESSED_SHARE * needs, 0.0)
    # Sliding tyres still give what every road permits; with less the car lags its steering, or the angle is wrong.
    late = minimum(front, absolute(per_angle * hands.rate) * LAG)
    front = where(either(absolute(has) > 0.5 * SLIPPERIEST, speed > FOLLOWS), front, late)
    yaw = wheelbase * absolute(state.yaw_acceleration)
    rear = maximum(ACROSS_SHARE * absolute(state.bank_acceleration), YAW_SHARE * yaw)
    quick = absolute(hands.rate) > QUICK
    return where(either(needs > SLIPPERIEST, quick), maximum(front, rear), 0.0)


LIMITS = RollingCar.State(80.0, 15.0, 3.0, 10.0, 4.0, 0.1, 0.5, 0.04, 0.2, 0.04, 0.04, 0.5, 0.5, 3.0, 3.0, 0.5, 0.02)
"""Bounds of the state estimates; a faulty sensor then cannot drive a filter to infinity."""


SLOWEST = 0.1  # speed below which the steering angle is hardly used [m/s]


@dataclass(frozen=True)
class RollingError:
    """Standard deviations of the model error."""

    jerk: Annotated[float, "m/s**2.5"] = 6.0  # random walk of the longitudinal acceleration, brakes included
    # yaw acceleration times speed; occupants accept only so much of it, so that fast cars turn in slowly
    lateral_jerk: Annotated[float, "m/s**3"] = 2.0
    # steering, steering_share: error of the angle of a steady turn: at small angles, and its growth with the angle
    steering: Annotated[float, "rad"] = 0.01
    steering_share: Annotated[float, ""] = 0.04
    # yaw_rate_offset, angle_offset, wheel_speed_difference: offsets of a car whose file does not give them
    yaw_rate_offset: Annotated[float, "rad/s"] = 0.01
    angle_offset: Annotated[float, "rad"] = 0.06
    wheel_speed_difference: Annotated[float, ""] = 0.003
    track_width: Annotated[float, ""] = 0.04  # relative error of the track width
    front_wheel_speed_scale: Annotated[float, ""] = 0.02  # relative difference of the tyre radii of both axles
    slip: Annotated[float, ""] = 0.002  # slip, slip_share: slip of an axle at no acceleration, and its growth with it
    slip_share: Annotated[float, "s**2/m"] = 0.01
    # growth of that slip with the square of wheelbase over radius; front wheels do not roll exactly in the direction in
    # which they point
    slip_in_bends: Annotated[float, ""] = 0.1
    # difference of slip between the wheels of an axle, per acceleration
    uneven_slip: Annotated[float, "s**2/m"] = 0.001
    uneven: Annotated[float, ""] = 0.0  # difference of speed between them, as a share of the speed
    grade: Annotated[float, "m/s**2"] = 0.4  # grade, bank: accelerations by grade and bank of the road
    bank: Annotated[float, "m/s**2"] = 0.4
    # error of the steer of the road wheels at 1 m/s by scrub; it falls with the square of the speed
    walking: Annotated[float, "rad"] = 0.01
    building_up: Annotated[float, "m"] = 0.2  # error of the distance over which tyres build up the force of a turn
    steering_scale: Annotated[float, ""] = 0.01  # relative error of steering ratio over wheelbase in the vehicle file
    understeer: Annotated[float, "rad*s**2/m"] = 2e-4  # error of the understeer gradient of the vehicle file


NOISE = RollingCar.Output(
    **dict.fromkeys(ALL_WHEELS, 0.07),
    yaw_rate=0.002,
    steering_wheel_angle=0.01,
    **dict.fromkeys(ACCELERATIONS, 0.3),
)
"""Standard deviation of one reading in production cars; rough roads add to the noise that data sheets give."""


COARSEST = RollingCar.Output(
    **dict.fromkeys(ALL_WHEELS, 0.28),
    yaw_rate=0.03,
    steering_wheel_angle=0.05,
    **dict.fromkeys(ACCELERATIONS, 0.2),
)
"""Quantisation step of each sensor that is assumed until its readings have shown a smaller one."""

GUESSED = 3.0  # bound of the states for errors of the vehicle file, in their standard deviations [-]

OF_SCALE, OF_UNDERSTEER = 0.15, 0.3
"""Shares of the spread of a vehicle file that the states of the filter take [-]. Without the yaw rate a scale is hardly
observable: with the whole spread, the filter that leaves it out predicts the yaw rate of a passenger car in tight bends
with an error of 0.046 rad/s in place of 0.015 rad/s. `steering_share` and the limits cover the rest."""

DISTANCES = ("front_distance", "rear_distance")
HANDLING = ("mass", *DISTANCES, "front_cornering_stiffness", "rear_cornering_stiffness")
"""Parameters of the understeer gradient, in the order of its arguments."""

OFFSETS = {
    "yaw_rate_offset": "yaw_rate_offset",
    "angle_offset": "steering_wheel_angle_offset",
    "wheel_speed_difference": "wheel_speed_difference",
}
"""Field of `RollingError` -> parameter of the vehicle file whose standard deviation replaces its default."""
LEAST = {"yaw_rate_offset": 0.002, "angle_offset": 0.01, "wheel_speed_difference": 0.001}
"""Least standard deviations of these offsets, which change between drives with temperature, tyres and load [units of
`RollingError`]."""


def model_error_of(vehicle: Vehicle) -> RollingError:
    """Model errors from the uncertainty of a vehicle file: offsets, steering ratio, distances, understeer gradient."""
    # The errors below contain distances, ratio, stiffness and offsets; other parameters matter less than the defaults.
    hold_spread(vehicle, vehicle.parameters)
    car = with_spread(vehicle)[0]
    known = car.parameters

    def spread(name: str) -> float:
        return known[name].standard_deviation or 0.0 if name in known else 0.0

    usual, wheelbase = RollingError(), sum(known[name].value for name in DISTANCES)
    offsets = {of: max(spread(name), LEAST[of]) for of, name in OFFSETS.items() if name in known}
    of_wheelbase = ("wheelbase",) if bound_distance(car) else DISTANCES
    of_distances = hypot(*map(spread, of_wheelbase)) / wheelbase
    scale = hypot(spread("steering_ratio") / known["steering_ratio"].value, of_distances, spread("wheel_speed_scale"))
    values = [known[name].value for name in HANDLING]
    spreads = np.diag([spread(name) for name in HANDLING])
    nominal = understeer_gradient(*values)
    moved = (understeer_gradient(*(values + each)) for each in spreads)
    return replace(
        usual,
        **offsets,
        steering_scale=max(usual.steering_scale, OF_SCALE * scale),
        understeer=max(usual.understeer, OF_UNDERSTEER * hypot(*(float(each - nominal) for each in moved))),
    )


@dataclass(frozen=True)
class RollingFilter:
    """Extended Kalman filter of a rolling car that leaves out the suspects, interchangeable with `LeaveOutFilter`."""

    vehicle: RollingCar.Parameters  # parameters of `RollingCar`
    # sensor_noise, model_error: standard deviations of the readings, and of the model
    sensor_noise: RollingCar.Output = NOISE
    model_error: RollingError = field(default_factory=RollingError)
    plausible: Readings = PLAUSIBLE  # widths of the ranges in which failed sensors may read
    # bound of a normalised innovation, in standard deviations, for the correction and for the likelihood
    influence: Annotated[float, ""] = 8.0
    # duration of the transient after the start; offsets are estimated in it, and readings do not count for hypotheses
    settling: Annotated[float, "s"] = 1.0
    slowest: Annotated[float, "m/s"] = 1.5  # speed from which the car counts as moving
    braking: Annotated[float, "m/s**2"] = 6.0  # deceleration from which brakes may lock the wheels
    trusted: Elements = TRUSTED  # 1, or 0 for a sensor that is left out; only those of `OF_CARS` are used

    Sample = ConditionSample
    Output = LeaveOutFilter.Output

    class State(NamedTuple):
        """Mean, packed covariance, time since the start [s], resolution of the sensors, and steering wheel motion."""

        mean: RollingCar.State
        covariance: tuple[Scalar, ...]
        age: Scalar
        steps: SmallestSteps
        hands: Hands

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sample_time: float = 0.01) -> RollingFilter:
        parameters = replace(vehicle.parameters_for(RollingCar.Parameters), sample_time=sample_time)
        known = vehicle.parameters
        step = known["yaw_rate_resolution"].value if "yaw_rate_resolution" in known else 0.0
        noise = NOISE._replace(yaw_rate=hypot(NOISE.yaw_rate, step / sqrt_of(12.0)))
        return cls(parameters, noise, model_error_of(vehicle))

    def init(self) -> State:
        error = self.model_error
        difference = error.wheel_speed_difference
        offsets = (error.yaw_rate_offset, error.angle_offset, difference, error.track_width)
        front = (error.front_wheel_speed_scale, difference)
        turning = (0.5, error.lateral_jerk / LEAST_SPEED, error.steering)
        slopes, guessed = (error.grade, error.bank), (error.steering_scale, error.understeer)
        deviations = (20.0, 3.0, *turning, *offsets, *front, error.slip, error.slip, *slopes, *guessed)
        covariance = from_diagonal([value * value for value in deviations])
        at_rest = skeleton(RollingCar.State), tuple(value + 0.0 for value in covariance), 0.0
        return self.State(*at_rest, SmallestSteps.unseen(COARSEST), Hands(inf, 0.0, 0.0, 0.0))

    def step(self, state: State, sample: ConditionSample) -> tuple[State, LeaveOutFilter.Output]:
        p = self.vehicle
        rows = jacobian(lambda at: RollingCar.transition(at, (), p), state.mean)
        covariance = predict_covariance(rows, state.covariance, self._process_noise(state.mean))
        mean = RollingCar.transition(state.mean, (), p)
        expected = RollingCar.output(mean, (), p)
        derivatives = jacobian(lambda at: RollingCar.output(at, (), p), mean)
        readings = [getattr(sample, name) for name in expected._fields]
        steps = state.steps.after(readings, [residue_of(name) for name in expected._fields])
        noise = [each + rounding for each, rounding in zip(self._noise(mean), steps.variances, strict=True)]
        alike = (1.0,) * len(ACCELERATIONS)
        trusted = (*(getattr(self.trusted, name) for name in OF_CARS), *alike)
        usual = [value * value for value in self.sensor_noise]
        seen = observed(covariance, expected, derivatives, readings, noise, usual, trusted, self.influence)
        bounded = RollingCar.State(*seen.moved(mean, self._limits))
        age = minimum(state.age + p.sample_time, self.settling)
        likelihood = seen.log_likelihood((*(getattr(self.plausible, name) for name in OF_CARS), *alike), self.influence)
        along = sample.longitudinal_acceleration
        hands = state.hands.after(sample.steering_wheel_angle, p.sample_time)
        return self.State(bounded, seen.correction.covariance, age, steps, hands), self.Output(
            where(age < self.settling, 0.0, likelihood),
            *seen.of_sensors(OF_CARS),
            0.0,
            1.0,
            bounded.speed,
            p.rear_distance * bounded.yaw_rate,
            where(bounded.speed > self.slowest, 1.0, 0.0),
            where(where(present(along), along, 0.0) < -self.braking, 0.0, 1.0),
            lacking(bounded, p, hands),
            turning=bounded.speed * bounded.yaw_rate,
        )

    @property
    def _limits(self) -> RollingCar.State:
        """Bounds of the state; those for errors of the vehicle file are too tight to absorb a faulty steering angle."""
        error = self.model_error
        return LIMITS._replace(
            steering_scale=GUESSED * error.steering_scale, understeer_error=GUESSED * error.understeer
        )

    def _noise(self, mean: RollingCar.State) -> tuple[Scalar, ...]:
        """Variance of each reading; driven and braked wheels of an axle do not slip equally.

        At walking pace the angle does not give the yaw rate, since tyres scrub and speeds are coarse.
        """
        uneven = self.model_error.uneven_slip * mean.acceleration * mean.speed
        share = self.model_error.uneven * mean.speed
        more = dict.fromkeys(ALL_WHEELS, uneven * uneven + share * share)
        angle = self._unsteady(mean)
        more["steering_wheel_angle"] = angle * angle
        known = self.sensor_noise._asdict()
        return tuple(value * value + more.get(name, 0.0) for name, value in known.items())

    def _unsteady(self, mean: RollingCar.State) -> Scalar:
        """Error of the steering wheel angle that a yaw motion gives, at walking pace and while the yaw rate changes."""
        error, p = self.model_error, self.vehicle
        speed = maximum(absolute(mean.speed), SLOWEST)
        share = self._wheelbase * mean.yaw_rate / maximum(mean.speed, LEAST_SPEED)
        turning = (
            self._wheelbase
            * absolute(mean.yaw_acceleration)
            / (maximum(mean.speed, LEAST_SPEED) * (1.0 + share * share))
        )
        below = maximum(LEAST_SPEED / speed - 1.0, 0.0) * absolute(share)
        return (error.walking / (speed * speed) + error.building_up * turning / speed + below) / p.steering_ratio

    def _process_noise(self, mean: RollingCar.State) -> RollingCar.State:
        error, wander, step = self.model_error, self.vehicle.wander, self.vehicle.sample_time

        def gained(deviation: Scalar, time: Scalar) -> Scalar:
            return gauss_markov_noise(deviation, time, step)

        steady = RollingCar.output(mean, (), self.vehicle).steering_wheel_angle - mean.steering_error
        steering = error.steering + error.steering_share * absolute(steady)
        bend = minimum(absolute(self._wheelbase * mean.yaw_rate) / maximum(mean.speed, LEAST_SPEED), 1.0)
        slip = error.slip + error.slip_share * absolute(mean.acceleration) + error.slip_in_bends * bend * bend
        return RollingCar.State(
            speed=0.0,
            acceleration=error.jerk * error.jerk * step,
            yaw_rate=0.0,
            yaw_acceleration=gained(error.lateral_jerk / maximum(mean.speed, LEAST_SPEED), wander.turning),
            steering_error=gained(steering, wander.steering),
            yaw_rate_offset=gained(error.yaw_rate_offset, wander.offset),
            angle_offset=gained(error.angle_offset, wander.offset),
            wheel_speed_difference=gained(error.wheel_speed_difference, wander.offset),
            track_width_error=gained(error.track_width, wander.offset),
            front_wheel_speed_scale=gained(error.front_wheel_speed_scale, wander.offset),
            front_wheel_speed_difference=gained(error.wheel_speed_difference, wander.offset),
            rear_slip=gained(slip, wander.slip),
            front_slip=gained(slip, wander.slip),
            grade_acceleration=gained(error.grade, wander.road),
            bank_acceleration=gained(error.bank, wander.road),
            steering_scale=gained(error.steering_scale, wander.offset),
            understeer_error=gained(error.understeer, wander.offset),
        )

    @property
    def _wheelbase(self) -> Scalar:
        return self.vehicle.front_distance + self.vehicle.rear_distance

    def leaving_out(self, hypothesis: Hypothesis) -> RollingFilter:
        return replace(self, trusted=self.trusted._replace(**dict.fromkeys(hypothesis.suspects, 0.0)))
