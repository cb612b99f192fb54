"""The study of the steering column: the linear model, torque of the hands, hands on and off, control of position."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from tierod.core.block import Block
from tierod.core.content import Chart, Item
from tierod.models.column_observation import linear_column
from tierod.models.steering_column import SteeringColumn
from tierod.vehicles import load
from tierod_lab.papers.column import hand_datasets as hands
from tierod_lab.papers.column import model_datasets as models
from tierod_lab.papers.column.benches import HANDS, STEP
from tierod_lab.papers.column.columns import SETS, gain_of_bar, reduced_columns
from tierod_lab.papers.column.hand_datasets import BEGIN, Held, Natural, Run
from tierod_lab.papers.column.model_datasets import Excitation, decibels
from tierod_lab.papers.seeds import ReportedSeeds
from tierod_lab.studies import engine
from tierod_lab.studies.charts import Curves, chart
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame


def _judged() -> Sequence[Block]:
    """Default observer and monitor of the hands on bench and car; the position control is not among them."""
    from tierod.monitors.driver_torque.hands import HandsMonitor
    from tierod.monitors.driver_torque.observer import ColumnObserver

    bench, car = load("column-bench"), load("midsize-eps")
    hands = HandsMonitor.of_vehicle(bench, 1e-3), HandsMonitor.of_vehicle(car, 1e-2)
    return ColumnObserver.of_vehicle(bench, 1e-3), ColumnObserver.of_vehicle(car, 1e-2), *hands


SEEDS = ReportedSeeds(
    _judged,
    {
        "natural drives": 5,
        "observers on the bench": 11,
        "frequency response": 60,
        "hands": 2000,
        "hands, parameters far off": 4000,
        "identified by instruments": 6000,
        "identified by likelihood": 7000,
    },
    "the observers and hands of bench and car",
)


def _excitations(effort: Effort) -> list[Excitation]:
    first, second = SEEDS.of("frequency response", 2)
    seconds = 60.0 if effort.quick else 240.0
    sweeps = (Excitation(amplitude, seconds, second) for amplitude in (0.12, 0.2, 0.4, 1.0))
    return [Excitation(0.0, seconds, first), *sweeps]


def _identified(effort: Effort) -> list[tuple[str, int]]:
    parts = {"wheel": "identified by instruments", "motor": "identified by likelihood"}
    return [(side, seed) for side, part in parts.items() for seed in SEEDS.of(part, 2 if effort.quick else 50)]


def _held(effort: Effort) -> list[Held]:
    sizes = {"usual": ("hands", 2, 20, 1800.0), "far off": ("hands, parameters far off", 1, 6, 900.0)}
    return [
        Held(kind, seed, 300.0 if effort.quick else seconds)
        for kind, (part, quick, usual, seconds) in sizes.items()
        for seed in SEEDS.of(part, quick if effort.quick else usual)
    ]


def _natural(effort: Effort) -> list[Natural]:
    motorway, mixed = SEEDS.of("natural drives", 2)
    seconds = 60.0 if effort.quick else 300.0
    drives = (("straight", 1, 60.0), ("motorway", motorway, seconds), ("mixed", mixed, seconds))
    return [Natural(course, sensing, seed, length) for course, seed, length in drives for sensing in hands.SENSINGS]


DATASETS = (
    Dataset("ranks", "Observability by the sensors (Tables 2 and 3)", models.ranks, lambda effort: list(SETS)),
    Dataset("reductions", "Four states instead of six (Figure 7)", models.reductions, lambda effort: [None]),
    Dataset("frequency", "Frequency response (Figure 5)", models.frequency_gains, _excitations),
    Dataset("identified", "Identification on the bench", models.identified, _identified),
    Dataset(
        "torque",
        "Torque of the driver's hands",
        hands.hand_torque,
        lambda effort: [
            (each, seed) for each in HANDS for seed in SEEDS.of("observers on the bench", 1 if effort.quick else 5)
        ],
    ),
    Dataset("hands", "Hands on and hands off", hands.hands_on_and_off, _held),
    Dataset("natural", "Natural drives of the virtual car", hands.natural_drives, _natural),
    Dataset(
        "tracking",
        "Position control (Figure 10)",
        hands.tracking,
        lambda effort: [(name, effort.quick) for name in hands.loops()],
    ),
)
"""The datasets, in the order of the paper."""


def charts(frames: Mapping[str, Frame], effort: Effort) -> Iterator[Chart]:
    """The paper's Figures 5, 7 and 10."""
    frequency = np.geomspace(0.5, 300.0, 400)
    systems = {"whole column": linear_column(SteeringColumn, SETS["S1"]), **reduced_columns(SETS["S1"])}
    gains = {name: (frequency, decibels(gain_of_bar(each, frequency))) for name, each in systems.items()}
    yield chart(
        "column-figure-7",
        "Gain of a column and of its reductions (Figure 7)",
        "From the motor's torque to that of the bar. The reductions leave out the gear's resonance at 112 Hz.",
        "All curves agree to 30 Hz; without its feed-through the balanced one falls above.",
        {("", "gain (dB)"): gains},
        along="frequency (Hz)",
        logarithmic_along=True,
    )
    shown: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for test in _excitations(effort):
        name = f"sweep of {test.amplitude:g} N·m" if test.amplitude else "noise, no friction"
        found = models.response(test)
        shown[name] = (found.frequency, decibels(found.gain))
    shown["linear column"] = (found.frequency, decibels(models.model_gain(found.frequency)))
    yield chart(
        "column-figure-5",
        "Measured gain from the motor's torque to that of the bar (Figure 5)",
        "A sweep that hardly overcomes the friction finds a column with another gain and more damping.",
        "The gain without friction and that of a strong sweep lie on the linear column; weak sweeps lie below.",
        {("", "gain (dB)"): shown},
        along="frequency (Hz)",
        dashed=("linear column",),
        logarithmic_along=True,
    )
    done = hands.sweep(hands.loops()["printed, mechanical"], 1, effort.quick)
    yield chart(
        "figure-10",
        "Figure 10 anew",
        "The sweep of the output shaft, 30° from 0.1 to 3 Hz, on the simulated bench under position control; the hands "
        "are off.",
        "Reference and shaft lie on each other; the observer sees torques of hands of some tenths of a newton metre.",
        _figure_10(done),
        every=10,
        dashed=("reference",),
    )


def _figure_10(done: Run) -> Mapping[tuple[str, str], Curves]:
    time, signals = done.time - BEGIN, done.signals

    def curves(scale: float, **named: np.ndarray) -> Curves:
        return {name.replace("_", " "): (time, scale * values) for name, values in named.items()}

    degrees, wheel = 180.0 / np.pi, signals["measured.steering_wheel_angle"]
    shaft, observed = signals["plant.truth_gear_angle"], signals["controller.observed.steering_wheel_angle"]
    rate = signals["controller.observed.steering_wheel_rate"]
    return {
        ("Output shaft", "angle in °"): curves(degrees, reference=done.reference.angle, output_shaft=shaft),
        ("Steering wheel", "angle in °"): curves(degrees, measured=wheel, filtered=observed),
        ("Its rate", "rate in °/s"): curves(degrees, from_differences=np.gradient(wheel, STEP), estimated=rate),
        ("Hands, who are not there", "torque in N·m"): curves(1.0, estimated_torque=signals["controller.hand_torque"]),
    }


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress, charts)
    yield SEEDS.table()
