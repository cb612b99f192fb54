"""Sideslip on race laps of a real car, compared with an inertial navigation system (INS)."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim, at_most
from tierod.core.content import Band, Chart, Item, Lines, Panel, Table
from tierod.core.recording import Recording
from tierod.vehicles import Vehicle, load
from tierod_lab.papers.sideslip import rivals
from tierod_lab.papers.sideslip.calibration import (
    TYRES,
    BesideTruth,
    ErrorFigures,
    beside_truth,
    calibrated,
    with_parameters,
)
from tierod_lab.papers.sideslip.real_recordings import GOAL, absent, claims, share_in_band
from tierod_lab.studies.effort import Effort

FILE, VEHICLE = ("ferrari_250lm_race", "laps.parquet"), "ferrari-250lm"
FITTED = 0.6
"""Share of the laps to which all parameters were fitted [-]; the rest is judged."""

SETTLING = 1.0
"""Warm-up at the start of the recording [s], which is not judged."""

LAP = (253.3, 349.9)
"""Start and end of the second lap [s]; the curvature of the path repeats after 3.1 km."""

PUBLISHED = "about 0.5"
"""Published error of estimators with such sensors [degrees]."""

WRONG = (1.2, 0.8)
"""Factors of a wrong cornering stiffness [-]."""

_FIT = (
    "Last 40 % of the laps. Fitted to the first 60 %: tyres, noises, place of the accelerometer, and the zeros of "
    "steering sensor and INS. The last 40 % entered no fit."
)


def items(laps: Recording | None, effort: Effort) -> Iterator[Item]:
    if laps is None:
        yield from absent("race-laps", ("mean", "rms"))
        return
    car = load(VEHICLE)
    first, last = laps["sideslip_angle"].time[[0, -1]].tolist()
    until = first + FITTED * (last - first)
    seen = beside_truth(laps, car)
    fixed = fixed_tyres(laps, car, until)
    yield _rows_of_race(laps, car, fixed, seen, until)
    rest = seen.figures(until)
    where = "race laps of a Ferrari 250 LM"
    yield from claims("race-laps", where, rest, (0.15, 0.20), _FIT, PUBLISHED)
    yield _sections(seen, until)
    yield _picture(seen)
    if not effort.quick:
        yield from _recovery(laps, car, fixed, until)


def _rows_of_race(laps: Recording, car: Vehicle, fixed: Vehicle, seen: BesideTruth, until: float) -> Table:
    compared = {
        "sideslip of zero": rivals.nothing(laps),
        "integral with a leak of 1.5 s": rivals.leaky(laps, until),
        "linear Kalman filter, fixed stiffness": rivals.linear(laps, car, until),
        "combined, stiffness not followed": beside_truth(laps, fixed),
        "combined": seen,
    }
    rows = [
        (name, str(each.figures(seen.time[0] + SETTLING, until)), str(each.figures(until)), share_in_band(each, until))
        for name, each in compared.items()
    ]
    header = ("estimator", "first 60 %, fitted", "last 40 %", "in the 95 % band")
    note = (
        "Every estimator has what it leaves constant fitted to the first part. The INS itself wanders by some 0.14 "
        "degrees on straights, so that differences below 0.01 mean nothing."
    )
    return Table(
        "Race laps: mean absolute / root mean square error of the sideslip (degrees)", header, tuple(rows), note
    )


def fixed_tyres(laps: Recording, car: Vehicle, until: float) -> Vehicle:
    """The car with constant tyre parameters, fitted to the first part of the laps.

    The fit starts from the median of the stiffnesses that the estimator learns on that part.

    Args:
        laps: recording
        car: vehicle file whose stiffness the estimator learns
        until: end of the part that is fitted [s]
    """
    settled = beside_truth(laps, car).result
    assert settled is not None
    early = settled.values[: round(len(settled.values) * FITTED)]
    values = {"stiffness_wander": 0.0}
    for axle in ("front", "rear"):
        share = float(np.median(early[:, settled.names.index(f"estimate.{axle}_stiffness")]))
        values[f"{axle}_cornering_stiffness"] = share * car[f"{axle}_cornering_stiffness"]
    return calibrated(laps, with_parameters(car, values), TYRES, until)


def _sections(seen: BesideTruth, until: float) -> Table:
    rows: list[tuple[str, ...]] = []
    for start in np.arange(seen.time[0], seen.time[-1] - 1.0, 25.0).tolist():
        part = seen.figures(start + (SETTLING if not rows else 0.0), start + 25.0)
        fitted = "fitted" if start + 25.0 <= until else "judged" if start >= until else "both"
        share = f"{100.0 * part.coverage:.0f} %"
        rows.append((f"{start:.0f} to {start + 25.0:.0f} s", fitted, str(part), share))
    header = ("section", "", "mean absolute / RMS (degrees)", "in the 95 % band")
    return Table("Race laps: error of the combined estimator section by section", header, tuple(rows))


def _picture(seen: BesideTruth) -> Chart:
    shown = np.flatnonzero((seen.time >= LAP[0]) & (seen.time < LAP[1]))[::10]
    time, estimate, band = seen.time[shown], np.degrees(seen.estimate[shown]), 1.96 * np.degrees(seen.deviation[shown])
    marks = (
        Band("95 % band", time, estimate - band, estimate + band),
        Lines("combined estimator", time, estimate),
        Lines("INS", time, np.degrees(seen.truth[shown]), dashed=True),
    )
    return Chart(
        "sideslip-of-a-lap",
        "Sideslip over a lap",
        "Second lap of the Ferrari: the estimate with its band, and the truth.",
        "The estimate follows the truth between minus five and three degrees within a few tenths of a degree.",
        (Panel("Sideslip angle", "time (s)", "sideslip (degrees)", marks),),
    )


def _recovery(laps: Recording, car: Vehicle, fixed: Vehicle, until: float) -> Iterator[Item]:
    rows: list[tuple[str, ...]] = []
    worst = ErrorFigures(0.0, 0.0, 1.0)
    for axle in ("front", "rear"):
        for factor in WRONG:
            name = f"{axle}_cornering_stiffness"
            wrong = (with_parameters(each, {name: factor * each[name]}) for each in (car, fixed))
            followed, not_followed = (beside_truth(laps, each).figures(until) for each in wrong)
            worst = max(worst, followed, key=lambda each: each.rms)
            rows.append((f"{axle} {100.0 * (factor - 1.0):+.0f} %", str(followed), str(not_followed)))
    yield Table(
        "Race laps: stiffness given wrong by a fifth, error over the last 40 % (degrees)",
        ("wrong", "stiffness followed", "stiffness held"),
        tuple(rows),
        "Both fitted to the first 60 %, then one stiffness changed.",
    )
    yield Claim(
        "cars.stiffness-wrong",
        "Stiffness wrong by a fifth, of either axle and either way, is recovered from on race laps.",
        GOAL,
        None,
        math.degrees(worst.rms),
        at_most(0.31),
        "deg",
        "Largest root mean square error over the last 40 % of the laps; the goal is the best of earlier trials.",
    )
