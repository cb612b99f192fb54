"""Seeds of the reported columns and drives; they change whenever the observer or the monitor of the hands changes."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.block import Block
from tierod.vehicles import load
from tierod_lab.papers.seeds import ReportedSeeds


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
        "identified under other conditions": 200,
        "hands": 2000,
        "hands, thresholds compared": 3000,
        "hands, parameters far off": 4000,
        "still hands": 5000,
        "identified by instruments": 6000,
        "identified by likelihood": 7000,
    },
    "the observers and hands of bench and car",
)
