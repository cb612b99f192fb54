"""Seeds of the reported sideslip drives, which change whenever one of the judged estimators changes."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.block import Block
from tierod.vehicles import load
from tierod_lab.papers.seeds import ReportedSeeds


def _judged() -> Sequence[Block]:
    """The combined estimator with and without the steering torque, and all observers of the paper."""
    from tierod.monitors.sideslip.estimator import CombinedSideslip
    from tierod_lab.papers.sideslip.estimators import OBSERVERS, built
    from tierod_lab.papers.sideslip.matching import from_file

    combined = CombinedSideslip.of_vehicle(load("midsize-eps"), 0.01), CombinedSideslip.of_vehicle(load("rav4"), 0.01)
    return *combined, *(built(name, from_file()) for name in OBSERVERS)


SEEDS = ReportedSeeds(
    _judged,
    {
        "the test of the paper": 0,
        "the observers": 21,
        "the combined estimator": 201,
        "ramps to the limit of grip": 231,
        "slow cars": 1000,
    },
    "the combined estimator and of every observer of the study",
)
