"""Single-track model of lateral motion, and a car whose wheels roll without slip."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import POSITIVE
from tierod.core.graph.maths import Number, arctan, exp, maximum, sqrt
from tierod.physics import motion
from tierod.physics.tyre import linear_lateral_force


class SingleTrack:
    """Lateral motion of a vehicle at small slip angles: one front and one rear axle, linear tyres.

    Validity: |lateral acceleration| below about 4 m/s^2 on a dry road, vehicle_speed above about 3 m/s. Source: Mohtat
    et al., the model behind eqs (1) and (3); C_f and C_r are values of an axle, not of a wheel.
    """

    class State(NamedTuple):
        sideslip_angle: Annotated[float, "rad"]
        yaw_rate: Annotated[float, "rad/s"]

    class Input(NamedTuple):
        road_wheel_angle: Annotated[float, "rad"]
        vehicle_speed: Annotated[float, "m/s"]

    class Output(NamedTuple):
        yaw_rate: Annotated[float, "rad/s"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    @dataclass(frozen=True)
    class Parameters:
        """Mass, geometry and axle stiffness."""

        mass: Annotated[float, "kg"]  # of the vehicle [kg]
        yaw_inertia: Annotated[float, "kg*m**2"]  # about the vertical axis through the centre of gravity [kg m^2]
        front_distance: Annotated[float, "m"]  # centre of gravity to front axle [m]
        rear_distance: Annotated[float, "m"]  # centre of gravity to rear axle [m]
        front_cornering_stiffness: Annotated[float, "N/rad"]  # both front tyres together [N/rad]
        rear_cornering_stiffness: Annotated[float, "N/rad"]  # both rear tyres together [N/rad]

    @staticmethod
    def derivative(x: State, u: Input, p: Parameters) -> State:
        """Rates of the sideslip angle and of the yaw rate, from eq (3) and linear axle forces."""
        front, rear = SingleTrack.axle_forces(x, u, p)
        sideslip_rate = motion.lateral_acceleration(front, rear, p.mass) / u.vehicle_speed - x.yaw_rate
        return SingleTrack.State(
            sideslip_rate, motion.yaw_acceleration(front, rear, p.yaw_inertia, p.front_distance, p.rear_distance)
        )

    @staticmethod
    def output(x: State, u: Input, p: Parameters) -> Output:
        front, rear = SingleTrack.axle_forces(x, u, p)
        return SingleTrack.Output(x.yaw_rate, motion.lateral_acceleration(front, rear, p.mass))

    @staticmethod
    def axle_forces(x: State, u: Input, p: Parameters) -> tuple[Scalar, Scalar]:
        """Lateral forces of the front and the rear axle [N], positive in a left turn."""
        speed, lateral_speed = u.vehicle_speed, u.vehicle_speed * x.sideslip_angle
        front = motion.front_slip_speed(lateral_speed, x.yaw_rate, speed, u.road_wheel_angle, p.front_distance) / speed
        rear = motion.rear_slip_speed(lateral_speed, x.yaw_rate, p.rear_distance) / speed
        return (
            linear_lateral_force(front, p.front_cornering_stiffness),
            linear_lateral_force(rear, p.rear_cornering_stiffness),
        )

    @staticmethod
    def steady_yaw_gain(speed: Number, p: Parameters) -> Number:
        """Yaw rate per road-wheel angle [1/s] in a steady turn at a speed [m/s]."""
        gradient = motion.understeer_gradient(
            p.mass, p.front_distance, p.rear_distance, p.front_cornering_stiffness, p.rear_cornering_stiffness
        )
        return motion.steady_yaw_gain(speed, p.front_distance + p.rear_distance, gradient)


LEAST_SPEED = 1.0  # Smallest speed in denominators [m/s]


@dataclass(frozen=True)
class Wander:
    """Correlation times of the unknown states, which return to zero."""

    turning: Annotated[float, "s", POSITIVE] = 0.5  # of the yaw acceleration; the duration of a steering movement
    steering: Annotated[float, "s", POSITIVE] = 0.7  # of the deviation of the angle from that of a steady turn
    # of an axle under drive and brake torque; the duration of a pedal movement
    slip: Annotated[float, "s", POSITIVE] = 0.3
    road: Annotated[float, "s", POSITIVE] = 8.0  # of grade and bank; some hundred metres
    offset: Annotated[float, "s", POSITIVE] = 3000.0  # of sensor offsets and tyre errors; longer than a drive


class RollingCar:
    """The sampled model.

    Validity: forward driving, equal slip on both sides of an axle, linear tyres, any steer of rolling wheels; any
    drive, brake and road slope. Source: kinematics of the rear axle; Li, Frey, Gauterin, eq (7), with the understeer of
    a linear single track.
    """

    class State(NamedTuple):
        """Motion of the centre of the rear axle, and unknown states; offsets are deviations from the parameters.

        `steering_error` is the excess of the reading over the angle of a steady turn, by the build-up of tyre forces or
        a variable ratio. `track_width_error` is relative, by the position of the contact patches and their slip in
        tight bends. `front_wheel_speed_scale` and `front_wheel_speed_difference` are due to the wheel radii;
        `rear_slip` and `front_slip` are the excess speed of both wheels of an axle under drive and brake torque.
        `grade_acceleration` and `bank_acceleration` are the components of gravity in the measured accelerations.
        `steering_scale` is the relative error of the kinematic steering angle by ratio and wheelbase,
        `understeer_error` the error of the understeer gradient: both for guessed vehicle files.
        """

        speed: Annotated[float, "m/s"]
        acceleration: Annotated[float, "m/s**2"]
        yaw_rate: Annotated[float, "rad/s"]
        yaw_acceleration: Annotated[float, "rad/s**2"]
        steering_error: Annotated[float, "rad"]
        yaw_rate_offset: Annotated[float, "rad/s"]
        angle_offset: Annotated[float, "rad"]
        wheel_speed_difference: Annotated[float, ""]
        track_width_error: Annotated[float, ""]
        front_wheel_speed_scale: Annotated[float, ""]
        front_wheel_speed_difference: Annotated[float, ""]
        rear_slip: Annotated[float, ""]
        front_slip: Annotated[float, ""]
        grade_acceleration: Annotated[float, "m/s**2"]
        bank_acceleration: Annotated[float, "m/s**2"]
        steering_scale: Annotated[float, ""]
        understeer_error: Annotated[float, "rad*s**2/m"]

    class Input(NamedTuple):
        """No inputs: the torques and forces that move the car are unknown."""

    class Output(NamedTuple):
        wheel_speed_rear_left: Annotated[float, "m/s"]
        wheel_speed_rear_right: Annotated[float, "m/s"]
        yaw_rate: Annotated[float, "rad/s"]
        steering_wheel_angle: Annotated[float, "rad"]
        wheel_speed_front_left: Annotated[float, "m/s"]
        wheel_speed_front_right: Annotated[float, "m/s"]
        longitudinal_acceleration: Annotated[float, "m/s**2"]
        lateral_acceleration: Annotated[float, "m/s**2"]

    @dataclass(frozen=True)
    class Parameters:
        """The car, named as in a vehicle file, and the sampling interval."""

        mass: Annotated[float, "kg", POSITIVE]
        # from the centre of gravity to the axles
        front_distance: Annotated[float, "m", POSITIVE]
        rear_distance: Annotated[float, "m", POSITIVE]
        front_cornering_stiffness: Annotated[float, "N/rad", POSITIVE]
        rear_cornering_stiffness: Annotated[float, "N/rad", POSITIVE]
        track_width: Annotated[float, "m", POSITIVE]
        steering_ratio: Annotated[float, "", POSITIVE]  # road wheel angle per angle of the column
        turn_in: Annotated[float, "s"] = 0.1  # lead time of the steering angle before the yaw rate
        wheel_speed_scale: Annotated[float, ""] = 1.0  # reading of both rear wheel speeds over the speed of the wheels
        wheel_speed_difference: Annotated[float, ""] = 0.0  # relative excess of the right over the left reading
        yaw_rate_offset: Annotated[float, "rad/s"] = 0.0
        steering_wheel_angle_offset: Annotated[float, "rad"] = 0.0
        longitudinal_acceleration_offset: Annotated[float, "m/s**2"] = 0.0
        lateral_acceleration_offset: Annotated[float, "m/s**2"] = 0.0
        wander: Wander = field(default_factory=Wander)
        sample_time: Annotated[float, "s", POSITIVE] = 0.01

        # The table of relations between sensors also has those of torque and force, which this car does not measure.
        rack_ratio: ClassVar[float] = 1.0
        rack_stiffness: ClassVar[float] = 0.0
        steering_shaft_torque_offset: ClassVar[float] = 0.0
        tie_rod_force_offset: ClassVar[float] = 0.0

    @staticmethod
    def transition(x: State, u: Input | tuple[()], p: Parameters) -> State:
        step = p.sample_time
        keep = Wander(*(exp(-step / time) for time in vars(p.wander).values()))
        return RollingCar.State(
            x.speed + step * x.acceleration,
            x.acceleration,
            x.yaw_rate + step * x.yaw_acceleration,
            keep.turning * x.yaw_acceleration,
            keep.steering * x.steering_error,
            keep.offset * x.yaw_rate_offset,
            keep.offset * x.angle_offset,
            keep.offset * x.wheel_speed_difference,
            keep.offset * x.track_width_error,
            keep.offset * x.front_wheel_speed_scale,
            keep.offset * x.front_wheel_speed_difference,
            keep.slip * x.rear_slip,
            keep.slip * x.front_slip,
            keep.road * x.grade_acceleration,
            keep.road * x.bank_acceleration,
            keep.offset * x.steering_scale,
            keep.offset * x.understeer_error,
        )

    @staticmethod
    def output(x: State, u: Input | tuple[()], p: Parameters) -> Output:
        half_turn = 0.5 * p.track_width * (1.0 + x.track_width_error) * x.yaw_rate
        difference = p.wheel_speed_difference + x.wheel_speed_difference
        steer = road_wheel_angle(x, p) / p.steering_ratio
        across = motion.lateral_acceleration_of_turning(x.speed, x.yaw_rate, 0.0)
        along = x.acceleration - p.rear_distance * x.yaw_rate * x.yaw_rate
        rear = p.wheel_speed_scale * (1.0 + x.rear_slip)
        front = p.wheel_speed_scale * (1.0 + x.front_slip + x.front_wheel_speed_scale)
        sideways = (p.front_distance + p.rear_distance) * x.yaw_rate
        return RollingCar.Output(
            rear * (1.0 - 0.5 * difference) * (x.speed - half_turn),
            rear * (1.0 + 0.5 * difference) * (x.speed + half_turn),
            x.yaw_rate + p.yaw_rate_offset + x.yaw_rate_offset,
            steer + x.steering_error + p.steering_wheel_angle_offset + x.angle_offset,
            front * (1.0 - 0.5 * x.front_wheel_speed_difference) * rolling_speed(x.speed - half_turn, sideways),
            front * (1.0 + 0.5 * x.front_wheel_speed_difference) * rolling_speed(x.speed + half_turn, sideways),
            along + p.longitudinal_acceleration_offset + x.grade_acceleration,
            motion.lateral_acceleration_at(across, x.yaw_acceleration, x.yaw_rate, p.rear_distance)
            + p.lateral_acceleration_offset
            + x.bank_acceleration,
        )


def rolling_speed(forward: Scalar, sideways: Scalar) -> Scalar:
    """Speed of a wheel that rolls without slip in its own direction [m/s].

    Args: forward, sideways: motion of its hub in the directions of the car [m/s].
    """
    share = sideways / maximum(forward, LEAST_SPEED)
    return forward * sqrt(1.0 + share * share)


def road_wheel_angle(x: RollingCar.State, p: RollingCar.Parameters) -> Scalar:
    """Mean steer of the front wheels [rad] for a yaw motion: kinematic, understeer, and the steering's lead."""
    distances, stiffness = (
        (p.front_distance, p.rear_distance),
        (p.front_cornering_stiffness, p.rear_cornering_stiffness),
    )
    gradient = motion.understeer_gradient(p.mass, *distances, *stiffness)
    coming = x.yaw_rate + p.turn_in * x.yaw_acceleration
    rolling = arctan(sum(distances) * coming / maximum(x.speed, LEAST_SPEED))
    return (1.0 + x.steering_scale) * rolling + (gradient + x.understeer_error) * x.speed * coming
