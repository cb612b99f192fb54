"""Parts of the virtual car alone: any block by names of its signals, a chassis, a steering, and a car for faults."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.block import leaves, named_tuple, skeleton
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph import Result, scan
from tierod_lab.ground.chassis import TwoTrack
from tierod_lab.ground.control import AssistUnit
from tierod_lab.ground.integration import rosenbrock, steering_inverse
from tierod_lab.ground.parts import Demand, Loads, Reaction, Road, Steer, Wheels, Wind, pass_through, ports_type
from tierod_lab.ground.recorder import channel_names
from tierod_lab.ground.sensors import Sensor, SensorSet
from tierod_lab.ground.steering.column_eps import ColumnEps

ONES = ("road.adhesion_left", "road.adhesion_right", "road.support", "demand.grip")
"""What is one unless said otherwise, as are the gains of ports; all else is zero."""


class Run:
    """A block's outputs over `count` steps, sub-sampled signals interleaved; `demand__x` names the input demand.x."""

    def __init__(self, block, count, state=None, **inputs):
        names = [name for name, _ in leaves(skeleton(block.Sample))]
        inputs = {name.replace("__", "."): value for name, value in inputs.items()}
        assert inputs.keys() <= set(names), sorted(inputs.keys() - set(names))
        samples = np.zeros((count, len(names)))
        for column, name in enumerate(names):
            samples[:, column] = inputs.get(name, 1.0 if name in ONES or name.endswith(".gain") else 0.0)
        self.result = scan(block, samples, state)
        self.columns = channel_names(block)

    def __getitem__(self, name):
        return self.result.values[:, self.columns[name]].reshape(-1)


STEP = 1e-3


class Inputs(NamedTuple):
    steer: float = 0.0
    steer_rate: float = 0.0
    drive_left: float = 0.0
    drive_right: float = 0.0
    brake: float = 0.0
    bank: float = 0.0
    grade: float = 0.0
    adhesion_left: float = 1.0
    adhesion_right: float = 1.0
    support: float = 1.0
    crosswind: float = 0.0
    headwind: float = 0.0


def surroundings(sample: Inputs) -> tuple[Steer, Road, Wind]:
    return (
        Steer(sample.steer, sample.steer, sample.steer_rate, sample.steer_rate),
        Road(0.0, sample.bank, sample.grade, sample.adhesion_left, sample.adhesion_right, sample.support),
        Wind(sample.crosswind, sample.headwind),
    )


class ChassisSeen(NamedTuple):
    reaction: Reaction
    motion: Any


@dataclass(frozen=True)
class Bench:
    chassis: Any = field(default_factory=TwoTrack)
    speed: float = 20.0
    step_time: float = STEP

    Sample = Inputs

    def init(self) -> Any:
        return self.chassis.init(self.speed)

    def step(self, state: Any, sample: Inputs) -> tuple[Any, ChassisSeen]:
        around = surroundings(sample)
        torques = Wheels(sample.drive_left, sample.drive_right, 0.0, 0.0)
        brakes = Wheels(*[sample.brake] * 4)

        def slope(motion: tuple) -> tuple:
            reaction = self.chassis.reaction(motion[0], *around)
            return (self.chassis.derivative(motion[0], reaction, torques, brakes),)

        reaction = self.chassis.reaction(state, *around)
        (after,) = rosenbrock(slope, (state,), self.step_time, "", [])
        return after, ChassisSeen(reaction._replace(private=0.0), state)


def columns(seconds: float, **given: Any) -> np.ndarray:
    time = np.arange(round(seconds / STEP)) * STEP
    inputs = np.tile(np.array(Inputs()), (len(time), 1))
    for name, value in given.items():
        inputs[:, Inputs._fields.index(name)] = value(time) if callable(value) else value
    if "steer_rate" not in given:
        inputs[:, 1] = np.gradient(inputs[:, 0], STEP)
    return inputs


def drive(chassis: Any, seconds: float, speed: float, **given: Any) -> Result:
    return scan(Bench(chassis, speed), columns(seconds, **given))


def finite(out: Result) -> bool:
    return bool(np.isfinite(out.values).all())


class RigInputs(NamedTuple):
    hand_torque: Annotated[float, "N*m"] = 0.0
    hand_angle: Annotated[float, "rad"] = 0.0
    motor_torque: Annotated[float, "N*m"] = 0.0
    kingpin_torque: Annotated[float, "N*m"] = 0.0
    speed: Annotated[float, "m/s"] = 0.0


class RigMotion(NamedTuple):
    steering: Any


class RigState(NamedTuple):
    motion: RigMotion
    friction: Any
    assist: Any


@dataclass(frozen=True)
class Rig:
    steering: Any = field(default_factory=ColumnEps)
    assist: AssistUnit | None = None
    kingpin_stiffness: float = 0.0
    front_load: float = 9400.0
    arm_stiffness: float = 0.0
    arm_damping: float = 0.0
    step_time: float = STEP

    Sample = RigInputs

    def init(self):
        assist = () if self.assist is None else self.assist.remembered()
        return RigState(RigMotion(self.steering.init()), self.steering.remembered(), assist)

    def loads(self, motion, given, torques):
        steer, hand = self.steering.steer(motion), self.steering.hand(motion)
        arms = self.arm_stiffness * (given.hand_angle - hand.angle) - self.arm_damping * hand.rate
        half = 0.5 * given.kingpin_torque
        return Loads(
            half + self.kingpin_stiffness * steer.left,
            half + self.kingpin_stiffness * steer.right,
            given.hand_torque + arms,
            torques,
            self.front_load,
            given.speed,
        )

    def step(self, state, given):
        steering, start = self.steering, state.motion.steering
        hand = steering.hand(start)
        torques = (given.motor_torque,) * len(steering.actuators)
        signals = steering.signals(start, state.friction, self.loads(start, given, torques))
        assist = state.assist
        if self.assist is not None:
            assist, torque = self.assist.decide(assist, signals.driver_torque, given.speed, hand.angle, hand.rate)
            torques = (torque,)

        def slope(motion):
            loads = self.loads(motion.steering, given, torques)
            return RigMotion(steering.derivative(motion.steering, start, state.friction, loads))

        inverse = steering_inverse(steering, start, state.friction, self.step_time)
        after = rosenbrock(slope, state.motion, self.step_time, "steering", inverse)
        loads = self.loads(after.steering, given, torques)
        friction = steering.advance(after.steering, start, state.friction, loads)
        return RigState(after, friction, assist), signals

    def run(self, seconds, state=None, **given):
        time = np.arange(round(seconds / self.step_time)) * self.step_time
        columns = RigInputs()._replace(**given)
        values = [value(time) if callable(value) else np.full(len(time), value) for value in columns]
        return time, scan(self, np.column_stack(values), self.init() if state is None else state)

    def placed(self, **motion):
        state = self.init()
        return state._replace(motion=RigMotion(state.motion.steering._replace(**motion)))


PORTS = ("driver_torque", "vehicle_speed", "motor_torque")


class Output(NamedTuple):
    yaw_rate: Annotated[Any, "rad/s"]
    driver_torque: Annotated[Any, "N*m"]
    motor_torque: Annotated[Any, "N*m"]
    vehicle_speed: Annotated[Any, "m/s"]
    sideslip_angle: Annotated[Any, "rad"]
    truth_distance: Annotated[Any, "m"]
    truth_speed: Annotated[Any, "m/s"]


@dataclass(frozen=True)
class StandInMotor:
    lag: Annotated[float, "s", POSITIVE] = 0.002


@dataclass(frozen=True)
class StandInSteering:
    level: Annotated[float, "N*m", NOT_NEGATIVE] = 4.0
    motor: StandInMotor = field(default_factory=StandInMotor)

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("motor_torque",)


@dataclass(frozen=True)
class Car:
    steering: StandInSteering = field(default_factory=StandInSteering)
    mass: Annotated[float, "kg", POSITIVE] = 1600.0
    step_time: float = 1e-3

    Sample = named_tuple("Sample", [("road", Road), ("demand", Demand), ("ports", ports_type(PORTS))])

    def init(self) -> Any:
        return (0.0, 0.0, 0.0, 0.0)

    def step(self, state: Any, sample: Any) -> tuple[Any, Output]:
        distance, *held = state
        torque = 100.0 * sample.road.curvature + self.steering.level
        kept_torque, torque_read = pass_through(sample.ports.driver_torque, held[0], torque)
        kept_speed, _ = pass_through(sample.ports.vehicle_speed, held[1], sample.demand.speed)
        kept_motor, motor = pass_through(sample.ports.motor_torque, held[2], 2.0 * torque_read)
        output = Output(
            sample.demand.speed * sample.road.curvature,
            torque,
            motor,
            sample.demand.speed,
            sample.road.bank_angle,
            distance,
            sample.demand.speed,
        )
        return (distance + sample.demand.speed * self.step_time, kept_torque, kept_speed, kept_motor), output


SENSORS = SensorSet(
    {
        "yaw_rate": Sensor(),
        "driver_torque": Sensor(),
        "motor_torque": Sensor(),
        "vehicle_speed": Sensor(quantum=0.5, rate=50.0, saturation=(0.0, 100.0)),
    }
)
