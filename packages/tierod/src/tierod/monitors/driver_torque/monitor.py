"""Torque of the driver's hands and whether they are on the wheel, in one block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Block, Scalar, Tree
from tierod.core.findings import Status
from tierod.core.graph.maths import both, present, where
from tierod.core.statement import Statement, code_of
from tierod.monitors.driver_torque.hands import HandsMonitor, HandsSample
from tierod.monitors.driver_torque.signs import ColumnSigns, SignState, SignVerdict
from tierod.monitors.driver_torque.starting import ColumnSample


@dataclass(frozen=True)
class DriverTorqueMonitor:
    """An observer of the column with the hands monitor, whose learnt offset corrects the torque of the torsion bar.

    Args:
        observer: a block with input `ColumnSample` and output `hand_torque`; optional outputs are its deviation, the
            disturbance torque, `nis`, `present` and `ready`
        hands: detection of hands on the wheel
        signs: test of the signals' signs
    """

    observer: Block
    hands: HandsMonitor
    signs: ColumnSigns

    class Sample(NamedTuple):
        """Input of the monitor; a missing motor torque is replaced by its target, or by the last one."""

        steering_wheel_angle: Annotated[Scalar, "rad"]
        driver_torque: Annotated[Scalar, "N*m"]
        motor_torque: Annotated[Scalar, "N*m"]
        motor_target_torque: Annotated[Scalar, "N*m"]
        motor_angle_mechanical: Annotated[Scalar, "rad"]

    class State(NamedTuple):
        """State of all three, and the last valid motor torque."""

        observer: Tree
        hands: HandsMonitor.State
        signs: SignState
        motor_torque: Annotated[Scalar, "N*m"]

    class Output(NamedTuple):
        """Estimated state of the driver's hands.

        Args:
            statement: torque of the hands [N*m] with its deviation, healthy while it is known; the evidence is the
                CUSUM for hands on (positive) or off (negative), over the threshold
            disturbance_torque, disturbance_torque_deviation: torque that the motor overcomes at its shaft besides the
                column
            hands: 1 on, 0 off, 0.5 uncertain
            inertia_error, torque_offset: errors of wheel and torsion bar, learnt without hands
            nis, present: NIS of the observer, and its number of outputs
            turned: 1 for every signal with a wrong sign
        """

        statement: Statement
        disturbance_torque: Annotated[Scalar, "N*m"]
        disturbance_torque_deviation: Annotated[Scalar, "N*m"]
        hands: Annotated[Scalar, ""]
        inertia_error: Annotated[Scalar, "kg*m**2"]
        torque_offset: Annotated[Scalar, "N*m"]
        nis: Annotated[Scalar, ""]
        present: Annotated[Scalar, ""]
        turned: SignVerdict

    def init(self) -> State:
        """State before the first sample."""
        return self.State(self.observer.init(), self.hands.init(), self.signs.init(), 0.0)

    def step(self, state: State, sample: Sample) -> tuple[State, Output]:
        """Process one sample."""
        # The hands monitor runs first: its learnt offset corrects the torque that the observer gets.
        hands, found = self.hands.step(state.hands, HandsSample(sample.steering_wheel_angle, sample.driver_torque))
        wanted = where(present(sample.motor_target_torque), sample.motor_target_torque, state.motor_torque)
        motor = where(present(sample.motor_torque), sample.motor_torque, wanted)
        corrected = sample.driver_torque - found.torque_offset
        column = ColumnSample(motor, sample.steering_wheel_angle, sample.motor_angle_mechanical, corrected)
        observer, estimate = self.observer.step(state.observer, column)
        signs, turned = self.signs.step(state.signs, column)
        there = both(present(sample.steering_wheel_angle), present(sample.driver_torque))

        def of_observer(name: str, otherwise: Scalar = 0.0) -> Scalar:
            value: Scalar = getattr(estimate, name, otherwise)
            return value

        ready = where(there, of_observer("ready", 1.0), 0.0)
        statement = Statement(
            status=where(ready > 0.5, code_of(Status.ESTIMATED), code_of(Status.NOT_READY)),
            since=-1.0,
            kind=0.0,
            magnitude=of_observer("hand_torque"),
            deviation=of_observer("hand_torque_deviation"),
            evidence=found.evidence_on - found.evidence_off,
        )
        return self.State(observer, hands, signs, motor), self.Output(
            statement=statement,
            disturbance_torque=of_observer("disturbance_torque"),
            disturbance_torque_deviation=of_observer("disturbance_torque_deviation"),
            hands=found.hands,
            inertia_error=found.inertia_error,
            torque_offset=found.torque_offset,
            nis=of_observer("nis"),
            present=of_observer("present"),
            turned=turned,
        )
