"""Phases of an observer of a column: start, follow, hold and restart over gaps in its samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, leaves, rebuild
from tierod.core.graph.maths import all_of, either, maximum, present, where
from tierod.monitors.driver_torque.design import Layout


class ColumnSample(NamedTuple):
    """Measurements of a column at one instant; NaN where a value is missing.

    Args:
        motor_torque: at the motor's shaft
        steering_wheel_angle: above the torsion bar
        motor_angle_mechanical: of the motor's shaft
        driver_torque: in the torsion bar, positive towards left
    """

    motor_torque: Annotated[Scalar, "N*m"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    motor_angle_mechanical: Annotated[Scalar, "rad"]
    driver_torque: Annotated[Scalar, "N*m"]


class StartState(NamedTuple):
    """Memory of the gaps.

    Args:
        motor_torque: the last one that was there
        missing: for how long samples have been incomplete [s]
        started: 1 after the first complete sample
        settling: time that the observer still settles after a start [s]
    """

    motor_torque: Annotated[Scalar, "N*m"]
    missing: Annotated[Scalar, "s"]
    started: Annotated[Scalar, ""]
    settling: Annotated[Scalar, "s"]


class Phase(NamedTuple):
    """Mode of an observer at a sample.

    Args:
        motor_torque: of the sample before, which acts until this one; held where it is missing
        measured: outputs that the observer uses, in the order of the layout
        restart: 1 begins anew from this sample, as if at rest
        following: 1 goes on with it, or begins; 0 holds
        ready: 1 where the estimate can be used
    """

    motor_torque: Annotated[Scalar, "N*m"]
    measured: tuple[Scalar, ...]
    restart: Annotated[Scalar, ""]
    following: Annotated[Scalar, ""]
    ready: Annotated[Scalar, ""]

    def chosen(self, resting: Tree, moved: Tree, held: Tree) -> Tree:
        """The one of three trees of one shape that belongs to the phase."""
        triples = zip(leaves(resting), leaves(moved), leaves(held), strict=True)
        return rebuild(
            held, [where(self.following, where(self.restart, a, b), c) for (_, a), (_, b), (_, c) in triples]
        )


@dataclass(frozen=True)
class Starting:
    """Starts at the first complete sample, and again after a gap longer than `longest_gap`, within which it follows.

    Args:
        layout: of the observer
        longest_gap: a quarter of the period at which a driver still turns the wheel is 0.05 s (5 Hz)
        settling_time: of the observer, should the wheel turn at the start: ten time constants of the filter for jumps
    """

    layout: Layout
    longest_gap: Annotated[float, "s"] = 0.05
    settling_time: Annotated[float, "s"] = 0.1

    Sample = ColumnSample

    def init(self) -> StartState:
        """Not started."""
        return StartState(0.0, 0.0, 0.0, 0.0)

    def step(self, state: StartState, sample: ColumnSample) -> tuple[StartState, Phase]:
        """One sample on."""
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
