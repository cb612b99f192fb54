"""A steering on a rig: hands, motor and kingpins as given, integrated as a car does it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod_lab.ground.control.assist import AssistUnit
from tierod_lab.ground.integration import rosenbrock, steering_inverse
from tierod_lab.ground.parts import Loads
from tierod_lab.ground.steering.column_eps import ColumnEps

STEP = 1e-3


class Given(NamedTuple):
    hand_torque: Annotated[float, "N*m"] = 0.0
    hand_angle: Annotated[float, "rad"] = 0.0
    motor_torque: Annotated[float, "N*m"] = 0.0
    kingpin_torque: Annotated[float, "N*m"] = 0.0
    speed: Annotated[float, "m/s"] = 0.0


class Motion(NamedTuple):
    steering: Any


class State(NamedTuple):
    motion: Motion
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

    Sample = Given

    def init(self):
        assist = () if self.assist is None else self.assist.remembered()
        return State(Motion(self.steering.init()), self.steering.remembered(), assist)

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
            return Motion(steering.derivative(motion.steering, start, state.friction, loads))

        inverse = steering_inverse(steering, start, state.friction, self.step_time)
        after = rosenbrock(slope, state.motion, self.step_time, "steering", inverse)
        loads = self.loads(after.steering, given, torques)
        friction = steering.advance(after.steering, start, state.friction, loads)
        return State(after, friction, assist), signals

    def run(self, seconds, state=None, **given):
        time = np.arange(round(seconds / self.step_time)) * self.step_time
        columns = Given()._replace(**given)
        values = [value(time) if callable(value) else np.full(len(time), value) for value in columns]
        return time, scan(self, np.column_stack(values), self.init() if state is None else state)

    def placed(self, **motion):
        state = self.init()
        return state._replace(motion=Motion(state.motion.steering._replace(**motion)))
