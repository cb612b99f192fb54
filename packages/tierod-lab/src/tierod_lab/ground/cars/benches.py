"""Test benches without a road: the column of an electric power steering, and a permanent-magnet motor."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.fields import COUNT, NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import limit, where
from tierod.physics.steering import gear_coupling_torque, torsion_bar_torque
from tierod_lab.ground.control import AngleControl, AngleMemory
from tierod_lab.ground.integration import runge_kutta
from tierod_lab.ground.motor import AFS_MOTOR, IN_LOOP, DriveSignals, DriveState, PmMotor, Senses
from tierod_lab.ground.parts import Port, pass_through, ports_type
from tierod_lab.ground.steering import Ripple, rippled
from tierod_lab.ground.steering.friction import Dahl, DryFriction


class ColumnMotion(NamedTuple):
    """Angles [rad] and rates [rad/s] of steering wheel, motor and gear."""

    wheel_angle: Scalar
    motor_angle: Scalar
    gear_angle: Scalar
    wheel_rate: Scalar
    motor_rate: Scalar
    gear_rate: Scalar


class BenchState(NamedTuple):
    """State of a bench between two steps."""

    motion: ColumnMotion
    friction: Scalar
    held: Scalar


class BenchPorts(NamedTuple):
    """Ports for faults of the motor."""

    motor_torque: Port


class Acting(NamedTuple):
    """External inputs of the bench."""

    motor_torque: Annotated[float, "N*m"]
    motor_disturbance: Annotated[float, "N*m"]
    gear_torque: Annotated[float, "N*m"]
    hand_torque: Annotated[float, "N*m"]
    grip: Annotated[float, ""]
    held_angle: Annotated[float, "rad"]
    locked: Annotated[float, ""]
    ports: BenchPorts


class BenchSignals(NamedTuple):
    """Signals of the bench at the instant of a sample; `truth_hand_torque` is all external torque on the wheel."""

    steering_wheel_angle: Annotated[Scalar, "rad"]
    motor_angle_mechanical: Annotated[Scalar, "rad"]
    driver_torque: Annotated[Scalar, "N*m"]
    motor_target_torque: Annotated[Scalar, "N*m"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]
    motor_speed: Annotated[Scalar, "rad/s"]
    truth_motor_torque: Annotated[Scalar, "N*m"]
    truth_gear_angle: Annotated[Scalar, "rad"]
    truth_gear_rate: Annotated[Scalar, "rad/s"]
    truth_hand_torque: Annotated[Scalar, "N*m"]
    truth_motor_friction_torque: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class Arms:
    """Contribution of the hands to the wheel at full grip; with stiffness only if they hold an angle."""

    inertia: Annotated[float, "kg*m**2", NOT_NEGATIVE] = 0.007
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.08
    stiffness: Annotated[float, "N*m/rad", NOT_NEGATIVE] = 0.0


@dataclass(frozen=True)
class ColumnBench:
    """Steering wheel, gear and motor as three inertias, with dry friction at the motor.

    The defaults have the eigenvalues of the paper's table 3, which determines five parameters; inertia of the wheel,
    stiffness of the torsion bar and ratio are typical values. The fastest mode has 112 Hz and no damping, so a step is
    divided into several steps of the Runge-Kutta method of fourth order. Source: Raffone, eqs (1) to (4), corrected.
    """

    wheel_inertia: Annotated[float, "kg*m**2", POSITIVE] = 0.035
    wheel_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.2286477177
    bar_stiffness: Annotated[float, "N*m/rad", POSITIVE] = 140.0
    gear_ratio: Annotated[float, "", POSITIVE] = 18.0
    gear_stiffness: Annotated[float, "N*m/rad", POSITIVE] = 7.259936574
    gear_inertia: Annotated[float, "kg*m**2", POSITIVE] = 5.51681521e-3
    motor_inertia: Annotated[float, "kg*m**2", POSITIVE] = 1.448563969e-4
    motor_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 1.483924848e-3
    friction: DryFriction = field(default_factory=lambda: DryFriction(level=0.1, law=Dahl(0.05)))
    ripple: Ripple | None = None  # None for a smooth motor
    arms: Arms = field(default_factory=Arms)
    locking_time: Annotated[float, "s", POSITIVE] = 1e-3
    parts: Annotated[int, "", COUNT] = 5
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    Sample = Acting

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("motor_torque",)

    def init(self) -> BenchState:
        return BenchState(ColumnMotion(*[0.0] * 6), self.friction.remembered(), 0.0)

    def step(self, state: BenchState, sample: Acting) -> tuple[BenchState, BenchSignals]:
        held, given = pass_through(sample.ports.motor_torque, state.held, sample.motor_torque)
        motion, friction = state.motion, state.friction
        for _ in range(self.parts):
            start, memory = motion, friction

            def slope(now: ColumnMotion, start: ColumnMotion = start, memory: Scalar = memory) -> ColumnMotion:
                return self.derivative(now, start, memory, given, sample)

            motion = runge_kutta(slope, motion, self.step_time / self.parts)
            friction = self.friction.advance(memory, motion.motor_angle - start.motor_angle, motion.motor_rate)
        return BenchState(motion, friction, held), self._signals(state, given, sample)

    def derivative(
        self, motion: ColumnMotion, start: ColumnMotion, friction: Scalar, motor_torque: Scalar, acting: Acting
    ) -> ColumnMotion:
        bar = torsion_bar_torque(motion.wheel_angle, motion.gear_angle, self.bar_stiffness)
        coupling = gear_coupling_torque(motion.motor_angle, motion.gear_angle, self.gear_ratio, self.gear_stiffness)
        dry = self.friction.torque(friction, motion.motor_angle - start.motor_angle, motion.motor_rate)
        driving = rippled(motor_torque, motion.motor_angle, self.ripple) + acting.motor_disturbance
        motor = driving - coupling - dry - self.motor_damping * motion.motor_rate
        gear = bar + self.gear_ratio * coupling + acting.gear_torque
        return ColumnMotion(
            motion.wheel_rate,
            motion.motor_rate,
            motion.gear_rate,
            self._wheel_acceleration(motion, bar, acting),
            motor / self.motor_inertia,
            gear / self.gear_inertia,
        )

    def _wheel_acceleration(self, motion: ColumnMotion, bar: Scalar, acting: Acting) -> Scalar:
        arms = self.arms
        pull = arms.damping * motion.wheel_rate + arms.stiffness * (motion.wheel_angle - acting.held_angle)
        torque = acting.hand_torque - acting.grip * pull - bar - self.wheel_damping * motion.wheel_rate
        free = torque / (self.wheel_inertia + acting.grip * arms.inertia)
        # The wheel may move when it is locked, so the lock stops it with a short time constant.
        return where(acting.locked > 0.5, -motion.wheel_rate / self.locking_time, free)

    def _signals(self, state: BenchState, given: Scalar, acting: Acting) -> BenchSignals:
        motion = state.motion
        bar = torsion_bar_torque(motion.wheel_angle, motion.gear_angle, self.bar_stiffness)
        from_outside = bar + self.wheel_damping * motion.wheel_rate
        from_outside = from_outside + self.wheel_inertia * self._wheel_acceleration(motion, bar, acting)
        return BenchSignals(
            motion.wheel_angle,
            motion.motor_angle,
            bar,
            acting.motor_torque,
            motion.wheel_rate,
            motion.motor_rate,
            rippled(given, motion.motor_angle, self.ripple) + acting.motor_disturbance,
            motion.gear_angle,
            motion.gear_rate,
            from_outside,
            self.friction.torque(state.friction, 0.0, motion.motor_rate),
        )


PORTS = ports_type((*IN_LOOP, "motor_torque"))
"""Ports for faults inside the loops: inputs of the current control, and the torque request of the drive."""


class MotorBenchInputs(NamedTuple):
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

    Sample = MotorBenchInputs

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("motor_torque",)

    def init(self) -> MotorBenchState:
        return MotorBenchState(self.motor.init(), self.angle_control.remembered(), PORTS(0.0, 0.0, 0.0, 0.0))

    def step(self, state: MotorBenchState, sample: MotorBenchInputs) -> tuple[MotorBenchState, MotorBenchSignals]:
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
