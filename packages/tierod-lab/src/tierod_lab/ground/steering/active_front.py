"""Active front steering: a motor superposes its angle on that of the steering wheel."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError
from tierod.core.fields import POSITIVE
from tierod.physics.friction import viscous
from tierod.physics.gear import superposed_angle
from tierod_lab.ground.parts import Hand, Loads, Steer
from tierod_lab.ground.steering.column_eps import ColumnEps, ColumnMemory, ColumnMotion
from tierod_lab.ground.steering.shaft import Motor, Wheel


class ActiveFrontMotion(NamedTuple):
    """Column below the gear, steering wheel above it, and the angle of the superposition motor."""

    column: ColumnMotion
    motor_angle: Scalar


class ActiveFrontSignals(NamedTuple):
    """Signals of the steering before sensors; those of the motor come from its drive.

    `truth_gear_input_angle` is the angle of the shaft that enters the gear, below the torsion bar; the friction is
    defined as in `SteeringSignals`.
    """

    steering_wheel_angle: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]
    driver_torque: Annotated[Scalar, "N*m"]
    column_assist_torque: Annotated[Scalar, "N*m"]
    pinion_angle: Annotated[Scalar, "rad"]
    pinion_rate: Annotated[Scalar, "rad/s"]
    rack_position: Annotated[Scalar, "m"]
    rack_force: Annotated[Scalar, "N"]
    tie_rod_force_left: Annotated[Scalar, "N"]
    tie_rod_force_right: Annotated[Scalar, "N"]
    road_wheel_angle_left: Annotated[Scalar, "rad"]
    road_wheel_angle_right: Annotated[Scalar, "rad"]
    truth_gear_input_angle: Annotated[Scalar, "rad"]
    truth_friction_torque: Annotated[Scalar, "N*m"]
    truth_friction_resistance: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class ActiveFront:
    """Steering wheel, torsion bar, superposition gear with its motor, and below it a column with assist.

    Pinion = motor / i_M + shaft from the steering wheel / i_D; the gear is rigid, so that only the torsion bar is
    elastic between hands and motor. The rotor is not part of the column: its drive integrates it at its own, higher
    rate, supplies its speed, and obtains the load torque from `motor_load`.

    Args:
        column: column below the gear; its torsion bar and assist motor are referred to the pinion
    """

    column: ColumnEps = field(
        default_factory=lambda: ColumnEps(
            motor=Motor(ratio=1.0, inertia=0.06, damping=0.4, lag=2e-3, maximum_torque=60.0)
        )
    )
    motor_ratio: Annotated[float, "", POSITIVE] = 22.5
    input_ratio: Annotated[float, "", POSITIVE] = 1.0

    def __post_init__(self) -> None:
        if self.column.torsion_bar is None:
            raise ParameterError("the column of an ActiveFront has no torsion bar; give ColumnEps a TorsionBar")

    @property
    def actuators(self) -> tuple[str, ...]:
        return ("column_assist_torque", "motor_speed")

    def init(self) -> ActiveFrontMotion:
        return ActiveFrontMotion(self.column.init(), 0.0)

    def remembered(self) -> ColumnMemory:
        return self.column.remembered()

    def stiff(self) -> ActiveFrontMotion:
        return ActiveFrontMotion(self.column.stiff(), 0.0)

    def sticking(self, motion: ActiveFrontMotion, memory: ColumnMemory) -> dict[tuple[str, str], Scalar]:
        entries = self.column.sticking(motion.column, memory)
        return {(f"column.{rate}", f"column.{angle}"): entry for (rate, angle), entry in entries.items()}

    def steer(self, motion: ActiveFrontMotion) -> Steer:
        return self.column.steer(motion.column)

    def hand(self, motion: ActiveFrontMotion) -> Hand:
        return Hand(*motion.column.wheel)

    def motor_load(self, signals: ActiveFrontSignals, angle: Scalar, speed: Scalar, elapsed: Scalar) -> Scalar:
        """Load torque of the gear on the motor [N*m]; steering wheel and pinion are extrapolated at constant rate.

        Args:
            angle, speed: angle [rad] and speed [rad/s] of the motor
            elapsed: time since the start of the step [s]
        """
        bar = self.column.torsion_bar
        assert bar is not None
        hand = Hand(signals.steering_wheel_angle + elapsed * signals.steering_wheel_rate, signals.steering_wheel_rate)
        pinion = signals.pinion_angle + elapsed * signals.pinion_rate
        torque = bar.torque(self._superposed(angle, speed, hand), pinion, signals.pinion_rate)
        return torque / self.motor_ratio

    def derivative(
        self, motion: ActiveFrontMotion, start: ActiveFrontMotion, memory: ColumnMemory, loads: Loads
    ) -> ActiveFrontMotion:
        speed, column, wheel = loads.actuator_torques[1], self.column, self.hand(motion)
        seen = self._seen(motion, speed)
        rates = column.derivative(seen, start.column, memory, self._below(loads))
        assert column.torsion_bar is not None
        shaft = column.torsion_bar.torque(seen.wheel, seen.angle, seen.rate) / self.input_ratio
        turning = loads.hand_torque - viscous(wheel.rate, column.wheel_damping) - shaft
        # The steering wheel's own balance replaces that of the column, whose wheel is the upper end of the torsion bar.
        return ActiveFrontMotion(rates._replace(wheel=Wheel(wheel.rate, turning / column.wheel_inertia)), speed)

    def advance(
        self, motion: ActiveFrontMotion, start: ActiveFrontMotion, memory: ColumnMemory, loads: Loads
    ) -> ColumnMemory:
        return self.column.advance(motion.column, start.column, memory, self._below(loads))

    def signals(self, motion: ActiveFrontMotion, memory: ColumnMemory, loads: Loads) -> ActiveFrontSignals:
        seen = self._seen(motion, loads.actuator_torques[1])
        below, column = self.column.signals(seen, memory, self._below(loads)), motion.column
        return ActiveFrontSignals(
            column.wheel.angle,
            column.wheel.rate,
            below.driver_torque / self.input_ratio,
            below.motor_torque,
            column.angle,
            column.rate,
            below.rack_position,
            below.rack_force,
            below.tie_rod_force_left,
            below.tie_rod_force_right,
            below.road_wheel_angle_left,
            below.road_wheel_angle_right,
            self.input_ratio * (column.angle - motion.motor_angle / self.motor_ratio),
            below.truth_friction_torque,
            below.truth_friction_resistance,
        )

    def _superposed(self, motor_angle: Scalar, motor_speed: Scalar, hand: Hand) -> Wheel:
        return Wheel(
            superposed_angle(motor_angle, hand.angle, self.motor_ratio, self.input_ratio),
            superposed_angle(motor_speed, hand.rate, self.motor_ratio, self.input_ratio),
        )

    def _seen(self, motion: ActiveFrontMotion, motor_speed: Scalar) -> ColumnMotion:
        return motion.column._replace(wheel=self._superposed(motion.motor_angle, motor_speed, self.hand(motion)))

    def _below(self, loads: Loads) -> Loads:
        return loads._replace(actuator_torques=loads.actuator_torques[:1])
