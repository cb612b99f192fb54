"""The study of sideslip: observers of the paper, the combined estimator, real cars."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tierod.core.content import Item
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.papers.sideslip import combined_datasets as combined
from tierod_lab.papers.sideslip import observer_datasets as observers
from tierod_lab.papers.sideslip import real_datasets as real
from tierod_lab.papers.sideslip.charts import charts
from tierod_lab.papers.sideslip.observer_datasets import Poles
from tierod_lab.papers.sideslip.reported import SEEDS
from tierod_lab.papers.sideslip.setting import CARS, FAST, SLOW
from tierod_lab.studies import engine
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame

FACTORS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)
"""Factors by which the observer poles are faster than the eigenvalues of the system [-]."""


def _seeds(part: str, effort: Effort, usual: int = 3) -> range:
    return SEEDS.of(part, 1 if effort.quick else usual)


def _poles(effort: Effort) -> list[Poles]:
    factors = FACTORS[::3] if effort.quick else FACTORS
    return [Poles(drive.speed, seed, factors) for drive in (SLOW, FAST) for seed in _seeds("the observers", effort, 2)]


def _quiet(effort: Effort) -> list[tuple[str, int]]:
    few, many = (_seeds("the combined estimator", effort, count) for count in (3, 8))
    return [(name, seed) for name in combined.QUIET for seed in (many if name.startswith("mixed") else few)]


DATASETS = (
    Dataset(
        "test",
        "The test of the paper",
        observers.driven_test,
        lambda effort: SEEDS.of("the test of the paper", 1),
    ),
    Dataset(
        "observers",
        "The observers side by side",
        observers.side_by_side,
        lambda effort: [
            (car, case, seed) for car in CARS for case in observers.CASES for seed in _seeds("the observers", effort)
        ],
    ),
    Dataset(
        "cosine",
        "Equation (6) with the cosine of the steer",
        observers.cosine,
        lambda effort: [
            (car, name, seed) for car in CARS for name in observers.TURNS for seed in _seeds("the observers", effort)
        ],
    ),
    Dataset(
        "limits",
        "What limits the observers at 6.7 m/s",
        observers.limits,
        lambda effort: [(name, SEEDS.of("the observers", 1)[0]) for name in observers.changed_cars()],
    ),
    Dataset("poles", "Ever faster poles", observers.poles, _poles),
    Dataset(
        "neutral",
        "Neutral steer",
        observers.neutral_steer,
        lambda effort: [
            (ratio, speed) for ratio in (0.8, 0.95, 0.99, 1.0, 1.01, 1.05, 1.4) for speed in (6.7, 25.0, 40.0)
        ],
    ),
    Dataset(
        "combined",
        "Combined estimator",
        combined.combined,
        lambda effort: [(case, seed) for case in combined.CASES for seed in _seeds("the combined estimator", effort)],
    ),
    Dataset(
        "ramps",
        "Low friction: the peak announced",
        combined.ramps,
        lambda effort: [
            (name, SEEDS.of("ramps to the limit of grip", 1)[0])
            for name in ((combined.SHOWN,) if effort.quick else combined.RAMPS)
        ],
    ),
    Dataset("quiet", "False announcements and false ice", combined.quiet, _quiet),
    Dataset("race-laps", "Race laps", real.race_laps, lambda effort: [not effort.quick], missing=NO_DATA),
    Dataset("car-park", "A passenger car in a car park", real.car_park, lambda effort: [None], missing=NO_DATA),
    Dataset("unprepared", "Cars without preparation", real.unprepared, lambda effort: list(real.CARS), missing=NO_DATA),
    Dataset(
        "blocks",
        "Race laps, block by block",
        real.blocks,
        lambda effort: () if effort.quick else range(2, real.BLOCKS + 1),
        missing=f"Left out of a quick study. {NO_DATA}",
    ),
    Dataset(
        "slow",
        "Small, slow, strongly steered",
        combined.slow,
        lambda effort: [
            (name, speed, SEEDS.of("slow cars", 1)[0])
            for name in combined.small_cars()
            for speed in ((3.0,) if effort.quick else combined.STEERED)
        ],
    ),
)
"""The datasets, in the order of the report."""


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress, charts)
    yield SEEDS.table()
