"""Limits of the condition monitor for uncalibrated vehicles, from fault-free drives of four demonstrators.

python scripts/smartload_limits.py     # prints [thresholds.condition], and the ratio of the new to the shipped limits

These demonstrators are not used in reported results, and the nominal vehicle file describes none of them. A limit is
twice the largest ratio that lasted for three samples on any of them; the limit of two actuators is at least that of
each one alone.
"""

from __future__ import annotations

import sys

import numpy as np

from tierod.experiments.effort import Effort
from tierod.monitors.condition.bank.weighing import Limits
from tierod.monitors.condition.calibration.healthy_ratios import Watched, watch
from tierod.monitors.condition.calibration.limits import LEAST, limits_of
from tierod.monitors.condition.hypotheses import hypotheses
from tierod.papers.condition.drives import ACTUATORS, calibration_drives
from tierod.papers.condition.recorded import recorded
from tierod.vehicles import load

DEMONSTRATORS = (11, 12, 13, 14)
"""Numbers of vehicles that only this script uses."""
TWICE = 2.0
"""Factor between limit and largest ratio; vehicles in use vary more than four demonstrators show."""
LEGS = 2
"""Drives of ten minutes per demonstrator."""


def watched(number: int) -> list[Watched]:
    """Ratios of all hypotheses on fault-free drives of a demonstrator, computed with the shipped vehicle file."""
    drives = calibration_drives(number)[1][:LEGS]
    return watch([recorded(drive) for drive in drives], load("smartload"))


def limits(found: list[Watched]) -> tuple[np.ndarray, np.ndarray]:
    """Fast and slow limits of all hypotheses except the fault-free one."""
    largest = np.concatenate([each.blocks for each in found]).max(axis=0).reshape(2, -1)
    both = np.maximum(TWICE * largest, np.array(LEAST)[:, None])
    names = [each.name for each in hypotheses()[1:]]
    for place, name in enumerate(names):
        alone = [names.index(part) for part in name.split(" + ")]
        if len(alone) == 2 and all(part in ACTUATORS for part in name.split(" + ")):
            both[:, place] = np.maximum(both[:, place], both[:, alone].max(axis=1))
    return both[0], both[1]


def main() -> int:
    """Print the limits as tables of a vehicle file, and their ratio to the shipped ones."""
    found = [each for several in Effort().made(watched, DEMONSTRATORS) for each in several]
    names, made, shipped = [each.name for each in hypotheses()[1:]], limits(found), limits_of(load("smartload"))
    hours = sum(each.hours for each in found)
    print(f"[thresholds.condition]\nhours = {hours:.6g}\nfactor = {TWICE:g}")
    for key, values in zip(("fast", "slow"), made, strict=True):
        print(f"\n[thresholds.condition.{key}]")
        print("\n".join(f'"{name}" = {value:.6g}' for name, value in zip(names, values, strict=True)))
    print(_compared(made, shipped), file=sys.stderr)
    return 0


def _compared(made: tuple[np.ndarray, np.ndarray], shipped: Limits) -> str:
    ratios = np.concatenate([ours / theirs for ours, theirs in zip(made, (shipped.fast, shipped.slow), strict=True)])
    crossed = int(np.count_nonzero(ratios > TWICE))
    return (
        f"new limits over the shipped ones: median {np.median(ratios):.2f}, 5 to 95 % of them "
        f"{np.quantile(ratios, 0.05):.2f} to {np.quantile(ratios, 0.95):.2f}; "
        f"{crossed} of {len(ratios)} shipped limits were exceeded on these fault-free drives"
    )


if __name__ == "__main__":
    sys.exit(main())
