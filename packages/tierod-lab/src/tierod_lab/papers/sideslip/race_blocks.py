"""Race laps in five blocks, each estimated with a vehicle file that was fitted to the blocks before it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from tierod.core.claims import Claim, at_least, at_most, between
from tierod.core.content import Heading, Item, Table
from tierod.core.recording import Recording
from tierod.monitors.sideslip.tuning import BAND
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.real_data import NO_DATA
from tierod_lab.papers.sideslip import race_laps
from tierod_lab.papers.sideslip.calibration import TYRES, BesideTruth, ErrorFigures, beside_truth
from tierod_lab.papers.sideslip.noise_calibration import calibrated_with_noises, with_noises
from tierod_lab.papers.sideslip.real_recordings import GOAL, recorded
from tierod_lab.papers.sideslip.typical_cars import SPORTS, typical
from tierod_lab.studies.effort import Effort

BLOCKS = 5
CAUSE = (
    "Too wide rather than too narrow: the noises are fitted so that the worst stratum holds, {least} with {share:.2f}. "
    "Noises that grow with use of the tyres would narrow the rest."
)

FITTED = (*TYRES, "sensor_forward", "roll_share")
"""Parameters that are fitted beside the noises."""

SPREADS = {
    "front_cornering_stiffness": 0.3,
    "rear_cornering_stiffness": 0.3,
    "tyre_friction": 0.15,
    "rear_friction_ratio": 0.1,
}
"""Relative standard deviations of the typical values [-]."""

PLACED = {"rear_friction_ratio": (1.0, 0.1), "sensor_forward": (0.0, 0.3), "roll_share": (0.05, 0.02)}
"""Value and standard deviation of parameters for which the class of the car has no typical value; assumed."""

SPEEDS = (0.0, 25.0, 42.0, math.inf)
ANGLES = (*(math.radians(each) for each in (0.0, 0.5, 1.0, 3.0)), math.inf)
"""Bounds of the strata of speed [m/s] and of sideslip angle [rad]."""


@dataclass(frozen=True)
class Block:
    """Results of a block that was estimated with a file of those before it.

    Args:
        number: number of the block, from one
        figures: errors and coverage
        speed, truth, error, deviation: speed [m/s], true sideslip angle, its error and standard deviation [rad], (n,)
    """

    number: int
    figures: ErrorFigures
    speed: np.ndarray
    truth: np.ndarray
    error: np.ndarray
    deviation: np.ndarray

    @property
    def inside(self) -> np.ndarray:
        """Whether the 95 % band contains the truth, (n,)."""
        held: np.ndarray = np.abs(self.error) <= BAND * self.deviation
        return held


def unfitted(car: Vehicle) -> Vehicle:
    """The race car with typical tyres and the prior standard deviations that a fit needs."""
    found = typical(car, SPORTS)
    parameters = dict(found.parameters)
    placed = with_noises(found, {name: value for name, (value, _) in PLACED.items()}, "assumed").parameters
    for name, (_, spread) in PLACED.items():
        parameters[name] = dataclasses.replace(placed[name], standard_deviation=spread)
    for name, share in SPREADS.items():
        each = parameters[name]
        parameters[name] = dataclasses.replace(each, standard_deviation=share * each.value)
    return dataclasses.replace(found, parameters=parameters)


def ends(laps: Recording) -> np.ndarray:
    """Bounds of the blocks [s], (6,)."""
    first, last = laps["sideslip_angle"].time[[0, -1]]
    limits: np.ndarray = np.linspace(first, last, BLOCKS + 1)
    return limits


def judged(laps: Recording, number: int) -> Block:
    """A block with a file that was fitted to those before it; the filter runs from the start of the laps."""
    limits = ends(laps)
    before = laps.slice(float(limits[0]), float(limits[number - 1]))
    car = calibrated_with_noises(before, unfitted(load(race_laps.VEHICLE)), FITTED)
    return block(laps, beside_truth(laps, car), number)


def block(laps: Recording, seen: BesideTruth, number: int) -> Block:
    """Results of one block from an estimate over all laps."""
    start, stop = ends(laps)[number - 1 : number + 1].tolist()
    kept = (seen.time >= start) & (seen.time < stop) & np.isfinite(seen.error)
    speed = laps["vehicle_speed"]
    return Block(
        number,
        seen.figures(start, stop),
        np.interp(seen.time[kept], speed.time, speed.values),
        seen.truth[kept],
        seen.error[kept],
        seen.deviation[kept],
    )


def items(effort: Effort) -> Iterator[Item]:
    laps = recorded(race_laps.FILE, race_laps.VEHICLE)
    if laps is None or effort.quick:
        note = NO_DATA if laps is None else "Left out of a quick study."
        for key in ("mean", "rms", "band", "stratum"):
            yield Claim(f"blocks.{key}", "Race laps block by block.", GOAL, None, None, None, "deg", note)
        return
    yield Heading(
        "Race laps, block by block",
        (
            "Five blocks of 55 s. Each but the first is estimated with a vehicle file that was made of the blocks "
            "before it alone: typical tyres to begin with, tyres and noises fitted to the reference.",
        ),
    )
    found = effort.made(partial(judged, laps), range(2, BLOCKS + 1))
    yield _table(laps, found)
    strata = _strata(found)
    yield _strata_table(strata)
    error = np.degrees(np.concatenate([each.error for each in found]))
    inside = np.concatenate([each.inside for each in found])
    figures = {
        "mean": (float(np.mean(np.abs(error))), at_most(0.16), "deg", "Mean absolute error"),
        "rms": (float(np.sqrt(np.mean(error * error))), at_most(0.21), "deg", "Root mean square error"),
        "band": (float(np.mean(inside)), between(0.92, 0.97), "", "Share of the truth in the 95 % band"),
        "stratum": (min(strata.values()), at_least(0.88), "", "The same in the worst stratum of speed or angle"),
    }
    for key, (measured, goal, unit, words) in figures.items():
        claim = f"{words}, blocks 2 to 5 of the race laps."
        cause = CAUSE.format(least=min(strata, key=strata.__getitem__), share=min(strata.values()))
        yield Claim(f"blocks.{key}", claim, GOAL, None, measured, goal, unit, cause=cause if key == "band" else "")


def _strata(found: list[Block]) -> dict[str, float]:
    """Coverage of the 95 % band by stratum [-], for those that occur."""
    speed, angle, inside = (
        np.concatenate(parts)
        for parts in zip(*((each.speed, np.abs(each.truth), each.inside) for each in found), strict=True)
    )
    shares: dict[str, float] = {}
    for what, values, limits, factor, unit in (
        ("speed", speed, SPEEDS, 3.6, "km/h"),
        ("angle", angle, ANGLES, 180.0 / math.pi, "degrees"),
    ):
        for low, high in pairwise(limits):
            kept = (values >= low) & (values < high)
            name = f"{what} {low * factor:.3g} to {high * factor:.3g} {unit}"
            shares[name] = float(np.mean(inside[kept])) if kept.any() else math.nan
    return {name: share for name, share in shares.items() if math.isfinite(share)}


def _strata_table(strata: dict[str, float]) -> Table:
    rows = tuple((name, f"{100.0 * share:.0f} %") for name, share in strata.items())
    return Table("Race laps: share of the truth in the 95 % band, blocks 2 to 5", ("stratum", "in the band"), rows)


def _table(laps: Recording, found: list[Block]) -> Table:
    plain = beside_truth(laps, typical(load(race_laps.VEHICLE), SPORTS))
    rows = []
    for each in found:
        unfitted_figures = block(laps, plain, each.number).figures
        rows.append(
            (
                f"block {each.number}",
                str(unfitted_figures),
                f"{100.0 * unfitted_figures.coverage:.0f} %",
                str(each.figures),
                f"{100.0 * each.figures.coverage:.0f} %",
            )
        )
    header = ("", "typical tyres, default noises", "in the band", "file of the blocks before", "in the band")
    return Table("Race laps: mean absolute / root mean square error (degrees)", header, tuple(rows))
