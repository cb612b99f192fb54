"""Torque of the driver's hands, hands on and off the wheel, natural drives, and control of position."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from tierod.core.block import Block, Tree
from tierod.core.recording import Recording
from tierod.models.steering_column import without_gear
from tierod.monitors.driver_torque.definition import DRIVER_TORQUE
from tierod.monitors.driver_torque.design import ColumnTuning
from tierod.monitors.driver_torque.evidence import TRUTH
from tierod.monitors.driver_torque.hands import OFF, THRESHOLDS, HandsMonitor, Tolerance
from tierod.monitors.driver_torque.observer import ColumnObserver, DelayedHandTorque
from tierod.vehicles import Vehicle, load
from tierod_lab.ground.cars.benches import ColumnBench
from tierod_lab.ground.cars.catalogue import load as load_car
from tierod_lab.ground.courses import AnyCourse
from tierod_lab.ground.courses import load as load_course
from tierod_lab.ground.courses.course import During, Grip, Tremor
from tierod_lab.ground.run import run
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.ground.steering.friction import Coulomb, Dahl, DahlPower, DryFriction, Law, LuGre, MaxwellSlip, Stribeck
from tierod_lab.papers.column.closed_loop import SAMPLE_TIME, ClosedLoop, belief, loop_of, sine, sweep
from tierod_lab.papers.column.column_friction import ColumnFrictionObserver, FrictionTuning
from tierod_lab.papers.column.columns import SETS, bench_of
from tierod_lab.papers.column.handled_bench import STEP, decisions, drawn, scored
from tierod_lab.papers.column.printed import COLUMNS, PrintedObserver
from tierod_lab.papers.column.swept_bench import (
    DELAY,
    SIGNALS,
    SweptBench,
    errors,
    known_column,
    swept,
)
from tierod_lab.studies.metrics import Row


@cache
def observers() -> dict[str, tuple[Block, int]]:
    """Every compared observer with its lag in samples."""
    known = known_column()
    found: dict[str, tuple[Block, int]] = {
        f"paper: {column}": (PrintedObserver.of_column(known, column), 0) for column in COLUMNS
    }
    found["default"] = (ColumnObserver.of_parameters(known), 0)
    found["20 ms later"] = (DelayedHandTorque.of_parameters(known), DELAY)
    for name, level, angle in (
        ("friction by its law", 0.1, 0.05),
        ("friction by its law, level half", 0.05, 0.05),
        ("friction by its law, level half, angle twice", 0.05, 0.1),
    ):
        found[name] = (ColumnFrictionObserver.of_parameters(known, angle, friction=FrictionTuning(level=level)), 0)
    return found


def hand_torque(task: tuple[str, int]) -> list[Row]:
    """The motor of the simulated bench sweeps the column by ±30° from 0.1 to 3 Hz, as in Figure 10 of the paper.

    The hands first pull by a sine of 1.5 N·m, then twice by 2 N·m for 4 s, as steps or as ramps of 100 ms, or are off.
    Noise of 0.05° on the wheel's angle, 0.2° on the motor's, 0.02 N·m on the bar's torque; 1 kHz. Friction at the motor
    is 0.1 N·m by Dahl's law, of which the observers know nothing unless it is said. A step weighs heavily: within the
    15 ms until it stands out from noise the error is 2 N·m.
    """
    hands, seed = task
    drive = swept(hands, 40.0, seed)
    return [
        {"observer": name, "kind": name.partition(":")[0], "hands": hands, **_errors(block, drive, delay)}
        for name, (block, delay) in observers().items()
    ]


def _errors(block: Block, drive: Mapping[str, np.ndarray], delay: int = 0, change: Any = None) -> dict[str, float]:
    found = errors(block, [drive], delay, change)
    return {"error": found.hand_torque, "disturbance": found.disturbance_torque, "nis": found.nis / 3.0}


WRONG = {
    f"{name.replace('_', ' ')} {100.0 * (factor - 1.0):+.0f} %": (name, factor)
    for name, factors in {
        "steering_wheel_inertia": (0.9, 0.98, 1.02, 1.1),
        "steering_wheel_damping": (0.9, 1.1),
        "torsion_bar_stiffness": (0.9, 1.1),
        "motor_inertia": (0.9, 1.1),
        "motor_damping": (0.9, 1.1),
        "gear_stiffness": (0.9, 1.1),
    }.items()
    for factor in factors
}
"""Wrong parameters: field of `ColumnParameters` and factor, by name."""


def _scaled(column: int, factor: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda samples: samples * np.where(np.arange(samples.shape[1]) == column, factor, 1.0)


def _late_bar(samples: np.ndarray) -> np.ndarray:
    late = samples.copy()
    late[1:, BAR] = samples[:-1, BAR]
    return late


def _offset(samples: np.ndarray) -> np.ndarray:
    return np.asarray(samples + np.array([0.0, 0.0, 0.0, 0.05]))


TORQUE, BAR = SIGNALS.index("motor_torque"), SIGNALS.index("driver_torque")
SENSORS: dict[str, tuple[Callable[[np.ndarray], np.ndarray], ColumnTuning]] = {
    "gain of the bar's sensor +2 %": (_scaled(BAR, 1.02), ColumnTuning()),
    "bar's torque 1 ms late": (_late_bar, ColumnTuning()),
    "torque of the motor +2 %": (_scaled(TORQUE, 1.02), ColumnTuning()),
    "bar +0.05 N·m, not learnt": (_offset, ColumnTuning()),
    "bar +0.05 N·m, learnt": (_offset, ColumnTuning(offset="driver_torque")),
}
"""Sensor errors, as functions from correct to wrong samples, and the observer's tuning, by name."""
LAWS: Mapping[str, Law] = {
    "Dahl, exponent 0.5": DahlPower(0.05, 0.5),
    "Dahl, exponent 2": DahlPower(0.05, 2.0),
    "Maxwell slip": MaxwellSlip(),
    "Stribeck": Stribeck(),
    "LuGre": LuGre(),
    "Coulomb": Coulomb(),
    "Dahl, as on the bench": Dahl(0.05),
}
"""Friction laws of the plant, all of the level 0.1 N·m."""


def wrong_columns(task: tuple[str, str, int]) -> list[Row]:
    """The default observer with wrong parameters and sensors, on other columns and under other laws of friction.

    At 3 Hz the wheel's inertia takes 6.5 N·m, of which 2 % are an amplitude of 0.13 N·m: no observer can know better.
    An offset of the bar is learnt where the angles are known to be zero on the unloaded bar. The three columns have the
    eigenvalues of the paper's Table 3, and each observer the numbers of its column.
    """
    what, hands, seed = task
    known, plant, change, tuning = known_column(), SweptBench(), None, ColumnTuning()
    if what in WRONG:
        name, factor = WRONG[what]
        known = replace(known, **{name: factor * getattr(known, name)})
    elif what in SENSORS:
        change, tuning = SENSORS[what]
    elif what in SETS:
        known, plant = SETS[what], SweptBench(bench_of(SETS[what]))
    elif what in LAWS:
        plant = SweptBench(ColumnBench(friction=DryFriction(level=0.1, law=LAWS[what])))
    kinds: dict[str, Mapping[str, Any]] = {"parameter": WRONG, "sensor": SENSORS, "column": SETS, "law": LAWS}
    kind = next((kind for kind, named in kinds.items() if what in named), "nothing")
    found = _errors(ColumnObserver.of_parameters(known, tuning=tuning), swept(hands, 40.0, seed, plant), change=change)
    return [{"wrong": what, "kind": kind, "hands": hands, **found}]


LADDER = ((8.0, 8.0), (15.0, 15.0), (22.0, 22.0), THRESHOLDS, (45.0, 45.0))
"""Compared pairs of thresholds for "on" and "off" [nat]."""


class Held(NamedTuple):
    """A run of a drawn bench: "usual", "ladder", "far off" or "still", its seed and duration [s]."""

    kind: str
    seed: int
    seconds: float


@cache
def _monitors(kind: str) -> dict[str, HandsMonitor]:
    vehicle = load("column-bench")
    found = {"default": HandsMonitor.of_vehicle(vehicle, STEP)}
    if kind == "ladder":
        for on, off in LADDER:
            found[f"{on:g} to on, {off:g} to off"] = HandsMonitor.of_vehicle(vehicle, STEP, thresholds=(on, off))
    if kind == "far off":
        found["without learning"] = HandsMonitor.of_vehicle(vehicle, STEP, tolerance=Tolerance(share=0.0))
    return found


def hands_on_and_off(task: Held) -> list[Row]:
    """Benches whose parameters and torque sensor are off from the vehicle file by 2 % each, with an offset besides.

    Hands come and go after 3 to 20 s, with a torque of 0.1 to 0.5 N·m, while the motor rests, keeps a lane or sweeps. A
    delay counts from the first touch of a grip that takes 30 ms, and from the moment at which it begins to let go. Far
    off: by 10 %. Still: hands that do not tremble at all.
    """
    share, tremor = 0.1 if task.kind == "far off" else 0.02, 0.0 if task.kind == "still" else 0.03
    plant = drawn(task.seed, share, task.seconds, tremor)
    named = _monitors(task.kind)
    rows: list[Row] = []
    for name, found in zip(named, scored(list(named.values()), plant), strict=True):
        shared = {"kind": task.kind, "monitor": name}
        for event, delays in (("grab", found.grabs), ("release", found.releases)):
            never = event == "release"
            rows += [
                {**shared, "event": event, "delay": 1e3 * each, "wrong": float(never and math.isinf(each))}
                for each in delays
            ]
        wrong = found.false_on + found.false_off
        hours = found.seconds / 3600.0
        rows.append({**shared, "event": "run", "wrong": wrong, "false_off": found.false_off, "hours": hours})
    return rows


CAR, SCATTER, STARTED = "midsize-eps", 0.05, 5.0
"""The car, relative error of its wheel and torsion bar against the vehicle file, and warm-up [s]."""
EVERY, LEAVES, COMES, RAMP = 40.0, 20.0, 25.0, 0.3
"""Period of the releases on long drives, start and end of a release in it, and fade time of the grip [s]."""
SENSINGS = {"bench, 1000 Hz": (True, 1000.0)} | {
    f"production, {rate:g} Hz": (False, rate) for rate in (1000.0, 500.0, 200.0, 100.0)
}
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
    now, later = (_shown(recording, name, vehicle, rate) for name in ("interacting", "fixed-lag"))
    grid = recording.align(("driver_torque",), rate, maximum_age=0.05)
    true = recording.align((TRUTH,), rate, "linear").values[:, 0]
    counted = (grid.time > STARTED) & np.isfinite(true)
    # The values that wrap around lie in the warm-up and are not counted.
    before = np.roll(true, round(0.02 * rate))

    def rms(values: np.ndarray) -> float:
        return float(np.sqrt(np.mean(values[counted] ** 2)))

    shared: Row = {"course": task.course, "sensors": task.sensing}
    held, delays = _hands_times(grid.time, now["hands_on"], windows, rate)
    return [
        {
            **shared,
            "bar": rms(grid.values[:, 0] - true),
            "torque": rms(now["hand_torque"] - true),
            "later": rms(later["hand_torque"] - before),
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


def _shown(recording: Recording, variant: str, vehicle: Vehicle, rate: float) -> Mapping[str, np.ndarray]:
    session = DRIVER_TORQUE.variants[variant].open(vehicle, rate, None)
    return session.absorb(recording.align(session.signals, rate, maximum_age=0.05))


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


@cache
def loops() -> dict[str, ClosedLoop]:
    """The closed loop with every compared observer, and without parts of its control, by name."""
    known = belief()
    column = known.column
    blocks: dict[str, Block] = {
        "printed, mechanical": PrintedObserver.of_column(column, "series spring", SAMPLE_TIME),
        "printed, balanced": PrintedObserver.of_column(column, "balanced", SAMPLE_TIME),
        "printed, full": PrintedObserver.of_column(column, "full", SAMPLE_TIME),
        "default, without gear": ColumnObserver.of_parameters(without_gear(column), SAMPLE_TIME),
        "default, with gear": ColumnObserver.of_parameters(column, SAMPLE_TIME),
    }
    found = {name: loop_of(block, known) for name, block in blocks.items()}
    chosen = found["printed, mechanical"]
    for name, fields in (("friction not fed forward", {"friction": 0.0}), ("no feed-forward", {"feed_forward": 0.0})):
        found[name] = replace(chosen, control=replace(chosen.control, **fields))  # type: ignore[arg-type]
    return found


def tracking(task: tuple[str, float, bool]) -> list[Row]:
    """The paper closes the loop with a first attempt at a linear quadratic regulator and shows one sweep (Figure 10).

    Here the regulator has integral action, a plan from the flat output, friction fed forward, and limits of torque and
    rate; what it finds from one sample acts from the next on. The angle that counts is that of the gear, which no
    sensor measures. An observer that has the gear follows its oscillation at 112 Hz, which the control then excites.
    """
    name, frequency, quick = task
    loop = loops()[name]
    found = sine(loop, frequency, 3, quick) if frequency else sweep(loop, 4, quick)[1]
    return [
        {
            "loop": name,
            "frequency": frequency,
            "rms": found.rms,
            "largest": found.largest,
            "phase": abs(found.phase),
        }
    ]
