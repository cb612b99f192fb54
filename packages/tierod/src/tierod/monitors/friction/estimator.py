"""The friction estimator: a regression on friction as it builds up; law and Dahl angle are learnt."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import absolute, all_of, exp, limit, log, maximum, minimum, sin, sqrt, where
from tierod.methods.estimators.kernels import add, correct, dot, from_diagonal, product, unpack
from tierod.methods.filters import Butterworth
from tierod.models.steering_column import FrictionParameters
from tierod.monitors.friction.signals import (
    SAMPLE_TIME,
    ConditionedSteering,
    FrictionGate,
    SteeringConditioning,
    SteeringSample,
)
from tierod.monitors.friction.verdict import VerdictSample
from tierod.physics.friction import RELAXED, BuildUp, build_ups
from tierod.physics.motion import front_axle_load
from tierod.physics.steering import (
    column_torque_of_motor,
    force_across_wheels,
    front_force_from_motion,
    longitudinal_force_from_motion,
    road_wheel_angle,
    torque_at_steering_wheel,
    torsion_bar_twist,
    weight_torque,
)
from tierod.physics.tyre import turn_slip, turn_slip_stiffness
from tierod.vehicles import Vehicle


class Coefficients(NamedTuple):
    """Coefficients of the regression; also the shape of one row of it, of its variances and of its process noises."""

    # finite, exponential, long: shares of the friction torque that build up with Dahl exponent 1/2, 1 and 2; their sum
    # is the friction torque [N*m]. One of them may be negative where the true law lies outside the three
    finite: Annotated[Scalar, "N*m"]
    exponential: Annotated[Scalar, "N*m"]
    long: Annotated[Scalar, "N*m"]
    log_dahl_angle: Annotated[Scalar, ""]  # logarithm of their common Dahl angle [rad]
    aligning_gain: Annotated[Scalar, ""]  # factor on the self-aligning torque of the vehicle file
    # change of that factor per torque at the steering wheel, as the pneumatic trail shrinks
    trail_drop: Annotated[Scalar, "1/(N*m)"]
    weight_lever: Annotated[Scalar, "m"]  # lever of the front axle load, which turns the wheels back to straight ahead
    turn_slip: Annotated[Scalar, "m**2"]  # turn slip stiffness of both front tyres over the load of their axle
    # factor on the torque that the whole drive and brake force, at the front axle, would exert on the steered wheels
    # through the trail of the vehicle file
    drive_share: Annotated[Scalar, ""]
    load_share: Annotated[Scalar, ""]  # friction per magnitude of the road torque at the steering wheel
    offset: Annotated[Scalar, "N*m"]  # constant torque: offsets of both torque sensors, pull of the car
    damping: Annotated[Scalar, "N*m*s/rad"]  # viscous damping at the steering wheel axis
    inertia: Annotated[Scalar, "kg*m**2"]  # inertia below the torsion bar, at the steering wheel axis

    @property
    def friction_torque(self) -> Scalar:
        """Level of dry friction [N*m] at the reference load."""
        return self.finite + self.exponential + self.long


PROCESS = Coefficients(
    finite=1.0,
    exponential=1.0,
    long=1.0,
    log_dahl_angle=1e-6,
    aligning_gain=1e-7,
    trail_drop=1e-10,
    weight_lever=1e-10,
    turn_slip=1e-9,
    drive_share=1e-7,
    load_share=1e-8,
    offset=1e-6,
    damping=1e-8,
    inertia=1e-10,
)
"""Variance that each coefficient gains per enabled second; for the three shares of friction, in multiples of
error_density / memory**2 of the tuning."""

DEVIATIONS = Coefficients(
    finite=2.0,
    exponential=5.0,
    long=2.0,
    log_dahl_angle=1.0,
    aligning_gain=0.5,
    trail_drop=0.03,
    weight_lever=0.006,
    turn_slip=0.03,
    drive_share=0.4,
    load_share=0.22,
    offset=1.0,
    damping=0.5,
    inertia=0.1,
)
"""Standard deviation of each coefficient before the first sample."""


@dataclass(frozen=True)
class PreslidingTuning:
    """Noises and priors of the regression."""

    # spectral density of persistent errors of the balance [N**2*m**2*s]; 0.35 N*m over a second
    error_density: Annotated[float, "N**2*m**2*s"] = 0.125
    # duration of such an error [s]; larger innovations widen the reported standard deviation
    error_time: Annotated[float, "s"] = 1.0
    # time constant of the friction torque in enabled time [s]; 10 s halves the delay for 1.3 times the scatter
    memory: Annotated[float, "s"] = 20.0
    # variance gained per enabled second by each coefficient, tuned in simulation; see `PROCESS`
    process: Coefficients = PROCESS
    # standard deviations before the first sample: 2 N*m for the shares of exponent 1/2 and 2 lets another law be learnt
    # within 50 s (simulated); the vehicle's constants by their uncertainty in a vehicle file [assumed]
    deviations: Coefficients = DEVIATIONS
    initial_friction: Annotated[float, "N*m"] = 3.0  # initial estimate of friction [N*m]; 3 as printed by Mohtat et al.
    # initial estimate of the Dahl angle [rad]; 1 degree
    initial_dahl_angle: Annotated[float, "rad"] = math.radians(1.0)
    # smallest_dahl_angle, largest_dahl_angle: bounds of the learnt Dahl angle [rad]; 0.05 and 8 degrees
    smallest_dahl_angle: Annotated[float, "rad"] = math.radians(0.05)
    largest_dahl_angle: Annotated[float, "rad"] = math.radians(8.0)
    # initial lever of the front axle load [m]; kingpins at 12 degrees with a scrub radius of 10 mm give 15 mm, round
    # tyre shoulders reduce it
    initial_weight_lever: Annotated[float, "m"] = 0.012
    # initial turn slip stiffness over load [m**2]; a contact patch 160 mm wide, 25 times as stiff as the load
    initial_turn_slip: Annotated[float, "m**2"] = turn_slip_stiffness(25.0, 0.08)
    # initial share of the drive and brake force [-]: that of brake forces at the front axle
    initial_drive_share: Annotated[float, ""] = 0.7
    # lever of the front axle load that gives the road torque for which friction is stated [m]: a trail of 45 mm at 1.44
    # m/s**2; 4 N*m of a mid-size car. At a torque that never occurs friction would stay uncertain
    reference_lever: Annotated[float, "m"] = 0.0066
    # innovation beyond which its influence no longer grows (Huber) [N*m]; above a step of friction from 4 to 12.5
    outlier: Annotated[float, "N*m"] = 10.0
    # time constant of the excitation in enabled time [s]; equal to that of the friction torque
    excitation_memory: Annotated[float, "s"] = 20.0


class ColumnMotion(NamedTuple):
    """Motion of the column below the torsion bar."""

    angle: Scalar  # column angle [rad]
    increment: Scalar  # change of the angle since the previous sample [rad]
    rate: Scalar  # column rate [rad/s]
    acceleration: Scalar  # column acceleration [rad/s**2]


def column_motion(clean: ConditionedSteering, stiffness: Scalar, sample_time: Any) -> ColumnMotion:
    signals = clean.signals
    twist_rate = torsion_bar_twist(clean.driver_torque_rate, stiffness)
    return ColumnMotion(
        signals.steering_wheel_angle - torsion_bar_twist(signals.driver_torque, stiffness),
        clean.angle_increment - sample_time * twist_rate,
        signals.steering_wheel_rate - twist_rate,
        clean.steering_wheel_acceleration - torsion_bar_twist(clean.driver_torque_acceleration, stiffness),
    )


ROLLING_SPEED = 3.0  # Speed of the vehicle below which tyres scrub, which the balance does not model [m/s]


def reference_load(p: FrictionParameters, lever: Scalar) -> Scalar:
    """Torque of the road at the steering wheel [N*m] for which friction is stated."""
    load = front_axle_load(p.mass, p.front_distance, p.rear_distance)
    return torque_at_steering_wheel(lever * load, p.steering_ratio)


class RoadTorques(NamedTuple):
    """Torques of the road at the steering wheel, each per unit of its coefficient."""

    aligning: Scalar  # lateral force of the front axle times the trail of the vehicle file [N*m]
    weight: Scalar  # torque of the front axle load per lever [N]
    turn_slip: Scalar  # torque per turn slip stiffness over load [N/m]
    drive: Scalar  # drive and brake force of the whole car, as if all at the front axle, times the trail [N*m]


class Regressors(NamedTuple):
    """Terms and torques of the balance that pass the second low-pass."""

    finite: Scalar
    finite_sensitivity: Scalar
    exponential: Scalar
    exponential_sensitivity: Scalar
    long: Scalar
    long_sensitivity: Scalar
    aligning_torque: Scalar
    squared_aligning_torque: Scalar
    weight: Scalar
    turn_slip: Scalar
    drive: Scalar
    loaded_friction: Scalar
    rate: Scalar
    acceleration: Scalar
    torque: Scalar
    driver_torque: Scalar
    motor_torque: Scalar
    steering_wheel_rate: Scalar


def regressors(
    clean: ConditionedSteering,
    column: ColumnMotion,
    laws: tuple[BuildUp, BuildUp, BuildUp],
    mean: Coefficients,
    parameters: FrictionParameters,
    reference_load: Scalar,
) -> Regressors:
    """Both sides of the balance before the low-pass."""
    signals = clean.signals
    road = road_torques(clean, column, parameters)
    finite, exponential, long = laws
    return Regressors(
        *finite,
        *exponential,
        *long,
        aligning_torque=road.aligning,
        squared_aligning_torque=road.aligning * absolute(road.aligning),
        weight=road.weight,
        turn_slip=road.turn_slip,
        drive=road.drive,
        loaded_friction=exponential.level * (absolute(_load(road, mean)) - reference_load),
        rate=column.rate,
        acceleration=column.acceleration,
        torque=signals.driver_torque + column_torque_of_motor(signals.motor_torque, parameters.motor_ratio),
        driver_torque=signals.driver_torque,
        motor_torque=signals.motor_torque,
        steering_wheel_rate=signals.steering_wheel_rate,
    )


def road_torques(clean: ConditionedSteering, column: ColumnMotion, p: FrictionParameters) -> RoadTorques:
    """Torques of tyres and weight at the steering wheel; they oppose a turn to the left."""
    signals = clean.signals
    steer = road_wheel_angle(column.angle, p.steering_ratio)
    across = front_force_from_motion(
        signals.lateral_acceleration,
        clean.yaw_acceleration,
        mass=p.mass,
        yaw_inertia=p.yaw_inertia,
        front_distance=p.front_distance,
        rear_distance=p.rear_distance,
    )
    along = longitudinal_force_from_motion(
        clean.vehicle_acceleration, signals.yaw_rate, mass=p.mass, rear_distance=p.rear_distance
    )
    load = front_axle_load(p.mass, p.front_distance, p.rear_distance)
    turning = road_wheel_angle(column.rate, p.steering_ratio) + signals.yaw_rate
    about_kingpins = RoadTorques(
        aligning=p.trail * force_across_wheels(across, 0.0, steer),
        weight=weight_torque(load, 1.0, sin(steer)),
        # The speed is bounded below, or the turn slip would be infinite at rest.
        turn_slip=load * turn_slip(turning, maximum(signals.vehicle_speed, ROLLING_SPEED)),
        drive=p.trail * force_across_wheels(0.0, along, steer),
    )
    return RoadTorques(*(torque_at_steering_wheel(torque, p.steering_ratio) for torque in about_kingpins))


def _load(road: RoadTorques, mean: Coefficients) -> Scalar:
    """Torque [N*m] that loads gear and joints, by the present estimate of the coefficients."""
    aligning = (mean.aligning_gain + mean.trail_drop * absolute(road.aligning)) * road.aligning
    return aligning + mean.weight_lever * road.weight + mean.turn_slip * road.turn_slip + mean.drive_share * road.drive


def row_of(mean: Coefficients, given: Regressors) -> Coefficients:
    """Row of the regression: derivative of the torque with respect to each coefficient."""
    return Coefficients(
        finite=given.finite,
        exponential=given.exponential,
        long=given.long,
        log_dahl_angle=mean.finite * given.finite_sensitivity
        + mean.exponential * given.exponential_sensitivity
        + mean.long * given.long_sensitivity,
        aligning_gain=given.aligning_torque,
        trail_drop=given.squared_aligning_torque,
        weight_lever=given.weight,
        turn_slip=given.turn_slip,
        drive_share=given.drive,
        load_share=given.loaded_friction,
        offset=1.0,
        damping=given.rate,
        inertia=given.acceleration,
    )


def expected_torque(mean: Coefficients, row: Coefficients) -> Scalar:
    """Torque of the balance [N*m]: linear in every coefficient except the Dahl angle, which acts through build-up."""
    return dot(mean, row._replace(log_dahl_angle=0.0))


COUNTS_OF_HANDS_ON = 10.0
"""Driver's torque in raw counts that opens the gate; 0.03 to 0.1 N*m at the usual 100 to 300 counts per N*m
[assumed]."""

FASTEST_STEERING = 15.0
"""Rate of the steering wheel above which the gate closes [rad/s]; drivers do not reach it even in an emergency, so a
higher rate is a signal fault or a car out of control."""


class FrictionTorque(NamedTuple):
    """Output of the estimator after a sample."""

    friction_torque: Annotated[Scalar, "N*m"]  # level of dry friction at the steering wheel axis, at the reference load
    friction_deviation: Annotated[Scalar, "N*m"]  # its standard deviation, for correct torque sensors
    # factor by which it was widened because the torque balance fits worse than the tuning expects
    misfit: Annotated[Scalar, ""]
    residual: Annotated[Scalar, "N*m"]  # root mean square of `innovation` over the last enabled time
    enabled: Annotated[Scalar, ""]  # 1 where the sample was used
    # hands_on, same_direction, moving, rolling, settled: the enabling conditions, one by one
    hands_on: Annotated[Scalar, ""]
    same_direction: Annotated[Scalar, ""]
    moving: Annotated[Scalar, ""]
    rolling: Annotated[Scalar, ""]
    settled: Annotated[Scalar, ""]
    dahl_angle: Annotated[Scalar, "rad"]  # travel over which friction builds up
    # aligning_gain, trail_drop, weight_lever, turn_slip, drive_share, load_share, offset, damping, inertia: see
    # `Coefficients`
    aligning_gain: Annotated[Scalar, ""]
    trail_drop: Annotated[Scalar, "1/(N*m)"]
    weight_lever: Annotated[Scalar, "m"]
    turn_slip: Annotated[Scalar, "m**2"]
    drive_share: Annotated[Scalar, ""]
    load_share: Annotated[Scalar, ""]
    reference_load: Annotated[Scalar, "N*m"]  # road torque at the steering wheel for which friction is stated
    offset: Annotated[Scalar, "N*m"]
    damping: Annotated[Scalar, "N*m*s/rad"]
    inertia: Annotated[Scalar, "kg*m**2"]
    build_up: Annotated[Scalar, ""]  # share of the full level that friction has reached, with sign
    # mean magnitude of `build_up` over the enabled time; 1 is permanent sliding, below 0.5 the strokes end before
    # friction has built up
    excitation: Annotated[Scalar, ""]
    innovation: Annotated[Scalar, "N*m"]  # measured less expected torque
    # variance expected by the filter; set wide for errors that last over many samples
    innovation_variance: Annotated[Scalar, "N**2*m**2"]
    nis: Annotated[Scalar, ""]  # normalised innovation squared; far below 1 for that reason


@dataclass(frozen=True)
class PreslidingFrictionFilter:
    """Estimate the dry friction of the steering without the bias of pre-sliding.

    The torque balance of eq (2) with friction that builds up over an angle, in place of Tf sgn(theta'):

        Td + n Tm = sum_j F_j h_j + c (|road| - reference) h + road + offset + B w + J w'
        road = (k + d |rho Mz|) rho Mz + rho (lever W sin(delta) + s W phi - share trail X sin(delta))

    where each h_j follows the column by Dahl's law with exponent 1/2, 1, 2; their common Dahl angle is learnt. The
    column angle is that below the torsion bar: the steering wheel angle less Td over the bar's stiffness. Beside the
    self-aligning torque, the road torque contains the effects of the weight W of the front axle, of the turn slip phi
    of the tyres, and of the drive and brake force X of the steered wheels.

    Both sides pass the same low-pass after the law: filtering the angle before it would blunt the reversals. The filter
    makes one scalar update per sample while the gate is open; otherwise nothing is learnt or forgotten.

    Args:
        gate: eq (14) for both ends of the torsion bar, with an upper limit on the rate that no driver reaches (the law
            is valid at any rate, and the printed limit biases by -0.2 to -0.7 N*m, simulated), and a lower limit on
            speed because of tyre scrub
        regressor_cutoff: cutoff frequency of the low-pass on both sides [Hz]; 5 passes steering and removes noise

    Validity: both torques calibrated together; a common factor scales everything learnt and is not observable.
    The driver's torque is that in the bar, so that inertia and damping exclude the steering wheel.
    Source: docs/explanation/friction.md; developed from the "single-law estimator" there, with the low-pass after the
    law, three laws in place of one, friction that depends on load, a trail that drops, no play, bounded influence of
    outliers, elastic bar, weight, turn slip, and drive force of steered wheels. Each contribution is measured there.
    """

    parameters: FrictionParameters  # parameters of the vehicle; their `sample_time` is that of the samples
    tuning: PreslidingTuning = field(default_factory=PreslidingTuning)  # noises and priors
    conditioning: SteeringConditioning = field(default_factory=SteeringConditioning)  # conditioning of the signals
    gate: FrictionGate = field(default_factory=lambda: _gate(FrictionGate().minimum_driver_torque))
    regressor_cutoff: Annotated[float, "Hz"] = 5.0
    low_pass: Butterworth = field(init=False, repr=False)

    Sample = SteeringSample
    learnt: ClassVar[Mapping[str, str]] = {
        "dahl_angle_rad": "dahl_angle",
        "aligning_gain": "aligning_gain",
        "torque_offset_Nm": "offset",
        "damping_Nms_per_rad": "damping",
        "inertia_kgm2": "inertia",
        "load_share": "load_share",
        "reference_load_Nm": "reference_load",
    }
    """Evidence of the estimator: name with unit -> field of the estimate."""

    class State(NamedTuple):
        conditioning: Any
        finite: BuildUp
        exponential: BuildUp
        long: BuildUp
        low_pass: Any
        mean: Coefficients
        covariance: tuple[Scalar, ...]
        innovation_power: Scalar
        excitation: Scalar

    def __post_init__(self) -> None:
        sample_time = self.conditioning.sample_time
        if self.parameters.sample_time != sample_time:
            raise ParameterError(
                f"the vehicle's parameters are for samples every {self.parameters.sample_time} s, the conditioning for "
                f"every {sample_time} s; give both the same sample_time"
            )
        low_pass = Butterworth(Regressors, sample_time, 0.0, self.regressor_cutoff)
        object.__setattr__(self, "low_pass", low_pass)

    @classmethod
    def of_vehicle(cls, vehicle: Vehicle, sample_time: float = SAMPLE_TIME) -> PreslidingFrictionFilter:
        """The filter for a vehicle, with every tuning as measured in docs/explanation/friction.md.

        Args:
            sample_time: time between two samples [s]
        """
        parameters = replace(vehicle.parameters_for(FrictionParameters), sample_time=sample_time)
        if not vehicle.calibrated:
            parameters = replace(parameters, torsion_bar_stiffness=math.inf)
        driver_torque = FrictionGate().minimum_driver_torque if vehicle.calibrated else COUNTS_OF_HANDS_ON
        return cls(parameters, conditioning=SteeringConditioning(sample_time), gate=_gate(driver_torque))

    def init(self) -> State:
        tuning = self.tuning
        mean = Coefficients(
            finite=0.0,
            exponential=tuning.initial_friction,
            long=0.0,
            log_dahl_angle=log(tuning.initial_dahl_angle),
            aligning_gain=1.0,
            trail_drop=0.0,
            weight_lever=tuning.initial_weight_lever,
            turn_slip=tuning.initial_turn_slip,
            drive_share=tuning.initial_drive_share,
            load_share=0.0,
            offset=0.0,
            damping=self.parameters.below_bar.damping,
            inertia=self.parameters.below_bar.inertia,
        )
        variances = from_diagonal([deviation * deviation for deviation in tuning.deviations])
        return self.State(
            self.conditioning.init(), RELAXED, RELAXED, RELAXED, self.low_pass.init(), mean, variances, 0.0, 0.0
        )

    def step(self, state: State, sample: SteeringSample) -> tuple[State, FrictionTorque]:
        conditioning, clean = self.conditioning.step(state.conditioning, sample)
        column = column_motion(clean, self.parameters.torsion_bar_stiffness, self.conditioning.sample_time)
        angle = exp(state.mean.log_dahl_angle)
        laws = build_ups((state.finite, state.exponential, state.long), column.increment, angle)
        load = reference_load(self.parameters, self.tuning.reference_lever)
        both_sides = regressors(clean, column, laws, state.mean, self.parameters, load)
        low_pass, passed = self.low_pass.step(state.low_pass, both_sides)
        # Friction has a direction only where the bar moves at both ends, so the gate takes the slower one.
        slower = minimum(absolute(passed.rate), absolute(passed.steering_wheel_rate))
        conditions = self.gate.conditions(
            passed.driver_torque, passed.motor_torque, slower, clean.signals.vehicle_speed
        )
        enabled = all_of(*conditions, clean.settled, clean.present)
        row = row_of(state.mean, passed)
        innovation = passed.torque - expected_torque(state.mean, row)
        spread = dot(row, product(unpack(state.covariance), row))
        mean, covariance = self._update(state, row, innovation, enabled)
        noise = self.tuning.error_density / self.conditioning.sample_time
        share = self.conditioning.sample_time / self.tuning.excitation_memory
        power = _followed(state.innovation_power, innovation * innovation, share, enabled)
        excitation = _followed(state.excitation, absolute(passed.exponential), share, enabled)
        misfit = self._misfit(power)
        after = self.State(conditioning, *laws, low_pass, mean, covariance, power, excitation)
        return after, FrictionTorque(
            friction_torque=mean.friction_torque,
            friction_deviation=_deviation(covariance) * misfit,
            misfit=misfit,
            residual=sqrt(power),
            enabled=enabled,
            hands_on=conditions.hands_on,
            same_direction=conditions.same_direction,
            moving=conditions.moving,
            rolling=conditions.rolling,
            settled=clean.settled,
            dahl_angle=exp(mean.log_dahl_angle),
            aligning_gain=mean.aligning_gain,
            trail_drop=mean.trail_drop,
            weight_lever=mean.weight_lever,
            turn_slip=mean.turn_slip,
            drive_share=mean.drive_share,
            load_share=mean.load_share,
            reference_load=load,
            offset=mean.offset,
            damping=mean.damping,
            inertia=mean.inertia,
            build_up=passed.exponential,
            excitation=excitation,
            innovation=innovation,
            innovation_variance=spread + noise,
            nis=innovation * innovation / (spread + noise),
        )

    @property
    def vehicle_parameters(self) -> FrictionParameters:
        """Parameters of the vehicle file, as the estimator assumes them."""
        return self.parameters

    def seen(self, sample: SteeringSample, estimate: FrictionTorque) -> VerdictSample:
        """Input of the verdict from a sample and its estimate."""
        return VerdictSample(*(getattr(estimate, name) for name in VerdictSample._fields))

    def _update(
        self, state: State, row: Coefficients, innovation: Scalar, enabled: Any
    ) -> tuple[Coefficients, tuple[Scalar, ...]]:
        """One scalar update where enabled; elsewhere neither mean nor covariance changes."""
        tuning, sample_time = self.tuning, self.conditioning.sample_time
        # Huber weight as a noise that grows with the innovation; an infinite innovation is a missing measurement.
        noise = tuning.error_density / sample_time * maximum(1.0, absolute(innovation) / tuning.outlier)
        correction = correct(state.covariance, [row], [where(enabled, innovation, math.inf)], [noise], state.mean)
        mean = Coefficients(*correction.shift)
        smallest, largest = log(tuning.smallest_dahl_angle), log(tuning.largest_dahl_angle)
        wander = tuning.error_density / (tuning.memory * tuning.memory)
        process = tuning.process
        gained = process._replace(
            finite=wander * process.finite, exponential=wander * process.exponential, long=wander * process.long
        )
        growth = from_diagonal([where(enabled, rate * sample_time, 0.0) for rate in gained])
        return (
            mean._replace(log_dahl_angle=limit(mean.log_dahl_angle, smallest, largest)),
            add(correction.covariance, growth),
        )

    def _misfit(self, innovation_power: Scalar) -> Scalar:
        """Factor on the standard deviation where the balance fits worse than the tuning expects."""
        expected = self.tuning.error_density / self.tuning.error_time
        return sqrt(maximum(1.0, innovation_power / expected))


def _gate(minimum_driver_torque: float) -> FrictionGate:
    """Eq (14) with the limits of this estimator on rate and speed."""
    return FrictionGate(minimum_driver_torque, maximum_rate=FASTEST_STEERING, minimum_speed=ROLLING_SPEED)


def _deviation(covariance: tuple[Scalar, ...]) -> Scalar:
    """Standard deviation of the friction torque, the sum of its three shares."""
    full = unpack(covariance)
    return sqrt(maximum(sum(full[i][j] for i in range(3) for j in range(3)), 0.0))


def _followed(average: Scalar, value: Scalar, share: Scalar, enabled: Scalar) -> Scalar:
    """Low-pass over the enabled samples; held elsewhere."""
    return where(enabled, average + share * (value - average), average)
