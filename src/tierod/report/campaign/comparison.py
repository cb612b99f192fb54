"""Two campaigns side by side: page and terminal, from the document of the comparison."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tierod.report.campaign.differences import difference_figure
from tierod.report.campaign.page import with_own_style
from tierod.report.campaign.words import TITLES, amount, count, place, value
from tierod.report.display import number
from tierod.report.html import chart_script, library, looks, moment, template

if TYPE_CHECKING:
    from rich.console import Console

SIGNIFICANT = 0.05
"""Probability of chance alone below which a difference is called one."""

MOST = 3
"""Figures that the headline names."""

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
_SHOWN = ("detection_s", "bias", "absolute_bias", "deviation")
"""Figures whose differences are drawn."""


def render_comparison(content: Mapping[str, Any]) -> str:
    """The page as text.

    Args:
        content: the document of `tierod.experiments.compare.document`
    """
    views = [_view(index, monitor) for index, monitor in enumerate(content["monitors"])]
    figures = [view["figure"] for view in views if view["figure"] is not None]
    return template("comparison.html.j2").render(
        page=content,
        created=moment(content["created"]),
        columns=COLUMNS,
        views=views,
        charts=[chart_script(figure) for figure in figures],
        library=library() if figures else "",
        **with_own_style(looks()),
    )


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
    told = [
        f"{TITLES[figure['name']]} {'rose' if value(figure['mean']) > 0.0 else 'fell'} by "
        f"{amount(abs(value(figure['mean'])), figure['unit'])}"
        for figure in monitor["figures"]
        if figure["rank_p"] is not None and figure["rank_p"] < SIGNIFICANT
    ]
    changed = f"{count(len(monitor['changed']), 'verdict')} of {monitor['pairs']} changed"
    if not told:
        return f"{changed}; no figure differs by more than chance would."
    return f"{changed}; {', '.join(told[:MOST])}{f', and {len(told) - MOST} more' if len(told) > MOST else ''}."


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
    """Print what differs."""
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
