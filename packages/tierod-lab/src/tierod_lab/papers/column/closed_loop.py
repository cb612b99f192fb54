"""The bench column under position control as one block at 1 kHz, and the tracking error of its shaft."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Block, Scalar, Tree, rebuild, skeleton
from tierod.core.graph import Result, scan
from tierod.models.steering_column import ColumnOutput, ColumnParameters, without_gear
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import Acting, BenchPorts, BenchSignals, BenchState, ColumnBench
from tierod_lab.ground.parts import NO_FAULT
from tierod_lab.papers.column import swept_bench
from tierod_lab.papers.column.control.position_control import ObservedColumn, PositionControl
from tierod_lab.papers.column.control.reference import Reference, Sweep

SAMPLE_TIME = 1e-3  # Sampling interval of sensors, observer and controller [s]

NOISE = ColumnOutput(**swept_bench.NOISE)
"""Standard deviations of the sensor noise: both angles [rad], torque of the torsion bar [N m]."""

REQUEST = 1.5  # Time from which control is enabled, after the warm-up of the observer [s]

BEGIN = 2.0  # Time at which the reference begins to move, with control fully engaged [s]


class Outside(NamedTuple):
    """External inputs: reference of the output shaft, whether control is enabled (1.0 or 0.0), noise of the sensors."""

    reference: Reference
    enabled: Annotated[float, ""]
    noise: ColumnOutput


class LoopState(NamedTuple):
    """States of plant, observer and control, motor torque of this and the last sample."""

    plant: BenchState
    observer: Tree
    control: PositionControl.State
    acting: Scalar
    acted: Scalar


class LoopSignals(NamedTuple):
    """Signals of a sample; `plant` is the truth, `measured` adds the noise of the sensors."""

    plant: BenchSignals
    measured: ColumnOutput
    observed: ObservedColumn
    hand_torque: Annotated[float, "N*m"]
    control: PositionControl.Output


def read_estimate(estimate: Tree) -> tuple[ObservedColumn, Scalar]:
    """State and hand torque from an estimate, or from its mean, by the names of its fields."""
    named: Tree = getattr(estimate, "mean", estimate)
    motor_angle = named.motor_angle if hasattr(named, "motor_angle") else named.motor_angle_mechanical
    column = ObservedColumn(
        named.steering_wheel_rate, named.motor_speed, named.steering_wheel_angle, motor_angle, named.disturbance_torque
    )
    return column, named.hand_torque


@dataclass(frozen=True)
class ClosedLoop:
    """Plant, sensors, observer and control at 1 kHz.

    The torque that the control computes from the measurements of one sample acts from the next sample on; the
    observer receives the torque that acted until its sample.
    """

    bench: ColumnBench  # the plant
    observer: Block  # block whose sample is the motor torque and the measurements
    control: PositionControl  # position control that acts on the estimates of the observer

    Sample = Outside

    def init(self) -> LoopState:
        return LoopState(self.bench.init(), self.observer.init(), self.control.init(), 0.0, 0.0)

    def step(self, state: LoopState, sample: Outside) -> tuple[LoopState, LoopSignals]:
        acting = Acting(state.acting, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, BenchPorts(NO_FAULT))
        plant, signals = self.bench.step(state.plant, acting)
        measured = ColumnOutput(*(getattr(signals, name) + noise for name, noise in sample.noise._asdict().items()))
        given = rebuild(skeleton(self.observer.Sample), [state.acted, *measured])
        observer, estimate = self.observer.step(state.observer, given)
        observed, hands = read_estimate(estimate)
        asked = PositionControl.Sample(observed, sample.reference, sample.enabled)
        control, output = self.control.step(state.control, asked)
        after = LoopState(plant, observer, control, output.motor_torque, state.acting)
        return after, LoopSignals(signals, measured, observed, hands, output)


class Belief(NamedTuple):
    """Parameters of the column as observer and control assume them; those of the plant may differ."""

    column: ColumnParameters  # parameters of the column
    friction: float  # dry friction at the motor [N m]


def belief(vehicle: str = "column-bench") -> Belief:
    """Assumed parameters from a vehicle file."""
    known = load(vehicle)
    return Belief(known.parameters_for(ColumnParameters), known["motor_friction"])


def loop_of(observer: Block, known: Belief) -> ClosedLoop:
    """The closed loop with an observer, and with feed-forward of friction."""
    column, stiffness = without_gear(known.column), known.column.torsion_bar_stiffness
    position = PositionControl.design(column, stiffness, SAMPLE_TIME, friction=known.friction)
    return ClosedLoop(ColumnBench(), observer, position)


class Run(NamedTuple):
    """A run of a closed loop: time [s], reference (each field an array over time), signals by name."""

    time: np.ndarray
    reference: Tree
    signals: Result


def run(loop: ClosedLoop, source: Sweep, seconds: float, seed: int = 0) -> Run:
    """Simulate the loop with a reference that begins at `BEGIN`.

    Args:
        source: reference, with its time counted from `BEGIN`
        seconds: duration of the whole run [s]
    """
    time = np.arange(round(seconds / SAMPLE_TIME)) * SAMPLE_TIME
    reference = source.at(np.maximum(time - BEGIN, 0.0))
    enabled = (time >= REQUEST).astype(float)
    rows = np.column_stack([*reference, enabled, _noise(len(time), seed)])
    return Run(time, reference, scan(loop, rows))


def _noise(count: int, seed: int) -> np.ndarray:
    return np.asarray(np.random.default_rng([seed, 31]).normal(size=(count, 3)) * np.array(NOISE))


class Followed(NamedTuple):
    """Tracking error of the true gear angle against the reference."""

    rms: float  # rms, largest: root mean square and largest error [deg]
    largest: float
    phase: float  # phase of the angle against the reference, negative for a lag [deg]; NaN where no frequency was given


def error(done: Run) -> np.ndarray:
    """Tracking error over time: true angle of the shaft less reference [deg]."""
    return np.asarray(np.degrees(done.signals["plant.truth_gear_angle"] - done.reference.angle))


def followed(done: Run, after: float, until: float = math.inf, frequency: float = math.nan) -> Followed:
    """Evaluate the tracking error over an interval of a run.

    Args:
        after, until: start and end of the interval; whole periods where a frequency is given [s]
        frequency: frequency of a plain sine [Hz]
    """
    # Half a sample of tolerance keeps rounding of the time from adding or dropping a sample at the ends.
    chosen = (done.time >= after - 0.5 * SAMPLE_TIME) & (done.time < until - 0.5 * SAMPLE_TIME)
    wrong = error(done)[chosen]
    phase = math.nan
    if math.isfinite(frequency):
        turning = np.exp(-2j * math.pi * frequency * done.time[chosen])
        shaft = done.signals["plant.truth_gear_angle"][chosen] @ turning
        phase = math.degrees(np.angle(shaft / (done.reference.angle[chosen] @ turning)))
    return Followed(float(np.sqrt(np.mean(wrong**2))), float(np.abs(wrong).max()), phase)


def sine(loop: ClosedLoop, frequency: float, seed: int = 0, quick: bool = False) -> Followed:
    """Tracking of a sine of 30 degrees, over whole periods in steady state."""
    periods = 1.0 if quick else max(2.0, round(4.0 * frequency))
    after = BEGIN + 2.0
    until = after + periods / frequency
    done = run(loop, Sweep(start=frequency, stop=frequency), until, seed)
    return followed(done, after, until, frequency)


def sweep(loop: ClosedLoop, seed: int = 0, quick: bool = False) -> tuple[Run, Followed]:
    """The sweep of figure 10, 0.1 to 3 Hz, and its tracking error after the fade-in."""
    source = Sweep(duration=10.0) if quick else Sweep()
    done = run(loop, source, BEGIN + source.duration, seed)
    return done, followed(done, BEGIN + source.fade)
