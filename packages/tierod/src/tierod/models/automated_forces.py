"""Parameters and forces of a car that steers, drives and brakes by itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, limit, sqrt
from tierod.physics.planar_motion import longitudinal_load_transfer
from tierod.physics.single_track import front_axle_load, yaw_moment
from tierod.physics.tyre import saturating_lateral_force


@dataclass(frozen=True)
class AutomatedParameters:
    """A car with two steering motors and a drive at each front wheel, named as in a vehicle file.

    Args:
        rolling_mass: equivalent mass of the rotation of all wheels
        front_distance, rear_distance: from the centre of gravity to the axles
        tyre_friction, rear_friction_ratio: peak lateral force over load of the front axle; that of the rear over it
        relaxation_length, rear_relaxation_ratio: of the front axle's lateral force; that of the rear over it
        stiffness_growth: relative growth of the rear axle's stiffness per relative growth of its load
        mechanical_trail, pneumatic_trail: of the front axle; the pneumatic one also of the rear axle
        turn_slip_stiffness: torque of one wheel per turn slip
        jacking_torque: of both kingpins per sine of the road-wheel angle, from the weight that steering lifts
        scrub_radius: lever of the drive forces about the kingpins
        wheel_radius: nominal effective radius; the drives act with this radius over `wheel_speed_scale`
        steering_ratio: road wheel angle per angle of the column
        rack_ratio: travel of the rack per angle of the column
        column_inertia: of everything that turns with the column, motors included
        steering_motor_inertia: of both motors together, above the shaft torque sensor
        nominal_friction, column_friction_angle: level of dry friction at the column, and angle of its build-up
        sensor_forward: distance of the accelerometers ahead of the centre of gravity
        roll_share: component of gravity in the measured lateral acceleration by roll, per acceleration
        wheel_speed_scale: reading of both rear wheel speeds over the speed of the wheels
        wheel_speed_difference: relative excess of the right over the left reading
    """

    mass: Annotated[float, "kg"]
    yaw_inertia: Annotated[float, "kg*m**2"]
    rolling_mass: Annotated[float, "kg"]
    front_distance: Annotated[float, "m"]
    rear_distance: Annotated[float, "m"]
    track_width: Annotated[float, "m"]
    centre_height: Annotated[float, "m"]
    front_cornering_stiffness: Annotated[float, "N/rad"]
    rear_cornering_stiffness: Annotated[float, "N/rad"]
    tyre_friction: Annotated[float, ""]
    rear_friction_ratio: Annotated[float, ""]
    relaxation_length: Annotated[float, "m"]
    rear_relaxation_ratio: Annotated[float, ""]
    stiffness_growth: Annotated[float, ""]
    mechanical_trail: Annotated[float, "m"]
    pneumatic_trail: Annotated[float, "m"]
    turn_slip_stiffness: Annotated[float, "N*m**2"]
    jacking_torque: Annotated[float, "N*m/rad"]
    scrub_radius: Annotated[float, "m"]
    wheel_radius: Annotated[float, "m"]
    rolling_resistance: Annotated[float, "N"]
    drag: Annotated[float, "N*s**2/m**2"]
    steering_ratio: Annotated[float, ""]
    rack_ratio: Annotated[float, "m/rad"]
    column_inertia: Annotated[float, "kg*m**2"]
    steering_motor_inertia: Annotated[float, "kg*m**2"]
    rack_damping: Annotated[float, "N*s/m"]
    rack_stiffness: Annotated[float, "N/m"]
    nominal_friction: Annotated[float, "N*m"]
    column_friction_angle: Annotated[float, "rad"]
    sensor_forward: Annotated[float, "m"]
    roll_share: Annotated[float, ""]
    wheel_speed_scale: Annotated[float, ""] = 1.0
    wheel_speed_difference: Annotated[float, ""] = 0.0
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

    Args:
        torque: at the wheels [N*m]
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
