"""Torque of the driver's hands and whether they are on the wheel, in one block."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Block
from tierod.core.graph.maths import both, present, where
from tierod.models.steering_column import ColumnOutput
from tierod.monitors.driver_torque.hands import HandsMonitor
from tierod.monitors.driver_torque.hands_filters import SensorNoise
from tierod.monitors.driver_torque.signs import ColumnSigns, SignVerdict
from tierod.monitors.driver_torque.starting import ColumnSample
from tierod.monitors.driver_torque.tuning import ColumnTuning

LONGEST_JUMP = 3.0
"""A jump of the hands' torque lasts at least so many samples."""


@dataclass(frozen=True)
class DriverTorqueMonitor:
    """An observer of the column beside the monitor of the hands, which tells it the offset of the torsion bar.

    Args:
        observer: a block that takes a `ColumnSample` and tells `hand_torque`; what else it tells is passed on
        hands: whether they are on the wheel
        signs: of the signals
    """

    observer: Block
    hands: HandsMonitor
    signs: ColumnSigns

    class Sample(NamedTuple):
        """What the monitor reads; for a missing motor torque stands what the motor is told to give, or the last one."""

        steering_wheel_angle: Annotated[float, "rad"]
        driver_torque: Annotated[float, "N*m"]
        motor_torque: Annotated[float, "N*m"]
        motor_target_torque: Annotated[float, "N*m"]
        motor_angle_mechanical: Annotated[float, "rad"]

    class State(NamedTuple):
        """Memory of all three, and the motor's torque that was last known."""

        observer: Any
        hands: Any
        signs: Any
        motor_torque: Any

    class Output(NamedTuple):
        """What is known of the driver's hands.

        Args:
            hand_torque, hand_torque_deviation: that they put on the wheel, and one standard deviation
            disturbance_torque, disturbance_torque_deviation: that the motor overcomes at its shaft besides the column
            ready: 1 while the torques can be used
            hands: 1 on, 0 off, 0.5 uncertain
            evidence: for hands on (positive) or off, over the threshold
            inertia_error, torque_offset: of wheel and torsion bar, as learnt without hands
            nis, present: of the observer, over how many outputs
            turned: 1 for every signal whose sign is wrong
        """

        hand_torque: Annotated[float, "N*m"]
        hand_torque_deviation: Annotated[float, "N*m"]
        disturbance_torque: Annotated[float, "N*m"]
        disturbance_torque_deviation: Annotated[float, "N*m"]
        ready: Annotated[float, ""]
        hands: Annotated[float, ""]
        evidence: Annotated[float, ""]
        inertia_error: Annotated[float, "kg*m**2"]
        torque_offset: Annotated[float, "N*m"]
        nis: Annotated[float, ""]
        present: Annotated[float, ""]
        turned: SignVerdict

    def init(self) -> State:
        """Nothing known."""
        return self.State(self.observer.init(), self.hands.init(), self.signs.init(), 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        """One sample on."""
        seen = self.hands.Sample(sample.steering_wheel_angle, sample.driver_torque)
        hands, found = self.hands.step(state.hands, seen)
        wanted = where(present(sample.motor_target_torque), sample.motor_target_torque, state.motor_torque)
        motor = where(present(sample.motor_torque), sample.motor_torque, wanted)
        corrected = sample.driver_torque - found.torque_offset
        column = ColumnSample(motor, sample.steering_wheel_angle, sample.motor_angle_mechanical, corrected)
        observer, estimate = self.observer.step(state.observer, column)
        signs, turned = self.signs.step(state.signs, column)
        there = both(present(sample.steering_wheel_angle), present(sample.driver_torque))

        def told(name: str, otherwise: float = 0.0) -> Any:
            return getattr(estimate, name, otherwise)

        return self.State(observer, hands, signs, motor), self.Output(
            hand_torque=told("hand_torque"),
            hand_torque_deviation=told("hand_torque_deviation"),
            disturbance_torque=told("disturbance_torque"),
            disturbance_torque_deviation=told("disturbance_torque_deviation"),
            ready=where(there, told("ready", 1.0), 0.0),
            hands=found.hands,
            evidence=found.evidence_on - found.evidence_off,
            inertia_error=found.inertia_error,
            torque_offset=found.torque_offset,
            nis=told("nis"),
            present=told("present"),
            turned=turned,
        )


MOTOR_NOISE = math.radians(0.06)
"""Of the sensor of the motor's angle, rounding included: bench and production car read the same one [rad]."""


def tuning_at(rate: float, usual: ColumnTuning, noise: SensorNoise, with_motor: bool) -> ColumnTuning:
    """The tuning of the observer for a rate and the sensors that usually have it.

    Args:
        rate: of the samples [Hz]
        usual: of the vehicle
        noise: of the sensors at the wheel
        with_motor: whether the motor's angle is measured
    """
    outputs = ColumnOutput._fields if with_motor else ("steering_wheel_angle", "driver_torque")
    offset = usual.offset if with_motor or usual.offset != "motor_angle_mechanical" else None
    jump = max(usual.jump_time, LONGEST_JUMP / rate)
    return replace(
        usual,
        steering_wheel_angle_noise=noise.angle,
        motor_angle_noise=MOTOR_NOISE,
        driver_torque_noise=noise.torque,
        jump_time=jump,
        outputs=outputs,
        offset=offset,
    )
