"""Recordings of real cars for the study of sideslip, and the claims that are made on each."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tierod.core.claims import Claim, Goal, at_least, at_most
from tierod.core.recording import Recording
from tierod.vehicles import load
from tierod_lab.papers import real_data
from tierod_lab.papers.sideslip.calibration import BesideTruth, ErrorFigures

GOAL = "goal of tierod"


def recorded(parts: tuple[str, str], vehicle: str) -> Recording | None:
    """A recording of a real car; None where it or the library of its reader is missing."""
    return real_data.recorded(*parts, channel_map=load(vehicle).channel_map)


def share_in_band(seen: BesideTruth, until: float) -> str:
    """Table cell with the coverage of the 95 % band after a time [s]; empty for an estimate without a band."""
    return "" if seen.result is None else f"{100.0 * seen.figures(until).coverage:.0f} %"


def claims(
    name: str, where: str, found: ErrorFigures, goals: tuple[float, float], note: str, printed: str | None = None
) -> Iterator[Claim]:
    """Claims on mean error, root mean square error and coverage of the band on a recording.

    Args:
        name: name of the recording within the names of the claims
        where: name of the recording within the texts of the claims
        found: errors on the part that is judged
        goals: largest mean absolute and root mean square error [deg]
        note: note on what was fitted
        printed: published mean absolute error
    """
    figures: tuple[tuple[str, str, float, Goal, str], ...] = (
        ("mean", "mean absolute error", math.degrees(found.mean_absolute), at_most(goals[0]), "deg"),
        ("rms", "root mean square error", math.degrees(found.rms), at_most(goals[1]), "deg"),
        ("band", "share of the truth in the 95 % band", found.coverage, at_least(0.9), ""),
    )
    for key, what, measured, goal, unit in figures:
        yield Claim(
            f"cars.{name}-{key}",
            f"The {what} of the sideslip on {where}.",
            GOAL,
            printed if key == "mean" else None,
            measured,
            goal,
            unit,
            note,
        )


def absent(name: str, keys: tuple[str, ...]) -> Iterator[Claim]:
    """Claims without a figure, for a recording that is missing."""
    for key in keys:
        yield Claim(f"cars.{name}-{key}", "Sideslip of a real car.", GOAL, None, None, None, "deg", real_data.NO_DATA)
