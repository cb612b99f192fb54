"""The study of sideslip: observers of the paper, the combined estimator, a real car."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from tierod.core.block import Block
from tierod.core.content import Band, Chart, Item
from tierod.core.graph import Result
from tierod.vehicles import load
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.papers.seeds import ReportedSeeds
from tierod_lab.papers.sideslip import combined_datasets as combined
from tierod_lab.papers.sideslip import observer_datasets as observers
from tierod_lab.papers.sideslip import real_datasets as real
from tierod_lab.papers.sideslip.calibration import beside_truth
from tierod_lab.papers.sideslip.combined_datasets import SHOWN
from tierod_lab.papers.sideslip.drives import (
    CARS,
    OBSERVERS,
    RATE,
    SLOW,
    Driven,
    from_file,
    matched,
    observed,
    open_loop,
)
from tierod_lab.studies import engine
from tierod_lab.studies.charts import Curves, chart
from tierod_lab.studies.effort import Effort, Progress
from tierod_lab.studies.engine import Dataset
from tierod_lab.studies.metrics import Frame


def _judged() -> Sequence[Block]:
    """The combined estimator with and without the steering torque, and all observers of the paper."""
    from tierod.monitors.sideslip.estimator import CombinedSideslip

    estimators = CombinedSideslip.of_vehicle(load("midsize-eps"), 0.01), CombinedSideslip.of_vehicle(load("rav4"), 0.01)
    return *estimators, *(build(from_file(), 1.0 / RATE) for build in OBSERVERS.values())


SEEDS = ReportedSeeds(
    _judged,
    {
        "the test of the paper": 0,
        "the observers": 21,
        "the combined estimator": 201,
        "ramps to the limit of grip": 231,
    },
    "the combined estimator and of every observer of the study",
)


def _seeds(part: str, effort: Effort, usual: int = 3) -> range:
    return SEEDS.of(part, 1 if effort.quick else usual)


def _poles(effort: Effort) -> list[tuple[int, tuple[float, ...]]]:
    factors = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)
    return [(seed, factors[::3] if effort.quick else factors) for seed in _seeds("the observers", effort, 2)]


def _quiet(effort: Effort) -> list[tuple[str, int]]:
    few, many = (_seeds("the combined estimator", effort, count) for count in (3, 8))
    return [(name, seed) for name in combined.QUIET for seed in (many if name.startswith("mixed") else few)]


DATASETS = (
    Dataset(
        "test", "The test of the paper", observers.driven_test, lambda effort: SEEDS.of("the test of the paper", 1)
    ),
    Dataset(
        "observers",
        "The observers side by side",
        observers.side_by_side,
        lambda effort: [
            (car, case, seed) for car in CARS for case in observers.CASES for seed in _seeds("the observers", effort)
        ],
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
            for name in ((SHOWN,) if effort.quick else combined.RAMPS)
        ],
    ),
    Dataset("quiet", "False announcements and false ice", combined.quiet, _quiet),
    Dataset("race-laps", "Race laps", real.race_laps, lambda effort: [not effort.quick], missing=NO_DATA),
)
"""The datasets, in the order of the report."""
LAP = (253.3, 349.9)  # Start and end of the second lap [s]; the curvature of the path repeats after 3.1 km


def charts(frames: Mapping[str, Frame], effort: Effort) -> Iterator[Chart]:
    """The paper's Figures 6 to 10, and a lap of a race; drives are simulated once more."""
    p, drive = matched("virtual car", SLOW), observers.paper_test(SEEDS.of("the test of the paper", 1)[0])
    found = {
        name: observed(OBSERVERS[name](p, 1.0 / RATE), drive) for name in (observers.CONVENTIONAL, observers.TWO_STAGE)
    }
    for number, (name, result) in zip((6, 8), found.items(), strict=True):
        yield chart(
            f"figures-{number}-{number + 1}",
            f"Figures {number} and {number + 1}: {name}",
            "Angle and rate of the road wheels, sideslip angle and yaw rate as they are or were measured, and as "
            "estimated; beside them the sideslip of the linear model without feedback.",
            "Estimated curves lie on the true and measured ones; the linear model lies near.",
            _motion(drive, result, open_loop(p, drive)),
            every=25,
            dashed=("estimated", "linear model"),
        )
    yield chart(
        "figure-10",
        "Figure 10: estimated disturbance torque",
        "Torque of the road about the kingpins: as it is, as the disturbance observer finds it, and as the linear tyre "
        "would have it. What lifts the car and the scrub of tyres that hardly roll are in the first two.",
        "Time courses of three torques.",
        {
            ("", "torque (N·m)"): {
                "truth": (drive.time, drive.truths["kingpin_torque"]),
                "estimated": (drive.time, found[observers.TWO_STAGE]["self_aligning_torque"]),
                "eq (3) from the true motion": (drive.time, observers.modelled_torque(p, drive)),
            }
        },
        every=25,
        dashed=("estimated", "eq (3) from the true motion"),
    )
    if (laps := real.RACE.recording()) is not None:
        seen = beside_truth(laps, load(real.RACE.vehicle))
        part = (seen.time >= LAP[0]) & (seen.time < LAP[1])
        time, estimate, band = seen.time[part], np.degrees(seen.estimate[part]), 1.96 * np.degrees(seen.deviation[part])
        yield chart(
            "sideslip-of-a-lap",
            "Sideslip over a lap",
            "Second lap of the Ferrari: the estimate with its 95 % band, and the truth.",
            "The estimate follows the truth between minus five and three degrees within a few tenths of a degree.",
            {("", "sideslip (degrees)"): {"combined": (time, estimate), "INS": (time, np.degrees(seen.truth[part]))}},
            every=10,
            dashed=("INS",),
            marks=(Band("95 % band", time[::10], (estimate - band)[::10], (estimate + band)[::10]),),
        )


def _motion(drive: Driven, result: Result, model: np.ndarray) -> Mapping[tuple[str, str], Curves]:
    signals, truths = drive.signals, drive.truths

    def both(known: str, values: np.ndarray, output: str, **more: np.ndarray) -> Curves:
        named = {known: values, "estimated": result[output], **more}
        return {name.replace("_", " "): (drive.time, np.degrees(each)) for name, each in named.items()}

    steer, sideslip = signals["road_wheel_angle"], truths["sideslip_angle"]
    return {
        ("steering angle", "angle (deg)"): both("measured", steer, "estimated_road_wheel_angle"),
        ("steering rate", "rate (deg/s)"): both("truth", truths["road_wheel_rate"], "estimated_road_wheel_rate"),
        ("sideslip angle", "angle (deg)"): both("truth", sideslip, "sideslip_angle", linear_model=model),
        ("yaw rate", "rate (deg/s)"): both("measured", signals["yaw_rate"], "estimated_yaw_rate"),
    }


def items(effort: Effort, progress: Progress) -> Iterator[Item | Frame]:
    """All items of the study."""
    yield from engine.items(Path(__file__).with_name("claims.toml"), DATASETS, effort, progress, charts)
    yield SEEDS.table()
