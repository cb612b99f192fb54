"""Appendix A of the paper: lock-to-lock turns at rising PWM, on the hoist and on the ground; Figure 10 and Table 1."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.core.claims import Claim, at_least, at_most, between
from tierod.core.content import Chart, Heading, Item, Panel, Points, Table
from tierod.methods.identification.hysteresis import HysteresisIdentification, Support
from tierod_lab.ground import lock_to_lock
from tierod_lab.papers.friction.cases import HEALTHY
from tierod_lab.papers.friction.estimators import vehicle
from tierod_lab.papers.friction.paper_sets import SOURCE
from tierod_lab.papers.friction.reported import SEEDS, TURNS
from tierod_lab.papers.friction.statistics import mean
from tierod_lab.studies.effort import Effort

PWM = (0, 5, 10, 15, 20, 25, 30, 35)  # Duty cycles of the clutch brake [%]; appendix A

SUPPORTS: tuple[Support, ...] = ("hoist", "ground")
TRIALS = 2  # Turns at every duty cycle and support; appendix A

TABLE_1 = {15: (1.0, 2.0), 20: (3.0, 5.0), 25: (7.0, 10.0)}
"""Injected friction as printed in Table 1: PWM [%] -> range [N*m]."""

BRAKE_DEVIATION = 0.10
"""Relative standard deviation of the brake torque from trial to trial [-]; in line with printed ranges [assumed]."""


def brake_torque(pwm: float) -> float:
    """Friction that the clutch brake adds at the steering wheel axis [N*m], in agreement with Table 1.

    Args:
        pwm: duty cycle [%]

    Source: a power law with the exponent 3.4 meets the middles of the three printed ranges, 1.5, 4 and 8.5 N*m, within
    1 %; below and above them it is extrapolated [assumed].
    """
    return 1.5 * float((pwm / 15.0) ** 3.4)


@dataclass(frozen=True)
class Turn:
    """One lock-to-lock turn."""

    support: Support  # whether the wheels hang free or stand on the ground
    pwm: int  # duty cycle of the brake [%]
    added: float  # true friction added by the brake in this trial [N*m]
    total: float  # total friction estimated from the loop [N*m]


def turns(effort: Effort) -> list[Turn]:
    """The paper's series: two turns at every duty cycle on both supports."""
    method = HysteresisIdentification.of_vehicle(vehicle())
    seeds = SEEDS.of(TURNS, 10_000)
    chance = np.random.default_rng(seeds[-1])
    found = []
    for support in SUPPORTS:
        for pwm in (0, 15, 25) if effort.quick else PWM:
            for trial in range(1 if effort.quick else TRIALS):
                added = brake_torque(pwm) * math.exp(BRAKE_DEVIATION * chance.standard_normal())
                recording = lock_to_lock(HEALTHY + added, support == "hoist", seed=seeds[100 * pwm + trial])
                found.append(Turn(support, pwm, added, method.identify(recording, support).friction_torque))
    return found


def items(measured: list[Turn]) -> Iterator[Item]:
    fault_free = {support: _fault_free(measured, support) for support in SUPPORTS}
    yield Heading(
        "The friction that was injected",
        (
            "The work balance over a closed turn from lock to lock gives total friction; what the brake added is the "
            "difference to the mean of the turns at 0 %. The virtual brake follows a law in kind with Table 1 and "
            "scatters by 10 % from trial to trial, as a slipping clutch does.",
        ),
    )
    yield _figure(measured, fault_free)
    yield _table(measured, fault_free)
    yield from _claims(measured, fault_free)


def _fault_free(measured: list[Turn], support: Support) -> float:
    """Mean total friction of the turns without the brake [N*m]."""
    return _mean(turn.total for turn in measured if turn.support == support and turn.pwm == 0)


def _mean(values: Any) -> float:
    return mean(np.array(list(values), float))


def _increases(measured: list[Turn], fault_free: dict[Support, float], pwm: int) -> list[float]:
    return [turn.total - fault_free[turn.support] for turn in measured if turn.pwm == pwm]


def _figure(measured: list[Turn], fault_free: dict[Support, float]) -> Chart:
    marks: list[Points] = []
    for support in SUPPORTS:
        chosen = [turn for turn in measured if turn.support == support]
        marks.append(
            Points(support, [turn.pwm for turn in chosen], [turn.total - fault_free[support] for turn in chosen])
        )
    middles = [0.5 * (low + high) for low, high in TABLE_1.values()]
    lows, highs = zip(*TABLE_1.values(), strict=True)
    marks.append(Points("printed, Table 1", list(TABLE_1), middles, lows, highs))
    return Chart(
        "figure-10",
        "Figure 10: friction increase estimated from lock-to-lock turns",
        "One mark per turn, two turns at every setting; bars: the ranges printed in Table 1.",
        "Estimated increase of friction over the setting of the brake, on hoist and ground, with the printed ranges.",
        (Panel("", "PWM [%]", "increase of friction [N·m]", tuple(marks)),),
    )


def _table(measured: list[Turn], fault_free: dict[Support, float]) -> Table:
    rows = []
    for pwm in sorted({turn.pwm for turn in measured}):
        found = _increases(measured, fault_free, pwm)
        added = [turn.added for turn in measured if turn.pwm == pwm]
        printed = f"{TABLE_1[pwm][0]:g} to {TABLE_1[pwm][1]:g}" if pwm in TABLE_1 else "0" if pwm == 0 else ""
        rows.append(
            (
                f"{pwm} %",
                printed,
                f"{min(found):.1f} to {max(found):.1f}",
                f"{min(added):.1f} to {max(added):.1f}",
                f"{fault_free['hoist'] + min(found):.1f} to {fault_free['hoist'] + max(found):.1f}",
            )
        )
    return Table(
        "Table 1: friction injected, lowest to highest of all turns (N·m)",
        ("PWM", "injected, printed", "injected, estimated", "injected, true", "total, estimated"),
        tuple(rows),
        f"Fault-free car: {fault_free['hoist']:.2f} N·m on the hoist, "
        f"{fault_free['ground']:.2f} N·m on the ground, with scrub.",
    )


def _claims(measured: list[Turn], fault_free: dict[Support, float]) -> Iterator[Claim]:
    yield Claim(
        "paper.hysteresis-nominal",
        "The healthy steering has a total friction of 4 N·m.",
        f"{SOURCE}, Table 1",
        4.0,
        fault_free["hoist"],
        between(3.7, 4.3),
        "N*m",
        "Work balance on the hoist; the virtual car has 4 N·m.",
    )
    errors = [abs(turn.total - fault_free[turn.support] - turn.added) for turn in measured]
    yield Claim(
        "paper.hysteresis-error",
        "Lock-to-lock turns estimate what the brake adds.",
        f"{SOURCE}, appendix A, eqs (15) to (17)",
        "estimated",
        max(errors),
        at_most(0.2),
        "N*m",
        "Largest error of one turn against the truth, which the authors did not know; hoist and ground, 0 to 35 %.",
    )
    yield Claim(
        "paper.hysteresis-scrub",
        "On the ground the scrub of the tyres is felt beside the internal friction.",
        f"{SOURCE}, appendix A",
        "more",
        fault_free["ground"] - fault_free["hoist"],
        at_least(1.0),
        "N*m",
    )
