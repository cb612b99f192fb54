"""Development and test sets of the paper (Table 2), driven by virtual cars that differ from drive to drive."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tierod.core.content import Table
from tierod_lab.papers.friction import estimators as named
from tierod_lab.papers.friction.cases import HEALTHY, STATES, Case
from tierod_lab.papers.friction.runs import Drives, Wants
from tierod_lab.papers.friction.setups import TYRES
from tierod_lab.studies.effort import Effort

SOURCE = "Mohtat et al. 2020"
WORST = "PWM 25%"

SEEN_BY = (
    named.PRINTED,
    named.POSTERIOR,
    named.PER_SAMPLE,
    named.OPEN,
    named.CORRECTED,
    named.UNSCENTED,
    *named.BASELINES,
)
"""Estimators that run over the paper's drives, beside the default one."""


@dataclass(frozen=True)
class PaperSets:
    """The drives of the paper."""

    development: Mapping[str, tuple[Case, ...]]  # development, test: drives by health state
    test: Mapping[str, tuple[Case, ...]]
    # drives that the paper does not have: fault-free and worst state on the tyres that its sets leave out
    further: Mapping[str, tuple[Case, ...]]

    def all_of(self, state: str) -> tuple[Case, ...]:
        """Development and test drives of a health state."""
        return self.development[state] + self.test[state]

    def on(self, tyres: str, state: str) -> tuple[Case, ...]:
        """All drives of a health state on the given tyres."""
        return tuple(case for case in self.all_of(state) + self.further[state] if case.tyres == tyres)


def paper_sets(effort: Effort) -> PaperSets:
    """Both sets: 98 and 78 min fault-free in drives of 13 min (one of 7), one drive of 7 and 6 min for every fault."""
    healthy = ((4.0, 4.0), (4.0,)) if effort.quick else ((13.0,) * 7 + (7.0,), (13.0,) * 6)
    faulty = (4.0, 4.0) if effort.quick else (7.0, 6.0)
    states = list(STATES)
    sets = [
        {
            state: tuple(
                _case(100 * (1 + which) + 20 * states.index(state) + drive, state, minutes, 2 * which + drive)
                for drive, minutes in enumerate(healthy[which] if state == "Healthy" else (faulty[which],))
            )
            for state in states
        }
        for which in (0, 1)
    ]
    driven = {state: {case.tyres for each in sets for case in each[state]} for state in states}
    further = {
        state: tuple(
            _case(300 + 20 * states.index(state) + index, state, faulty[0], index)
            for index, tyres in enumerate(TYRES)
            if tyres not in driven[state] and state in ("Healthy", WORST) and not effort.quick
        )
        for state in states
    }
    return PaperSets(sets[0], sets[1], further)


def _case(seed: int, state: str, minutes: float, turn: int) -> Case:
    """A drive of a newly drawn car, with a reference drive of the same car on other roads and tyres."""
    kinds = list(TYRES)
    own, other = (kinds[place % len(kinds)] for place in (turn, turn + 1))
    reference = Case(seed + 5000, HEALTHY, 7.0 if minutes > 5.0 else 5.0, car=seed, tyres=other)
    return Case(seed, STATES[state], minutes, car=seed, tyres=own, reference=reference)


def wants(effort: Effort) -> Wants:
    """The drives of the paper."""
    sets = paper_sets(effort)
    cases = (case for each in (sets.development, sets.test, sets.further) for group in each.values() for case in group)
    return dict.fromkeys(cases, SEEN_BY)


def minutes(cases: Iterable[Case]) -> float:
    """Total duration of the drives [min]."""
    return sum(case.minutes for case in cases)


def quantities(sets: PaperSets, drives: Drives) -> Table:
    """Table 2: minutes, printed and driven, by health state."""
    printed = {"Healthy": "98 / 78"} | dict.fromkeys(("PWM 15%", "PWM 20%", "PWM 25%"), "7 / 6")
    rows = tuple(
        (
            state,
            f"{STATES[state] - HEALTHY:+.1f}" if state != "Healthy" else "",
            printed[state],
            f"{minutes(sets.development[state]):.0f} / {minutes(sets.test[state]):.0f}",
            f"{len(drives.of(sets.all_of(state)))}",
            ", ".join(dict.fromkeys(case.tyres for case in sets.all_of(state))),
        )
        for state in STATES
    )
    return Table(
        "Table 2: minutes of the development and the test set",
        ("health state", "change [N·m]", "printed", "ours", "drives", "tyres"),
        rows,
        "Every drive has a car, sensors, tyres, a route and a driver of its own. Figures 9 and the claims on tyres use "
        "further drives, so that healthy and PWM 25% were driven on all tyres.",
    )
