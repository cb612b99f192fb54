"""Page of a campaign: pass criteria first, then matrix, detection delays, states, estimates, and failures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tierod.core.shown import shown
from tierod.core.statuses import SEVERITY, Status
from tierod.report.charts.figure import Figure
from tierod.report.display import number
from tierod.report.html import Origin, rendered
from tierod_lab.campaign.report.charts import RIGHT, box_figure, detection_figure, grid
from tierod_lab.campaign.report.words import count, false_alarms, found, place, rate, seconds, shared, spread, value

_GATES = {True: ("✓", "met", "good"), False: ("✕", "missed", "bad"), None: ("?", "not judged", "open")}
_STATUSES = {
    "met": ("✓", "good", "All pass criteria are met"),
    "missed": ("✕", "bad", "A pass criterion is missed"),
    "not judged": ("?", "open", "Not everything could be judged"),
    "no gates": ("–", "open", "No pass criteria were set"),
}
_ACTIONS = {
    "missed": "See below which group of drives misses the criterion, and open the report of one of its drives.",
    "not judged": "See below which drives failed and why; the same command again simulates the missing drives.",
}
FAULT_FREE = "fault-free"
"""State of a drive without a fault."""

MOST_CELLS = 3000
"""Largest number of drives listed on the page; the table file contains all."""


def render_campaign(content: Mapping[str, Any]) -> str:
    """HTML page of a campaign."""
    symbol, kind, headline = _STATUSES[content["status"]]
    views = [_view(index, content, monitor) for index, monitor in enumerate(content["monitors"])]
    figures = [figure for view in views for figure in view["figures"]]
    return rendered(
        Path(__file__).with_name("campaign.html.j2"),
        Origin(content["created"], content["version"], content["command"]),
        figures,
        page=content,
        symbol=symbol,
        kind=kind,
        headline=headline,
        action=_ACTIONS.get(content["status"], ""),
        about=_facts(content),
        gates=[_gate(gate) for gate in content["gates"]],
        views=views,
        failures=_failures(content["cells"]),
        cells=[_cell(cell) for cell in content["cells"][:MOST_CELLS]],
        left_out=max(len(content["cells"]) - MOST_CELLS, 0),
    )


def _facts(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    cells = content["cells"]
    outcomes = [cell["outcome"] for cell in cells]
    facts = [
        ("Drives", str(len(cells))),
        ("Driving", f"{number(value(content['hours']), 3)} h"),
        *((axis.capitalize(), _levels(levels)) for axis, levels in content["axes"].items() if axis != "size"),
    ]
    for outcome, title in (("diverged", "Diverged"), ("failed", "Failed"), ("open", "Not driven yet")):
        if outcome in outcomes:
            facts.append((title, str(outcomes.count(outcome))))
    return facts


def _levels(levels: Sequence[str]) -> str:
    if len(levels) > 8:
        return f"{len(levels)}, from {levels[0]} to {levels[-1]}"
    return ", ".join(level for level in levels if level)


def _gate(gate: Mapping[str, Any]) -> dict[str, str]:
    symbol, word, kind = _GATES[gate["met"]]
    measured = seconds(gate["measured"]) if gate["figure"].endswith("_s") else number(value(gate["measured"]))
    return {
        "name": gate["figure"],
        "where": place(gate["where"]),
        "monitor": gate["monitor"],
        "goal": gate["goal"].replace("<=", "≤").replace(">=", "≥"),
        "measured": measured,
        "symbol": symbol,
        "word": word,
        "kind": kind,
        "note": gate["note"],
    }


def _view(index: int, content: Mapping[str, Any], monitor: Mapping[str, Any]) -> dict[str, Any]:
    label = monitor["label"]
    pools = [each for each in content["pools"] if each["monitor"] == label]
    states = next(each for each in content["states"] if each["monitor"] == label)
    whole = pools[0]["figures"]
    figures: list[Figure] = [
        figure
        for figure in (detection_figure(index, label, pools, content["gates"]), box_figure(index, states))
        if figure
    ]
    unit = shown(states["unit"])[1]
    return {
        "label": label,
        "monitor": monitor,
        "figures_of": _figures(whole, unit),
        "grid": grid(content["cells"], label),
        "figures": figures,
        "confusion": _confusion(states["confusion"]),
        "columns": _columns(unit),
        "pools": [_pool(pool) for pool in pools],
    }


def _figures(figures: Mapping[str, Any], unit: str) -> list[tuple[str, str]]:
    hours = number(value(figures["fault_free_judged_hours"]), 3)
    return [
        ("Faults found", found(figures)),
        ("Time to the alarm", f"median {seconds(figures['detection_median_s'])}, "
         f"95 % {seconds(figures['detection_p95_s'])}, worst {seconds(figures['detection_worst_s'])}"),
        ("The same in enabled time", f"median {seconds(figures['detection_enabled_median_s'])}, "
         f"95 % {seconds(figures['detection_enabled_p95_s'])}, worst {seconds(figures['detection_enabled_worst_s'])}"),
        ("False alarms", f"{figures['false_alarms']} in {hours} judged hours without fault; with 95 % confidence below "
         f"{rate(figures['false_alarm_bound'])} per hour"),
        ("Estimate less truth", f"{spread(figures)} {unit}".strip()),
        ("Area under the ROC curve", f"{number(value(figures['area']))} between drives, at least "
         f"{number(value(figures['smallest_area']))} within one"),
        ("Judged", f"{shared(figures, 'judged_share')} of the time, enabled {shared(figures, 'enabled_share')}"),
        ("Drives without a judgement", str(figures["not_judged"] + figures["failed"] + figures["diverged"])),
    ]  # fmt: skip


def _confusion(confusion: Mapping[str, Mapping[str, int]]) -> dict[str, Any]:
    """Confusion matrix: true states down, statuses across in the order of severity."""
    order = [*map(str, SEVERITY), "no verdict"]
    seen = {status for counts in confusion.values() for status in counts}
    statuses = [status for status in order if status in seen]
    rows = []
    for state, counts in confusion.items():
        total = sum(counts.values())
        cells = [(counts.get(status, 0), _right(state, status)) for status in statuses]
        rows.append((state, cells, total))
    return {"statuses": statuses, "rows": rows}


def _right(state: str, status: str) -> str:
    if status not in SEVERITY or not Status(status).judged:
        return "open"
    return "good" if Status(status).alarm == (state != FAULT_FREE) else "bad"


def _columns(unit: str) -> tuple[str, ...]:
    error = f"bias ± deviation [{unit}]" if unit else "bias ± deviation"
    alarms = ("false alarms", "at most")
    return ("group", "drives", "lost", "found", "median", "95 %", "worst", *alarms, error, "ROC area", "judged")


def _pool(pool: Mapping[str, Any]) -> tuple[str, ...]:
    figures = pool["figures"]
    return (
        place(pool["where"]),
        str(figures["drives"]),
        str(figures["failed"] + figures["diverged"] + figures["not_judged"]),
        found(figures),
        *(seconds(figures[f"detection_{name}_s"]) for name in ("median", "p95", "worst")),
        *false_alarms(figures),
        spread(figures),
        number(value(figures["area"])),
        shared(figures, "judged_share"),
    )


def _failures(cells: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Drives that failed and verdicts that are missing, grouped by reason."""
    alike: dict[tuple[str, str, str], list[str]] = {}
    for cell in cells:
        if cell["outcome"] != "driven":
            last = "" if cell["last_good_s"] is None else seconds(cell["last_good_s"])
            alike.setdefault((cell["outcome"], cell["reason"], last), []).append(place(cell["place"]))
            continue
        for verdict in cell["verdicts"]:
            if verdict["reason"]:
                key = (f"{verdict['monitor']} gave no verdict", verdict["reason"], "")
                alike.setdefault(key, []).append(place(cell["place"]))
    return [
        {"outcome": outcome, "reason": reason, "last": last, "number": count(len(places), "drive"),
         "places": "; ".join(places[:6]) + (f"; and {len(places) - 6} more" if len(places) > 6 else "")}
        for (outcome, reason, last), places in alike.items()
    ]  # fmt: skip


def _cell(cell: Mapping[str, Any]) -> dict[str, Any]:
    verdicts = [
        {
            "text": each["status"] or "no verdict",
            "outcome": each.get("outcome", ""),
            "kind": Status(each["status"] or Status.NOT_AVAILABLE).colour,
            "symbol": Status(each["status"] or Status.NOT_AVAILABLE).symbol,
            "time": seconds(each["detection_s"]) if each.get("outcome") == "found" else "",
            "headline": each.get("headline") or each["reason"],
            "wrong": each.get("outcome") not in RIGHT,
        }
        for each in cell["verdicts"]
    ]
    return {
        "place": place(cell["place"]),
        "outcome": cell["outcome"],
        "recording": cell["recording"],
        "verdicts": verdicts,
    }
