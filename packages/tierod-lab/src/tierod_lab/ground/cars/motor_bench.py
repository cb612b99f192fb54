"""Test bench for a permanent-magnet motor: a shaft against a spring, with or without angle control."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import limit
from tierod_lab.ground.control.angle_control import AngleControl, AngleMemory
from tierod_lab.ground.motor import AFS_MOTOR, DriveState, PmMotor
from tierod_lab.ground.motor.pm_motor import IN_LOOP, DriveSignals, Senses
from tierod_lab.ground.parts import pass_through, ports_type

PORTS = ports_type((*IN_LOOP, "motor_torque"))
"""Ports for faults inside the loops: inputs of the current control, and the torque request of the drive."""


class Acting(NamedTuple):
    """External inputs of the bench."""

    target_motor_angle: Annotated[float, "rad"]
    control: Annotated[float, ""]  # share of the angle control's torque in the drive's request; 0 disables the control
    motor_torque: Annotated[float, "N*m"]
    load_torque: Annotated[float, "N*m"]
    locked: Annotated[float, ""]
    ports: PORTS  # type: ignore[valid-type]  # a class made at run time


class MotorBenchState(NamedTuple):
    """State of a bench between two steps."""

    motor: DriveState
    angle: AngleMemory
    held: Tree


class MotorBenchSignals(NamedTuple):
    """Signals of control and motor."""

    target_motor_angle_mechanical: Annotated[Scalar, "rad"]
    motor_target_torque: Annotated[Scalar, "N*m"]
    motor: DriveSignals


@dataclass(frozen=True)
class MotorBench:
    """Motor of a superposition on a bench; the load is a spring with limited torque, as of turning tyres."""

    motor: PmMotor = field(default_factory=lambda: AFS_MOTOR)
    angle_control: AngleControl = field(
        default_factory=lambda: AngleControl(stiffness=3.0, damping=0.03, integral=30.0, torque_limit=3.0)
    )
    load_stiffness: Annotated[float, "N*m/rad", NOT_NEGATIVE] = 0.05
    load_limit: Annotated[float, "N*m", NOT_NEGATIVE] = 0.6
    load_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.0
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    Sample = Acting

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("motor_torque",)

    def init(self) -> MotorBenchState:
        return MotorBenchState(self.motor.init(), self.angle_control.remembered(), PORTS(0.0, 0.0, 0.0, 0.0))

    def step(self, state: MotorBenchState, sample: Acting) -> tuple[MotorBenchState, MotorBenchSignals]:
        kept = state.held._asdict()

        def read(name: str, value: Scalar) -> Scalar:
            kept[name], passed = pass_through(getattr(sample.ports, name), kept[name], value)
            return passed

        def load(angle: Scalar, speed: Scalar, elapsed: Scalar) -> Scalar:
            spring = limit(self.load_stiffness * angle, -self.load_limit, self.load_limit)
            return sample.load_torque + spring + self.load_damping * speed

        sensed = read("motor_angle_mechanical", state.motor.rotor.angle)
        angle, torque = self.angle_control.decide(state.angle, sample.target_motor_angle, sensed)
        wanted = sample.motor_torque + sample.control * torque
        request, senses = read("motor_torque", wanted), Senses.through(read)
        motor, signals = self.motor.turn(state.motor, request, self.step_time, load, senses, sample.locked)
        after = MotorBenchState(motor, angle, PORTS(**kept))
        return after, MotorBenchSignals(sample.target_motor_angle, wanted, signals)
