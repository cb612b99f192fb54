"""The residuals of sensors and actuators as one block: r1 to r19, r1a to r8a, and four beyond the paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, Tree, named_tuple
from tierod.core.fields import POSITIVE
from tierod.core.graph.maths import (
    absolute,
    all_of,
    arctan,
    both,
    cos,
    limit,
    maximum,
    minimum,
    present,
    tan,
    where,
)
from tierod.core.signals import SIGNALS
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.filters import InputHold
from tierod.models.single_track import SingleTrack
from tierod.monitors.condition.signals import OF_AUTOMATED, TARGETS, ConditionSample, Measured
from tierod.physics.friction import share_reached
from tierod.physics.motion import _ratio, lateral_acceleration_of_turning, longitudinal_acceleration
from tierod_lab.methods.unscented import UnscentedFilter
from tierod_lab.papers.condition.rules.filters import AdaptiveSpeed, LostShares, SteeringSignals
from tierod_lab.papers.condition.rules.models import StiffRack, discretise_stiff, lateral_filter, one_body
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, CarParameters, Coefficients, Residual, part

Targets: Any = named_tuple(
    "Targets",
    [
        (name, Annotated[float, SIGNALS[name].unit])
        for name in (*TARGETS, "target_steering_wheel_angle", "target_vehicle_speed")
    ],
)
"""Targets of the controller; NaN where missing."""

Residuals: Any = named_tuple("Residuals", [(each.name, Annotated[float, each.unit]) for each in RESIDUALS.values()])
"""Every residual in its unit; zero where it is missing."""

Flags: Any = named_tuple("Flags", [(name, Annotated[float, ""]) for name in RESIDUALS])
"""Presence of each residual as a flag, 1.0 or 0.0."""

MAIN = dict(zip(OF_AUTOMATED, ("r10", "r14", "r4", "r2", "r3", "r19"), strict=True))
"""Sensor -> main residual, which compares its reading with the expected one."""

_MOST_STEER = 1.2
"""Bound of the road-wheel angle [rad], so that a faulty sensor cannot carry the routes over the pole of the tangent."""


def steer_of_rolling(yaw_rate: Scalar, left: Scalar, right: Scalar, car: CarParameters) -> Scalar:
    """Mean steer angle of the front wheels [rad] from yaw rate and rear wheel speeds, for rolling without slip.

    An understeering vehicle needs more steer. Source: Li, Frey, Gauterin, eqs (7), (8), as atan(r L / (v + r lever)):
    the printed cotangents are singular at zero steer. Each line gives the angle of the single track, not that of the
    left or right wheel as its symbols suggest.
    """
    half, turn = 0.5 * car.track_width, yaw_rate * (car.front_distance + car.rear_distance)
    by_left = arctan(_ratio(turn, left + yaw_rate * half))
    return 0.5 * (by_left + arctan(_ratio(turn, right - yaw_rate * half)))


class Route(NamedTuple):
    """Sideslip angle and speeds of both rear wheels over that of the centre of gravity, by a road-wheel angle."""

    sideslip: Scalar
    left: Scalar
    right: Scalar

    @classmethod
    def of(cls, road_wheel_angle: Scalar, car: CarParameters) -> Route:
        """Eqs (22) to (25), for rolling without slip; the radicand of eqs (24) to (33) is the square of a share."""
        turned = tan(limit(road_wheel_angle, -_MOST_STEER, _MOST_STEER)) / (car.front_distance + car.rear_distance)
        sideslip = arctan(car.rear_distance * turned)
        aside = 0.5 * car.track_width * cos(sideslip) * turned
        return cls(sideslip, absolute(cos(sideslip) - aside), absolute(cos(sideslip) + aside))

    def by_mean(self, left: Scalar, right: Scalar, misprint: bool = False) -> tuple[Scalar, Scalar]:
        """Speeds of both rear wheels [m/s] from the mean of their central speeds: eqs (24) to (33).

        Args:
            left, right: measured wheel speeds [m/s]
            misprint: whether the right wheel is divided by the share of the left one, as eq (27) is printed
        """
        centre = 0.5 * (_ratio(left, self.left) + _ratio(right, self.left if misprint else self.right))
        return centre * self.left, centre * self.right

    def by_speed(self, forward_speed: Scalar) -> tuple[Scalar, Scalar]:
        """Speeds of both rear wheels [m/s] from a forward speed of the centre of gravity, as in eqs (35) to (41)."""
        centre = forward_speed / cos(self.sideslip)
        return centre * self.left, centre * self.right


class Seen(NamedTuple):
    """What the residuals of one sample are computed from."""

    now: Measured  # readings, zero where missing
    steer: SteeringSignals.Output  # low-passed signals of the steering and their rates
    balanced: Scalar  # estimate of the filter of r1 [rad]
    turning: SingleTrack.State  # estimate of the lateral filter
    forward: AdaptiveSpeed.Output


class Responses(NamedTuple):
    """State of the residuals of the actuators."""

    ideal: SingleTrack.State  # motion by the targets
    target_speed: Scalar  # filtered [m/s]
    shares: tuple[tuple[Scalar, ...], ...]  # of motors, drives and side
    asked: Scalar  # steering torque of the last sample [N*m]
    unrest: Scalar  # recent change of it [N*m]


@dataclass(frozen=True)
class ResidualSet:
    """All residuals at every sample, each with a flag for its presence.

    Those of the actuators are the response to the targets less the readings, of which the declared ones are replaced by
    expected ones.

    Args:
        coefficients: coefficients of `calibrate_residuals`
        steering: low-passes and derivatives of the signals of the steering
        angle: filter of r1; as in the paper it measures the angle, so that it follows a faulty sensor after a jump
        motors: lost shares of both steering torques; the shaft torque is that of its sensor or that of the motion of
            the steering, whichever lacks less, since a faulty torque sensor is no faulty motor
        drives: share of the drive torque that the longitudinal acceleration lacks
        side: share of the drive torque that appears as a force at the tie rods, as when one side alone drives
        moving: speed of the faster rear wheel below which the vehicle counts as standing
        most_lateral_acceleration: limit above which residuals of the single-track model are disabled, as its tyres are
            linear
        settling: time for which a signal must have been present before its residuals are enabled, as filters restart
        speed_memory: time constant of the derivative of the target speed
        restless: change of the commanded steering torque per sample, halved with each, above which the shaft torque is
            not compared with it, since motors and bus lag
        printed: whether eqs (9), (11), (14), (27) and (46) keep their misprints

    Source: Li, Frey, Gauterin, eqs (6) to (52). Build it by `residual_set`.
    """

    car: CarParameters
    coefficients: Coefficients
    hold: InputHold
    targets: InputHold
    steering: SteeringSignals
    angle: UnscentedFilter
    lateral: KalmanFilter
    speed: AdaptiveSpeed
    motors: LostShares
    drives: LostShares
    side: LostShares
    moving: Annotated[float, "m/s", POSITIVE] = 1.5
    most_lateral_acceleration: Annotated[float, "m/s**2", POSITIVE] = 6.0
    settling: Annotated[float, "s", POSITIVE] = 1.0
    speed_memory: Annotated[float, "s", POSITIVE] = 0.1
    restless: Annotated[float, "N*m", POSITIVE] = 1.0
    printed: bool = False

    Sample = ConditionSample

    class State(NamedTuple):
        hold: Tree
        targets: Tree
        filters: Tree  # of steering, angle, lateral and speed
        waited: Measured  # time for which each signal has been present [s], at most twice `settling`
        actuators: Responses

    class Output(NamedTuple):
        residuals: Residuals
        there: Flags
        held: Measured

    @property
    def _track(self) -> SingleTrack.Parameters:
        found: SingleTrack.Parameters = part(SingleTrack.Parameters, self.car)
        return found

    def init(self) -> State:
        filters = tuple(each.init() for each in (self.steering, self.angle, self.lateral, self.speed))
        shares = tuple(each.init() for each in (self.motors, self.drives, self.side))
        actuators = Responses(SingleTrack.State(0.0, 0.0), 0.0, shares, 0.0, 0.0)
        waited = Measured(*(0.0,) * len(Measured._fields))
        return self.State(self.hold.init(), self.targets.init(), filters, waited, actuators)

    def step(
        self, state: State, sample: ConditionSample, faulty: Mapping[str, Scalar] | None = None
    ) -> tuple[State, Output]:
        """The residuals of a sample.

        Args:
            faulty: flags of the sensors whose readings are replaced for the residuals of the actuators
        """
        hold, held = self.hold.step(state.hold, Measured(*(getattr(sample, name) for name in Measured._fields)))
        targets, asked = self.targets.step(state.targets, Targets(*(getattr(sample, name) for name in Targets._fields)))
        # Zeros in place of NaN keep the state finite; the flags exclude the residuals of missing signals.
        now, wanted = (type(each)(*(where(present(value), value, 0.0) for value in each)) for each in (held, asked))
        moving = maximum(now.wheel_speed_rear_left, now.wheel_speed_rear_right) > self.moving
        filters, seen = self._filtered(state.filters, held, now)
        waited = Measured(*(self._waited(*each) for each in zip(state.waited, held, strict=True)))
        known = {name: each > self.settling for name, each in waited._asdict().items()}
        gentle = absolute(now.lateral_acceleration) < self.most_lateral_acceleration
        expected, values = self.of_sensors(seen)
        there = {name: self._there(RESIDUALS[name], known, moving=moving, gentle=gentle) for name in values}
        values = {name: where(there[name], value, 0.0) for name, value in values.items()}
        repaired = held
        for name, wrong in (faulty or {}).items():
            reading = getattr(held, name)
            other = where(there[MAIN[name]] > 0.5, reading + values[MAIN[name]], reading)
            repaired = repaired._replace(**{name: where(wrong > 0.5, other, reading)})
        torques = held.steering_shaft_torque, expected["r3"], values["r19"]
        after, more, flags = self._actuators(state.actuators, asked, wanted, repaired, seen, torques)
        output = self.Output(Residuals(**values, **more), Flags(**there, **flags), held)
        return self.State(hold, targets, filters, waited, after), output

    def _filtered(self, state: Tree, held: Measured, now: Measured) -> tuple[Tree, Seen]:
        """Advances the filters of the readings by one sample; returns their states and estimates."""
        balance = held.steering_wheel_angle, held.steering_shaft_torque, held.tie_rod_force, held.lateral_acceleration
        steering, steer = self.steering.step(state[0], self.steering.Sample(*balance))
        torques = StiffRack.Input(held.steering_shaft_torque, held.tie_rod_force)
        reading = StiffRack.Output(held.steering_wheel_angle)
        angle, balanced = self.angle.step(state[1], self.angle.Sample(torques, reading))
        speed = maximum(0.5 * (now.wheel_speed_rear_left + now.wheel_speed_rear_right), self.moving)
        inputs = SingleTrack.Input(self._steer(held), speed)
        motion = SingleTrack.Output(held.yaw_rate, held.lateral_acceleration)
        lateral, turning = self.lateral.step(state[2], self.lateral.Sample(inputs, motion))
        along = held.longitudinal_acceleration, held.yaw_rate, turning.mean.sideslip_angle
        fused, forward = self.speed.step(state[3], AdaptiveSpeed.Sample(*along, *held[:2]))
        seen = Seen(now, steer, balanced.mean.steering_wheel_angle, turning.mean, forward)
        return (steering, angle, lateral, fused), seen

    def _steer(self, readings: Measured) -> Scalar:
        """Road-wheel angle by the steering angle [rad]."""
        angle: Scalar = readings.steering_wheel_angle - self.coefficients.angle_offset
        return self.car.steering_ratio * angle

    def _waited(self, before: Scalar, value: Scalar) -> Scalar:
        waited: Scalar = minimum(before + self.hold.sample_time, 2.0 * self.settling)
        return where(present(value), waited, 0.0)

    @staticmethod
    def _there(each: Residual, known: Mapping[str, Scalar], **enabled: Scalar) -> Scalar:
        """Whether all signals of a residual are present and its enabling conditions hold, 1.0 or 0.0."""
        asked = [flag for name, flag in enabled.items() if getattr(each, name)]
        return where(all_of(*(known[name] for name in each.signals), *asked), 1.0, 0.0)

    def _steering(self, seen: Seen, rolling: Scalar) -> dict[str, Scalar]:
        """Expected angle (r2), shaft torque (r3) and tie-rod force (r19): eqs (9) to (12), (46), (47)."""
        known, car, steer, now = self.coefficients, self.car, seen.steer, seen.now
        mean = 0.5 * (now.wheel_speed_rear_left + now.wheel_speed_rear_right)
        if self.printed:
            # Misprints: inverted ratio in eq (9), friction without the sign of the rate in eqs (11) and (46).
            angle = rolling * car.steering_ratio
            friction, about = car.nominal_friction, -car.nominal_friction
        else:
            angle = (rolling + known.understeer * mean * now.yaw_rate) / car.steering_ratio + known.angle_offset
            friction, about = known.friction * steer.direction, known.force_friction * steer.direction
        motion = known.angle * steer.angle + known.rate * steer.rate + known.acceleration * steer.acceleration
        across = steer.lateral_acceleration
        force = known.per_mass * car.mass * across + known.per_torque * (steer.torque - about)
        torque = motion + friction + known.cornering * across + known.torque_offset
        return {"r2": angle, "r3": torque, "r19": force + known.force_offset}

    def of_sensors(self, seen: Seen) -> tuple[dict[str, Scalar], dict[str, Scalar]]:
        """Expected signals of the steering, and r1 to r19 from eqs (6) to (47)."""
        now, steer, turning, forward = seen.now, seen.steer, seen.turning, seen.forward
        left, right = now.wheel_speed_rear_left, now.wheel_speed_rear_right
        mean = 0.5 * (left + right)
        rolling = steer_of_rolling(now.yaw_rate, left, right, self.car)
        expected = self._steering(seen, rolling)
        by_yaw, by_angle = (Route.of(each, self.car) for each in (rolling, self._steer(now)))
        yaw_left, yaw_right = by_yaw.by_mean(left, right, misprint=self.printed)
        angle_left, angle_right = by_angle.by_mean(left, right)
        own_left, own_right = by_yaw.by_speed(forward.forward_speed)
        other_left, other_right = by_angle.by_speed(forward.forward_speed)
        speed, sideslip = maximum(mean, self.moving), turning.sideslip_angle
        # Eqs (18) and (19).
        rate = 0.5 * (forward.left_rate + forward.right_rate)
        along = longitudinal_acceleration(rate, speed, sideslip, now.yaw_rate)
        slope = SingleTrack.derivative(turning, SingleTrack.Input(self._steer(now), speed), self._track)
        across = lateral_acceleration_of_turning(speed, now.yaw_rate, slope.sideslip_angle)
        filtered = longitudinal_acceleration(forward.forward_rate, forward.forward_speed, sideslip, now.yaw_rate)
        values = {
            "r1": seen.balanced - now.steering_wheel_angle,
            "r2": expected["r2"] - now.steering_wheel_angle,
            "r3": expected["r3"] - steer.torque,
            "r4": turning.yaw_rate - now.yaw_rate,
            "r5": along - now.longitudinal_acceleration,
            "r6": across - now.lateral_acceleration,
            "r7": yaw_left - left,
            "r8": own_left - left,
            "r9": angle_left - left,
            "r10": other_left - left,
            "r11": yaw_right - right,
            "r12": own_right - right,
            "r13": angle_right - right,
            "r14": other_right - right,
            "r15": forward.forward_speed - mean,
            "r16": filtered - now.longitudinal_acceleration,
            "r17": sideslip - by_angle.sideslip,
            "r18": sideslip - by_yaw.sideslip,
            "r19": expected["r19"] - steer.force,
        }
        return expected, values

    def _actuators(
        self,
        state: Responses,
        asked: Targets,
        wanted: Targets,
        repaired: Measured,
        seen: Seen,
        torques: tuple[Scalar, Scalar, Scalar],
    ) -> tuple[Responses, dict[str, Scalar], dict[str, Scalar]]:
        """Next states, residuals and flags of the actuators: eqs (48) to (52), and the lost shares of torques.

        Args:
            torques: shaft torque by its sensor and by the motion of the steering, and residual of the tie-rod force
        """
        now = Measured(*(where(present(value), value, 0.0) for value in repaired))
        moving = minimum(wanted.target_vehicle_speed, maximum(*now[:2])) > self.moving
        speed = maximum(wanted.target_vehicle_speed, self.moving)
        turn = SingleTrack.Input(self.car.steering_ratio * wanted.target_steering_wheel_angle, speed)
        model: Any = discretise_stiff(SingleTrack)
        time = self.hold.sample_time
        ideal = model.transition(state.ideal, turn, model.Parameters(self._track, time))
        ideal = SingleTrack.State(*(where(moving, value, 0.0) for value in ideal))
        change = share_reached(time / self.speed_memory) * (wanted.target_vehicle_speed - state.target_speed)
        use = all_of(moving, *(present(each) for each in (*repaired, *asked)))
        steering = wanted.steering_motor_1_target_torque + wanted.steering_motor_2_target_torque
        unrest = maximum(absolute(steering - state.asked), 0.5 * state.unrest)
        steady = unrest < self.restless
        values = self._responses(wanted, now, seen, ideal, turn, change / time)
        gaps = steering - torques[0] + self.coefficients.torque_offset, steering - torques[1]
        missing = where(absolute(gaps[1]) < absolute(gaps[0]), gaps[1], gaps[0])
        motors, by_motor = self.motors.step(state.shares[0], LostShares.Sample(missing, *wanted[:2]), both(use, steady))
        driving = wanted.target_drive_torque_left + wanted.target_drive_torque_right
        lacking = driving - self._driven(now) * self.car.wheel_radius
        drives, by_sum = self.drives.step(state.shares[1], LostShares.Sample(lacking, driving, 0.0), use)
        turned = LostShares.Sample(torques[2] * self.car.wheel_radius, driving, 0.0)
        side, by_side = self.side.step(state.shares[2], turned, use)
        values |= {"motor_1_share": by_motor.first, "motor_2_share": by_motor.second}
        values |= {"drive_share": by_sum.first, "drive_side": by_side.first}
        known = {name: present(value) for each in (asked, repaired) for name, value in each._asdict().items()}
        there = {name: self._there(RESIDUALS[name], known, moving=moving, steady=steady) for name in values}
        values = {name: where(there[name], value, 0.0) for name, value in values.items()}
        after = Responses(ideal, state.target_speed + change, (motors, drives, side), steering, unrest)
        return after, values, there

    def _responses(
        self,
        wanted: Targets,
        now: Measured,
        seen: Seen,
        ideal: SingleTrack.State,
        turn: SingleTrack.Input,
        speed_rate: Scalar,
    ) -> dict[str, Scalar]:
        """r1a to r8a by eqs (48) to (52)."""
        known, car = self.coefficients, self.car
        across = SingleTrack.output(ideal, turn, self._track).lateral_acceleration
        along = longitudinal_acceleration(speed_rate, turn.vehicle_speed, ideal.sideslip_angle, ideal.yaw_rate)
        asked = wanted.steering_motor_1_target_torque + wanted.steering_motor_2_target_torque
        force = known.per_mass * car.mass * across + known.per_torque * asked
        mean = 0.5 * (now.wheel_speed_rear_left + now.wheel_speed_rear_right)
        return {
            "r1a": ideal.yaw_rate - now.yaw_rate,
            "r2a": ideal.sideslip_angle - seen.turning.sideslip_angle,
            "r3a": along - now.longitudinal_acceleration,
            "r4a": across - now.lateral_acceleration,
            "r5a": wanted.target_steering_wheel_angle - now.steering_wheel_angle,
            "r6a": asked - now.steering_shaft_torque + known.torque_offset,
            "r7a": wanted.target_vehicle_speed - mean,
            "r8a": force + known.force_offset - now.tie_rod_force,
        }

    def _driven(self, now: Measured) -> Scalar:
        """Force of both drives by the motion [N]."""
        known = self.coefficients
        speed = 0.5 * (now.wheel_speed_rear_left + now.wheel_speed_rear_right)
        turning = known.turning * now.lateral_acceleration * self.car.steering_ratio * now.steering_wheel_angle
        along: Scalar = known.inertia * now.longitudinal_acceleration + known.drag * speed * speed
        force: Scalar = along + known.resistance + turning
        return force


def residual_set(
    car: CarParameters,
    coefficients: Coefficients | None = None,
    sample_time: float = 0.01,
    printed: bool = False,
) -> ResidualSet:
    """The residuals of a vehicle.

    Args:
        coefficients: coefficients of a calibration; zeros where None, which leaves r3 and r19 without a model
        sample_time: sampling interval [s]
    """
    return ResidualSet(
        car,
        coefficients or Coefficients(),
        InputHold(Measured, sample_time, 2.0 * sample_time),
        InputHold(Targets, sample_time, 2.0 * sample_time),
        SteeringSignals(sample_time=sample_time),
        one_body(part(StiffRack.Parameters, car), sample_time),
        lateral_filter(part(SingleTrack.Parameters, car), sample_time, printed),
        AdaptiveSpeed.design(car.track_width, sample_time),
        LostShares(0.4, 0.5, sample_time),
        LostShares(0.5, 8.0, sample_time),
        LostShares(2.0, 8.0, sample_time),
        printed=printed,
    )
