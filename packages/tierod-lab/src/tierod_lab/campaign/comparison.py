"""Paired comparison of two campaigns: changed verdicts, and significance of differences in times and errors."""

from __future__ import annotations

import datetime
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.content import Chart, Facts, Heading, Item, Panel, Points, Table, Verdict
from tierod.core.errors import InputError
from tierod.core.shown import shown
from tierod.core.version import __version__
from tierod.report.display import bracketed, number
from tierod.report.html import Origin, page
from tierod_lab.campaign.figures import CONFIDENCE, Moments, paired, pooled
from tierod_lab.campaign.judging import Judged, Row, json_value
from tierod_lab.campaign.report import RIGHT, amount, count, place, value
from tierod_lab.campaign.summary import monitors_of, read_table

Pair = tuple[Row, Row]  # The same drive in both campaigns
SCHEMA = "tierod.comparison/1"  # Name and version of the document


@dataclass(frozen=True)
class Comparison:
    """One monitor in both campaigns."""

    monitors: tuple[str, str]  # its labels, which may differ if each campaign has one monitor
    pairs: tuple[Pair, ...]  # rows of the drives that both campaigns have
    alone: tuple[int, int]  # number of drives of the first campaign only, and of the second only


def compare(first: Path, second: Path) -> list[Comparison]:
    """Compare the monitors of two campaigns, pair by pair."""
    tables = [read_table(folder / "cells.parquet") for folder in (first, second)]
    labels = [monitors_of(rows) for rows in tables]
    common = [(label, label) for label in labels[0] if label in labels[1]]
    if not common and len(labels[0]) == len(labels[1]) == 1:
        common = [(labels[0][0], labels[1][0])]
    if not common:
        raise InputError(
            f"{first} and {second} have no monitor in common: {', '.join(labels[0])} here, {', '.join(labels[1])} "
            "there; give the monitors the same labels"
        )
    found = [_compared(tables[0], tables[1], pair) for pair in common]
    if not any(each.pairs for each in found):
        axes = [", ".join(rows[0].place) if rows else "" for rows in tables]
        raise InputError(
            f"{first} and {second} have no drive in common; drives are alike where all axes ({axes[0]} and {axes[1]}) "
            "have the same level"
        )
    return found


def _compared(first: Sequence[Row], second: Sequence[Row], labels: tuple[str, str]) -> Comparison:
    tables = [
        {frozenset(row.place.items()): row for row in rows if row.monitor == label}
        for rows, label in zip((first, second), labels, strict=True)
    ]
    pairs = tuple((row, tables[1][key]) for key, row in tables[0].items() if key in tables[1])
    return Comparison(labels, pairs, (len(tables[0]) - len(pairs), len(tables[1]) - len(pairs)))


def _errors(judged: Judged) -> Moments:
    return pooled((judged.errors_fault_free, judged.errors_faulty))


_OF_ESTIMATE = "unit of the estimate"

FIGURES: dict[str, tuple[str, str, Callable[[Judged], float]]] = {
    "detection_s": ("time to the alarm", "s", lambda judged: judged.detection_s),
    "detection_enabled_s": ("enabled time to the alarm", "s", lambda judged: judged.detection_enabled_s),
    "bias": ("bias", _OF_ESTIMATE, lambda judged: _errors(judged).mean),
    "absolute_bias": ("size of the bias", _OF_ESTIMATE, lambda judged: abs(_errors(judged).mean)),
    "deviation": ("deviation of the estimate", _OF_ESTIMATE, lambda judged: _errors(judged).deviation),
    "value": ("last estimate", _OF_ESTIMATE, lambda judged: judged.value),
    "false_alarms": ("false alarms", "", lambda judged: float(judged.false_alarms)),
    "judged_s": ("time judged", "s", lambda judged: judged.judged_s),
}
"""Figures that are compared: name -> (title, unit, function); differences are second minus first."""


def document(found: Sequence[Comparison], folders: tuple[Path, Path], command: str = "") -> dict[str, Any]:
    """The comparison as a JSON document; values that JSON cannot represent are null."""
    content: dict[str, Any] = json_value(
        {
            "schema": SCHEMA,
            "version": __version__,
            "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
            "command": command,
            "confidence": CONFIDENCE,
            "folders": [str(folder) for folder in folders],
            "monitors": [_of_monitor(each) for each in found],
        }
    )
    return content


def _of_monitor(found: Comparison) -> dict[str, Any]:
    verdicts = [(_verdict_of(first), _verdict_of(second)) for first, second in found.pairs]
    outcomes = Counter((first[1], second[1]) for first, second in verdicts)
    return {
        "labels": found.monitors,
        "pairs": len(found.pairs),
        "only_first": found.alone[0],
        "only_second": found.alone[1],
        "outcomes": [{"first": a, "second": b, "drives": drives} for (a, b), drives in sorted(outcomes.items())],
        "changed": [
            {"place": row.place, "first": first, "second": second}
            for (row, _), (first, second) in zip(found.pairs, verdicts, strict=True)
            if first != second
        ],
        "right": _right([(first[1] in RIGHT, second[1] in RIGHT) for first, second in verdicts]),
        "figures": [{"name": name, "unit": _unit(unit, found.pairs)} | _figure(found.pairs, get)
                    for name, (_, unit, get) in FIGURES.items()],
    }  # fmt: skip


def _verdict_of(row: Row) -> tuple[str, str]:
    if row.judged is None:
        return "no verdict", row.drive["outcome"] if row.drive["outcome"] != "driven" else "not judged"
    return row.judged.status, row.judged.outcome


def _right(flags: Sequence[tuple[bool, bool]]) -> dict[str, Any]:
    test = paired([float(second) - float(first) for first, second in flags])
    return {
        "first": sum(first for first, _ in flags),
        "second": sum(second for _, second in flags),
        "only_first": test.negative,
        "only_second": test.positive,
        "sign_p": test.sign_p,
    }


def _figure(pairs: Sequence[Pair], get: Callable[[Judged], float]) -> dict[str, Any]:
    values = [(get(one.judged), get(other.judged)) for one, other in pairs if one.judged and other.judged]
    known = [(math.isfinite(first), math.isfinite(second)) for first, second in values]
    differences = [second - first for (first, second), both in zip(values, known, strict=True) if all(both)]
    test = paired(differences)
    return {
        "pairs": test.count,
        "first_only": known.count((True, False)),
        "second_only": known.count((False, True)),
        "mean": test.mean,
        "median": test.median,
        "interval": test.interval,
        "greater": test.positive,
        "smaller": test.negative,
        "sign_p": test.sign_p,
        "rank_p": test.rank_p,
        "differences": differences,
    }


def _unit(unit: str, pairs: Sequence[Pair]) -> str:
    if unit != _OF_ESTIMATE:
        return unit
    return next((row.judged.unit for row, _ in pairs if row.judged and row.judged.unit), "")


_DRAWN = ("detection_s", "bias", "absolute_bias", "deviation")  # Figures whose differences are drawn
_CHANCE = (
    "The interval is that of the mean, by bootstrap. The last two columns: the probability of so uneven a result by "
    "chance alone. Several figures are tested at once, so about one in twenty falls below 0.05 by chance."
)
_SIGNIFICANT = 0.05  # Significance level: probability by chance below which a difference is reported
_MOST, _LISTED = 3, 10  # Largest number of figures in the headline, and of changed verdicts in the terminal
_COLUMNS = (
    "figure", "pairs", "mean difference", "95 % interval", "median", "greater / smaller", "sign test", "Wilcoxon",
)  # fmt: skip


def render_comparison(content: Mapping[str, Any]) -> str:
    """HTML page of a comparison."""
    monitors = content["monitors"]
    title = _headline(monitors[0]) if len(monitors) == 1 else "Two campaigns compared"
    over = count(len(monitors), "monitor")
    text = f"Every difference is the second campaign less the first, over {over} and the drives that both have."
    items: list[Item] = [Verdict(title, text=(text,))]
    items.append(Facts(list(zip(("First campaign", "Second campaign"), content["folders"], strict=True))))
    for index, monitor in enumerate(monitors):
        items += _of(index, monitor, len(monitors) > 1)
    return page(items, Origin(content["created"], content["version"], content["command"]), title, "comparison")


def shown_comparison(content: Mapping[str, Any]) -> Iterator[Item]:
    """What a terminal shows of a comparison."""
    for monitor in content["monitors"]:
        yield Verdict(f"{_label(monitor)}: {_headline(monitor)}")
        yield Table("", _COLUMNS, tuple(map(_figure_row, monitor["figures"])))
        if changed := _changed(monitor):
            more = f"{len(changed) - _LISTED} more are in the report." if len(changed) > _LISTED else ""
            yield Table("Changed verdicts", ("drive", "in the first", "in the second"), changed[:_LISTED], more)


def _label(monitor: Mapping[str, Any]) -> str:
    first, second = monitor["labels"]
    return first if first == second else f"{first} against {second}"


def _of(index: int, monitor: Mapping[str, Any], several: bool) -> Iterator[Item]:
    right = monitor["right"]
    yield Heading(_label(monitor), (_headline(monitor),) if several else ())
    yield Facts([
        ("Drives in both", str(monitor["pairs"])),
        ("Only in one of them", f"{monitor['only_first']} in the first, {monitor['only_second']} in the second"),
        ("Right verdicts", f"{right['first']} in the first, {right['second']} in the second"),
        ("Right in one alone", f"{right['only_first']} in the first, {right['only_second']} in the second; "
         f"by chance {_chance(right['sign_p'])}"),
    ])  # fmt: skip
    yield Heading("Differences")
    if chart := _differences(index, monitor["figures"]):
        yield chart
    yield Table("Figure by figure", _COLUMNS, tuple(map(_figure_row, monitor["figures"])), _CHANCE)
    yield Heading("Verdicts")
    outcomes = tuple((each["first"], each["second"], str(each["drives"])) for each in monitor["outcomes"])
    yield Table("", ("in the first", "in the second", "drives"), outcomes)
    if changed := _changed(monitor):
        yield Table("Drives whose verdict changed", ("drive", "in the first", "in the second"), changed)


def _changed(monitor: Mapping[str, Any]) -> tuple[tuple[str, str, str], ...]:
    return tuple(
        (place(each["place"]), " / ".join(each["first"]), " / ".join(each["second"])) for each in monitor["changed"]
    )


def _differences(index: int, figures: Sequence[Mapping[str, Any]]) -> Chart | None:
    panels, rows = [], []
    for figure in figures:
        if figure["name"] not in _DRAWN or not figure["pairs"]:
            continue
        factor, label = shown(figure["unit"])
        found = np.asarray(figure["differences"], float) * factor
        # Spread across by the golden ratio: even, and the same for every rendering.
        across = 0.7 * (((np.arange(len(found)) * 0.6180339887) % 1.0) - 0.5)
        low, mean, high = (
            [factor * value(each)] for each in (figure["interval"][0], figure["mean"], figure["interval"][1])
        )
        marks = (Points("pairs", across, found), Points("mean, 95 %", [0.75], mean, low, high))
        title = FIGURES[figure["name"]][0].capitalize()
        rows_ = (("pairs", 0.0), ("mean", 0.75))
        panels.append(
            Panel(title, "", bracketed("difference", label), marks, (("none", 0.0),), sideways=True, rows=rows_)
        )
        means = (amount(value(figure[key]), figure["unit"]) for key in ("mean", "median"))
        rows.append((title, *means, str(figure["pairs"])))
    if not panels:
        return None
    return Chart(
        f"differences-{index}",
        "Differences of pairs",
        "The second campaign less the first: a dot per drive, and the mean with its 95 % interval. Left of the dashed "
        "line the second one has less.",
        "Differences of every pair for several figures; means in the table beneath.",
        tuple(panels),
        ("figure", "mean", "median", "pairs"),
        tuple(rows),
    )


def _headline(monitor: Mapping[str, Any]) -> str:
    changes = [
        f"{FIGURES[figure['name']][0]} {'rose' if value(figure['mean']) > 0.0 else 'fell'} by "
        f"{amount(abs(value(figure['mean'])), figure['unit'])}"
        for figure in monitor["figures"]
        if figure["rank_p"] is not None and figure["rank_p"] < _SIGNIFICANT
    ]
    changed = f"{count(len(monitor['changed']), 'verdict')} of {monitor['pairs']} changed"
    if not changes:
        return f"{changed}; no figure differs by more than chance would"
    return f"{changed}; {', '.join(changes[:_MOST])}{f', and {len(changes) - _MOST} more' * (len(changes) > _MOST)}"


def _figure_row(figure: Mapping[str, Any]) -> tuple[str, ...]:
    unit = figure["unit"]
    low, high = (amount(value(end), unit) for end in figure["interval"])
    return (
        FIGURES[figure["name"]][0].capitalize(),
        str(figure["pairs"]),
        amount(value(figure["mean"]), unit),
        f"{low} to {high}" if figure["pairs"] else "–",
        amount(value(figure["median"]), unit),
        f"{figure['greater']} / {figure['smaller']}",
        _chance(figure["sign_p"]),
        _chance(figure["rank_p"]),
    )


def _chance(probability: float | None) -> str:
    if probability is None:
        return "–"
    return "below 0.001" if probability < 0.001 else number(probability, 2)
