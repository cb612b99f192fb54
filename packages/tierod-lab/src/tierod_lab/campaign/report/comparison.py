"""Comparison of two campaigns: chart of the differences, page and terminal output, from its document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tierod.core.content import Table
from tierod.core.shown import shown
from tierod.report.charts.figure import BLUE, GREY, RED, Figure, axis, layout, rounded, strip_title, upright
from tierod.report.display import bracketed, number
from tierod.report.html import Origin, Section, rendered
from tierod_lab.campaign.report.words import TITLES, amount, count, place, value

if TYPE_CHECKING:
    from rich.console import Console


_SHOWN = ("detection_s", "bias", "absolute_bias", "deviation")
"""Figures whose differences are drawn."""
_CHANCE = (
    "The interval is that of the mean, by bootstrap. The last two columns: the probability of so uneven a result by "
    "chance alone. Several figures are tested at once, so about one in twenty falls below 0.05 by chance."
)


def difference_figure(index: int, figures: Sequence[Mapping[str, Any]]) -> Figure | None:
    """Differences of all pairs of drives, with mean and confidence interval."""
    drawn = [figure for figure in figures if figure["name"] in _SHOWN and figure["pairs"]]
    if not drawn:
        return None
    height = 60 + 110 * len(drawn)
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    notes, shapes, rows = [], [], []
    for at, figure in enumerate(drawn):
        suffix = "" if at == 0 else str(at + 1)
        domain = [1.0 - (at + 1) / len(drawn) + 46.0 / height, 1.0 - at / len(drawn) - 24.0 / height]
        factor, label = shown(figure["unit"])
        axes[f"xaxis{suffix}"] = axis("", anchor=f"y{suffix}", zeroline=False)
        axes[f"yaxis{suffix}"] = axis("", domain=domain, anchor=f"x{suffix}", range=[-1, 1], visible=False)
        data += _dots(figure, factor, suffix)
        shapes.append(upright(0, RED, 1.2, xref=f"x{suffix}", yref=f"y{suffix} domain"))
        notes.append(strip_title(bracketed(TITLES[figure["name"]].capitalize(), label), domain[1]))
        mean, median = (amount(value(figure[key]), figure["unit"]) for key in ("mean", "median"))
        rows.append((TITLES[figure["name"]].capitalize(), mean, median, str(figure["pairs"])))
    return Figure(
        name=f"differences-{index}",
        title="Differences of pairs",
        caption="The second campaign less the first: a grey dot per drive, mean and its 95 % interval in blue. Left of "
        "the dashed line the second one has less.",
        alternative="Differences of every pair for several figures; means in the table beneath.",
        data=data,
        layout=layout(height, showlegend=False, annotations=notes, shapes=shapes, **axes),
        height=height,
        summary=rows,
        columns=("figure", "mean", "median", "pairs"),
    )


def _dots(figure: Mapping[str, Any], factor: float, suffix: str) -> list[dict[str, Any]]:
    differences = np.asarray(figure["differences"], float) * factor
    # Vertical spread by the golden ratio: even, and the same for every rendering.
    across = 0.7 * (((np.arange(len(differences)) * 0.6180339887) % 1.0) - 0.5)
    low, high = (value(end) * factor for end in figure["interval"])
    mean = value(figure["mean"]) * factor
    places = {"type": "scatter", "mode": "markers", "xaxis": f"x{suffix}", "yaxis": f"y{suffix}"}
    spread = {"type": "data", "symmetric": False, "array": [high - mean], "arrayminus": [mean - low], "color": BLUE}
    dots = {"x": rounded(differences), "y": rounded(across), "marker": {"color": GREY, "size": 6, "opacity": 0.6}}
    middle = {"x": [mean], "y": [0.75], "marker": {"color": BLUE, "size": 10, "symbol": "diamond"}}
    return [
        places | dots | {"hovertemplate": "%{x:.4g}<extra></extra>"},
        places | middle | {"error_x": spread | {"thickness": 2.5}, "hovertemplate": "mean %{x:.4g}<extra></extra>"},
    ]


SIGNIFICANT = 0.05
"""Significance level: probability by chance below which a difference is reported."""

MOST = 3
"""Largest number of figures in the headline."""

COLUMNS = (
    "figure",
    "pairs",
    "mean difference",
    "95 % interval",
    "median",
    "greater / smaller",
    "sign test",
    "Wilcoxon",
)


def render_comparison(content: Mapping[str, Any]) -> str:
    """HTML page of a comparison."""
    views = [_view(index, monitor) for index, monitor in enumerate(content["monitors"])]
    first, second = content["folders"]
    return rendered(
        "analysis.html.j2",
        Origin(content["created"], content["version"], content["command"]),
        sections=[section for view in views for section in _sections(view, len(views) > 1)],
        title=views[0]["headline"] if len(views) == 1 else "Two campaigns compared",
        summary=(f"Every difference is the second campaign less the first, over {count(len(views), 'monitor')} and "
                 "the drives that both have.",),
        kind="comparison",
        facts_of=[("First campaign", first), ("Second campaign", second)],
    )  # fmt: skip


def _sections(view: Mapping[str, Any], several: bool) -> list[Section]:
    """Sections on one monitor: number of drives, differences of figures, differences of verdicts."""
    verdicts = [Table("Verdicts", ("in the first", "in the second", "drives"), tuple(view["outcomes"]))]
    if view["changed"]:
        header = ("drive", "in the first", "in the second")
        verdicts.append(Table("Drives whose verdict changed", header, tuple(view["changed"])))
    differences: list[tuple[str, Any]] = [("chart", view["figure"])] if view["figure"] else []
    differences.append(("table", Table("Figure by figure", COLUMNS, tuple(view["figures"]), _CHANCE)))
    return [
        Section(view["label"], (view["headline"],) if several else (), [("facts", view["about"])]),
        Section("Differences", (), differences),
        Section("Verdicts", (), [("table", table) for table in verdicts]),
    ]


def _view(index: int, monitor: Mapping[str, Any]) -> dict[str, Any]:
    first, second = monitor["labels"]
    right = monitor["right"]
    return {
        "label": first if first == second else f"{first} against {second}",
        "about": [
            ("Drives in both", str(monitor["pairs"])),
            ("Only in one of them", f"{monitor['only_first']} in the first, {monitor['only_second']} in the second"),
            ("Right verdicts", f"{right['first']} in the first, {right['second']} in the second"),
            ("Right in one alone", f"{right['only_first']} in the first, {right['only_second']} in the second; "
             f"by chance {_chance(right['sign_p'])}"),
        ],
        "headline": _headline(monitor),
        "figures": [_row(figure) for figure in monitor["figures"]],
        "outcomes": [(each["first"], each["second"], str(each["drives"])) for each in monitor["outcomes"]],
        "changed": [(place(each["place"]), " / ".join(each["first"]), " / ".join(each["second"]))
                    for each in monitor["changed"]],
        "figure": difference_figure(index, monitor["figures"]),
    }  # fmt: skip


def _headline(monitor: Mapping[str, Any]) -> str:
    changes = [
        f"{TITLES[figure['name']]} {'rose' if value(figure['mean']) > 0.0 else 'fell'} by "
        f"{amount(abs(value(figure['mean'])), figure['unit'])}"
        for figure in monitor["figures"]
        if figure["rank_p"] is not None and figure["rank_p"] < SIGNIFICANT
    ]
    changed = f"{count(len(monitor['changed']), 'verdict')} of {monitor['pairs']} changed"
    if not changes:
        return f"{changed}; no figure differs by more than chance would."
    return (
        f"{changed}; {', '.join(changes[:MOST])}{f', and {len(changes) - MOST} more' if len(changes) > MOST else ''}."
    )


def _row(figure: Mapping[str, Any]) -> tuple[str, ...]:
    unit = figure["unit"]
    low, high = (amount(value(end), unit) for end in figure["interval"])
    return (
        TITLES[figure["name"]].capitalize(),
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


def show_comparison(content: Mapping[str, Any], console: Console) -> None:
    """Print the differences to a terminal."""
    from rich.table import Table
    from rich.text import Text

    for index, monitor in enumerate(content["monitors"]):
        view = _view(index, monitor)
        console.print(Text(f"{view['label']}: {view['headline']}", style="bold"), soft_wrap=True)
        table = Table(box=None, pad_edge=False, header_style="bold")
        for title in COLUMNS:
            table.add_column(title, justify="left" if title == "figure" else "right")
        for row in view["figures"]:
            table.add_row(*map(Text, row))
        console.print(table)
        for where, before, after in view["changed"][:10]:
            console.print(f"  {where}: {before} -> {after}", markup=False, soft_wrap=True)
        if len(view["changed"]) > 10:
            console.print(f"  and {len(view['changed']) - 10} more; the report has all of them")
