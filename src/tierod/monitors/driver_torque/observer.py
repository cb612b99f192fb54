"""The default observer of a steering column: torque of the hands, disturbance torque, angles and rates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.block import leaves, rebuild
from tierod.estimators.stationary_bank import StationaryBank
from tierod.graph.maths import all_of, both, either, maximum, present, sqrt, where
from tierod.models.column_observation import MotorTorque
from tierod.models.steering_column import ColumnOutput
from tierod.monitors.driver_torque.tuning import ColumnTuning, Layout, design
from tierod.monitors.driver_torque.vehicle_column import column_of_vehicle, usual_tuning
from tierod.vehicles import Vehicle

UNKNOWN = 10.0
"""Standard deviation of a torque of which nothing is known yet: more than hands usually give [N m]."""


class ColumnSample(NamedTuple):
    """What a column measures at one instant; NaN where a value is missing.

    Args:
        motor_torque: at the motor's shaft
        steering_wheel_angle: above the torsion bar
        motor_angle_mechanical: of the motor's shaft
        driver_torque: in the torsion bar, positive towards left
    """

    motor_torque: Annotated[float, "N*m"]
    steering_wheel_angle: Annotated[float, "rad"]
    motor_angle_mechanical: Annotated[float, "rad"]
    driver_torque: Annotated[float, "N*m"]


class ColumnEstimate(NamedTuple):
    """What an observer says of a column; a deviation is one standard deviation.

    Args:
        hand_torque: that the driver's hands put on the steering wheel
        hand_torque_deviation: of it
        disturbance_torque: that the motor overcomes at its shaft besides the column: dry friction, rack and road
        disturbance_torque_deviation: of it
        steering_wheel_angle, motor_angle_mechanical, gear_angle: filtered; the gear's is of the shaft below the bar
        steering_wheel_rate, motor_speed, gear_rate: likewise
        offset: of the sensor that the tuning names, in its unit; 0 where it names none
        innovation: measured less expected; NaN where missing, 0 of a sensor that the tuning leaves out
        nis: normalised innovation squared over what was present
        present: how many of the outputs were
        ready: 1 while the estimate can be used; 0 before the first complete sample, in a long gap, and while settling
    """

    hand_torque: Annotated[float, "N*m"]
    hand_torque_deviation: Annotated[float, "N*m"]
    disturbance_torque: Annotated[float, "N*m"]
    disturbance_torque_deviation: Annotated[float, "N*m"]
    steering_wheel_angle: Annotated[float, "rad"]
    motor_angle_mechanical: Annotated[float, "rad"]
    gear_angle: Annotated[float, "rad"]
    steering_wheel_rate: Annotated[float, "rad/s"]
    motor_speed: Annotated[float, "rad/s"]
    gear_rate: Annotated[float, "rad/s"]
    offset: Annotated[float, ""]
    innovation: ColumnOutput
    nis: Annotated[float, ""]
    present: Annotated[float, ""]
    ready: Annotated[float, ""]


class ColumnMemory(NamedTuple):
    """Memory of the observer.

    Args:
        bank: state of its filters
        motor_torque: the last one that was there
        missing: for how long samples have been incomplete [s]
        started: 1 after the first complete sample
        settling: how long the observer still settles after a start [s]
    """

    bank: Any
    motor_torque: Any
    missing: Any
    started: Any
    settling: Any


@dataclass(frozen=True)
class ColumnObserver:
    """Torque of the hands and of the disturbance, with the states of a steering column, from angles and torques.

    Two Kalman filters with stationary gains run side by side: one for hands whose torque has a rate, one for hands
    that jump. The observer starts at its first complete sample as if at rest, and starts again after a gap longer than
    `longest_gap`; in a gap the standard deviations grow, and they are those of no knowledge while it settles. A missing
    motor torque is held.

    Args:
        bank: the filters
        layout: what else it knows of the column
        longest_gap: after which a gap is a new start; a quarter of the period at which a driver still turns the wheel
            is 0.05 s (5 Hz)
        settling_time: of the filters, should the wheel turn at the start: ten times that of the one for jumps

    Without the motor's angle (`outputs` of the tuning) what is below the bar is known through the bar alone: the
    disturbance torque becomes slower and noisier, and an offset of the bar cannot be told from a twist of it.

    Source: Raffone, eq (18), with no noise on the mechanical states, a rate of the hands' torque, and a bank.
    """

    bank: StationaryBank
    layout: Layout
    longest_gap: Annotated[float, "s"] = 0.05
    settling_time: Annotated[float, "s"] = 0.1

    Sample = ColumnSample

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float = 1e-3, tuning: ColumnTuning | None = None
    ) -> ColumnObserver:
        """The observer of a vehicle's column, see `column_of_vehicle`.

        Args:
            vehicle: with gear stiffness, or with the inertia of its whole column
            sample_time: [s]
            tuning: that of a bench or of the road where None, see `usual_tuning`

        Raises:
            ParameterError: parameters are missing, or do not fit, as `require_fit` says
        """
        return cls.of_parameters(column_of_vehicle(vehicle), sample_time, tuning or usual_tuning(vehicle))

    @classmethod
    def of_parameters(
        cls, parameters: Any, sample_time: float = 1e-3, tuning: ColumnTuning | None = None
    ) -> ColumnObserver:
        """The observer of a column.

        Args:
            parameters: `ColumnParameters` (with gear) or `TwoInertiaParameters` (without)
            sample_time: [s]
            tuning: that of a bench where None

        Raises:
            ParameterError: as `require_fit` says
        """
        made = design(parameters, sample_time, tuning or ColumnTuning())
        return cls(made.bank, made.layout)

    def init(self) -> ColumnMemory:
        """Not started."""
        return ColumnMemory(self.bank.init(), 0.0, 0.0, 0.0, 0.0)

    def step(self, state: ColumnMemory, sample: ColumnSample) -> tuple[ColumnMemory, ColumnEstimate]:
        """One sample on."""
        measured = [getattr(sample, name) for name in self.layout.outputs]
        motor = where(present(sample.motor_torque), sample.motor_torque, state.motor_torque)
        complete = all_of(present(sample.motor_torque), *(present(value) for value in measured))
        missing = where(complete, 0.0, state.missing + self.layout.sample_time)
        restart = where(complete, either(state.started < 0.5, state.missing > self.longest_gap), 0.0)
        started = where(complete, 1.0, state.started)
        following = all_of(started > 0.5, missing <= self.longest_gap)
        model = self.bank.model
        moved, estimate = self.bank.step(state.bank, self.bank.Sample(MotorTorque(motor), model.Output(*measured)))
        resting = self.resting(sample)
        bank = _chosen(following, _chosen(restart, self.bank.at(resting), moved), state.bank)
        mean = _chosen(restart, resting, estimate.mean)
        mean = _chosen(following, mean, self.bank.mean(state.bank))
        left = maximum(state.settling - self.layout.sample_time, 0.0)
        settling = where(restart, self.settling_time, where(following, left, state.settling))
        after = ColumnMemory(bank, motor, missing, started, settling)
        return after, self._estimate(after, mean, estimate, following)

    def resting(self, sample: ColumnSample) -> Any:
        """The state of the filters if the column were at rest; zeros where values are missing."""
        ratio, bar = self.layout.motor_ratio, _there(sample.driver_torque)
        wheel = _there(sample.steering_wheel_angle)
        gear = wheel - bar / self.layout.stiffness
        motor = (
            _there(sample.motor_angle_mechanical) if "motor_angle_mechanical" in self.layout.outputs else ratio * gear
        )
        known = {
            "steering_wheel_angle": wheel,
            "gear_angle": gear,
            "motor_angle": motor,
            "hand_torque": bar,
            "disturbance_torque": _there(sample.motor_torque) + bar / ratio,
        }
        if self.layout.offset == "motor_angle_offset":
            known |= {"motor_angle": ratio * gear, "motor_angle_offset": motor - ratio * gear}
        return self.bank.model.State(*(known.get(name, 0.0) for name in self.bank.model.State._fields))

    def _estimate(self, memory: ColumnMemory, mean: Any, estimate: Any, following: Any) -> ColumnEstimate:
        layout = self.layout
        ready = all_of(following, memory.settling <= 0.0)
        unknown = where(both(memory.started > 0.5, memory.settling <= 0.0), 0.0, UNKNOWN**2)
        hand = estimate.variance.hand_torque + layout.hand_torque_growth * memory.missing + unknown
        disturbance = estimate.variance.disturbance_torque + layout.disturbance_torque_growth * memory.missing
        innovation = dict(zip(layout.outputs, (leaf for _, leaf in leaves(estimate.innovation)), strict=True))
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
            where(following, estimate.nis, 0.0),
            where(following, estimate.present, 0.0),
            where(ready, 1.0, 0.0),
        )


def _there(value: Any) -> Any:
    return where(present(value), value, 0.0)


def _chosen(condition: Any, taken: Any, otherwise: Any) -> Any:
    """One of two trees of the same shape."""
    pairs = zip(leaves(taken), leaves(otherwise), strict=True)
    return rebuild(otherwise, [where(condition, a, b) for (_, a), (_, b) in pairs])
