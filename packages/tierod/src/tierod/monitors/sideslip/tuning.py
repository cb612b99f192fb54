"""Tuning of the combined sideslip estimator for a car: unknowns, noises, limit of grip, and the filter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Annotated, Any, NamedTuple, TypeVar

import numpy as np

from tierod.core.block import Scalar, Tree
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import absolute, all_of, both, exp, limit, log, maximum, present, sqrt, where
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.lateral_motion import OF_STEERING, UNKNOWNS, LateralParameters, Sampled, lateral_motion
from tierod.physics.friction import gauss_markov_noise
from tierod.physics.motion import GRAVITY
from tierod.vehicles.classes import held_deviation
from tierod.vehicles.vehicle import Vehicle

# Floor of the expected variance, which keeps the ratio finite for a filter without noise, in the squared unit of the
# reading.
LEAST_VARIANCE = 1e-18


class ScaleState(NamedTuple):
    """Low-passed innovation, and the natural logarithm of the scale."""

    innovation: Annotated[Scalar, ""]
    logarithm: Annotated[Scalar, ""]


@dataclass(frozen=True)
class NoiseScale:
    """Adaptive factor of a noise variance, from the innovations of one reading.

    Innovations of a consistent filter are white: their low-pass has the expected variance times share / (2 - share).
    Model errors last longer than a sample, so that the low-pass has more. The scale rises while it has more and falls
    while it has less, until the larger noise makes the innovations white. It rises faster than it falls, so that it
    settles on the cautious side: with the default times where the filter expects 2.6 times the observed variance. It
    never falls below one: the given noise is the minimum.

    Args:
        memory: time constant of the low-pass; shorter errors count as noise
        rise, fall: times in which the logarithm rises and falls by one
        most: largest relative excess that counts in one sample

    Valid for a reading with white noise; errors slower than the filter's own unknowns are left to those.
    Source: whiteness of innovations, R. K. Mehra, IEEE Trans. Automatic Control 15 (1970) 175, as a stochastic
    approximation instead of from autocorrelations over a record.
    """

    sample_time: Annotated[float, "s", POSITIVE]
    memory: Annotated[float, "s", POSITIVE] = 0.2
    rise: Annotated[float, "s", POSITIVE] = 1.0
    fall: Annotated[float, "s", POSITIVE] = 10.0
    most: Annotated[float, "", POSITIVE] = 4.0
    greatest: Annotated[float, "", NOT_NEGATIVE] = 9.0

    def init(self) -> ScaleState:
        return ScaleState(0.0, 0.0)

    def scale(self, state: ScaleState) -> Scalar:
        """Factor of the variance."""
        return exp(state.logarithm)

    def after(self, state: ScaleState, innovation: Scalar, variance: Scalar, running: Scalar) -> ScaleState:
        share = self.sample_time / (self.memory + self.sample_time)
        usable = both(running, present(innovation))
        smoothed = state.innovation + share * (where(usable, innovation, 0.0) - state.innovation)
        expected = maximum(variance * share / (2.0 - share), LEAST_VARIANCE)
        excess = limit(smoothed * smoothed / expected - 1.0, -1.0, self.most)
        moved = state.logarithm + self.sample_time * excess / where(excess > 0.0, self.rise, self.fall)
        return ScaleState(
            where(usable, smoothed, state.innovation), where(usable, limit(moved, 0.0, self.greatest), state.logarithm)
        )


BAND = 1.96  # standard deviations that contain 95 % of a Gaussian error

Share = TypeVar("Share", Scalar, np.ndarray)


@dataclass(frozen=True)
class GripLimit:
    """Least speed, turn and force of a car whose front axle nears its largest force.

    Slip alone shows no limit. Over a rolling speed near zero it says nothing of the force, and in a tight turn it is
    the small difference of two large angles. Beside a wrong steering angle, whatever its fault, it is wrong as well.
    """

    # speed from which the slip of a tyre says something of its force; at 3 m/s it builds up within 0.1 s
    slowest: Annotated[float, "m/s", POSITIVE] = 3.0
    # least lateral acceleration by speed and yaw rate; polished ice has a friction of 0.1
    acceleration: Annotated[float, "m/s**2", POSITIVE] = 1.0
    # share of its largest force that the axle uses at the lower end of the 95 % band; with less an announcement counts
    # as false
    force: Annotated[float, "", POSITIVE] = 0.6
    # largest factor of the yaw rate's noise by which its innovations are explained; with more the steering angle
    # predicts another yaw rate than the measured one. Virtual cars that slide reach 150, also where they are known by
    # class only; an angle held at 10 Hz, or wrong by a third or by 15 degrees, makes more than 1000
    agreeing: Annotated[float, "", POSITIVE] = 200.0
    # road-wheel angle from which that share must show in the lateral acceleration, on a road as in the vehicle file;
    # steering ratio and Ackermann's difference are wrong by some % of the angle, a degree and more there
    tight: Annotated[float, "rad", POSITIVE] = 0.35

    def shown(
        self, estimate: Mapping[str, Scalar], speed: Scalar, road_wheel_angle: Scalar, usual: Scalar, yaw_noise: Scalar
    ) -> Scalar:
        """Whether force and turn of the car are near the limit, and the steering angle fits the yaw rate."""
        across = absolute(speed * estimate["corrected_yaw_rate"])
        tight = limit(absolute(road_wheel_angle) / self.tight, 0.0, 1.0)
        needed = self.acceleration + tight * maximum(self.force * usual - self.acceleration, 0.0)
        forced = self.forced(estimate["front_friction_used"], estimate["front_friction_used_deviation"])
        shown: Scalar = all_of(speed > self.slowest, across > needed, forced, yaw_noise < self.agreeing)
        return shown

    def forced(self, used: Share, deviation: Share) -> Share:
        """Whether the axle uses enough of its largest force; never where the deviation is NaN."""
        return used - BAND * deviation > self.force


BY_WIRE = "gearhead_ratio"  # a vehicle file that gives this parameter describes a car steered by wire


@dataclass(frozen=True)
class Wandering:
    """An unknown as a first-order Gauss-Markov process about its usual value."""

    # Stationary standard deviation, which is also the prior, in the unit of the unknown.
    deviation: Annotated[float, "", POSITIVE]
    # Correlation time, in which it returns to its usual value without information from the data.
    time: Annotated[float, "s", POSITIVE]
    usual: Annotated[float, ""] = 0.0  # mean of the process, in the unit of the unknown

    def fading(self, sample_time: float) -> float:
        """Factor by which the deviation from the usual value decays in a sample."""
        return math.exp(-sample_time / self.time)

    def noise(self, sample_time: float) -> float:
        """Process noise variance per sample that keeps the stationary standard deviation."""
        return float(gauss_markov_noise(self.deviation, self.time, sample_time))


@dataclass(frozen=True)
class Noises:
    """Process noise (standard deviation after one second) and sensor noise (of one reading)."""

    # Effect of unmodelled forces. Small, since inflated noise biases the stiffness.
    lateral_speed: Annotated[float, "m/s**1.5", NOT_NEGATIVE] = 0.02
    yaw_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 0.005
    roll_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 0.002  # effect of unmodelled roll moments
    # Effect of unmodelled torques at the road wheels.
    road_wheel_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 1.4
    # The same where the actuator's torque is unknown.
    free_road_wheel_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 2.0
    # Standard deviations of the sensors.
    yaw_rate_reading: Annotated[float, "rad/s", POSITIVE] = 0.003
    lateral_acceleration_reading: Annotated[float, "m/s**2", POSITIVE] = 0.15
    road_wheel_angle_reading: Annotated[float, "rad", POSITIVE] = 3e-4
    # Growth while the estimate is held.
    held_lateral_speed: Annotated[float, "m/s**1.5", NOT_NEGATIVE] = 0.3
    held_yaw_rate: Annotated[float, "rad/s**1.5", NOT_NEGATIVE] = 0.1
    held_road_wheel_angle: Annotated[float, "rad/s**0.5", NOT_NEGATIVE] = 0.1


@dataclass(frozen=True)
class CombinedTuning:
    """Unknowns that the estimator estimates together with the motion (None: not estimated), and its noises."""

    # Wrong by a fifth at first, and changing over an hour.
    log_front_stiffness: Wandering | None = field(default_factory=lambda: Wandering(0.2, 3600.0))
    log_rear_stiffness: Wandering | None = field(default_factory=lambda: Wandering(0.2, 3600.0))
    # Friction of both axles. It returns to the usual value: as a random walk it diverges where tyres are not used, and
    # with a return within 30 s, which takes eight times the noise, gentle bends on a dry road look like ice.
    log_friction: Wandering | None = field(default_factory=lambda: Wandering(0.6, 240.0))
    bank_angle: Wandering | None = field(default_factory=lambda: Wandering(0.03, 10.0))  # bank of the road
    # Force of wind at the centre of gravity, and moment about it.
    side_force: Wandering | None = field(default_factory=lambda: Wandering(100.0, 60.0))
    side_moment: Wandering | None = field(default_factory=lambda: Wandering(50.0, 60.0))
    # Constant errors of the sensors.
    lateral_acceleration_bias: Wandering | None = None
    yaw_rate_bias: Wandering | None = None
    road_wheel_angle_offset: Wandering | None = None
    # Friction and trail of the steering, where its torque is known.
    log_steering_friction: Wandering | None = field(default_factory=lambda: Wandering(0.4, 3600.0))
    log_trail: Wandering | None = field(default_factory=lambda: Wandering(0.25, 3600.0))
    roll: bool = True  # whether the body's roll is a state
    # Process and sensor noise; those of yaw rate (process) and lateral acceleration (sensor) are minima, see
    # `NoiseScale`.
    noises: Noises = field(default_factory=Noises)
    # Largest logarithm of those scales; zero keeps the noises as given.
    yaw_adaptation: Annotated[float, "", NOT_NEGATIVE] = 0.0
    acceleration_adaptation: Annotated[float, "", NOT_NEGATIVE] = 0.0
    # Relative error of the steering ratio; the noise of the angle's offset grows with this share of the angle.
    ratio_error: Annotated[float, "", NOT_NEGATIVE] = 0.0
    # Relative error of the rear slip angle that no state of the model describes.
    slip_error: Annotated[float, "", NOT_NEGATIVE] = 0.0
    # Error of the sideslip angle itself that no state describes.
    constant_error: Annotated[float, "rad", NOT_NEGATIVE] = 0.0
    slowest: Annotated[float, "m/s", POSITIVE] = 0.5  # speed below which the last estimate is held
    # Share of the greatest front force from which the limit of grip is announced.
    limit_share: Annotated[float, "", POSITIVE] = 0.7
    limit_certainty: Annotated[float, "", POSITIVE] = 1.0  # standard deviations by which the share must exceed it
    # What shows that the front axle nears its largest force, beside its slip.
    limit: GripLimit = field(default_factory=GripLimit)
    # Mean squared innovation over its variance, per reading, above which the filter restarts; a correct model has 1,
    # one as wrong as those of real cars 2.
    most_misfit: Annotated[float, "", POSITIVE] = 4.0

    def followed(self, steering: bool) -> dict[str, Wandering]:
        """The unknowns that are states, in the order of `UNKNOWNS`; those of the steering only where it is a state."""
        given = {each.name: getattr(self, each.name) for each in fields(self)}
        wanted = {name: given[name] for name in UNKNOWNS if steering or name not in OF_STEERING}
        return {name: each for name, each in wanted.items() if each is not None}


def per_sample(growth: float, sample_time: float) -> float:
    """Variance per sample of a random walk with this standard deviation after one second."""
    return growth * growth * sample_time


USUAL = CombinedTuning()

USUAL_TIME = 60.0  # correlation time of an unknown where neither the file nor the default tuning gives one [s]
WIND_ARM = 0.5  # distance of the wind's force from the centre of gravity [m]; typical of passenger cars
# Logarithm of the cornering stiffness of tyres that were not measured: 30 % about a value typical of the load, changing
# within minutes as tyres heat and cool. A standard deviation in the vehicle file replaces the 30 %.
UNKNOWN_TYRES = Wandering(0.3, 300.0)
TYRES_KNOWN = (0.05, 0.5)  # least and greatest standard deviation of that logarithm that is taken from a file
# Largest logarithm of the scale of the yaw rate's noise [-]; at 55 times the usual drift the filter follows the
# gyroscope, and unmodelled forces and moments no longer disturb the estimated stiffness.
YAW_ADAPTATION = 8.0
# Largest logarithm of the scale of the accelerometer's noise [-]; 33 times the usual noise, 5 m/s**2 per reading.
ACCELERATION_ADAPTATION = 7.0
# Relative error of a constant steering ratio [-]; variable-ratio racks and Cardan joints change it by some %.
RATIO_ERROR = 0.03
# Relative error of the slip angle of a tyre of known stiffness [-]; camber, load transfer, drive force, heat.
SLIP_ERROR = 0.1
# Error of the sideslip angle of a car without calibration [rad]; axles not parallel, sensors not aligned with the body.
# Measured between a race car and its inertial navigation system.
CONSTANT_ERROR = 0.0025
# Error of a road wheels' angle that is computed from the steering wheel [rad]: the torsion bar twists, the steering
# yields, the ratio is not constant. Taken as exact, an angle that is off by 0.04 degrees halves the stiffness that is
# estimated on a country road. Chosen on three virtual drives; on three others the error is 0.2 to 0.4 of that.
THROUGH_A_COLUMN = Wandering(0.001, 3.0)
# Offset and misalignment (half a degree) of a production car's accelerometer [m/s2], which vary with temperature.
LATERAL_ACCELERATION = Wandering(0.1, 600.0)
# Offset of a production car's yaw rate [rad/s] after calibration at standstill, a tenth of a degree per second. Either
# of the two unknowns alone makes the estimate worse: the error of the other sensor is then attributed to it.
YAW_RATE = Wandering(0.002, 600.0)


@dataclass(frozen=True)
class VehicleTuning:
    """Noises and Gauss-Markov processes as a vehicle file names them; elsewhere those of `CombinedTuning` apply.

    A wander of zero leaves its unknown out.
    """

    # Noise of one reading, including vibration at the sensor.
    yaw_rate_noise: Annotated[float, "rad/s"] = USUAL.noises.yaw_rate_reading
    lateral_acceleration_noise: Annotated[float, "m/s**2"] = USUAL.noises.lateral_acceleration_reading
    # Growth of the error that the tyre model leaves.
    lateral_speed_drift: Annotated[float, "m/s**1.5"] = USUAL.noises.lateral_speed
    yaw_rate_drift: Annotated[float, "rad/s**1.5"] = USUAL.noises.yaw_rate
    # Process of the cornering stiffness of both axles, relative.
    stiffness_wander: Annotated[float, ""] | None = None
    stiffness_wander_time: Annotated[float, "s"] | None = None
    friction_wander: Annotated[float, ""] | None = None  # process of the tyres' friction, relative
    # Process of the road's bank.
    bank_wander: Annotated[float, "rad"] | None = None
    bank_wander_time: Annotated[float, "s"] | None = None
    # Process of the lateral force; that of its moment is `WIND_ARM` times as large.
    wind_wander: Annotated[float, "N"] | None = None
    # Bias of the sensor. Without it in the file the bias is `LATERAL_ACCELERATION` and that of the yaw rate `YAW_RATE`;
    # neither in a car steered by wire, whose sensors are those of a test car.
    lateral_acceleration_wander: Annotated[float, "m/s**2"] | None = None
    lateral_acceleration_wander_time: Annotated[float, "s"] | None = None
    # Error of the angle; by default `THROUGH_A_COLUMN`, and none in a car steered by wire.
    road_wheel_angle_wander: Annotated[float, "rad"] | None = None
    road_wheel_angle_wander_time: Annotated[float, "s"] | None = None


def tuning_of(vehicle: Vehicle, usual: CombinedTuning = USUAL) -> CombinedTuning:
    """The tuning of the combined estimator for a vehicle."""
    given = vehicle.parameters_for(VehicleTuning)
    stiffness = given.stiffness_wander, given.stiffness_wander_time
    front, rear = usual.log_front_stiffness, usual.log_rear_stiffness
    angle, acceleration, yaw = usual.road_wheel_angle_offset, usual.lateral_acceleration_bias, usual.yaw_rate_bias
    if BY_WIRE not in vehicle:
        if given.stiffness_wander != 0.0:  # zero leaves the stiffness to the parameter spread
            front, rear = (_tyres(vehicle, axle) for axle in ("front", "rear"))
        angle = angle or THROUGH_A_COLUMN
        if given.lateral_acceleration_wander is None:
            acceleration, yaw = acceleration or LATERAL_ACCELERATION, yaw or YAW_RATE
    return replace(
        _guarded(vehicle, usual),
        log_front_stiffness=_wandering(front, *stiffness),
        log_rear_stiffness=_wandering(rear, *stiffness),
        log_friction=_wandering(usual.log_friction, given.friction_wander, None),
        bank_angle=_wandering(usual.bank_angle, given.bank_wander, given.bank_wander_time),
        side_force=_wandering(usual.side_force, given.wind_wander, None),
        side_moment=_wandering(
            usual.side_moment, None if given.wind_wander is None else WIND_ARM * given.wind_wander, None
        ),
        lateral_acceleration_bias=_wandering(
            acceleration, given.lateral_acceleration_wander, given.lateral_acceleration_wander_time
        ),
        yaw_rate_bias=yaw,
        road_wheel_angle_offset=_wandering(angle, given.road_wheel_angle_wander, given.road_wheel_angle_wander_time),
        noises=replace(
            usual.noises,
            lateral_speed=given.lateral_speed_drift,
            yaw_rate=given.yaw_rate_drift,
            yaw_rate_reading=given.yaw_rate_noise,
            lateral_acceleration_reading=given.lateral_acceleration_noise,
        ),
    )


def _guarded(vehicle: Vehicle, usual: CombinedTuning) -> CombinedTuning:
    """The tuning with guards for a production car; each is off where the file gives the noise it stands for.

    A car steered by wire is a test car with known sensors and parameters, and has no guards.
    """
    if BY_WIRE in vehicle:
        return usual
    return replace(
        usual,
        yaw_adaptation=0.0 if "yaw_rate_drift" in vehicle else YAW_ADAPTATION,
        acceleration_adaptation=0.0 if "lateral_acceleration_noise" in vehicle else ACCELERATION_ADAPTATION,
        ratio_error=0.0 if "road_wheel_angle_wander" in vehicle else RATIO_ERROR,
        slip_error=0.0 if "lateral_speed_drift" in vehicle else SLIP_ERROR,
        constant_error=0.0 if "lateral_speed_drift" in vehicle else CONSTANT_ERROR,
    )


def _tyres(vehicle: Vehicle, axle: str) -> Wandering:
    """Gauss-Markov process of an axle's stiffness about the value of the file."""
    name = f"{axle}_cornering_stiffness"
    deviation = held_deviation(vehicle, name) if name in vehicle else 0.0
    if not deviation or not vehicle[name] > 0.0:
        return UNKNOWN_TYRES
    least, most = TYRES_KNOWN
    return replace(UNKNOWN_TYRES, deviation=min(max(deviation / vehicle[name], least), most))


def _wandering(usual: Wandering | None, deviation: float | None, time: float | None) -> Wandering | None:
    if deviation == 0.0 or (usual is None and deviation is None):
        return None
    start = usual or Wandering(1.0, USUAL_TIME)
    return replace(
        start, deviation=start.deviation if deviation is None else deviation, time=start.time if time is None else time
    )


START = {
    "lateral_speed": 0.5,
    "yaw_rate": 0.2,
    "front_deflection": 0.02,
    "rear_deflection": 0.02,
    "roll_angle": 0.02,
    "roll_rate": 0.05,
    "road_wheel_angle": 0.3,
    "road_wheel_rate": 0.5,
    "friction_share": 0.7,
}
"""Standard deviation of the motion before the first sample, in the units of the states."""

# Bound on the squared normalised innovation of a reading, and of a jump of the steering angle; the 99.9 % quantile of
# the chi-square distribution with one degree of freedom.
GATE = 10.83
DEFLECTED = 0.03  # growth of the tyres' deflection over that of the lateral speed while the estimate is held [s]
# Bound on the logarithm of a factor, in standard deviations of its prior about its usual value; it stops divergence
# where the linearised filter is overconfident. Never less than one, a factor of e.
FARTHEST = 3.5
NARROWEST = 1.0  # smallest such bound [-, natural logarithm]; no factor of a tyre is known better than to a factor of e


def combined_filter(car: LateralParameters, sample_time: float, tuning: CombinedTuning, steering: bool) -> KalmanFilter:
    """The Kalman filter over the states that the tuning selects."""
    followed = tuning.followed(steering)
    model = lateral_motion(tuple(followed), roll=tuning.roll, steering=steering)
    noises, names = tuning.noises, model.State._fields
    moving = ("lateral_speed", "yaw_rate", "roll_rate", "road_wheel_rate")
    process = {name: per_sample(getattr(noises, name), sample_time) for name in moving}
    process |= {name: each.noise(sample_time) for name, each in followed.items()}
    first = START | {name: each.deviation for name, each in followed.items()}
    return KalmanFilter(
        model,
        Sampled(
            car,
            sample_time,
            usual=tuple(each.usual for each in followed.values()),
            fading=tuple(each.fading(sample_time) for each in followed.values()),
        ),
        initial_mean=tuple(followed[name].usual if name in followed else 0.0 for name in names),
        initial_variance=tuple(first[name] ** 2 for name in names),
        process_noise=tuple(process.get(name, 0.0) for name in names),
        measurement_noise=tuple(getattr(noises, f"{name}_reading") ** 2 for name in model.Output._fields),
        gate=GATE,
    )


def held_growth(model: Any, noises: Noises, sample_time: float) -> tuple[float, ...]:
    """Variance that every state gains per sample while the estimate is held, in the order of the states."""
    moving = ("lateral_speed", "yaw_rate", "road_wheel_angle")
    held = {name: per_sample(getattr(noises, f"held_{name}"), sample_time) for name in moving}
    held |= dict.fromkeys(("front_deflection", "rear_deflection"), held["lateral_speed"] * DEFLECTED * DEFLECTED)
    return tuple(held.get(name, 0.0) for name in model.State._fields)


def bounded(filter: KalmanFilter, mean: Tree, lateral: Scalar) -> Tree:
    """The mean of a belief with every factor held within the bounds of its prior.

    Friction is at least what the lateral acceleration proves, as far as that is below the usual friction."""
    car = filter.parameters.car
    shown = absolute(lateral) / ((1.0 + car.roll_share) * GRAVITY * car.tyre_friction)
    least = log(limit(shown, 1e-3, 1.0))
    kept = []
    for name, value, usual, variance in zip(
        mean._fields, mean, filter.initial_mean, filter.initial_variance, strict=True
    ):
        width = maximum(FARTHEST * sqrt(variance), NARROWEST)
        value = limit(value, usual - width, usual + width) if name.startswith("log_") else value
        kept.append(maximum(value, least) if name == "log_friction" else value)
    return type(mean)(*kept)
