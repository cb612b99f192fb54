"""Phases of a column observer: start, follow, hold and restart over gaps in its samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.graph.maths import all_of, both, either, maximum, present, select, where
from tierod.monitors.driver_torque.design import Layout

UNKNOWN = 10.0
"""Standard deviation of an unknown torque [N m]; more than hands usually give."""


class ColumnSample(NamedTuple):
    """Measurements of a column at one instant; NaN where a value is missing.

    Args:
        motor_torque: torque at the motor's shaft
        steering_wheel_angle: angle above the torsion bar
        motor_angle_mechanical: angle of the motor's shaft
        driver_torque: torque in the torsion bar, positive towards left
    """

    motor_torque: Annotated[Scalar, "N*m"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    motor_angle_mechanical: Annotated[Scalar, "rad"]
    driver_torque: Annotated[Scalar, "N*m"]


class StartState(NamedTuple):
    """State of the gap handling.

    Args:
        motor_torque: last valid motor torque
        missing: time for which samples have been incomplete [s]
        started: 1 after the first complete sample
        settling: remaining settling time after a start [s]
    """

    motor_torque: Annotated[Scalar, "N*m"]
    missing: Annotated[Scalar, "s"]
    started: Annotated[Scalar, ""]
    settling: Annotated[Scalar, "s"]

    @property
    def unknown(self) -> Scalar:
        """Variance that an observer adds to its torques until it has settled [N**2*m**2]."""
        return where(both(self.started > 0.5, self.settling <= 0.0), 0.0, UNKNOWN**2)


class Phase(NamedTuple):
    """Mode of an observer in a sample.

    Args:
        motor_torque: torque of the previous sample, which acts until this one; held where it is missing
        measured: outputs that the observer uses, in the order of the layout
        restart: 1 where the observer restarts from this sample, as if at rest
        following: 1 where it continues or restarts; 0 where it is held
        ready: 1 where the estimate can be used
    """

    motor_torque: Annotated[Scalar, "N*m"]
    measured: tuple[Scalar, ...]
    restart: Annotated[Scalar, ""]
    following: Annotated[Scalar, ""]
    ready: Annotated[Scalar, ""]

    def chosen(self, resting: Tree, moved: Tree, held: Tree) -> Tree:
        """The tree that belongs to the phase: restarted, updated or held."""
        return select(self.following, select(self.restart, resting, moved), held)


@dataclass(frozen=True)
class Starting:
    """Start at the first complete sample, and restart after a gap longer than `longest_gap`; shorter ones are bridged.

    Args:
        layout: layout of the observer
        longest_gap: longest bridged gap; 0.05 s is a quarter of the period at which a driver still turns the wheel
            (5 Hz)
        settling_time: settling time after a start with a turning wheel; ten time constants of the filter for jumps
    """

    layout: Layout
    longest_gap: Annotated[float, "s"] = 0.05
    settling_time: Annotated[float, "s"] = 0.1

    Sample = ColumnSample

    def init(self) -> StartState:
        """State before the first sample: not started."""
        return StartState(0.0, 0.0, 0.0, 0.0)

    def step(self, state: StartState, sample: ColumnSample) -> tuple[StartState, Phase]:
        """Process one sample."""
        measured = tuple(getattr(sample, name) for name in self.layout.outputs)
        motor = where(present(sample.motor_torque), sample.motor_torque, state.motor_torque)
        complete = all_of(present(sample.motor_torque), *(present(value) for value in measured))
        missing = where(complete, 0.0, state.missing + self.layout.sample_time)
        restart = where(complete, either(state.started < 0.5, state.missing > self.longest_gap), 0.0)
        started = where(complete, 1.0, state.started)
        following = all_of(started > 0.5, missing <= self.longest_gap)
        left = maximum(state.settling - self.layout.sample_time, 0.0)
        settling = where(restart, self.settling_time, where(following, left, state.settling))
        ready = where(all_of(following, settling <= 0.0), 1.0, 0.0)
        return StartState(motor, missing, started, settling), Phase(
            state.motor_torque, measured, restart, following, ready
        )
