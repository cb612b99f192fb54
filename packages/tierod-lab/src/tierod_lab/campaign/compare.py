"""Paired comparison of two campaigns: changed verdicts, and significance of differences in times and errors."""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError
from tierod.core.version import __version__
from tierod_lab.campaign.figures import CONFIDENCE, paired, pooled
from tierod_lab.campaign.judged import Judged
from tierod_lab.campaign.rows import Row
from tierod_lab.campaign.table import monitors_of, read_table

SCHEMA = "tierod.comparison/1"
"""Name and version of the document."""

RIGHT = {"quiet", "found"}
"""Correct outcomes of a drive."""


@dataclass(frozen=True)
class Pair:
    """The same drive in both campaigns.

    Args:
        place: axis -> level
        first, second: results of the monitors
    """

    place: Mapping[str, str]
    first: Row
    second: Row

    @property
    def both(self) -> tuple[Judged, Judged] | None:
        """Both judgements; None unless both exist."""
        if self.first.judged is None or self.second.judged is None:
            return None
        return self.first.judged, self.second.judged


@dataclass(frozen=True)
class Comparison:
    """One monitor in both campaigns.

    Args:
        monitors: its labels, which may differ if each campaign has one monitor
        pairs: drives of both campaigns
        alone: number of drives of the first campaign only, and of the second only
    """

    monitors: tuple[str, str]
    pairs: tuple[Pair, ...]
    alone: tuple[int, int]


def compare(first: Path, second: Path) -> list[Comparison]:
    """Compare the monitors of two campaigns, pair by pair.

    Args:
        first, second: folders of finished campaigns

    Raises:
        InputError: a folder without a campaign, or no common drive or monitor
    """
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
    pairs = tuple(Pair(row.place, row, tables[1][key]) for key, row in tables[0].items() if key in tables[1])
    return Comparison(labels, pairs, (len(tables[0]) - len(pairs), len(tables[1]) - len(pairs)))


def _bias(judged: Judged) -> float:
    return pooled((judged.errors_fault_free, judged.errors_faulty)).mean


def _deviation(judged: Judged) -> float:
    return pooled((judged.errors_fault_free, judged.errors_faulty)).deviation


FIGURES: dict[str, tuple[str, Callable[[Judged], float]]] = {
    "detection_s": ("s", lambda judged: judged.detection_s),
    "detection_enabled_s": ("s", lambda judged: judged.detection_enabled_s),
    "bias": ("unit of the estimate", _bias),
    "absolute_bias": ("unit of the estimate", lambda judged: abs(_bias(judged))),
    "deviation": ("unit of the estimate", _deviation),
    "value": ("unit of the estimate", lambda judged: judged.value),
    "false_alarms": ("", lambda judged: float(judged.false_alarms)),
    "judged_s": ("s", lambda judged: judged.judged_s),
}
"""Figures that are compared: name -> (unit, function); differences are second minus first."""


def document(found: Sequence[Comparison], folders: tuple[Path, Path], command: str = "") -> dict[str, Any]:
    """The comparison as a JSON document; values that JSON cannot represent are null."""
    return {
        "schema": SCHEMA,
        "version": __version__,
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "command": command,
        "confidence": CONFIDENCE,
        "folders": [str(folder) for folder in folders],
        "monitors": [_of_monitor(each) for each in found],
    }


def _of_monitor(found: Comparison) -> dict[str, Any]:
    changed = [pair for pair in found.pairs if _verdict_of(pair.first) != _verdict_of(pair.second)]
    outcomes: dict[tuple[str, str], int] = {}
    for pair in found.pairs:
        key = (_verdict_of(pair.first)[1], _verdict_of(pair.second)[1])
        outcomes[key] = outcomes.get(key, 0) + 1
    return {
        "labels": list(found.monitors),
        "pairs": len(found.pairs),
        "only_first": found.alone[0],
        "only_second": found.alone[1],
        "outcomes": [{"first": a, "second": b, "drives": drives} for (a, b), drives in sorted(outcomes.items())],
        "changed": [
            {
                "place": dict(pair.place),
                "first": list(_verdict_of(pair.first)),
                "second": list(_verdict_of(pair.second)),
            }
            for pair in changed
        ],
        "right": _right(found.pairs),
        "figures": [{"name": name, "unit": _unit(unit, found.pairs)} | _figure(found.pairs, get)
                    for name, (unit, get) in FIGURES.items()],
    }  # fmt: skip


def _verdict_of(row: Row) -> tuple[str, str]:
    if row.judged is None:
        return "no verdict", row.drive["outcome"] if row.drive["outcome"] != "driven" else "not judged"
    return row.judged.status, row.judged.outcome


def _right(pairs: Sequence[Pair]) -> dict[str, Any]:
    """Numbers of verdicts that are correct in one campaign only, with their sign test, which is McNemar's test."""
    flags = [(_verdict_of(pair.first)[1] in RIGHT, _verdict_of(pair.second)[1] in RIGHT) for pair in pairs]
    test = paired([float(second) - float(first) for first, second in flags])
    return {
        "first": sum(first for first, _ in flags),
        "second": sum(second for _, second in flags),
        "only_first": test.negative,
        "only_second": test.positive,
        "sign_p": _finite(test.sign_p),
    }


def _figure(pairs: Sequence[Pair], get: Callable[[Judged], float]) -> dict[str, Any]:
    values = [(get(both[0]), get(both[1])) for pair in pairs if (both := pair.both) is not None]
    test = paired([second - first for first, second in values if math.isfinite(first) and math.isfinite(second)])
    return {
        "pairs": test.count,
        "first_only": sum(math.isfinite(first) and not math.isfinite(second) for first, second in values),
        "second_only": sum(math.isfinite(second) and not math.isfinite(first) for first, second in values),
        "mean": _finite(test.mean),
        "median": _finite(test.median),
        "interval": [_finite(end) for end in test.interval],
        "greater": test.positive,
        "smaller": test.negative,
        "sign_p": _finite(test.sign_p),
        "rank_p": _finite(test.rank_p),
        "differences": [second - first for first, second in values if math.isfinite(first) and math.isfinite(second)],
    }


def _unit(unit: str, pairs: Sequence[Pair]) -> str:
    if unit != "unit of the estimate":
        return unit
    return next((pair.first.judged.unit for pair in pairs if pair.first.judged and pair.first.judged.unit), "")


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
