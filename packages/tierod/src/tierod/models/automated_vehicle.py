"""Motion, steering and sensors of a small automated car, with its unknown quantities as states.

Planar motion on two axles whose tyres have a relaxation length, so that nothing is divided by the speed; a column with
Dahl friction on a stiff rack; torques from their targets. Sine and cosine of the small road-wheel angle are
polynomials, since library functions keep a compiler from vectorising over many filters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple, TypeAlias

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, exp
from tierod.models.automated_forces import (
    AutomatedParameters,
    AutomatedState,
    Fading,
    Forces,
    Torques,
    direction,
    forces_of,
    tie_rod_force_of,
    yaw_acceleration_of,
)
from tierod.physics.friction import dahl_update
from tierod.physics.gear import column_balance
from tierod.physics.lag import DampedRotation, damped_rotation
from tierod.physics.single_track import (
    lateral_acceleration,
    lateral_acceleration_at,
    rear_slip_speed,
)


class AutomatedVehicle:
    """The sampled model.

    A step first updates the tyre deflections, then motion and steering under the forces of the new deflections, which
    is stable at standstill too; rack and column are one body, since their gear is stiff.

    Validity: forward driving below the limit of grip; steer of up to 0.4 rad at the road wheels.
    Source: Li, Frey, Gauterin, eqs (1), (2), (13), corrected: the connection force turns the column by the rack ratio,
    which is printed as its reciprocal; tyres, friction and loss of torque beyond the paper.
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
        """Measurements of the sensors."""

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
