"""Charts of a campaign, and its matrix with one row per combination of levels and one column per fault and size."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tierod.core.shown import shown
from tierod.report.charts.figure import (
    AMBER,
    BLUE,
    GREEN,
    GREY,
    RED,
    Figure,
    across,
    axis,
    layout,
    rounded,
    strip_title,
)
from tierod.report.display import bracketed, number
from tierod_lab.campaign.report.words import NEVER, count, found, seconds, value

RIGHT = {"quiet", "found"}
"""Correct outcomes."""


@dataclass
class Square:
    """Outcomes of all seeds of one cell of the matrix."""

    right: int = 0
    wrong: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)

    @property
    def kind(self) -> str:
        """CSS class: "bad", "open" or "good"; "" without outcomes."""
        return "bad" if self.wrong else "open" if self.lost else "good" if self.right else ""

    @property
    def symbol(self) -> str:
        """Symbol that marks the kind without colour."""
        return {"bad": "✕", "open": "?", "good": "✓", "": ""}[self.kind]

    @property
    def text(self) -> str:
        """Number of correct verdicts, of all."""
        total = self.right + len(self.wrong) + len(self.lost)
        return f"{self.right}/{total}" if total else ""

    @property
    def title(self) -> str:
        """Incorrect and missing outcomes with their numbers, as text."""
        outcomes = [*self.wrong, *self.lost]
        return ", ".join(count(outcomes.count(what), what, what) for what in dict.fromkeys(outcomes))


@dataclass(frozen=True)
class Grid:
    """Matrix of outcomes.

    Args:
        axes: names of the factors that distinguish the rows
        columns: fault-free, then faults with their sizes
        rows: (levels, squares) each
    """

    axes: tuple[str, ...]
    columns: tuple[str, ...]
    rows: tuple[tuple[tuple[str, ...], tuple[Square, ...]], ...]


def grid(cells: Sequence[Mapping[str, Any]], monitor: str) -> Grid:
    """Matrix of one monitor's verdicts."""
    apart = ("fault", "size", "seed")
    axes = tuple(axis for axis in cells[0]["place"] if axis not in apart) if cells else ()
    # Axes with a single level would repeat it in every row.
    axes = tuple(axis for axis in axes if len({cell["place"][axis] for cell in cells}) > 1)
    rows: dict[tuple[str, ...], dict[str, Square]] = {}
    columns: dict[str, None] = {}
    for cell in cells:
        place = cell["place"]
        column = " ".join(filter(None, (place["fault"], place["size"])))
        columns[column] = None
        square = rows.setdefault(tuple(place[axis] for axis in axes), {}).setdefault(column, Square())
        _count(square, cell, next((each for each in cell["verdicts"] if each["monitor"] == monitor), None))
    table = tuple(
        (levels, tuple(squares.get(column, Square()) for column in columns)) for levels, squares in rows.items()
    )
    return Grid(axes, tuple(columns), table)


def _count(square: Square, cell: Mapping[str, Any], verdict: Mapping[str, Any] | None) -> None:
    if verdict is None or verdict["status"] is None:
        square.lost.append(cell["outcome"] if cell["outcome"] != "driven" else "not judged")
    elif verdict["outcome"] in RIGHT:
        square.right += 1
    elif verdict["outcome"] == "not judged":
        square.lost.append("not judged")
    else:
        square.wrong.append(verdict["outcome"])


_PANEL = 210
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)")
_QUANTILES = (
    ("median", "median", BLUE, "circle"),
    ("p95", "95 %", AMBER, "diamond"),
    ("worst", "worst", RED, "square"),
)


Sizes = list[tuple[str, Mapping[str, Any]]]
"""(size, figures) pairs of a fault."""


def detection_figure(
    number_: int, monitor: str, pools: Sequence[Mapping[str, Any]], gates: Sequence[Mapping[str, Any]] = ()
) -> Figure | None:
    """Detection delay over fault size, one panel per fault; None where there are no faults."""
    faults = _faults(pools)
    if not faults:
        return None
    height = 120 + _PANEL * len(faults)
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    notes: list[dict[str, Any]] = []
    shapes: list[dict[str, Any]] = []
    rows = []
    for index, (fault, sizes) in enumerate(faults.items()):
        suffix = "" if index == 0 else str(index + 1)
        bottom, top = 1.0 - (index + 1) / len(faults), 1.0 - index / len(faults)
        domain = [bottom + (62.0 / height if index + 1 < len(faults) else 0.0), top - 24.0 / height]
        places, unit = _places([size for size, _ in sizes])
        axes[f"xaxis{suffix}"] = axis(f"size [{unit}]" if unit else "size", anchor=f"y{suffix}")
        axes[f"yaxis{suffix}"] = axis("time [s]", domain=domain, anchor=f"x{suffix}", rangemode="tozero")
        data += _curves(sizes, places, suffix, first=index == 0)
        notes += [strip_title(fault, domain[1]), *_missed(sizes, places, suffix)]
        shapes += _goals(gates, monitor, fault, suffix)
        for size, figures in sizes:
            median, high, worst = (seconds(figures[f"detection_{name}_s"]) for name, *_ in _QUANTILES)
            rows.append((f"{fault} {size}".strip() + f" ({found(figures)} found)", median, high, worst))
    return Figure(
        name=f"detection-{number_}",
        title="How soon faults are found",
        caption="Time from the beginning of a fault to the first alarm. Above each size: how many faults were never "
        "found; with half of them there is no median, with more than 5 % no 95 % value. Dashed: goal of a pass "
        "criterion.",
        alternative=f"Detection times of {monitor} over the size of each fault; all figures in the table beneath.",
        data=data,
        layout=layout(height, annotations=notes, shapes=shapes, **axes),
        height=height,
        summary=rows,
        columns=("fault", "median", "95 %", "worst"),
    )


_GOALS = {f"detection_{key}_s": colour for key, _, colour, _ in _QUANTILES}
"""Colours of the curves, by the name of their figure in a pass criterion."""


def _goals(gates: Sequence[Mapping[str, Any]], monitor: str, fault: str, suffix: str) -> list[dict[str, Any]]:
    """Dashed lines at the goals of the pass criteria on a fault's delays, in the colours of the curves."""
    drawn = []
    for gate in gates:
        part = _NUMBER.fullmatch(gate["goal"].lstrip("<>= "))
        of = gate["where"].get("fault", fault)
        on = fault in of if isinstance(of, list) else fault == of
        if part is None or gate["figure"] not in _GOALS or not on or gate["monitor"] not in ("", monitor):
            continue
        axes = {"xref": f"x{suffix} domain", "yref": f"y{suffix}"}
        drawn.append(across(float(part[1]), _GOALS[gate["figure"]], 1.2, **axes))
    return drawn


def _faults(pools: Sequence[Mapping[str, Any]]) -> dict[str, Sizes]:
    """Every fault with its sizes, in the order of the matrix; a fault without sizes has the single size ""."""
    found: dict[str, Sizes] = {}
    for pool in pools:
        where, figures = pool["where"], pool["figures"]
        if set(where) == {"fault"} and figures["faulty"]:
            found[where["fault"]] = [("", figures)]
    for pool in pools:
        where, figures = pool["where"], pool["figures"]
        if set(where) == {"fault", "size"} and where["fault"] in found:
            sizes = found[where["fault"]]
            found[where["fault"]] = [*(each for each in sizes if each[0]), (where["size"], figures)]
    return found


def _places(sizes: Sequence[str]) -> tuple[list[Any], str]:
    """Sizes as numbers with their common unit; sizes that are not numbers stay names."""
    parts = [_NUMBER.fullmatch(size) for size in sizes]
    units = {part[2].strip() for part in parts if part}
    if all(parts) and len(units - {""}) <= 1:
        return [float(part[1]) for part in parts if part], next(iter(units - {""}), "").replace("*", "·")
    return [size or "as it is" for size in sizes], ""


def _curves(sizes: Sizes, places: Sequence[Any], suffix: str, first: bool) -> list[dict[str, Any]]:
    curves = []
    for key, name, colour, symbol in _QUANTILES:
        times = [value(figures[f"detection_{key}_s"]) for _, figures in sizes]
        curves.append(
            {
                "type": "scatter",
                "mode": "lines+markers",
                "name": name,
                "x": list(places),
                "y": rounded([math.nan if math.isinf(each) else each for each in times]),
                "line": {"color": colour, "width": 1.6},
                "marker": {"color": colour, "size": 8, "symbol": symbol},
                "xaxis": f"x{suffix}",
                "yaxis": f"y{suffix}",
                "showlegend": first,
                "legendgroup": name,
                "hovertemplate": "%{x}: %{y:.4g} s<extra>" + name + "</extra>",
            }
        )
    return curves


def _missed(sizes: Sizes, places: Sequence[Any], suffix: str) -> list[dict[str, Any]]:
    notes = []
    for (_, figures), at in zip(sizes, places, strict=True):
        lost = figures["faulty"] - figures["early"] - figures["found"]
        if lost:
            where = {"x": at, "xref": f"x{suffix}", "yref": f"y{suffix} domain", "y": 0.98, "yanchor": "top"}
            text = f"{lost} {NEVER}"
            notes.append({"text": text, "showarrow": False, "font": {"size": 12, "color": RED}} | where)
    return notes


def box_figure(number_: int, states: Mapping[str, Any]) -> Figure | None:
    """Distribution of the estimates in every state, with the true value; None without estimates."""
    boxes = states["boxes"]
    if not boxes:
        return None
    factor, label = shown(states["unit"])
    names = [box["state"] for box in boxes]
    keys = {"q1": "lower", "median": "median", "q3": "upper", "lowerfence": "low", "upperfence": "high"}
    drawn = {key: rounded([factor * value(box[name]) for box in boxes]) for key, name in keys.items()}
    line = {"color": BLUE, "width": 1.5}
    data: list[dict[str, Any]] = [
        {"type": "box", "name": "estimates", "x": names, "line": line, "fillcolor": "var(--accent-tint)", **drawn},
        {
            "type": "scatter",
            "mode": "markers",
            "name": "truth",
            "x": names,
            "y": rounded([factor * value(box["truth"]) for box in boxes]),
            "marker": {"color": GREEN, "size": 22, "symbol": "line-ew", "line": {"color": GREEN, "width": 3}},
        },
    ]
    rows = [
        (
            box["state"],
            f"{number(factor * value(box['truth']), 3)} {label}".strip(),
            f"{number(factor * value(box['median']), 3)} {label}".strip(),
            f"{number(factor * value(box['bias']), 3)} ± {number(factor * value(box['deviation']), 3)} {label}".strip(),
        )
        for box in boxes
    ]
    return Figure(
        name=f"estimates-{number_}",
        title="What was estimated in each state",
        caption="Settled estimates of all drives: middle half as the box, 5 to 95 % as whiskers. Green: the truth. "
        "The column `fault_free` includes the drives with a fault, until it comes.",
        alternative="Boxes of the estimates by state; truth, median and errors in the table beneath.",
        data=data,
        layout=layout(400, yaxis=axis(bracketed("estimate", label)), xaxis=axis("", automargin=True, linecolor=GREY)),
        height=400,
        summary=rows,
        columns=("state", "truth", "median", "bias ± deviation"),
    )
