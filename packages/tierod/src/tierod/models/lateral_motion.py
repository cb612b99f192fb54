"""Sampled lateral motion of a car: parameters, forces of its axles, and the model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, get_type_hints

from tierod.core.block import Model, Scalar, Tree, named_tuple
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.maths import absolute, cos, exp, limit, maximum, sin, sqrt, where
from tierod.physics.motion import (
    GRAVITY,
    front_axle_load,
    lateral_acceleration,
    lateral_acceleration_at,
    longitudinal_load_transfer,
    yaw_acceleration,
)
from tierod.physics.tyre import magic_angle

# Possible states beside the motion, with units; `log_` is the natural logarithm of the true over the given value
UNKNOWNS: dict[str, str] = {
    "log_front_stiffness": "",
    "log_rear_stiffness": "",
    "log_friction": "",
    "bank_angle": "rad",
    "side_force": "N",
    "side_moment": "N*m",
    "lateral_acceleration_bias": "m/s**2",
    "yaw_rate_bias": "rad/s",
    "road_wheel_angle_offset": "rad",
    "log_steering_friction": "",
    "log_trail": "",
}

OF_STEERING = ("log_steering_friction", "log_trail")  # Unknowns that need the steering among the states


@dataclass(frozen=True)
class LateralParameters:
    """Parameters of a car for the sideslip estimator, named as in a vehicle file."""

    mass: Annotated[float, "kg"]  # mass, yaw_inertia: of the vehicle
    yaw_inertia: Annotated[float, "kg*m**2"]
    front_distance: Annotated[float, "m"]  # front_distance, rear_distance: from the centre of gravity to the axles
    rear_distance: Annotated[float, "m"]
    # front_cornering_stiffness, rear_cornering_stiffness: of the axles at their static load
    front_cornering_stiffness: Annotated[float, "N/rad"]
    rear_cornering_stiffness: Annotated[float, "N/rad"]
    centre_height: Annotated[float, "m"] = 0.5  # of the centre of gravity, above ground
    # of the front axle's lateral force; shorter than that of the tyre, because of the compliance of the suspension,
    # which acts later
    relaxation_length: Annotated[float, "m"] = 0.3
    rear_relaxation_ratio: Annotated[float, ""] = 1.0  # relaxation length of the rear axle over that of the front axle
    tyre_friction: Annotated[float, ""] = 1.0  # peak lateral force over load of the front axle on a dry road
    rear_friction_ratio: Annotated[float, ""] = 1.0  # friction of the rear axle over that of the front axle
    # front_force_shape, rear_force_shape: C of the Magic Formula of the axles, with the compliance of the suspension;
    # the higher, the longer the force stays linear
    front_force_shape: Annotated[float, ""] = 1.4
    rear_force_shape: Annotated[float, ""] = 1.4
    # Ct of the pneumatic trail; above the force's shape the trail vanishes before the peak of the force
    trail_shape: Annotated[float, ""] = 1.15
    # load transferred to the outer front wheel per lateral force of the axle; the pneumatic trail grows with the load
    front_load_transfer: Annotated[float, ""] = 0.3
    # relative growth of the cornering stiffness per relative growth of the load
    stiffness_growth: Annotated[float, ""] = 0.6
    mechanical_trail: Annotated[float, "m"] = 0.023  # of the front axle
    pneumatic_trail: Annotated[float, "m"] = 0.03  # of both axles, without slip
    # component of gravity in the measured lateral acceleration by roll, per acceleration
    roll_share: Annotated[float, ""] = 0.05
    # roll_frequency, roll_damping_ratio: natural frequency and damping ratio of the body's roll
    roll_frequency: Annotated[float, "rad/s"] = 14.0
    roll_damping_ratio: Annotated[float, ""] = 0.4
    roll_arm: Annotated[float, "m"] = 0.4  # height of the centre of gravity above the roll axis
    sensor_forward: Annotated[float, "m"] = 0.0  # distance of the accelerometer ahead of the centre of gravity
    # drive_front_share, brake_front_share: share of the longitudinal force at the front axle
    drive_front_share: Annotated[float, ""] = 0.5
    brake_front_share: Annotated[float, ""] = 0.65
    road_wheel_inertia: Annotated[float, "kg*m**2"] = 3.5  # of everything that turns with the road wheels, J_w
    road_wheel_damping: Annotated[float, "N*m*s/rad"] = 160.0  # viscous, at the road wheels, b_w
    road_wheel_friction: Annotated[float, "N*m"] = 30.0  # level of dry friction at the road wheels, F_w
    # angle over which that friction builds up linearly; 3/4 of the angle of Dahl's law
    road_wheel_friction_angle: Annotated[float, "rad"] = 1.3e-3


@dataclass(frozen=True)
class Sampled:
    """Parameters of the sampled model."""

    car: LateralParameters  # as in the vehicle file
    sample_time: Annotated[float, "s"]  # sampling interval
    usual: tuple[float, ...] = ()  # value to which every unknown returns, in their order
    fading: tuple[float, ...] = ()  # share of the deviation from it that is left after a sample; one for a random walk


# Smallest share of the friction that is left for the lateral force under braking [-], so that it stays positive
LEAST_ACROSS = 0.3


class AxleLoad(NamedTuple):
    """Loads of an axle: vertical force [N], static vertical force [N], and force along the wheels [N]."""

    vertical: Scalar
    static: Scalar
    longitudinal: Scalar


class AxleForce(NamedTuple):
    """Force across the wheels [N], its largest possible value [N], angle inside the Magic Formula [rad]."""

    lateral: Scalar
    greatest: Scalar
    angle: Scalar


def axle_force(
    slip: Scalar, stiffness: Scalar, friction: Scalar, shape: Scalar, load: AxleLoad, growth: Scalar
) -> AxleForce:
    """Lateral force of an axle, and the other fields of `AxleForce`.

    The slip is scaled so that the slope at zero is the stiffness for any friction (similarity); the force along the
    wheels reduces the lateral friction by the friction ellipse.
    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed., sections 4.2 and 4.3.

    Args: slip: tangent of the slip angle, positive where the force is to the left [-]; stiffness: cornering stiffness
    at the static load [N/rad]; friction: peak force over load [-], positive; shape: C of the Magic Formula [-], above
    1; its curvature E is zero; growth: relative growth of the stiffness per relative growth of the load [-].
    """
    grip = friction * load.vertical
    used = load.longitudinal / grip
    greatest = grip * sqrt(maximum(1.0 - used * used, LEAST_ACROSS * LEAST_ACROSS))
    slope = stiffness * (1.0 + growth * (load.vertical / load.static - 1.0))
    angle = magic_angle(slope / (shape * greatest) * slip, 0.0)
    return AxleForce(greatest * sin(shape * angle), greatest, angle)


class Body(NamedTuple):
    """Lateral speed of the centre of gravity, yaw rate, and the lateral deflections of the axles' tyres."""

    lateral_speed: Annotated[float, "m/s"]
    yaw_rate: Annotated[float, "rad/s"]
    front_deflection: Annotated[float, "m"]
    rear_deflection: Annotated[float, "m"]


class Roll(NamedTuple):
    """Roll of the body, positive with the right side down."""

    roll_angle: Annotated[float, "rad"]
    roll_rate: Annotated[float, "rad/s"]


class Steering(NamedTuple):
    road_wheel_angle: Annotated[float, "rad"]
    road_wheel_rate: Annotated[float, "rad/s"]
    friction_share: Annotated[float, ""]


class Driven(NamedTuple):
    """Inputs of a car with known steering angle: speed, longitudinal acceleration, mean steer of the road wheels."""

    vehicle_speed: Annotated[float, "m/s"]
    longitudinal_acceleration: Annotated[float, "m/s**2"]
    road_wheel_angle: Annotated[float, "rad"]


class DrivenByWire(NamedTuple):
    """Inputs of a car with the steering as states; its rate is held while the torque is unknown (`torque_known` 0)."""

    vehicle_speed: Annotated[float, "m/s"]
    longitudinal_acceleration: Annotated[float, "m/s**2"]
    road_wheel_torque: Annotated[float, "N*m"]
    torque_known: Annotated[float, ""]


class Measured(NamedTuple):
    """Measurements of an inertial unit."""

    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]


class MeasuredByWire(NamedTuple):
    """Measurements of an inertial unit and the angle sensor of the road wheels."""

    yaw_rate: Annotated[float, "rad/s"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    road_wheel_angle: Annotated[float, "rad"]


class Forces(NamedTuple):
    """Forces of both axles and the torque that they make about the kingpins."""

    front: AxleForce  # front, rear: forces across the wheels
    rear: AxleForce
    front_across: Scalar  # front_across, rear_across: forces across the body [N]
    rear_across: Scalar
    front_slip: Scalar  # front_slip, rear_slip: tangents of the effective slip angles [-]
    rear_slip: Scalar
    pneumatic_trail: Scalar  # pneumatic_trail, rear_trail: pneumatic trails of the axles [m]
    rear_trail: Scalar
    self_aligning_torque: Scalar  # of the front axle, opposing positive steer [N*m]


# Smallest rolling speed in the relaxation of a tyre [m/s], which keeps its steady deflection finite at standstill
SLOWEST = 0.1
LEAST_LOAD = 0.2  # Smallest load of an axle over its static load, whatever the acceleration [-]
_MOST = 2.0


@lru_cache(maxsize=64)
def lateral_motion(unknowns: tuple[str, ...] = (), *, roll: bool = False, steering: bool = False) -> Model:
    """The sampled model with a selection of states.

    Args: roll: whether roll angle and rate are states; else the roll angle follows the lateral acceleration at once;
    steering: whether an actuator torque turns the road wheels; else their angle is an input.

    Returns:
        a discrete model; its `Parameters` are `Sampled`, whose `usual` and `fading` have one entry per unknown. It
            has
        an additional function `forces(x, u, p)`
    """
    for name in unknowns:
        if name not in UNKNOWNS:
            raise ParameterError(f"'{name}' is no unknown of the lateral motion{nearest(name, UNKNOWNS)}")
        if name in OF_STEERING and not steering:
            raise ParameterError(f"'{name}' needs the steering among the states; give steering=True or leave it out")
    return type("LateralMotion", (LateralMotion,), _members(unknowns, roll, steering))


def _members(unknowns: tuple[str, ...], roll: bool, steering: bool) -> dict[str, Any]:
    parts = [Body, *([Roll] if roll else []), *([Steering] if steering else [])]
    states = [each for part in parts for each in get_type_hints(part, include_extras=True).items()]
    states += [(name, Annotated[float, UNKNOWNS[name]]) for name in unknowns]
    state = named_tuple("State", states)
    state.__doc__ = "Motion, and what the car does not know about itself."
    return {
        "__module__": __name__,
        "__doc__": "Lateral motion, sampled; see `lateral_motion`.",
        "__made_by__": (lateral_motion, (unknowns, roll, steering)),
        "State": state,
        "Input": DrivenByWire if steering else Driven,
        "Output": MeasuredByWire if steering else Measured,
        "Parameters": Sampled,
        "unknowns": unknowns,
        "roll": roll,
        "steering": steering,
    }


class _Seen(NamedTuple):
    """Parts of a state: its motions, and the value of every unknown, zero where it is no state."""

    body: Body
    roll: Roll
    steering: Steering
    unknown: dict[str, Scalar]


class LateralMotion:
    """Equations of the model; the class attributes are set by `lateral_motion`."""

    State: type
    unknowns: tuple[str, ...]
    roll: bool
    steering: bool

    @classmethod
    def transition(cls, x: Tree, u: Tree, p: Sampled) -> Tree:
        seen, step = cls._seen(x, u), p.sample_time
        half = seen._replace(body=cls._deflected(seen, u, p, 0.5 * step))
        forces = cls._forces(half, u, p)
        moved = half._replace(
            body=cls._moved(half, forces, u, p),
            roll=cls._rolled(half, forces, p),
            steering=cls._steered(half, forces, u, p),
        )
        moved = moved._replace(body=cls._deflected(moved, u, p, 0.5 * step))
        unknowns = zip(x[len(x) - len(cls.unknowns) :], p.usual, p.fading, strict=True)
        faded = [usual + (value - usual) * share for value, usual, share in unknowns]
        parts = [*moved.body, *(moved.roll if cls.roll else ()), *(moved.steering if cls.steering else ()), *faded]
        return cls.State(*parts)

    @classmethod
    def output(cls, x: Tree, u: Tree, p: Sampled) -> Measured | MeasuredByWire:
        seen = cls._seen(x, u)
        forces, car, unknown = cls._forces(seen, u, p), p.car, seen.unknown
        centre = cls._acceleration(seen, forces, p)
        yaw = cls._yaw_acceleration(seen, forces, p)
        at_sensor = lateral_acceleration_at(centre, yaw, seen.body.yaw_rate, car.sensor_forward)
        lean = GRAVITY * seen.roll.roll_angle if cls.roll else car.roll_share * centre
        measured = Measured(
            seen.body.yaw_rate + unknown["yaw_rate_bias"],
            at_sensor + lean + unknown["lateral_acceleration_bias"],
        )
        if not cls.steering:
            return measured
        return MeasuredByWire(*measured, seen.steering.road_wheel_angle - unknown["road_wheel_angle_offset"])

    @classmethod
    def forces(cls, x: Tree, u: Tree, p: Sampled) -> Forces:
        """Forces of the axles in a state."""
        return cls._forces(cls._seen(x, u), u, p)

    @classmethod
    def _seen(cls, x: Tree, u: Tree) -> _Seen:
        first = 6 if cls.roll else 4
        unknown = dict.fromkeys(UNKNOWNS, 0.0) | dict(zip(cls.unknowns, x[len(x) - len(cls.unknowns) :], strict=True))
        roll = Roll(x[4], x[5]) if cls.roll else Roll(0.0, 0.0)
        if cls.steering:
            steering = Steering(*x[first : first + 3])
        else:
            steering = Steering(u.road_wheel_angle + unknown["road_wheel_angle_offset"], 0.0, 0.0)
        return _Seen(Body(*x[:4]), roll, steering, unknown)

    @classmethod
    def _deflected(cls, seen: _Seen, u: Tree, p: Sampled, time: Scalar) -> Body:
        body, car, sine, cosine = seen.body, p.car, *_direction(seen)
        across = body.lateral_speed + (car.roll_arm * seen.roll.roll_rate if cls.roll else 0.0)
        front = across + car.front_distance * body.yaw_rate
        rear = across - car.rear_distance * body.yaw_rate
        along, length = u.vehicle_speed, car.relaxation_length
        pairs = (
            (body.front_deflection, sine * along - cosine * front, cosine * along + sine * front, length),
            (body.rear_deflection, -rear, along, length * car.rear_relaxation_ratio),
        )
        after = []
        for deflection, slip_speed, speed, length in pairs:
            rolling = maximum(absolute(speed), SLOWEST)
            left = exp(-time * rolling / length)
            after.append(deflection * left + slip_speed * length / rolling * (1.0 - left))
        return body._replace(front_deflection=after[0], rear_deflection=after[1])

    @classmethod
    def _forces(cls, seen: _Seen, u: Tree, p: Sampled) -> Forces:
        car, unknown = p.car, seen.unknown
        friction = car.tyre_friction * _factor(unknown["log_friction"])
        along = car.mass * u.longitudinal_acceleration
        shift = longitudinal_load_transfer(along, car.centre_height, car.front_distance + car.rear_distance)
        share = where(along > 0.0, car.drive_front_share, car.brake_front_share)
        static = front_axle_load(car.mass, car.front_distance, car.rear_distance)
        other = front_axle_load(car.mass, car.rear_distance, car.front_distance)
        front_slip = seen.body.front_deflection / car.relaxation_length
        rear_slip = seen.body.rear_deflection / (car.relaxation_length * car.rear_relaxation_ratio)
        front = axle_force(
            front_slip,
            car.front_cornering_stiffness * _factor(unknown["log_front_stiffness"]),
            friction,
            car.front_force_shape,
            AxleLoad(maximum(static - shift, LEAST_LOAD * static), static, share * along),
            car.stiffness_growth,
        )
        rear = axle_force(
            rear_slip,
            car.rear_cornering_stiffness * _factor(unknown["log_rear_stiffness"]),
            friction * car.rear_friction_ratio,
            car.rear_force_shape,
            AxleLoad(maximum(other + shift, LEAST_LOAD * other), other, (1.0 - share) * along),
            car.stiffness_growth,
        )
        sine, cosine = _direction(seen)
        pneumatic = cls._trail(front, static, p) * _factor(unknown["log_trail"])
        across = cosine * front.lateral + sine * share * along
        behind = car.pneumatic_trail * cos(car.trail_shape * rear.angle)
        torque = (pneumatic + car.mechanical_trail) * front.lateral
        return Forces(front, rear, across, rear.lateral, front_slip, rear_slip, pneumatic, behind, torque)

    @classmethod
    def _trail(cls, front: AxleForce, load: Scalar, p: Sampled) -> Scalar:
        """Pneumatic trail of the axle [m]: for each wheel in proportion to its load, falling to zero with the slip."""
        car = p.car
        moved = 2.0 * car.front_load_transfer * front.lateral / load
        return car.pneumatic_trail * (1.0 + moved * moved) * cos(car.trail_shape * front.angle)

    @classmethod
    def _acceleration(cls, seen: _Seen, forces: Forces, p: Sampled) -> Scalar:
        """Lateral acceleration at the centre of gravity by all forces except gravity [m/s**2]."""
        own = lateral_acceleration(forces.front_across, forces.rear_across, p.car.mass)
        return own + seen.unknown["side_force"] / p.car.mass

    @classmethod
    def _yaw_acceleration(cls, seen: _Seen, forces: Forces, p: Sampled) -> Scalar:
        car = p.car
        own = yaw_acceleration(
            forces.front_across, forces.rear_across, car.yaw_inertia, car.front_distance, car.rear_distance
        )
        trails = forces.pneumatic_trail * forces.front.lateral + forces.rear_trail * forces.rear.lateral
        return own + (seen.unknown["side_moment"] - trails) / car.yaw_inertia

    @classmethod
    def _moved(cls, seen: _Seen, forces: Forces, u: Tree, p: Sampled) -> Body:
        """Lateral speed and yaw rate after a sample; their coupling takes the mean yaw rate (midpoint rule)."""
        body, step = seen.body, p.sample_time
        yaw_rate = body.yaw_rate + step * cls._yaw_acceleration(seen, forces, p)
        gravity = GRAVITY * sin(limit(seen.unknown["bank_angle"], -0.5, 0.5))
        turning = u.vehicle_speed * 0.5 * (body.yaw_rate + yaw_rate)
        rate = cls._acceleration(seen, forces, p) - turning - gravity
        return body._replace(lateral_speed=body.lateral_speed + step * rate, yaw_rate=yaw_rate)

    @classmethod
    def _rolled(cls, seen: _Seen, forces: Forces, p: Sampled) -> Roll:
        """Roll after a sample: the rate first, then the angle from the new rate (semi-implicit Euler)."""
        if not cls.roll:
            return seen.roll
        car, step, roll = p.car, p.sample_time, seen.roll
        goal = car.roll_share / GRAVITY * lateral_acceleration(forces.front_across, forces.rear_across, car.mass)
        swing, fade = car.roll_frequency * car.roll_frequency, 2.0 * car.roll_damping_ratio * car.roll_frequency
        rate = (roll.roll_rate + step * swing * (goal - roll.roll_angle)) / (1.0 + step * fade)
        return Roll(roll.roll_angle + step * rate, rate)

    @classmethod
    def _steered(cls, seen: _Seen, forces: Forces, u: Tree, p: Sampled) -> Steering:
        """Steering after a sample, implicit in damping and friction, with elastic-plastic friction (Prandtl).

        Unlike Dahl's law, this friction does not creep under small oscillations of an estimated angle. Its stiffness
        acts only until it slips: the rate is computed with the elastic stiffness first, then again with the limited
        friction (return mapping).
        """
        if not cls.steering:
            return seen.steering
        car, step, steering = p.car, p.sample_time, seen.steering
        level = car.road_wheel_friction * _factor(seen.unknown["log_steering_friction"])
        driving = u.road_wheel_torque - forces.self_aligning_torque
        damped = car.road_wheel_inertia + step * car.road_wheel_damping
        stopped = damped + step * step * level / car.road_wheel_friction_angle

        def rate(share: Scalar, inertia: Scalar) -> Scalar:
            impulse: Scalar = step * (driving - level * share)
            moving = (car.road_wheel_inertia * steering.road_wheel_rate + impulse) / inertia
            after: Scalar = where(u.torque_known > 0.5, moving, steering.road_wheel_rate)
            return after

        held = step * rate(steering.friction_share, stopped)
        share = limit(steering.friction_share + held / car.road_wheel_friction_angle, -1.0, 1.0)
        after = rate(share, damped)
        return Steering(steering.road_wheel_angle + step * after, after, share)


def _factor(logarithm: Scalar) -> Scalar:
    """Factor of a logarithmic unknown, limited to 1/7 to 7."""
    return exp(limit(logarithm, -_MOST, _MOST))


def _direction(seen: _Seen) -> tuple[Scalar, Scalar]:
    angle = seen.steering.road_wheel_angle
    return sin(angle), cos(angle)
