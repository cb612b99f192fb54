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


BENCH, SENSITIVITY, FREQUENCY = "observers on the bench", "an observer's parameters off", "frequency response"
MODEL, NATURAL = "chance of the model's modes", "natural drives"
BY_INSTRUMENTS, BY_LIKELIHOOD, FITS = (
    "identified by instruments",
    "identified by likelihood",
    "identified under other conditions",
)
HANDS, COMPARED, FAR_OFF, STILL = "hands", "hands, thresholds compared", "hands, parameters far off", "still hands"

SEEDS = ReportedSeeds(
    _judged,
    {
        NATURAL: 5,
        BENCH: 11,
        SENSITIVITY: 19,
        FREQUENCY: 60,
        MODEL: 70,
        FITS: 200,
        HANDS: 2000,
        COMPARED: 3000,
        FAR_OFF: 4000,
        STILL: 5000,
        BY_INSTRUMENTS: 6000,
        BY_LIKELIHOOD: 7000,
    },
    "the observers and hands of bench and car",
)
