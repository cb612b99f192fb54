"""The default observer of a steering column: torque of the hands, disturbance torque, angles and rates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, Tree, values_of
from tierod.core.graph.maths import present, sqrt, where
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod.models.column_observation import MotorTorque
from tierod.models.steering_column import ColumnOutput
from tierod.monitors.driver_torque.design import Column, Layout, column_of_vehicle, design
from tierod.monitors.driver_torque.starting import ColumnSample, Phase, Starting, StartState
from tierod.monitors.driver_torque.tuning import ColumnTuning, usual_tuning
from tierod.vehicles import Vehicle


class ColumnEstimate(NamedTuple):
    """Estimate of an observer of the column; deviations are standard deviations for the assumed column.

    Args:
        hand_torque: torque of the driver's hands on the steering wheel
        hand_torque_deviation: its standard deviation
        disturbance_torque: torque that the motor overcomes at its shaft besides the column: dry friction, rack and road
        disturbance_torque_deviation: its standard deviation
        steering_wheel_angle, motor_angle_mechanical, gear_angle: filtered; the gear's is that of the shaft below the
            bar
        steering_wheel_rate, motor_speed, gear_rate: likewise
        offset: offset of the sensor that the tuning names, in its unit; 0 where it names none
        innovation: measured less predicted; NaN where missing, 0 for a sensor that the tuning leaves out
        nis: normalised innovation squared over the present outputs
        present: number of present outputs
        ready: 1 while the estimate can be used; 0 before the first complete sample, in a long gap, and while settling
    """

    hand_torque: Annotated[Scalar, "N*m"]
    hand_torque_deviation: Annotated[Scalar, "N*m"]
    disturbance_torque: Annotated[Scalar, "N*m"]
    disturbance_torque_deviation: Annotated[Scalar, "N*m"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    motor_angle_mechanical: Annotated[Scalar, "rad"]
    gear_angle: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]
    motor_speed: Annotated[Scalar, "rad/s"]
    gear_rate: Annotated[Scalar, "rad/s"]
    offset: Annotated[Scalar, ""]
    innovation: ColumnOutput
    nis: Annotated[Scalar, ""]
    present: Annotated[Scalar, ""]
    ready: Annotated[Scalar, ""]


class ColumnMemory(NamedTuple):
    """State of the observer's filters, and of the gaps in its samples."""

    bank: Tree
    start: StartState


@dataclass(frozen=True)
class ColumnObserver:
    """Torques of hands and disturbance, and the states of a steering column, from angles and torques.

    Three Kalman filters with stationary gains run in parallel: for hands whose torque has a rate, for hands that jump,
    and for friction that reverses. The observer starts at its first complete sample as if at rest, and restarts after a
    long gap; in a gap the standard deviations grow, and while it settles they are those of an unknown torque. A missing
    motor torque is held.

    Args:
        bank: bank of filters
        starting: behaviour in gaps

    Without the motor's angle (`outputs` of the tuning) the column below the bar is observed through the bar alone: the
    disturbance torque becomes slower and noisier, and an offset of the bar cannot be separated from its twist.

    Source: Raffone, eq (18), with no noise on the mechanical states, a rate of the hands' torque, and a bank.
    """

    bank: StationaryBank
    starting: Starting

    Sample = ColumnSample

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float = 1e-3, tuning: ColumnTuning | None = None
    ) -> ColumnObserver:
        """The observer of a vehicle's column, see `column_of_vehicle`.

        Args:
            vehicle: vehicle with gear stiffness, or with the inertia of its whole column
            sample_time: sampling interval [s]
            tuning: tuning; that of a bench or of the road where None, see `usual_tuning`

        Raises:
            ParameterError: parameters are missing, or do not fit, as in `require_fit`
        """
        return cls.of_parameters(column_of_vehicle(vehicle, sample_time), sample_time, tuning or usual_tuning(vehicle))

    @classmethod
    def of_parameters(
        cls, parameters: Column, sample_time: float = 1e-3, tuning: ColumnTuning | None = None
    ) -> ColumnObserver:
        """The observer of a column.

        Args:
            parameters: `ColumnParameters` (with gear) or `TwoInertiaParameters` (without)
            sample_time: sampling interval [s]
            tuning: tuning; that of a bench where None

        Raises:
            ParameterError: as in `require_fit`
        """
        made = design(parameters, sample_time, tuning or ColumnTuning())
        return cls(made.bank, Starting(made.layout))

    def init(self) -> ColumnMemory:
        """State before the first sample: not started."""
        return ColumnMemory(self.bank.init(), self.starting.init())

    def step(self, state: ColumnMemory, sample: ColumnSample) -> tuple[ColumnMemory, ColumnEstimate]:
        """Process one sample."""
        start, phase = self.starting.step(state.start, sample)
        given = self.bank.Sample(MotorTorque(phase.motor_torque), self.bank.model.Output(*phase.measured))
        moved, estimate = self.bank.step(state.bank, given)
        resting = resting_state(self.bank.model, self.starting.layout, sample)
        bank = phase.chosen(self.bank.at(resting), moved, state.bank)
        return ColumnMemory(bank, start), self._estimate(start, self.bank.mean(bank), estimate, phase)

    def _estimate(self, start: StartState, mean: Tree, estimate: Tree, phase: Phase) -> ColumnEstimate:
        layout, unknown = self.starting.layout, start.unknown
        hand = estimate.variance.hand_torque + layout.hand_torque_growth * start.missing + unknown
        disturbance = estimate.variance.disturbance_torque + layout.disturbance_torque_growth * start.missing
        innovation = dict(zip(layout.outputs, values_of(estimate.innovation), strict=True))
        return ColumnEstimate(
            mean.hand_torque,
            sqrt(hand),
            mean.disturbance_torque,
            sqrt(disturbance + unknown),
            mean.steering_wheel_angle,
            mean.motor_angle,
            getattr(mean, "gear_angle", mean.motor_angle / layout.motor_ratio),
            mean.steering_wheel_rate,
            mean.motor_speed,
            getattr(mean, "gear_rate", mean.motor_speed / layout.motor_ratio),
            getattr(mean, layout.offset) if layout.offset else 0.0,
            ColumnOutput(*(innovation.get(name, 0.0) for name in ColumnOutput._fields)),
            where(phase.following, estimate.nis, 0.0),
            where(phase.following, estimate.present, 0.0),
            phase.ready,
        )


def resting_state(model: Any, layout: Layout, sample: ColumnSample) -> Tree:
    """State of a column filter for a column at rest under this sample; zeros where values are missing.

    Args:
        model: model of the filter
        layout: layout of the observer
        sample: angles and torques
    """
    ratio, bar, wheel = layout.motor_ratio, _there(sample.driver_torque), _there(sample.steering_wheel_angle)
    gear = wheel - bar / layout.stiffness
    known_motor = "motor_angle_mechanical" in layout.outputs
    motor = _there(sample.motor_angle_mechanical) if known_motor else ratio * gear
    known = {
        "steering_wheel_angle": wheel,
        "gear_angle": gear,
        "motor_angle": motor,
        "hand_torque": bar,
        "disturbance_torque": _there(sample.motor_torque) + bar / ratio,
    }
    if layout.offset == "motor_angle_offset":
        known |= {"motor_angle": ratio * gear, "motor_angle_offset": motor - ratio * gear}
    return model.State(*(known.get(name, 0.0) for name in model.State._fields))


def _there(value: Scalar) -> Scalar:
    return where(present(value), value, 0.0)
