"""How exact the friction estimators are, how soon the verdict comes, and how seldom it is false.

Everything is simulated: virtual drives of `tierod.proving_ground`, whose car shares no equation above `physics` with
the estimators. The default estimator was tuned on another plant and on seeds below 1000 of this one; what is reported
here comes from other seeds.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from typing import Any

import numpy as np

from tierod.errors import ParameterError
from tierod.studies.friction_cases import CARS, ESTIMATORS, Case, settled_estimates, verdict_of

LEVELS = (4.0, 8.0, 12.5)
"""Levels of friction [N*m]: healthy, and the middles of two of the injected ranges of Mohtat et al., Table 1."""

DAHL_DEGREES = (0.3, 1.0, 3.0)
SEEDS = (1001, 1002, 1003)
SCATTER_LEVELS = (4.0, 5.5, 8.0, 12.5)
STEPS = (12.5, 5.5)
KINDS_OF_SCATTER = ("usual", "hard")


@dataclass(frozen=True)
class Row:
    """One line of one table.

    Args:
        table: which table
        case: what was driven
        estimator: which estimator; the default one where a verdict was judged
        figures: named figures, unit in the name, in the order of the columns
    """

    table: str
    case: str
    estimator: str
    figures: dict[str, float]


Progress = Callable[[str], None]


def run(
    minutes: float = 13.0,
    seeds: Sequence[int] = SEEDS,
    scattered: int = 24,
    stepped: int = 12,
    healthy_drives: int = 40,
    estimators: Sequence[str] = tuple(ESTIMATORS),
    processes: int | None = None,
    progress: Progress = lambda table: None,
) -> list[Row]:
    """The whole study.

    Args:
        minutes: duration of each drive [min]; at least six, to have 50 s enabled
        seeds: of the drives without scatter; the same for every case, so that cases differ by the case alone
        scattered: drives per level and kind of scatter with car and sensors drawn at random
        stepped: drives per step of friction
        healthy_drives: healthy drives per kind of scatter, for false verdicts
        estimators: names in `ESTIMATORS`
        processes: worker processes; all cores if None
        progress: called with the name of each table before it is worked on

    Raises:
        ParameterError: no seeds, or an estimator that is not known
    """
    unknown = [name for name in estimators if name not in ESTIMATORS]
    if unknown or not seeds:
        raise ParameterError(
            f"the study needs seeds and estimators out of {', '.join(ESTIMATORS)}; given {list(seeds)}, {unknown}"
        )
    count = processes or os.cpu_count() or 1
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        rows: list[Row] = []
        for name, work in (
            ("accuracy", partial(_accuracy, minutes=minutes, seeds=seeds, estimators=tuple(estimators))),
            ("laws", partial(_laws, minutes=minutes, seeds=seeds, estimators=tuple(estimators))),
            ("scatter", partial(_scatter, minutes=minutes, count=scattered, estimators=tuple(estimators))),
            ("steps", partial(_steps, minutes=minutes, count=stepped)),
            ("healthy", partial(_healthy, minutes=minutes, count=healthy_drives)),
        ):
            progress(name)
            rows += work(pool.map)
        return rows


Map = Callable[..., Iterable[Any]]


def _accuracy(spread: Map, minutes: float, seeds: Sequence[int], estimators: tuple[str, ...]) -> list[Row]:
    """Bias and scatter for Dahl friction of unknown angle, Coulomb friction and a noisy rate."""
    cases = [(f"Dahl {degrees:g} deg", degrees, 0.01) for degrees in DAHL_DEGREES]
    cases += [(f"Dahl {degrees:g} deg, rate noise 0.05 rad/s", degrees, 0.05) for degrees in DAHL_DEGREES]
    cases += [("Coulomb", 0.01, 0.01)]
    drives = {
        (name, level): [
            Case(seed, level, dahl_angle=math.radians(degrees), rate_noise=noise, minutes=minutes) for seed in seeds
        ]
        for name, degrees, noise in cases
        for level in LEVELS
    }
    return _bias_rows("accuracy", drives, spread, estimators)


def _laws(spread: Map, minutes: float, seeds: Sequence[int], estimators: tuple[str, ...]) -> list[Row]:
    """Bias where friction follows a law that the estimators do not assume."""
    drives = {
        (law, level): [Case(seed, level, law=law, minutes=minutes) for seed in seeds]
        for law in CARS
        if law != "Dahl"
        for level in LEVELS
    }
    return _bias_rows("laws", drives, spread, estimators)


def _bias_rows(
    table: str, drives: dict[tuple[str, float], list[Case]], spread: Map, estimators: tuple[str, ...]
) -> list[Row]:
    cases = [case for group in drives.values() for case in group]
    estimates = iter(spread(partial(settled_estimates, estimators=estimators), cases))
    rows = []
    for (name, level), group in drives.items():
        found = [next(estimates) for _ in group]
        for estimator in estimators:
            pooled = np.concatenate([values[estimator] for values in found])
            bias, deviation = _moments(pooled, level)
            figures = {"truth [N*m]": level, "bias [N*m]": bias, "standard deviation [N*m]": deviation}
            rows.append(Row(table, name, estimator, figures))
    return rows


def _moments(values: np.ndarray, level: float) -> tuple[float, float]:
    return (float(values.mean() - level), float(values.std())) if len(values) else (math.nan, math.nan)


def _scatter(spread: Map, minutes: float, count: int, estimators: tuple[str, ...]) -> list[Row]:
    """Mean and scatter where car and sensors differ from drive to drive, and whether levels can be told apart."""
    rows = []
    for kind in KINDS_OF_SCATTER:
        cases = [
            Case(10_000 + 1000 * index + drive, level, scatter=kind, minutes=minutes)
            for index, level in enumerate(SCATTER_LEVELS)
            for drive in range(count)
        ]
        found = list(spread(partial(settled_estimates, estimators=estimators), cases))
        for estimator in estimators:
            groups = [
                [values[estimator] for values in found[index * count : (index + 1) * count]]
                for index in range(len(SCATTER_LEVELS))
            ]
            rows += _scatter_rows(kind, estimator, groups)
    return rows


def _scatter_rows(kind: str, estimator: str, groups: list[list[np.ndarray]]) -> list[Row]:
    healthy, rows = _last(groups[0]), []
    for level, group in zip(SCATTER_LEVELS, groups, strict=True):
        bias, deviation = _moments(np.concatenate(group), level)
        figures = {"truth [N*m]": level, "bias [N*m]": bias, "standard deviation [N*m]": deviation}
        above = _last(group)[:, None] > healthy[None]
        figures["AUC against 4 N*m"] = math.nan if level == SCATTER_LEVELS[0] else float(np.mean(above))
        rows.append(Row("scatter", f"scatter {kind}", estimator, figures))
    return rows


def _last(group: list[np.ndarray]) -> np.ndarray:
    return np.array([values[-1] if len(values) else math.nan for values in group])


def _steps(spread: Map, minutes: float, count: int) -> list[Row]:
    """Enabled time from a step of friction to the verdict."""
    rows = []
    for after in STEPS:
        for noise, kind in ((0.01, "none"), (0.05, "none"), (0.01, "usual")):
            cases = [
                Case(20_000 + drive, 4.0, after, rate_noise=noise, scatter=kind, minutes=minutes)
                for drive in range(count)
            ]
            verdicts = list(spread(verdict_of, cases))
            rising, fault = (sorted(verdict.delay[k] for verdict in verdicts) for k in (0, 1))
            figures = {
                "rising after, median [s enabled]": float(np.median(rising)),
                "worst": rising[-1],
                "fault after, median [s enabled]": float(np.median(fault)),
                "worst fault": fault[-1],
                "alarms before": float(sum(verdict.early for verdict in verdicts)),
            }
            name = f"4 to {after:g} N*m, rate noise {noise:g} rad/s, scatter {kind}"
            rows.append(Row("steps", name, "default", figures))
    return rows


def _healthy(spread: Map, minutes: float, count: int) -> list[Row]:
    """Healthy drives with scatter: false verdicts, and how far the ratio strays."""
    rows = []
    for kind in KINDS_OF_SCATTER:
        cases = [Case(30_000 + drive, 4.0, scatter=kind, minutes=minutes) for drive in range(count)]
        verdicts = list(spread(verdict_of, cases))
        figures = {
            "hours": sum(verdict.seconds for verdict in verdicts) / 3600.0,
            "drives": float(count),
            "drives with a false rising or fault": float(sum(max(v.codes, default=0) > 2 for v in verdicts)),
            "drives without verdict": float(sum(not v.codes for v in verdicts)),
            "smallest ratio": float(np.nanmin([v.ratios[0] for v in verdicts])),
            "largest ratio": float(np.nanmax([v.ratios[1] for v in verdicts])),
        }
        rows.append(Row("healthy", f"4 N*m, scatter {kind}", "default", figures))
    return rows


def table(rows: Sequence[Row]) -> str:
    """The rows as Markdown tables, one per kind, for docs/friction.md and the terminal."""
    blocks = []
    for name in dict.fromkeys(row.table for row in rows):
        chosen = [row for row in rows if row.table == name]
        columns = list(chosen[0].figures)
        lines = [f"| case | estimator | {' | '.join(columns)} |", "|---|---|" + "---:|" * len(columns)]
        for row in chosen:
            cells = " | ".join(_number(row.figures[column]) for column in columns)
            lines.append(f"| {row.case} | {row.estimator} | {cells} |")
        blocks.append(f"**{name}**\n\n" + "\n".join(lines))
    return "\n\n".join(blocks) + "\n"


def _number(value: float) -> str:
    if math.isnan(value):
        return ""
    if math.isinf(value):
        return "never"
    return f"{value:.0f}" if value == round(value) and abs(value) >= 1.0 else f"{value:.3f}"
