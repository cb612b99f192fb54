"""The bench's column under position control as one block at 1 kHz, and how well its shaft follows a reference."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Block, Scalar, Tree, rebuild, skeleton
from tierod.core.graph import Result, scan
from tierod.core.graph.maths import where
from tierod.models.steering_column import ColumnOutput, ColumnParameters
from tierod.models.two_inertia_column import without_gear
from tierod.papers.column import swept_bench
from tierod.papers.column.control.intervention import DriverIntervention, SteeringController, Takeover, noise_of
from tierod.papers.column.control.margins import Reading, read_estimate
from tierod.papers.column.control.position_control import ObservedColumn, PositionControl
from tierod.papers.column.control.reference import Reference, Step, Sweep
from tierod.proving_ground.cars.column_bench import Acting, Arms, BenchPorts, BenchSignals, BenchState, ColumnBench
from tierod.proving_ground.parts import NO_FAULT
from tierod.vehicles import load

SAMPLE_TIME = 1e-3
"""Of sensors, observer and controller [s]."""

NOISE = ColumnOutput(**swept_bench.NOISE)
"""Standard deviations of the sensors: both angles [rad], torque of the bar [N m]."""

REQUEST = 1.5
"""When control is asked for: after the observer has settled and the hands have been still as long as they must [s]."""

BEGIN = 2.0
"""When the reference begins to move: control has taken hold [s]."""


class Outside(NamedTuple):
    """External inputs: the reference, noise of the sensors, the driver.

    Args:
        reference: of the output shaft
        request: whether control is asked for (1.0 or 0.0)
        noise: of the sensors
        grip: of hands that hold the wheel where they took it, 0 to 1
    """

    reference: Reference
    request: Annotated[float, ""]
    noise: ColumnOutput
    grip: Annotated[float, ""]


class LoopState(NamedTuple):
    """Plant, observer, controller; torque that acts now, torque that acted before, and where hands took the wheel."""

    plant: BenchState
    observer: Tree
    controller: SteeringController.State
    acting: Scalar
    acted: Scalar
    held: Scalar


class LoopSignals(NamedTuple):
    """All that happens in a sample; `plant` is the truth, `measured` what the sensors make of it."""

    plant: BenchSignals
    measured: ColumnOutput
    observed: ObservedColumn
    hand_torque: Annotated[float, "N*m"]
    controller: SteeringController.Output


@dataclass(frozen=True)
class ClosedLoop:
    """Plant, sensors, observer and controller at 1 kHz.

    The torque that the controller finds from the measurements of one sample acts from the next sample on; the observer
    gets the torque that acted until its sample.

    Args:
        bench: the plant
        observer: block whose sample is the motor's torque and what is measured
        controller: takes what is observed
        read: finds the observed column and the hands' torque in the observer's output
    """

    bench: ColumnBench
    observer: Block
    controller: SteeringController
    read: Reading = read_estimate

    Sample = Outside

    def init(self) -> LoopState:
        """At rest, control off."""
        return LoopState(self.bench.init(), self.observer.init(), self.controller.init(), 0.0, 0.0, 0.0)

    def step(self, state: LoopState, sample: Outside) -> tuple[LoopState, LoopSignals]:
        """One sample on; the output belongs to the instant of the sample."""
        held = where(sample.grip > 0.0, state.held, state.plant.motion.wheel_angle)
        acting = Acting(state.acting, 0.0, 0.0, 0.0, sample.grip, held, 0.0, BenchPorts(NO_FAULT))
        plant, signals = self.bench.step(state.plant, acting)
        measured = ColumnOutput(*(getattr(signals, name) + noise for name, noise in sample.noise._asdict().items()))
        given = rebuild(skeleton(self.observer.Sample), [state.acted, *measured])
        observer, estimate = self.observer.step(state.observer, given)
        observed, hands = self.read(estimate)
        asked = SteeringController.Sample(observed, hands, sample.reference, sample.request)
        controller, output = self.controller.step(state.controller, asked)
        after = LoopState(plant, observer, controller, output.control.motor_torque, state.acting, held)
        return after, LoopSignals(signals, measured, observed, hands, output)


class Belief(NamedTuple):
    """Assumptions of observer and controller about the column; the plant has numbers of its own.

    Args:
        column: its parameters
        friction: of the motor [N m]
        inertia_uncertainty: of the steering wheel, twice its standard deviation [kg m^2]
    """

    column: ColumnParameters
    friction: float
    inertia_uncertainty: float


def belief(vehicle: str = "column-bench") -> Belief:
    """Assumptions by the file of a vehicle."""
    known = load(vehicle)
    uncertain = 2.0 * (known.parameters["steering_wheel_inertia"].standard_deviation or 0.0)
    return Belief(known.parameters_for(ColumnParameters), known["motor_friction"], uncertain)


def intervention(known: Belief, observer: Block, takeover: Takeover | None = None) -> DriverIntervention:
    """The rule for the noise that an observer has on this bench while nothing moves."""
    seconds = 100.0
    still = np.column_stack([np.zeros(round(seconds / SAMPLE_TIME)), _noise(round(seconds / SAMPLE_TIME), 77)])
    result = scan(observer, still)
    found = noise_of(result["hand_torque"][round(5.0 / SAMPLE_TIME) :])
    return DriverIntervention.design(found, SAMPLE_TIME, takeover, known.inertia_uncertainty)


def loop_of(observer: Block, known: Belief) -> ClosedLoop:
    """The closed loop with an observer, friction fed forward."""
    column, stiffness = without_gear(known.column), known.column.torsion_bar_stiffness
    position = PositionControl.design(column, stiffness, SAMPLE_TIME, friction=known.friction)
    return ClosedLoop(ColumnBench(), observer, SteeringController(position, intervention(known, observer)))


def holding(stiffness: float) -> ColumnBench:
    """The bench with arms that hold the wheel where they took it.

    Args:
        stiffness: [N m/rad]; 10 is a light hold, 30 a firm one, 100 one with both hands and stiff arms
    """
    return ColumnBench(arms=Arms(stiffness=stiffness))


class Run(NamedTuple):
    """A run of a closed loop: time [s], reference (whose fields hold a value per instant), signals by name."""

    time: np.ndarray
    reference: Tree
    signals: Result


def run(
    loop: ClosedLoop,
    source: Sweep | Step,
    seconds: float,
    seed: int = 0,
    grip: float = math.inf,
    request_end: float = math.inf,
) -> Run:
    """Let the loop follow a reference from `BEGIN` on.

    Args:
        loop: plant, observer and controller
        source: of the reference, its time counted from `BEGIN`
        seconds: duration of the whole
        seed: of the sensors' noise
        grip: when hands take the wheel [s]
        request_end: when control is no longer asked for [s]
    """
    time = np.arange(round(seconds / SAMPLE_TIME)) * SAMPLE_TIME
    reference = source.at(np.maximum(time - BEGIN, 0.0))
    request = ((time >= REQUEST) & (time < request_end)).astype(float)
    gripped = np.clip((time - grip) / GRIPPING, 0.0, 1.0)
    rows = np.column_stack([*reference, request, _noise(len(time), seed), gripped])
    return Run(time, reference, scan(loop, rows))


GRIPPING = 0.03
"""In which hands close round the wheel [s]."""


def _noise(count: int, seed: int) -> np.ndarray:
    return np.asarray(np.random.default_rng([seed, 31]).normal(size=(count, 3)) * np.array(NOISE))


class Followed(NamedTuple):
    """Error of the gear's true angle against the reference.

    Args:
        rms, largest: of the error [deg]
        phase: of the angle against the reference, negative where late [deg]; NaN where no frequency was asked for
        found: how often a driver was found
    """

    rms: float
    largest: float
    phase: float
    found: int


def error(done: Run) -> np.ndarray:
    """Shaft less reference, true, over time [deg]."""
    return np.asarray(np.degrees(done.signals["plant.truth_gear_angle"] - done.reference.angle))


def followed(done: Run, after: float, until: float = math.inf, frequency: float = math.nan) -> Followed:
    """Figures of a stretch of a run.

    Args:
        done: the run
        after, until: the stretch; whole periods where a frequency is given [s]
        frequency: of a plain sine [Hz]
    """
    chosen = (done.time >= after - 0.5 * SAMPLE_TIME) & (done.time < until - 0.5 * SAMPLE_TIME)
    wrong = error(done)[chosen]
    phase = math.nan
    if math.isfinite(frequency):
        turning = np.exp(-2j * math.pi * frequency * done.time[chosen])
        shaft = done.signals["plant.truth_gear_angle"][chosen] @ turning
        phase = math.degrees(np.angle(shaft / (done.reference.angle[chosen] @ turning)))
    found = int(done.signals["controller.driver.found"].sum())
    return Followed(float(np.sqrt(np.mean(wrong**2))), float(np.abs(wrong).max()), phase, found)


def sine(loop: ClosedLoop, frequency: float, seed: int = 0, quick: bool = False) -> Followed:
    """A plain sine of 30 degrees, whole periods after it has settled."""
    periods = 1.0 if quick else max(2.0, round(4.0 * frequency))
    after = BEGIN + 2.0
    until = after + periods / frequency
    done = run(loop, Sweep(start=frequency, stop=frequency), until, seed)
    return followed(done, after, until, frequency)


def sweep(loop: ClosedLoop, seed: int = 0, quick: bool = False) -> tuple[Run, Followed]:
    """The sweep of figure 10, 0.1 to 3 Hz, and how well it was followed once it had faded in."""
    source = Sweep(duration=10.0) if quick else Sweep()
    done = run(loop, source, BEGIN + source.duration, seed)
    return done, followed(done, BEGIN + source.fade)
