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
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from typing import Any

import numpy as np

from tierod.errors import ParameterError, nearest
from tierod.studies.friction_cases import CARS, ESTIMATORS, VARIANTS, Case, settled_estimates, verdict_of

LEVELS = (4.0, 8.0, 12.5)
"""Levels of friction [N*m]: healthy, and the middles of two of the injected ranges of Mohtat et al., Table 1."""

DAHL_DEGREES = (0.3, 1.0, 3.0)
SEEDS = (1001, 1002, 1003)
SCATTER_LEVELS = (4.0, 5.5, 8.0, 12.5)
STEPS = (12.5, 5.5)
KINDS_OF_SCATTER = ("usual", "hard")
TABLES = ("accuracy", "laws", "changes", "scatter", "steps", "healthy")


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


TRUTH = "truth [N*m]"
"""Figure of the rows that compare an estimate with the truth."""

Progress = Callable[[str], None]
Map = Callable[..., Iterable[Any]]


def run(
    minutes: float = 13.0,
    seeds: Sequence[int] = SEEDS,
    scattered: int = 24,
    stepped: int = 12,
    healthy_drives: int = 40,
    estimators: Sequence[str] = tuple(ESTIMATORS),
    tables: Sequence[str] = TABLES,
    processes: int | None = None,
    progress: Progress = lambda table: None,
) -> list[Row]:
    """The study, or some of its tables.

    Args:
        minutes: duration of each drive [min]; at least six, to have 50 s enabled
        seeds: of the drives without scatter; the same for every case, so that cases differ by the case alone
        scattered: drives per level and kind of scatter with car and sensors drawn at random
        stepped: drives per step of friction
        healthy_drives: healthy drives per kind of scatter, for false verdicts
        estimators: names in `ESTIMATORS`
        tables: names in `TABLES`
        processes: worker processes; all cores if None
        progress: called with the name of each table before it is worked on

    Raises:
        ParameterError: no seeds, or an estimator or table that is not known
    """
    _require("estimator", estimators, ESTIMATORS)
    _require("table", tables, TABLES)
    if not seeds:
        raise ParameterError("the study was given no seeds; give at least one")
    compared = tuple(estimators)
    work: dict[str, Callable[[Map], list[Row]]] = {
        "accuracy": partial(_accuracy, minutes=minutes, seeds=seeds, estimators=compared),
        "laws": partial(_laws, minutes=minutes, seeds=seeds, estimators=compared),
        "changes": partial(_changes, minutes=minutes, seeds=seeds),
        "scatter": partial(_scatter, minutes=minutes, count=scattered, estimators=compared),
        "steps": partial(_steps, minutes=minutes, count=stepped),
        "healthy": partial(_healthy, minutes=minutes, count=healthy_drives),
    }
    rows: list[Row] = []
    with ProcessPoolExecutor(processes or os.cpu_count() or 1, mp_context=get_context("spawn")) as pool:
        for name in tables:
            progress(name)
            rows += work[name](pool.map)
    return rows


def _require(what: str, names: Sequence[str], known: Iterable[str]) -> None:
    for name in names:
        if name not in known:
            raise ParameterError(f"the study has no {what} '{name}'{nearest(name, known)}")


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


def _changes(spread: Map, minutes: float, seeds: Sequence[int]) -> list[Row]:
    """What each change to the single-law estimator brings: the default one with that change taken back."""
    three = math.radians(3.0)
    cases = {
        "Dahl 3 deg": Case(0, 12.5, dahl_angle=three, minutes=minutes),
        "Dahl 3 deg, rate noise 0.05 rad/s": Case(0, 12.5, dahl_angle=three, rate_noise=0.05, minutes=minutes),
        "Dahl, exponent 2": Case(0, 12.5, law="Dahl, exponent 2", minutes=minutes),
        "load-dependent 40 %": Case(0, 12.5, law="load-dependent 40 %", minutes=minutes),
    }
    drives = {(name, case.level): [replace(case, seed=seed) for seed in seeds] for name, case in cases.items()}
    return _bias_rows("changes", drives, spread, ("default", *VARIANTS, "single-law estimator"))


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
            figures = {TRUTH: level, "bias [N*m]": bias, "standard deviation [N*m]": deviation}
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
        figures = {TRUTH: level, "bias [N*m]": bias, "standard deviation [N*m]": deviation}
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
        lines = _by_level(chosen) if TRUTH in chosen[0].figures else _by_figure(chosen)
        blocks.append(f"**{name}**\n\n" + "\n".join(lines))
    return "\n\n".join(blocks) + "\n"


def _by_figure(rows: list[Row]) -> list[str]:
    """One line per row, one column per figure."""
    columns = list(rows[0].figures)
    lines = [f"| case | {' | '.join(columns)} |", "|---|" + "---:|" * len(columns)]
    return lines + [f"| {row.case} | {' | '.join(_number(row.figures[c]) for c in columns)} |" for row in rows]


def _by_level(rows: list[Row]) -> list[str]:
    """One line per case and estimator, one column per level: bias and standard deviation."""
    levels = list(dict.fromkeys(row.figures[TRUTH] for row in rows))
    head = [
        f"| case | estimator | {' | '.join(f'{level:g} N·m' for level in levels)} |",
        "|---|---|" + "---:|" * len(levels),
    ]
    cells: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        _, bias, deviation, *others = row.figures.values()
        told_apart = "".join(f", AUC {value:.4f}" for value in others if not math.isnan(value))
        cells.setdefault((row.case, row.estimator), []).append(f"{bias:+.2f} ± {deviation:.2f}{told_apart}")
    return head + [f"| {case} | {estimator} | {' | '.join(values)} |" for (case, estimator), values in cells.items()]


def _number(value: float) -> str:
    if math.isnan(value):
        return ""
    if math.isinf(value):
        return "never"
    return f"{value:.0f}" if value == round(value) else f"{value:.2f}"
