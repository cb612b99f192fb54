"""A test bench for a permanent-magnet motor: a shaft against a spring, with or without control of its angle."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import limit
from tierod.proving_ground.control.angle_control import AngleControl, AngleMemory
from tierod.proving_ground.motor import AFS_MOTOR, DriveState, PmMotor
from tierod.proving_ground.motor.pm_motor import IN_LOOP, DriveSignals, Senses
from tierod.proving_ground.parts import pass_through, ports_type

PORTS = ports_type((*IN_LOOP, "motor_torque"))
"""Where faults reach the loops: what the current control reads, and the torque that is asked of the drive."""


class Acting(NamedTuple):
    """External inputs of the bench.

    Args:
        target_motor_angle: of the angle control
        control: share of the angle control's torque that is asked of the drive; 0 leaves it out
        motor_torque: asked of the drive besides
        load_torque: on the shaft, opposing, besides the spring
        locked: 1 holds the shaft still
        ports: faults inside the loops
    """

    target_motor_angle: Annotated[float, "rad"]
    control: Annotated[float, ""]
    motor_torque: Annotated[float, "N*m"]
    load_torque: Annotated[float, "N*m"]
    locked: Annotated[float, ""]
    ports: PORTS  # type: ignore[valid-type]  # a class made at run time


class MotorBenchState(NamedTuple):
    """A bench between two steps."""

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
    """The motor of a superposition on a bench; the load is a spring with a greatest torque, as of turning tyres.

    Args:
        motor: with its drive
        angle_control: of the shaft
        load_stiffness: of the spring
        load_limit: greatest torque of the spring
        load_damping: at the shaft
        step_time: between two samples
    """

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
        """The motor."""
        return ("motor_torque",)

    def init(self) -> MotorBenchState:
        """At rest, cold."""
        return MotorBenchState(self.motor.init(), self.angle_control.remembered(), PORTS(0.0, 0.0, 0.0, 0.0))

    def step(self, state: MotorBenchState, sample: Acting) -> tuple[MotorBenchState, MotorBenchSignals]:
        """One step on; the output belongs to the instant of the sample, fine signals to the step that follows."""
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
