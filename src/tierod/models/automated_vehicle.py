"""Motion, steering and sensors of a small automated car, with what it does not know about itself as states.

Planar motion on two axles whose tyres deflect over a relaxation length, so that nothing is divided by the speed; a
column with Dahl friction on a stiff rack; torques from their targets. Functions that keep a compiler from computing
many filters side by side are avoided: sine and cosine of the small road-wheel angle are polynomials.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.graph.maths import absolute, exp, limit, sqrt
from tierod.models.automated_parameters import AutomatedParameters, Fading
from tierod.physics.damped_rotation import DampedRotation, damped_rotation
from tierod.physics.friction import dahl_update
from tierod.physics.load_transfer import longitudinal_load_transfer
from tierod.physics.rack_balance import column_balance
from tierod.physics.single_track import (
    front_axle_load,
    lateral_acceleration,
    lateral_acceleration_at,
    rear_slip_speed,
    yaw_moment,
)
from tierod.physics.tyre import saturating_lateral_force

CRAWL = 0.5
"""Added to the speed where something is divided by it, and speed at which rolling resistance sets in [m/s]."""
LEAST_ACROSS = 0.3
"""Share of the friction that stays for the lateral force whatever the drives do [-]."""


class Torques(NamedTuple):
    """Of both steering motors at the column and of both drives at their wheels [N*m]."""

    steering_motor_1: Any
    steering_motor_2: Any
    drive_left: Any
    drive_right: Any


class Forces(NamedTuple):
    """What acts in a state.

    Args:
        front, rear: lateral, across the body [N]
        along: of the tyres along the body, and of the air [N]
        drive_difference: of the right drive less the left one [N]
        kingpin: torque of both kingpins that the tie rods hold, without its error [N*m]
    """

    front: Any
    rear: Any
    along: Any
    drive_difference: Any
    kingpin: Any


class AutomatedVehicle:
    """The sampled model.

    A step takes the tyres' deflections first, then motion and steering under the forces of the new deflections
    (stable at standstill too); rack and column are one body, since their gear is stiff.

    Validity: forward, on a road that the tyres grip; steering of up to 0.4 rad at the road wheels.
    Source: Li, Frey, Gauterin, eqs (1), (2), (13), corrected: the connection force turns the column by the rack ratio,
    which is printed as its reciprocal; tyres, friction and loss of torque beyond the paper.
    """

    class State(NamedTuple):
        """Motion, steering, and what is not known.

        The force errors are true less modelled force; `grade_acceleration` and `bank_acceleration` are what the road's
        slope takes from the acceleration forward and to the left; `torque_loss` is the lost share of the torque of
        whatever actuator is suspected; `wheel_speed_difference` is the excess over its parameter, and so are offsets.
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

    class Input(NamedTuple):
        """Torques that were asked for, of both motors at the column and of both drives at their wheels.

        In the mean over the step, at its end (`_now`), and whether an actuator is suspected (`_suspected`, 1 or 0) of
        having lost the share `torque_loss`.
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
        """What the sensors measure."""

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
        """The car, how what is unknown fades, and the time of a sample."""

        fading: Fading = field(default_factory=Fading)
        sample_time: Annotated[float, "s"] = 0.01

    @staticmethod
    def transition(x: Any, u: Any, p: Any) -> Any:
        """The state one sample on."""
        step, torques = p.sample_time, _given(u[:4], u[8:], x.torque_loss)
        x = _deflected(x, p)
        forces = _forces(x, torques, p)
        angle, rate, friction = _steered(x, forces, torques, p)
        along = forces.along / (p.mass + p.rolling_mass)
        across = lateral_acceleration(forces.front, forces.rear, p.mass)
        speed_rate = along + x.lateral_speed * x.yaw_rate - x.grade_acceleration
        keep = Fading(*(exp(-step / time) for time in vars(p.fading).values()))
        return AutomatedVehicle.State(
            x.speed + step * speed_rate,
            x.lateral_speed + step * (across - x.speed * x.yaw_rate - x.bank_acceleration),
            x.yaw_rate + step * _yaw_acceleration(x, forces, p),
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
        )

    @staticmethod
    def output(x: Any, u: Any, p: Any) -> Any:
        """What is measured at the end of a step."""
        torques = _given(u[4:8], u[8:], x.torque_loss)
        forces = _forces(x, torques, p)
        half_turn, difference = 0.5 * p.track_width * x.yaw_rate, p.wheel_speed_difference + x.wheel_speed_difference
        steering = torques.steering_motor_1 + torques.steering_motor_2
        above = p.steering_motor_inertia * _column_balance(x, forces, torques, p, x.column_rate) / p.column_inertia
        across = (1.0 + p.roll_share) * lateral_acceleration(forces.front, forces.rear, p.mass)
        lateral = lateral_acceleration_at(across, _yaw_acceleration(x, forces, p), x.yaw_rate, p.sensor_forward)
        along = forces.along / (p.mass + p.rolling_mass) - p.sensor_forward * x.yaw_rate * x.yaw_rate
        return AutomatedVehicle.Output(
            p.wheel_speed_scale * (1.0 - 0.5 * difference) * (x.speed - half_turn),
            p.wheel_speed_scale * (1.0 + 0.5 * difference) * (x.speed + half_turn),
            x.yaw_rate + p.yaw_rate_offset + x.yaw_rate_offset,
            x.column_angle + p.steering_wheel_angle_offset + x.angle_offset,
            steering - above + p.steering_shaft_torque_offset,
            _tie_rod_force(x, forces, p) + p.tie_rod_force_offset,
            along + p.longitudinal_acceleration_offset,
            lateral + p.lateral_acceleration_offset,
        )

    @staticmethod
    def forces(x: Any, u: Any, p: Any) -> Forces:
        """What acts at the end of a step."""
        return _forces(x, _given(u[4:8], u[8:], x.torque_loss), p)


def _given(asked: Any, suspected: Any, loss: Any) -> Torques:
    """Torques after what suspected actuators have lost."""
    return Torques(*(torque * (1.0 - share * loss) for torque, share in zip(asked, suspected, strict=True)))


def _direction(x: Any, p: Any) -> tuple[Any, Any]:
    """Sine and cosine of the road-wheel angle, good to 1e-4 up to 0.4 rad."""
    angle = p.steering_ratio * x.column_angle
    square = angle * angle
    return angle * (1.0 - square / 6.0), 1.0 - 0.5 * square * (1.0 - square / 12.0)


def _deflected(x: Any, p: Any) -> Any:
    """The tyres roll for a step, all else kept; implicit, so that no speed is too fast."""
    sine, cosine = _direction(x, p)
    across = x.lateral_speed + p.front_distance * x.yaw_rate
    travel = p.sample_time * absolute(x.speed)
    length, rear_length = p.relaxation_length, p.relaxation_length * p.rear_relaxation_ratio
    front = p.sample_time * (sine * x.speed - cosine * across)
    rear = p.sample_time * rear_slip_speed(x.lateral_speed, x.yaw_rate, p.rear_distance)
    return x._replace(
        front_slip=(length * x.front_slip + front) / (length + travel),
        rear_slip=(rear_length * x.rear_slip + rear) / (rear_length + travel),
    )


def _turn_slip(x: Any, p: Any) -> tuple[Any, Any]:
    """Turn slips of a front and a rear wheel [1/m]."""
    inverse = 1.0 / (absolute(x.speed) + CRAWL)
    return (x.yaw_rate + p.steering_ratio * x.column_rate) * inverse, x.yaw_rate * inverse


def _forces(x: Any, torques: Torques, p: Any) -> Forces:
    sine, cosine = _direction(x, p)
    per_radius = p.wheel_speed_scale / p.wheel_radius
    left, right = per_radius * torques.drive_left, per_radius * torques.drive_right
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


def _yaw_acceleration(x: Any, forces: Forces, p: Any) -> Any:
    front_turn, rear_turn = _turn_slip(x, p)
    moment = yaw_moment(forces.front, forces.rear, p.front_distance, p.rear_distance)
    moment = moment + 0.5 * p.track_width * forces.drive_difference - p.pneumatic_trail * (forces.front + forces.rear)
    return (moment - 2.0 * p.turn_slip_stiffness * (front_turn + rear_turn)) / p.yaw_inertia


def _tie_rod_force(x: Any, forces: Forces, p: Any) -> Any:
    """Sum of both sides [N], positive where it opposes a turn to the left; by virtual work."""
    return p.steering_ratio / p.rack_ratio * forces.kingpin + x.tie_rod_force_error


def _column_balance(x: Any, forces: Forces, torques: Torques, p: Any, rate: Any) -> Any:
    """Sum of all torques on the column while it turns at a rate [N*m]."""
    driving = torques.steering_motor_1 + torques.steering_motor_2
    friction = p.nominal_friction * x.friction_share
    force = _tie_rod_force(x, forces, p)
    return column_balance(
        driving, friction, force, x.column_angle, rate, p.rack_ratio, p.rack_stiffness, p.rack_damping
    )


def _steered(x: Any, forces: Forces, torques: Torques, p: Any) -> tuple[Any, Any, Any]:
    """Angle, rate and friction of the column after a step; exact for torques that stay constant over it."""
    torque, turning = _column_balance(x, forces, torques, p, 0.0), turning_column(p)
    turned = turning.path * x.column_rate + turning.angle_per_torque * torque
    rate = turning.kept * x.column_rate + turning.rate_per_torque * torque
    return x.column_angle + turned, rate, dahl_update(x.friction_share, turned, p.column_friction_angle)


def turning_column(p: Any) -> DampedRotation:
    """What rate and torque of the column make of its angle and rate after one sample.

    Args:
        p: parameters of `AutomatedVehicle`
    """
    return damped_rotation(p.column_inertia, p.rack_ratio * p.rack_ratio * p.rack_damping, p.sample_time)
