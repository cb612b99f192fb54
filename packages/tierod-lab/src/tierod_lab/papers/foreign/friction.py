"""The friction monitor on a simulated column whose equations and friction laws differ from the monitor's own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.claims import Claim, at_least, at_most, exactly
from tierod.core.content import Heading, Item, Table
from tierod.core.graph import scan
from tierod.core.statuses import Status
from tierod_lab.papers.foreign.reported import COLUMN, FRICTION
from tierod_lab.papers.foreign.rubbing_column import LUGRE, MAXWELL, SIGNALS, RubbingCar, course, driven, sliding_level
from tierod_lab.papers.friction.estimators import monitor
from tierod_lab.studies.effort import Effort

LEVELS = (4.0, 5.5, 8.0, 12.5)
"""Levels of friction at high sliding speed, as in the study of friction [N*m]; the first is fault-free."""
LAWS = (LUGRE, MAXWELL)
MINUTES, CARS = 7.0, 3  # Duration of a drive [min], and cars for each friction law
SPREAD = {
    "mass": 0.04,
    "yaw_inertia": 0.04,
    "front_stiffness": 0.08,
    "rear_stiffness": 0.08,
    "mechanical_trail": 0.1,
    "pneumatic_trail": 0.1,
    "pinion_inertia": 0.1,
    "pinion_damping": 0.2,
    "build_up": 0.3,
}
"""Standard deviation of the logarithm of each parameter over the cars; the monitor keeps its vehicle file."""
GOAL = "goal of tierod, as at home"
FREE, RISEN = (Status.HEALTHY,), (Status.RISING, Status.FAULT, Status.SUSPECT)
"""Verdicts that count as fault-free and as increased friction."""
TEXT = (
    "Wheel and pinion on an elastic shaft, with friction by LuGre or by generalised Maxwell slip, in a car whose "
    "equations were written for this study and share none with tierod. Each car differs from the vehicle file; it "
    "drives once without fault, which gives its baseline, and again with each level. The truth is the mean level of "
    "friction over the rates at which the monitor looked. Seeds follow from the judged monitor.",
)


class Judged(NamedTuple):
    """Estimate and verdict of one drive."""

    law: str  # law, level, car: friction law, level of friction [N*m] and number of the car
    level: float
    car: int
    true: float  # true mean level of friction over the samples at which the estimate was enabled [N*m]
    estimate: float  # estimate, deviation: estimate and its standard deviation at the end [N*m]
    deviation: float
    status: Status  # verdict at the end
    why: str = ""  # cause of the verdict, in a sentence


def drawn(law: str, level: float, random: np.random.Generator) -> RubbingCar:
    """Draw a car around that of the vehicle file.

    Args:
        level: level of friction [N*m]
    """
    nominal = RubbingCar(law, level)
    changes = {name: getattr(nominal, name) * float(np.exp(size * random.normal())) for name, size in SPREAD.items()}
    return replace(nominal, **changes)


def judged(task: tuple[str, int, int, float]) -> list[Judged]:
    """Judge a fault-free drive of a car, then one with every higher level of friction.

    Args:
        task: law, number of the car, first seed, duration of a drive [min]
    """
    law, number, seed, minutes = task
    car = drawn(law, LEVELS[0], np.random.default_rng([seed, number, 7]))
    own, first = _on(car, None, [seed, number, 0], minutes)
    found = [own]
    for place, level in enumerate(LEVELS[1:], 1):
        found.append(_on(replace(car, level=level), first, [seed, number, place], minutes)[0])
    return [each._replace(car=number) for each in found]


def _on(
    car: RubbingCar, level: tuple[float, float] | None, seeds: Sequence[int], minutes: float
) -> tuple[Judged, tuple[float, float] | None]:
    """Judge one drive; returns the judgement and the baseline that the monitor learnt, as (level, deviation) [N*m]."""
    seed = int(np.random.SeedSequence(list(seeds)).generate_state(1)[0])
    seen = driven(car, course(minutes, seed), seed)
    judge = monitor(level)
    names = [name for name, _ in leaves(skeleton(judge.Sample))]
    result = scan(judge, np.ascontiguousarray(seen[:, [SIGNALS.index(name) for name in names]]))
    rates = seen[result["estimate.enabled"] > 0.5, SIGNALS.index("steering_wheel_rate")]
    last = result.at(-1)
    estimate = (float(last.estimate.friction_torque), float(last.estimate.friction_deviation))
    own = last.verdict.baseline
    learnt = (own.level, own.deviation) if own.seconds > 0.0 else None
    true = sliding_level(car, rates) if len(rates) else np.nan
    finding = judge.finding(result)
    return Judged(car.law, car.level, 0, true, *estimate, finding.status, finding.cause), learnt


def items(effort: Effort) -> Iterator[Item]:
    seed = FRICTION.of(COLUMN, 1)[0]
    cars, minutes = (1, 6.0) if effort.quick else (CARS, MINUTES)
    tasks = [(law, number, seed, minutes) for law in LAWS for number in range(cars)]
    found = [each for several in effort.made(judged, tasks) for each in several]
    yield Heading("Friction on a foreign column", TEXT)
    yield from shown(found)


def shown(found: Sequence[Judged]) -> Iterator[Item]:
    """Table and claims."""
    rows = []
    for law in LAWS:
        for level in LEVELS:
            own = [each for each in found if (each.law, each.level) == (law, level)]
            off = [each.estimate - each.true for each in own]
            away = [abs(each.estimate - each.true) / each.deviation for each in own]
            statuses = ", ".join(sorted({each.status.value for each in own}))
            stated = float(np.mean([each.deviation for each in own]))
            cells = (
                f"{np.mean(off):+.2f}".replace("-", "−"),
                f"{np.std(off):.2f}",
                f"{stated:.2f}",
                f"{max(away):.1f}",
            )
            rows.append((law, f"{level:g}", *cells, statuses))
    yield Table(
        "Friction on a foreign column: estimate less truth",
        ("law", "level [N·m]", "mean [N·m]", "spread", "deviation stated", "largest in deviations", "verdicts"),
        tuple(rows),
        f"{len(found)} drives.",
    )
    yield from _claims(found)


def _claims(found: Sequence[Judged]) -> Iterator[Claim]:
    off = np.array([each.estimate - each.true for each in found])
    means = {
        key: abs(float(np.mean([each.estimate - each.true for each in found if (each.law, each.level) == key])))
        for key in dict.fromkeys((each.law, each.level) for each in found)
    }
    worst = max(means, key=means.__getitem__)
    within = np.abs(off) <= 1.96 * np.array([each.deviation for each in found])
    yield Claim(
        "friction.foreign-bias",
        "Largest mean error of a law and level on the foreign column.",
        GOAL,
        None,
        means[worst],
        at_most(0.3),
        "N*m",
        "Friction by generalised Maxwell slip builds up over several angles, which the estimator's laws take for more.",
        cause=f"Worst: {worst[0]} at {worst[1]:g} N·m, {100.0 * means[worst] / worst[1]:.0f} % of the level; the "
        "deviations stated hold the error. The law, which builds up over several angles behind an elastic shaft, is "
        "none of those that the estimator learns; the ratio to the car's own level drops it.",
    )
    yield Claim(
        "friction.foreign-covered",
        "Share of the estimates within 1.96 of the deviations that they state.",
        GOAL,
        None,
        float(within.mean()),
        at_least(0.9),
        "",
        f"{len(found)} drives; mean error {off.mean():+.2f} N·m.",
    )
    judged_ones = [each for each in found if each.status in (*FREE, *RISEN)]
    wrong = [each for each in judged_ones if (each.status in RISEN) != (each.level > LEVELS[0])]
    yield Claim(
        "friction.foreign-verdicts",
        "Wrong verdicts on the foreign column.",
        GOAL,
        None,
        float(len(wrong)),
        exactly(0.0),
        "",
        f"Of {len(judged_ones)} verdicts in {len(found)} drives.",
    )
    unjudged = "; ".join(f"{each.law}, {each.level:g} N·m: {each.why}" for each in found if each not in judged_ones)
    yield Claim(
        "friction.foreign-judged",
        "Share of the drives on the foreign column that end with a verdict.",
        GOAL,
        None,
        len(judged_ones) / len(found),
        at_least(0.95),
        "",
        "",
        cause=f"{unjudged}. Drives of 13 minutes, as the paper's, give more time.",
    )
