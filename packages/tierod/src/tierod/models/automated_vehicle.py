"""Small automated car: forces, motion and steering column in one discrete model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple, TypeAlias

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, exp, limit, sqrt
from tierod.physics.friction import DampedRotation, dahl_update, damped_rotation
from tierod.physics.motion import (
    front_axle_load,
    lateral_acceleration,
    lateral_acceleration_at,
    longitudinal_load_transfer,
    rear_slip_speed,
    yaw_moment,
)
from tierod.physics.steering import column_balance
from tierod.physics.tyre import saturating_lateral_force


@dataclass(frozen=True)
class AutomatedParameters:
    """A car with two steering motors and a drive at each front wheel, named as in a vehicle file."""

    mass: Annotated[float, "kg"]
    yaw_inertia: Annotated[float, "kg*m**2"]
    rolling_mass: Annotated[float, "kg"]  # equivalent mass of the rotation of all wheels
    # from the centre of gravity to the axles
    front_distance: Annotated[float, "m"]
    rear_distance: Annotated[float, "m"]
    track_width: Annotated[float, "m"]
    centre_height: Annotated[float, "m"]
    front_cornering_stiffness: Annotated[float, "N/rad"]
    rear_cornering_stiffness: Annotated[float, "N/rad"]
    # peak lateral force over load of the front axle; that of the rear over it
    tyre_friction: Annotated[float, ""]
    rear_friction_ratio: Annotated[float, ""]
    # of the front axle's lateral force; that of the rear over it
    relaxation_length: Annotated[float, "m"]
    rear_relaxation_ratio: Annotated[float, ""]
    # relative growth of the rear axle's stiffness per relative growth of its load
    stiffness_growth: Annotated[float, ""]
    # of the front axle; the pneumatic one also of the rear axle
    mechanical_trail: Annotated[float, "m"]
    pneumatic_trail: Annotated[float, "m"]
    turn_slip_stiffness: Annotated[float, "N*m**2"]  # torque of one wheel per turn slip
    # of both kingpins per sine of the road-wheel angle, from the weight that steering lifts
    jacking_torque: Annotated[float, "N*m/rad"]
    scrub_radius: Annotated[float, "m"]  # lever of the drive forces about the kingpins
    # nominal effective radius; the drives act with this radius over `wheel_speed_scale`
    wheel_radius: Annotated[float, "m"]
    rolling_resistance: Annotated[float, "N"]
    drag: Annotated[float, "N*s**2/m**2"]
    steering_ratio: Annotated[float, ""]  # road wheel angle per angle of the column
    rack_ratio: Annotated[float, "m/rad"]  # travel of the rack per angle of the column
    column_inertia: Annotated[float, "kg*m**2"]  # of everything that turns with the column, motors included
    steering_motor_inertia: Annotated[float, "kg*m**2"]  # of both motors together, above the shaft torque sensor
    rack_damping: Annotated[float, "N*s/m"]
    rack_stiffness: Annotated[float, "N/m"]
    # level of dry friction at the column, and angle of its build-up
    nominal_friction: Annotated[float, "N*m"]
    column_friction_angle: Annotated[float, "rad"]
    sensor_forward: Annotated[float, "m"]  # distance of the accelerometers ahead of the centre of gravity
    # component of gravity in the measured lateral acceleration by roll, per acceleration
    roll_share: Annotated[float, ""]
    wheel_speed_scale: Annotated[float, ""] = 1.0  # reading of both rear wheel speeds over the speed of the wheels
    wheel_speed_difference: Annotated[float, ""] = 0.0  # relative excess of the right over the left reading
    yaw_rate_offset: Annotated[float, "rad/s"] = 0.0
    steering_wheel_angle_offset: Annotated[float, "rad"] = 0.0
    steering_shaft_torque_offset: Annotated[float, "N*m"] = 0.0
    tie_rod_force_offset: Annotated[float, "N"] = 0.0
    longitudinal_acceleration_offset: Annotated[float, "m/s**2"] = 0.0
    lateral_acceleration_offset: Annotated[float, "m/s**2"] = 0.0
    greatest_steering_motor_torque: Annotated[float, "N*m"] = 1e3
    greatest_drive_torque: Annotated[float, "N*m"] = 1e4
    steering_motor_lag: Annotated[float, "s"] = 0.003
    drive_lag: Annotated[float, "s"] = 0.01


@dataclass(frozen=True)
class Fading:
    """Correlation times of the unknown states, which return to zero."""

    force: Annotated[float, "s"] = 0.9  # of the errors of the axle forces; about the duration of a bend
    tie_rod: Annotated[float, "s"] = 0.6  # of the error of the tie-rod force
    loss: Annotated[float, "s"] = 4.0  # of the torque loss of an actuator
    # of the offsets of yaw rate and angle, and of the difference of the wheel speeds
    offset: Annotated[float, "s"] = 600.0
    # of the scales of wheel speeds and drives; load and tyres change between drives, and hardly in a drive
    share: Annotated[float, "s"] = 3600.0
    road: Annotated[float, "s"] = 6.0  # of grade and bank


class AutomatedState(NamedTuple):
    """Motion, steering, and unknown states.

    The force errors are true less modelled force; `grade_acceleration` and `bank_acceleration` are the accelerations
    forward and to the left that the road's slope takes away; `torque_loss` is the lost share of the torque of the
    suspected actuators; `wheel_speed_difference` and the offsets are deviations from their parameters,
    `wheel_speed_scale` is a relative one; `drive_excess` is the relative excess of the drive forces over those of the
    torques, as with a lighter vehicle or smaller tyres.
    """

    speed: Annotated[float, "m/s"]
    lateral_speed: Annotated[float, "m/s"]
    yaw_rate: Annotated[float, "rad/s"]
    front_slip: Annotated[float, ""]
    rear_slip: Annotated[float, ""]
    column_angle: Annotated[float, "rad"]
    column_rate: Annotated[float, "rad/s"]
    friction_share: Annotated[float, ""]
    front_force_error: Annotated[float, "N"]
    rear_force_error: Annotated[float, "N"]
    tie_rod_force_error: Annotated[float, "N"]
    torque_loss: Annotated[float, ""]
    yaw_rate_offset: Annotated[float, "rad/s"]
    angle_offset: Annotated[float, "rad"]
    grade_acceleration: Annotated[float, "m/s**2"]
    bank_acceleration: Annotated[float, "m/s**2"]
    wheel_speed_difference: Annotated[float, ""]
    wheel_speed_scale: Annotated[float, ""]
    drive_excess: Annotated[float, ""]


CRAWL = 0.5  # Added to the speed in denominators; at this speed rolling resistance has half of its value [m/s]
LEAST_ACROSS = 0.3  # Smallest share of the friction that is left for the lateral force under drive forces [-]


class Torques(NamedTuple):
    """Torques of both steering motors at the column and of both drives at their wheels [N*m]."""

    steering_motor_1: Scalar
    steering_motor_2: Scalar
    drive_left: Scalar
    drive_right: Scalar


class Forces(NamedTuple):
    """Forces on the car in a state."""

    front: Scalar  # front, rear: lateral forces across the body [N]
    rear: Scalar
    along: Scalar  # longitudinal force of tyres, rolling resistance and air [N]
    drive_difference: Scalar  # drive force on the right less that on the left [N]
    kingpin: Scalar  # torque about both kingpins that the tie rods balance, without model error [N*m]


def direction(x: AutomatedState, p: AutomatedParameters) -> tuple[Scalar, Scalar]:
    """Sine and cosine of the road-wheel angle by polynomials, with an error below 1e-4 up to 0.4 rad."""
    angle = p.steering_ratio * x.column_angle
    square = angle * angle
    return angle * (1.0 - square / 6.0), 1.0 - 0.5 * square * (1.0 - square / 12.0)


def drive_force(torque: Scalar, p: AutomatedParameters) -> Scalar:
    """Longitudinal force [N] of a drive without slip; the wheel radius is the nominal one over the wheel speed scale.

    Args: torque: at the wheels [N*m].
    """
    return p.wheel_speed_scale / p.wheel_radius * torque


def _turn_slip(x: AutomatedState, p: AutomatedParameters) -> tuple[Scalar, Scalar]:
    """Turn slips of a front and a rear wheel [1/m]."""
    inverse = 1.0 / (absolute(x.speed) + CRAWL)
    return (x.yaw_rate + p.steering_ratio * x.column_rate) * inverse, x.yaw_rate * inverse


def forces_of(x: AutomatedState, torques: Torques, p: AutomatedParameters) -> Forces:
    """Forces on the car in a state."""
    sine, cosine = direction(x, p)
    left, right = drive_force(torques.drive_left, p), drive_force(torques.drive_right, p)
    drive = left + right
    load = front_axle_load(p.mass, p.front_distance, p.rear_distance)
    other = front_axle_load(p.mass, p.rear_distance, p.front_distance)
    shift = longitudinal_load_transfer(drive, p.centre_height, p.front_distance + p.rear_distance)
    grip = p.tyre_friction * load
    used = limit(drive / grip, -1.0, 1.0)
    left_over = grip * sqrt(1.0 - (1.0 - LEAST_ACROSS * LEAST_ACROSS) * used * used)
    growth = 1.0 + p.stiffness_growth * shift / other
    steered = saturating_lateral_force(x.front_slip, p.front_cornering_stiffness, left_over)
    greatest = p.tyre_friction * p.rear_friction_ratio * other
    rear = saturating_lateral_force(x.rear_slip, p.rear_cornering_stiffness * growth, greatest)
    steered, rear = steered + x.front_force_error, rear + x.rear_force_error
    front_turn, _ = _turn_slip(x, p)
    kingpin = (p.mechanical_trail + p.pneumatic_trail) * steered + p.jacking_torque * sine
    kingpin = kingpin + 2.0 * p.turn_slip_stiffness * front_turn + p.scrub_radius * (left - right)
    resisting = p.rolling_resistance * x.speed / (absolute(x.speed) + CRAWL) + p.drag * x.speed * absolute(x.speed)
    return Forces(
        cosine * steered + sine * drive,
        rear,
        cosine * drive - sine * steered - resisting,
        cosine * (right - left),
        kingpin,
    )


def yaw_acceleration_of(x: AutomatedState, forces: Forces, p: AutomatedParameters) -> Scalar:
    """Yaw acceleration of the body [rad/s**2]."""
    front_turn, rear_turn = _turn_slip(x, p)
    moment = yaw_moment(forces.front, forces.rear, p.front_distance, p.rear_distance)
    moment = moment + 0.5 * p.track_width * forces.drive_difference - p.pneumatic_trail * (forces.front + forces.rear)
    return (moment - 2.0 * p.turn_slip_stiffness * (front_turn + rear_turn)) / p.yaw_inertia


def tie_rod_force_of(x: AutomatedState, forces: Forces, p: AutomatedParameters) -> Scalar:
    """Tie-rod force [N], the sum of both sides by virtual work, positive where it opposes a turn to the left."""
    return p.steering_ratio / p.rack_ratio * forces.kingpin + x.tie_rod_force_error


class AutomatedVehicle:
    """The sampled model.

    A step first updates the tyre deflections, then motion and steering under the forces of the new deflections, which
    is stable at standstill too; rack and column are one body, since their gear is stiff.

    Validity: forward driving below the limit of grip; steer of up to 0.4 rad at the road wheels. Source: Li, Frey,
    Gauterin, eqs (1), (2), (13), corrected: the connection force turns the column by the rack ratio, which is printed
    as its reciprocal; tyres, friction and loss of torque beyond the paper.
    """

    State: TypeAlias = AutomatedState

    class Input(NamedTuple):
        """Commanded torques of both steering motors at the column and of both drives at their wheels.

        As the mean over the step and at its end (`_now`), and whether an actuator is suspected (`_suspected`, 1 or 0)
        of having lost the share `torque_loss`.
        """

        steering_motor_1: Annotated[float, "N*m"]
        steering_motor_2: Annotated[float, "N*m"]
        drive_left: Annotated[float, "N*m"]
        drive_right: Annotated[float, "N*m"]
        steering_motor_1_now: Annotated[float, "N*m"]
        steering_motor_2_now: Annotated[float, "N*m"]
        drive_left_now: Annotated[float, "N*m"]
        drive_right_now: Annotated[float, "N*m"]
        steering_motor_1_suspected: Annotated[float, ""]
        steering_motor_2_suspected: Annotated[float, ""]
        drive_left_suspected: Annotated[float, ""]
        drive_right_suspected: Annotated[float, ""]

    class Output(NamedTuple):
        wheel_speed_rear_left: Annotated[float, "m/s"]
        wheel_speed_rear_right: Annotated[float, "m/s"]
        yaw_rate: Annotated[float, "rad/s"]
        steering_wheel_angle: Annotated[float, "rad"]
        steering_shaft_torque: Annotated[float, "N*m"]
        tie_rod_force: Annotated[float, "N"]
        longitudinal_acceleration: Annotated[float, "m/s**2"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    @dataclass(frozen=True)
    class Parameters(AutomatedParameters):
        """The car, the correlation times of its unknown states, and the sampling interval."""

        fading: Fading = field(default_factory=Fading)
        sample_time: Annotated[float, "s"] = 0.01

    @staticmethod
    def transition(x: State, u: Input, p: Parameters) -> State:
        return AutomatedVehicle.moved(AutomatedVehicle.deflected(x, p), u, p)

    @staticmethod
    def deflected(x: State, p: Parameters) -> State:
        """First part of a step: update of the tyre deflections; implicit, hence stable at any speed."""
        sine, cosine = direction(x, p)
        across = x.lateral_speed + p.front_distance * x.yaw_rate
        travel = p.sample_time * absolute(x.speed)
        length, rear_length = p.relaxation_length, p.relaxation_length * p.rear_relaxation_ratio
        front = p.sample_time * (sine * x.speed - cosine * across)
        rear = p.sample_time * rear_slip_speed(x.lateral_speed, x.yaw_rate, p.rear_distance)
        return x._replace(
            front_slip=(length * x.front_slip + front) / (length + travel),
            rear_slip=(rear_length * x.rear_slip + rear) / (rear_length + travel),
        )

    @staticmethod
    def moved(x: State, u: Input, p: Parameters) -> State:
        """Second part of a step: motion and steering under the forces of the new deflections."""
        step, torques = p.sample_time, _given(u[:4], u[8:], x)
        forces = forces_of(x, torques, p)
        angle, rate, friction = _steered(x, forces, torques, p)
        along = forces.along / (p.mass + p.rolling_mass)
        across = lateral_acceleration(forces.front, forces.rear, p.mass)
        speed_rate = along + x.lateral_speed * x.yaw_rate - x.grade_acceleration
        keep = Fading(*(exp(-step / time) for time in vars(p.fading).values()))
        return AutomatedVehicle.State(
            x.speed + step * speed_rate,
            x.lateral_speed + step * (across - x.speed * x.yaw_rate - x.bank_acceleration),
            x.yaw_rate + step * yaw_acceleration_of(x, forces, p),
            x.front_slip,
            x.rear_slip,
            angle,
            rate,
            friction,
            keep.force * x.front_force_error,
            keep.force * x.rear_force_error,
            keep.tie_rod * x.tie_rod_force_error,
            keep.loss * x.torque_loss,
            keep.offset * x.yaw_rate_offset,
            keep.offset * x.angle_offset,
            keep.road * x.grade_acceleration,
            keep.road * x.bank_acceleration,
            keep.offset * x.wheel_speed_difference,
            keep.share * x.wheel_speed_scale,
            keep.share * x.drive_excess,
        )

    @staticmethod
    def output(x: State, u: Input, p: Parameters) -> Output:
        torques = _given(u[4:8], u[8:], x)
        forces = forces_of(x, torques, p)
        half_turn, difference = 0.5 * p.track_width * x.yaw_rate, p.wheel_speed_difference + x.wheel_speed_difference
        scale = p.wheel_speed_scale * (1.0 + x.wheel_speed_scale)
        steering = torques.steering_motor_1 + torques.steering_motor_2
        above = p.steering_motor_inertia * _column_balance(x, forces, torques, p, x.column_rate) / p.column_inertia
        across = (1.0 + p.roll_share) * lateral_acceleration(forces.front, forces.rear, p.mass)
        lateral = lateral_acceleration_at(across, yaw_acceleration_of(x, forces, p), x.yaw_rate, p.sensor_forward)
        along = forces.along / (p.mass + p.rolling_mass) - p.sensor_forward * x.yaw_rate * x.yaw_rate
        return AutomatedVehicle.Output(
            scale * (1.0 - 0.5 * difference) * (x.speed - half_turn),
            scale * (1.0 + 0.5 * difference) * (x.speed + half_turn),
            x.yaw_rate + p.yaw_rate_offset + x.yaw_rate_offset,
            x.column_angle + p.steering_wheel_angle_offset + x.angle_offset,
            steering - above + p.steering_shaft_torque_offset,
            tie_rod_force_of(x, forces, p) + p.tie_rod_force_offset,
            along + p.longitudinal_acceleration_offset,
            lateral + p.lateral_acceleration_offset,
        )

    @staticmethod
    def forces(x: State, u: Input, p: Parameters) -> Forces:
        """Forces at the end of a step."""
        return forces_of(x, _given(u[4:8], u[8:], x), p)


def _given(asked: Sequence[Scalar], suspected: Sequence[Scalar], x: AutomatedState) -> Torques:
    """Torques less the losses of suspected actuators; those of the drives scaled by `drive_excess`."""
    given = Torques(*(torque * (1.0 - share * x.torque_loss) for torque, share in zip(asked, suspected, strict=True)))
    excess = 1.0 + x.drive_excess
    return given._replace(drive_left=excess * given.drive_left, drive_right=excess * given.drive_right)


def _column_balance(
    x: AutomatedState, forces: Forces, torques: Torques, p: AutomatedVehicle.Parameters, rate: Scalar
) -> Scalar:
    """Sum of all torques on the column at a rate [N*m]."""
    driving = torques.steering_motor_1 + torques.steering_motor_2
    friction = p.nominal_friction * x.friction_share
    force = tie_rod_force_of(x, forces, p)
    return column_balance(
        driving, friction, force, x.column_angle, rate, p.rack_ratio, p.rack_stiffness, p.rack_damping
    )


def _steered(
    x: AutomatedState, forces: Forces, torques: Torques, p: AutomatedVehicle.Parameters
) -> tuple[Scalar, Scalar, Scalar]:
    """Angle, rate and friction of the column after a step; exact for torques that stay constant over it."""
    # The exact rotation contains the damping, so the torque is that without rate.
    torque, turning = _column_balance(x, forces, torques, p, 0.0), turning_column(p)
    turned = turning.path * x.column_rate + turning.angle_per_torque * torque
    rate = turning.kept * x.column_rate + turning.rate_per_torque * torque
    return x.column_angle + turned, rate, dahl_update(x.friction_share, turned, p.column_friction_angle)


def turning_column(p: AutomatedVehicle.Parameters) -> DampedRotation:
    """Transition of the column's angle and rate over one sample."""
    return damped_rotation(p.column_inertia, p.rack_ratio * p.rack_ratio * p.rack_damping, p.sample_time)
