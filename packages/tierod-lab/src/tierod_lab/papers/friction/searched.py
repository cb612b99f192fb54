"""Conditions tried in the search for the paper's conditions, one change at a time and then together."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tierod_lab.ground import FrictionCourse
from tierod_lab.papers.friction.setups import CONDITIONS, TYRES, USUAL_LAW, VARIABLE_RATIO


@dataclass(frozen=True)
class Setting:
    """A condition of the search."""

    condition: str = "as usual"  # a name in `CONDITIONS`
    tyres: tuple[str, ...] = ("summer",)  # names in `TYRES`, which the drives take in turn
    law: str = USUAL_LAW  # a name in `LAWS`
    scatter: str = ""  # a name in `SCATTERS`; empty for the nominal car
    wander: float = 0.0  # relative standard deviation of friction during a drive, as with temperature [-]


_ALL_TYRES = tuple(TYRES)[1:]

SEARCHED: Mapping[str, Setting] = {
    **{name: Setting(name) for name in CONDITIONS if name not in ("all together", VARIABLE_RATIO)},
    "other tyres": Setting(tyres=_ALL_TYRES),
    "friction that builds up over 3°": Setting(law="Dahl 3°"),
    "friction that depends on load": Setting(law="load-dependent 40 %"),
    "friction that wanders by 25 %": Setting(wander=0.25),
    "cars and sensors that differ": Setting(scatter="hard"),
    "all together": Setting("all together", _ALL_TYRES, "Dahl 3°"),
    "all together, cars that differ, friction that wanders": Setting(
        "all together", _ALL_TYRES, "Dahl 3°", "usual", 0.25
    ),
}
"""Name in the tables -> condition that is tried."""


def wandering(level: float, share: float, minutes: float, seed: int) -> FrictionCourse:
    """Friction with a random value every minute, log-normal about a level [N*m], and linear in between."""
    # Seeded by its arguments, since cases are keys of the results: equal arguments must give equal courses.
    chance = np.random.default_rng([seed, round(10.0 * level)])
    times = np.arange(math.ceil(minutes) + 1)
    levels = level * np.exp(share * chance.standard_normal(len(times)))
    return FrictionCourse(tuple((60.0 * times).tolist()), tuple(levels.tolist()))
