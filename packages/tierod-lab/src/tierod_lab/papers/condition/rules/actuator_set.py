"""All residuals of the actuators: response to the targets less the readings of the reconfigured sensors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, Tree, named_tuple
from tierod.core.fields import POSITIVE
from tierod.core.graph.maths import absolute, all_of, both, maximum, minimum, present, where
from tierod.methods.filters import InputHold
from tierod.models.single_track import SingleTrack
from tierod.monitors.condition.signals import Measured
from tierod.physics.friction import share_reached
from tierod.physics.motion import longitudinal_acceleration
from tierod_lab.papers.condition.rules.equations import tie_rod_force_of_balance
from tierod_lab.papers.condition.rules.parameters import ACTUATOR_RESIDUALS, Coefficients, Residual, ResidualParameters
from tierod_lab.papers.condition.rules.rack import discretise_pair
from tierod_lab.papers.condition.rules.readings import Motion
from tierod_lab.papers.condition.rules.steering_signals import LostShares


class Targets(NamedTuple):
    """Targets of the controller; NaN where missing."""

    steering_motor_1_target_torque: Annotated[float, "N*m"]
    steering_motor_2_target_torque: Annotated[float, "N*m"]
    target_drive_torque_left: Annotated[float, "N*m"]
    target_drive_torque_right: Annotated[float, "N*m"]
    target_steering_wheel_angle: Annotated[float, "rad"]
    target_vehicle_speed: Annotated[float, "m/s"]


ActuatorResiduals: Any = named_tuple(
    "ActuatorResiduals", [(each.name, Annotated[float, each.unit]) for each in ACTUATOR_RESIDUALS]
)
"""r1a to r8a and the residuals beyond the paper, in their units; zero where one is missing."""

ActuatorFlags: Any = named_tuple("ActuatorFlags", [(each.name, Annotated[float, ""]) for each in ACTUATOR_RESIDUALS])
"""Presence of each residual as a flag, 1.0 or 0.0."""


class Repaired(NamedTuple):
    """Readings after reconfiguration, estimates of the filters, measured shaft torque, and r19."""

    measured: Measured
    motion: Motion
    sensed_torque: Annotated[float, "N*m"]
    force_residual: Annotated[float, "N"]


@dataclass(frozen=True)
class ActuatorSet:
    """r1a to r8a at every sample, and four residuals beyond the paper that separate motors and sides.

    Args:
        coefficients: coefficients of `calibrate_residuals`
        motors: lost shares of both steering torques; the shaft torque is that of its sensor or that of the motion of
            the steering, whichever lacks less, since a faulty torque sensor is no faulty motor
        drives: share of the drive torque that the longitudinal acceleration lacks
        side: share of the drive torque that appears as a force at the tie rods, as when one side alone drives
        speed_memory: time constant of the derivative of the target speed
        restless: change of the commanded steering torque per sample, halved with each, above which the shaft torque is
            not compared with it, since motors and bus lag
        moving: speed below which the vehicle counts as standing

    Build it by `actuator_set`.
    """

    car: ResidualParameters
    coefficients: Coefficients
    hold: InputHold
    motors: LostShares
    drives: LostShares
    side: LostShares
    speed_memory: Annotated[float, "s", POSITIVE] = 0.1
    restless: Annotated[float, "N*m", POSITIVE] = 1.0
    moving: Annotated[float, "m/s", POSITIVE] = 1.5
    sample_time: Annotated[float, "s", POSITIVE] = 0.01

    class Sample(NamedTuple):
        targets: Targets
        repaired: Repaired

    class State(NamedTuple):
        hold: Tree
        ideal: SingleTrack.State
        speed: Scalar
        motors: LostShares.State
        drives: LostShares.State
        side: LostShares.State
        asked: Scalar
        unrest: Scalar

    class Output(NamedTuple):
        residuals: ActuatorResiduals
        there: ActuatorFlags

    def init(self) -> State:
        return self.State(
            self.hold.init(),
            SingleTrack.State(0.0, 0.0),
            0.0,
            self.motors.init(),
            self.drives.init(),
            self.side.init(),
            0.0,
            0.0,
        )

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        hold, held = self.hold.step(state.hold, sample.targets)
        # Zeros in place of NaN keep the state finite; the flags exclude the residuals of missing signals.
        wanted = Targets(*(where(present(value), value, 0.0) for value in held))
        now, motion = sample.repaired.measured, sample.repaired.motion
        seen = Measured(*(where(present(value), value, 0.0) for value in now))
        moving = minimum(wanted.target_vehicle_speed, maximum(*seen[:2])) > self.moving
        # The single-track model divides by the speed, hence the lower bound.
        turn = SingleTrack.Input(
            self.car.steering_ratio * wanted.target_steering_wheel_angle,
            maximum(wanted.target_vehicle_speed, self.moving),
        )
        model: Any = discretise_pair(SingleTrack)
        ideal = model.transition(state.ideal, turn, model.Parameters(self.car.single_track, self.sample_time))
        ideal = SingleTrack.State(*(where(moving, value, 0.0) for value in ideal))
        change = share_reached(self.sample_time / self.speed_memory) * (wanted.target_vehicle_speed - state.speed)
        values = self._of_paper(wanted, seen, motion, ideal, turn, change / self.sample_time)
        use = all_of(moving, *(present(each) for each in (*now, *held)))
        asked = wanted.steering_motor_1_target_torque + wanted.steering_motor_2_target_torque
        unrest = maximum(absolute(asked - state.asked), 0.5 * state.unrest)
        steady = unrest < self.restless
        gaps = (asked - sample.repaired.sensed_torque + self.coefficients.torque_offset, asked - motion.torque)
        missing = where(absolute(gaps[1]) < absolute(gaps[0]), gaps[1], gaps[0])
        motors, by_motor = self.motors.step(state.motors, LostShares.Sample(missing, *wanted[:2]), both(use, steady))
        drives, lost, side, on_side = self._drives(state, wanted, seen, sample.repaired.force_residual, use)
        values = (*values, by_motor.first, by_motor.second, lost, on_side)
        known = {name: present(value) for name, value in (*held._asdict().items(), *now._asdict().items())}
        there = ActuatorFlags(*(self._there(each, known, moving, steady) for each in ACTUATOR_RESIDUALS))
        residuals = ActuatorResiduals(*(where(flag, value, 0.0) for flag, value in zip(there, values, strict=True)))
        after = self.State(hold, ideal, state.speed + change, motors, drives, side, asked, unrest)
        return after, self.Output(residuals, there)

    @staticmethod
    def _there(each: Residual, known: dict[str, Scalar], moving: Scalar, steady: Scalar) -> Scalar:
        """Whether all signals of a residual are present and its enabling conditions hold, 1.0 or 0.0."""
        asked = [moving] if each.moving else []
        asked += [steady] if each.steady else []
        return where(all_of(*(known[name] for name in each.signals), *asked), 1.0, 0.0)

    def _of_paper(
        self,
        wanted: Targets,
        seen: Measured,
        motion: Motion,
        ideal: SingleTrack.State,
        turn: SingleTrack.Input,
        speed_rate: Scalar,
    ) -> tuple[Scalar, ...]:
        """Values of r1a to r8a, eqs (48) to (52)."""
        known, car = self.coefficients, self.car
        across = SingleTrack.output(ideal, turn, car.single_track).lateral_acceleration
        along = longitudinal_acceleration(speed_rate, turn.vehicle_speed, ideal.sideslip_angle, ideal.yaw_rate)
        asked = wanted.steering_motor_1_target_torque + wanted.steering_motor_2_target_torque
        torque = asked - seen.steering_shaft_torque + known.torque_offset
        force = tie_rod_force_of_balance(asked, 0.0, car.mass, across, known.per_mass, known.per_torque)
        mean = 0.5 * (seen.wheel_speed_rear_left + seen.wheel_speed_rear_right)
        return (
            ideal.yaw_rate - seen.yaw_rate,
            ideal.sideslip_angle - motion.sideslip,
            along - seen.longitudinal_acceleration,
            across - seen.lateral_acceleration,
            wanted.target_steering_wheel_angle - seen.steering_wheel_angle,
            torque,
            wanted.target_vehicle_speed - mean,
            force + known.force_offset - seen.tie_rod_force,
        )

    def _drives(
        self, state: State, wanted: Targets, seen: Measured, force: Scalar, use: Scalar
    ) -> tuple[LostShares.State, Scalar, LostShares.State, Scalar]:
        """Shares of the total drive torque: missing in the longitudinal acceleration, and found at the tie rods."""
        known, car = self.coefficients, self.car
        asked = wanted.target_drive_torque_left + wanted.target_drive_torque_right
        speed = 0.5 * (seen.wheel_speed_rear_left + seen.wheel_speed_rear_right)
        steer = car.steering_ratio * seen.steering_wheel_angle
        given = (
            known.inertia * seen.longitudinal_acceleration
            + known.resistance
            + known.drag * speed * speed
            + known.turning * seen.lateral_acceleration * steer
        )
        drives, by_sum = self.drives.step(
            state.drives, LostShares.Sample(asked - given * car.wheel_radius, asked, 0.0), use
        )
        side, by_side = self.side.step(state.side, LostShares.Sample(force * car.wheel_radius, asked, 0.0), use)
        return drives, by_sum.first, side, by_side.first


def actuator_set(
    car: ResidualParameters, coefficients: Coefficients | None = None, sample_time: float = 0.01
) -> ActuatorSet:
    """The residuals of the actuators of a vehicle.

    Args:
        coefficients: coefficients of a calibration; zeros where None
        sample_time: sampling interval [s]
    """
    return ActuatorSet(
        car,
        coefficients or Coefficients(),
        InputHold(Targets, sample_time, 2.0 * sample_time),
        LostShares(0.4, 0.5, sample_time),
        LostShares(0.5, 8.0, sample_time),
        LostShares(2.0, 8.0, sample_time),
        sample_time=sample_time,
    )
