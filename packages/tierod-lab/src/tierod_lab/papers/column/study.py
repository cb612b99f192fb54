"""The study of the steering column: the linear model, torque of the hands, hands on and off, control of position."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tierod.core.content import Item
from tierod_lab.papers.column import hand_datasets as hands
from tierod_lab.papers.column import model_datasets as models
from tierod_lab.papers.column.charts import charts
from tierod_lab.papers.column.columns import SETS
from tierod_lab.papers.column.hand_datasets import Held, Natural
from tierod_lab.papers.column.model_datasets import BENCHES, Excitation, Member
from tierod_lab.papers.column.reported import SEEDS
from tierod_lab.papers.column.swept_bench import HANDS
from tierod_lab.studies import engine
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame


def _members(effort: Effort) -> list[Member]:
    stiffnesses = (1500.0, 4500.0) if effort.quick else (600.0, 1200.0, 1800.0, 2400.0, 3000.0, 3800.0, 4600.0, 5600.0)
    ratios = (18.0,) if effort.quick else (6.0, 10.0, 14.0, 18.0, 24.0)
    inertias = (0.035,) if effort.quick else (0.025, 0.035, 0.05)
    others = [(p, ratio, inertia) for p in stiffnesses for ratio in ratios for inertia in inertias]
    return [*map(Member, SETS), *(Member(f"member {number}", *each) for number, each in enumerate(others))]


def _excitations(effort: Effort) -> list[Excitation]:
    first, second = SEEDS.of("frequency response", 2)
    seconds = 60.0 if effort.quick else 240.0
    sweeps = (Excitation(amplitude, seconds, second) for amplitude in (0.12, 0.2, 0.4, 1.0))
    return [Excitation(0.0, seconds, first), *sweeps]


def _identified(effort: Effort) -> list[tuple[str, int]]:
    count = 2 if effort.quick else 50
    parts = {"wheel": "identified by instruments", "motor": "identified by likelihood"}
    return [(side, seed) for side, part in parts.items() for seed in SEEDS.of(part, count)]


def _benches(effort: Effort) -> list[tuple[str, int, float | None]]:
    seed = SEEDS.of("identified under other conditions", 1)[0]
    if effort.quick:
        return [("motor torque noise 0.01 N·m", seed, models.SHORT)]
    return [(name, seed, None) for name in BENCHES]


def _wrong(effort: Effort) -> list[tuple[str, str, int]]:
    seed = SEEDS.of("observers on the bench", 1)[0]
    named = ["nothing", *hands.WRONG, *hands.SENSORS, *SETS, *hands.LAWS]
    if effort.quick:
        named = ["nothing", "steering wheel inertia +2 %", "bar +0.05 N·m, learnt", "S3", "Coulomb"]
    return [(what, each, seed) for what in named for each in ("steps", "ramps")]


def _held(effort: Effort) -> list[Held]:
    sizes = {
        "usual": ("hands", 2, 20, 1800.0),
        "ladder": ("hands, thresholds compared", 1, 4, 1800.0),
        "far off": ("hands, parameters far off", 1, 6, 900.0),
        "still": ("still hands", 1, 2, 1800.0),
    }
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


def _tracking(effort: Effort) -> list[tuple[str, float, bool]]:
    sines = ("printed, mechanical", "friction not fed forward", "no feed-forward")
    return [
        *((name, frequency, effort.quick) for name in sines for frequency in (0.1, 1.0, 2.0, 3.0)),
        *((name, 0.0, effort.quick) for name in hands.loops() if name not in sines[1:]),
    ]


DATASETS = (
    Dataset("ranks", "Observability by the sensors (Tables 2 and 3)", models.ranks, _members),
    Dataset("reductions", "Four states instead of six (Figure 7)", models.reductions, lambda effort: [None]),
    Dataset("frequency", "Frequency response (Figure 5)", models.frequency_gains, _excitations),
    Dataset("identified", "Identification on the bench", models.identified, _identified),
    Dataset("benches", "What the model does not know", models.unknown_benches, _benches),
    Dataset(
        "torque",
        "Torque of the driver's hands",
        hands.hand_torque,
        lambda effort: [
            (each, seed) for each in HANDS for seed in SEEDS.of("observers on the bench", 1 if effort.quick else 5)
        ],
    ),
    Dataset("wrong", "Wrong parameters, other columns, other friction", hands.wrong_columns, _wrong),
    Dataset("hands", "Hands on and hands off", hands.hands_on_and_off, _held),
    Dataset("natural", "Natural drives of the virtual car", hands.natural_drives, _natural),
    Dataset("tracking", "Position control (Figure 10)", hands.tracking, _tracking),
)
"""The datasets, in the order of the paper."""


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress, charts)
    yield SEEDS.table()
