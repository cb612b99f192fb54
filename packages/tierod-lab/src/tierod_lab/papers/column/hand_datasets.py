"""Torque of the driver's hands, hands on and off the wheel, natural drives, and control of position."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Block, Tree
from tierod.core.graph import Result, scan
from tierod.models.steering_column import ColumnOutput, without_gear
from tierod.monitors.driver_torque.definition import DRIVER_TORQUE
from tierod.monitors.driver_torque.evidence import TRUTH
from tierod.monitors.driver_torque.hands import OFF, HandsMonitor
from tierod.monitors.driver_torque.observer import ColumnObserver
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import Acting, BenchPorts, BenchSignals, BenchState, ColumnBench
from tierod_lab.ground.cars.catalogue import load as load_car
from tierod_lab.ground.courses import AnyCourse
from tierod_lab.ground.courses import load as load_course
from tierod_lab.ground.courses.course import During, Grip, Tremor
from tierod_lab.ground.parts import NO_FAULT
from tierod_lab.ground.run import run
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.papers.column.benches import NOISE, STEP, decisions, drawn, known_column, samples, scored, swept
from tierod_lab.papers.column.position_control import ObservedPositionControl
from tierod_lab.papers.column.printed import COLUMNS, PrintedObserver
from tierod_lab.papers.column.reference import Reference, Sweep
from tierod_lab.studies.metrics import Row

FROM = 0.5  # Warm-up of the observers, which start at rest without further knowledge; errors count after it [s]


@cache
def observers() -> dict[str, Block]:
    """Every compared observer."""
    known = known_column()
    found: dict[str, Block] = {f"paper: {each}": PrintedObserver.of_column(known, each) for each in COLUMNS}
    return found | {"default": ColumnObserver.of_parameters(known)}


def hand_torque(task: tuple[str, int]) -> list[Row]:
    """The motor of the simulated bench sweeps the column by ±30° from 0.1 to 3 Hz, as in Figure 10 of the paper.

    The hands first pull by a sine of 1.5 N·m, then twice by 2 N·m for 4 s, as steps or as ramps of 100 ms, or are off.
    Noise of 0.05° on the wheel's angle, 0.2° on the motor's, 0.02 N·m on the bar's torque; 1 kHz. Friction at the motor
    is 0.1 N·m by Dahl's law, of which the observers know nothing. A step weighs heavily: within the 15 ms until it
    stands out from noise the error is 2 N·m.
    """
    hands, seed = task
    drive = swept(hands, 40.0, seed)
    counted, rows = drive["time"] > FROM, list[Row]()
    for name, block in observers().items():
        found = scan(block, samples(drive))
        errors = {
            column: float(np.sqrt(np.mean((found[f"{what}_torque"] - drive[f"{what}_torque"])[counted] ** 2)))
            for column, what in (("error", "hand"), ("disturbance", "disturbance"))
        }
        rows.append({"observer": name, "kind": name.partition(":")[0], "hands": hands, **errors})
    return rows


class Held(NamedTuple):
    """A run of a drawn bench: "usual" or "far off", its seed and duration [s]."""

    kind: str
    seed: int
    seconds: float


@cache
def _monitor() -> HandsMonitor:
    return HandsMonitor.of_vehicle(load("column-bench"), STEP)


def hands_on_and_off(task: Held) -> list[Row]:
    """Benches whose parameters and torque sensor are off from the vehicle file by 2 % each, with an offset besides.

    Hands come and go after 3 to 20 s, with a torque of 0.1 to 0.5 N·m, while the motor rests, keeps a lane or sweeps. A
    delay counts from the first touch of a grip that takes 30 ms, and from the moment at which it begins to let go. Far
    off: by 10 %.
    """
    found = scored(_monitor(), drawn(task.seed, 0.1 if task.kind == "far off" else 0.02, task.seconds))
    rows: list[Row] = []
    for event, delays in (("grab", found.grabs), ("release", found.releases)):
        never = event == "release"
        rows += [
            {"kind": task.kind, "event": event, "delay": 1e3 * each, "wrong": float(never and math.isinf(each))}
            for each in delays
        ]
    wrong, hours = found.false_on + found.false_off, found.seconds / 3600.0
    return [*rows, {"kind": task.kind, "event": "run", "wrong": wrong, "hours": hours}]


CAR, SCATTER, STARTED = "midsize-eps", 0.05, 5.0
"""The car, relative error of its wheel and torsion bar against the vehicle file, and warm-up [s]."""
EVERY, LEAVES, COMES, RAMP = 40.0, 20.0, 25.0, 0.3
"""Period of the releases on long drives, start and end of a release in it, and fade time of the grip [s]."""
SENSINGS = {"bench, 1000 Hz": (True, 1000.0)} | {f"production, {rate:g} Hz": (False, rate) for rate in (1000.0, 100.0)}
"""Whether the sensors are those of a bench, and the common sampling rate [Hz], by name."""


class Natural(NamedTuple):
    """A natural drive with a set of sensors."""

    course: str
    sensing: str
    seed: int
    seconds: float


def natural_drives(task: Natural) -> list[Row]:
    """The car with a wheel and a torsion bar that are off from the vehicle file by 5 %.

    On a straight road hands hold firmly, lightly, touch and leave the wheel; on a motorway they leave it for 5 s out of
    40; through city, country and motorway they stay on it. Torque of the road is a white unknown torque at the pinion
    for the observer.
    """
    bench, rate = SENSINGS[task.sensing]
    sensors = (SensorSet.bench() if bench else SensorSet.production()).at_rate(rate)
    course, windows = _course(task)
    vehicle = load(CAR)
    recording = run(_car(task.seed), course, task.seconds, task.seed, sensors).recording
    session = DRIVER_TORQUE.variants["interacting"].open(vehicle, rate, None)
    now = session.absorb(recording.align(session.signals, rate, maximum_age=0.05))
    grid = recording.align(("driver_torque",), rate, maximum_age=0.05)
    true = recording.align((TRUTH,), rate, "linear").values[:, 0]
    counted = (grid.time > STARTED) & np.isfinite(true)

    def rms(values: np.ndarray) -> float:
        return float(np.sqrt(np.mean(values[counted] ** 2)))

    shared: Row = {"course": task.course, "sensors": task.sensing}
    held, delays = _hands_times(grid.time, now["hands_on"], windows, rate)
    return [
        {
            **shared,
            "bar": rms(grid.values[:, 0] - true),
            "torque": rms(now["hand_torque"] - true),
            "claimed": rms(now["hand_torque_standard_deviation"]),
            "off_while_held": float(np.mean(now["hands_on"][held] == OFF)),
        },
        *({**shared, "release": delay} for delay in delays),
    ]


def _course(task: Natural) -> tuple[AnyCourse, list[tuple[float, float]]]:
    """The course, and start and end of every release: the grip fades after the start and returns by the end [s]."""
    if task.course == "straight":
        return load_course("hands-on-and-off"), [(24.0, 28.0), (50.0, 53.0)]
    course = load_course(task.course)
    if task.course == "mixed":
        return replace(course, conditions=(*course.conditions, Tremor()), seed=task.seed), []
    leaving = (
        Grip(During(LEAVES, COMES, RAMP, EVERY), 0.0),
        Tremor(During(0.0, LEAVES, RAMP)),
        Tremor(During(COMES, LEAVES + EVERY, RAMP, EVERY)),
    )
    count = int((task.seconds - COMES) // EVERY) + 1
    windows = [(LEAVES + EVERY * each, COMES + EVERY * each) for each in range(count)]
    return replace(course, conditions=(*course.conditions, *leaving), seed=task.seed), windows


def _car(seed: int) -> Tree:
    car: Tree = load_car(CAR).block
    one, two, three = 1.0 + SCATTER * np.random.default_rng([seed, 9]).choice([-1.0, 1.0], 3)
    steering = car.steering
    bar = replace(steering.torsion_bar, stiffness=float(one) * steering.torsion_bar.stiffness)
    inertia, damping = float(two) * steering.wheel_inertia, float(three) * steering.wheel_damping
    return replace(car, steering=replace(steering, torsion_bar=bar, wheel_inertia=inertia, wheel_damping=damping))


def _hands_times(
    time: np.ndarray, hands: np.ndarray, windows: list[tuple[float, float]], rate: float
) -> tuple[np.ndarray, list[float]]:
    """Samples in which hands are held, and delay of every release [s]; infinite where it was not found."""
    decided, fading, delays = decisions(hands), np.zeros(len(time), bool), []
    for start, end in windows:
        # Held time starts a second after the grip has returned, so that the detection delay of hands on is not false.
        fading |= (time >= start) & (time < end + 1.0)
        part = (time >= start + RAMP) & (time < end)
        right = np.flatnonzero(decided[part] == OFF)
        delays.append(float(right[0]) / rate if len(right) else math.inf)
    return (time > STARTED) & ~fading, delays


REQUEST = 1.5  # Time from which control is enabled, after the warm-up of the observer [s]
BEGIN = 2.0  # Time at which the reference begins to move, with control fully engaged [s]


class Outside(NamedTuple):
    """External inputs: reference of the output shaft, whether control is enabled (1.0 or 0.0), noise of the sensors."""

    reference: Reference
    enabled: Annotated[float, ""]
    noise: ColumnOutput


class LoopSignals(NamedTuple):
    """Signals of a sample; `plant` is the truth, `measured` adds the noise of the sensors."""

    plant: BenchSignals
    measured: ColumnOutput
    controller: ObservedPositionControl.Output


class LoopState(NamedTuple):
    """States of plant and controller."""

    plant: BenchState
    controller: ObservedPositionControl.State


@dataclass(frozen=True)
class ClosedLoop:
    """Plant, sensors, observer and control at 1 kHz; what is found from one sample acts from the next on."""

    controller: ObservedPositionControl
    bench: ColumnBench = field(default_factory=ColumnBench)

    Sample = Outside

    def init(self) -> LoopState:
        return LoopState(self.bench.init(), self.controller.init())

    def step(self, state: LoopState, sample: Outside) -> tuple[LoopState, LoopSignals]:
        acting = Acting(state.controller.acting, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, BenchPorts(NO_FAULT))
        plant, signals = self.bench.step(state.plant, acting)
        measured = ColumnOutput(*(getattr(signals, name) + noise for name, noise in sample.noise._asdict().items()))
        given = ObservedPositionControl.Sample(measured, sample.reference, sample.enabled)
        controller, output = self.controller.step(state.controller, given)
        return LoopState(plant, controller), LoopSignals(signals, measured, output)


@cache
def loops() -> dict[str, ClosedLoop]:
    """The closed loop with every compared observer, by name."""
    vehicle, column = load("column-bench"), known_column()
    blocks: dict[str, Block] = {
        "printed, mechanical": PrintedObserver.of_column(column, "series spring", STEP),
        "printed, balanced": PrintedObserver.of_column(column, "balanced", STEP),
        "printed, full": PrintedObserver.of_column(column, "full", STEP),
        "default, without gear": ColumnObserver.of_parameters(without_gear(column), STEP),
    }
    make, friction = ObservedPositionControl.with_observer, vehicle["motor_friction"]
    return {name: ClosedLoop(make(block, column, friction)) for name, block in blocks.items()}


class Run(NamedTuple):
    """A run of a closed loop: time [s], reference (each field an array over time), signals by name."""

    time: np.ndarray
    reference: Tree
    signals: Result


def sweep(loop: ClosedLoop, seed: int = 0, quick: bool = False) -> Run:
    """Simulate the sweep of figure 10, 0.1 to 3 Hz, which begins at `BEGIN`."""
    source = Sweep(duration=10.0) if quick else Sweep()
    time = np.arange(round((BEGIN + source.duration) / STEP)) * STEP
    reference = source.at(np.maximum(time - BEGIN, 0.0))
    noise = np.random.default_rng([seed, 31]).normal(size=(len(time), 3)) * np.array(ColumnOutput(**NOISE))
    rows = np.column_stack([*reference, (time >= REQUEST).astype(float), noise])
    return Run(time, reference, scan(loop, rows))


def tracking(task: tuple[str, bool]) -> list[Row]:
    """The paper closes the loop with a first attempt at a linear quadratic regulator and shows one sweep (Figure 10).

    Here the regulator has integral action, a plan from the flat output, friction fed forward, and limits of torque and
    rate; what it finds from one sample acts from the next on. The angle that counts is that of the gear, which no
    sensor measures. An observer that has the gear follows its oscillation at 112 Hz, which the control then excites.
    """
    name, quick = task
    done = sweep(loops()[name], 4, quick)
    # Half a sample of tolerance keeps rounding of the time from adding or dropping a sample at the end of the fade-in.
    counted = done.time >= BEGIN + Sweep.fade - 0.5 * STEP
    away = np.degrees(done.signals["plant.truth_gear_angle"] - done.reference.angle)[counted]
    return [{"loop": name, "rms": float(np.sqrt(np.mean(away**2))), "largest": float(np.abs(away).max())}]
