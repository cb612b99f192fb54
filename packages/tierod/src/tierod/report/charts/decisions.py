"""Charts of a monitor's decisions: statistics with thresholds over time, and the design curve of each rule."""

from __future__ import annotations

from typing import Any

import numpy as np

from tierod.core.content import Chart, Lines, Panel, Points
from tierod.core.decimation import merged
from tierod.core.findings import Curve, Decided, Diagnosis, Trace
from tierod.core.shown import shown
from tierod.report.charts.figure import (
    RED,
    Figure,
    across,
    axis,
    centres,
    drawn_as,
    layout,
    line,
    strip,
    strip_title,
    summary,
)
from tierod.report.charts.over_time import span, verdict_marks
from tierod.report.display import alarm_from, bracketed, number, time_scale, words

Limit = tuple[float, bool]
"""A threshold, and whether the rule alarms below it."""

_STRIP, _PANEL = 130, 250
_WIDEST = 10.0
"""Largest ratio to the threshold that is drawn."""
DELAY = (
    "Detection delay over the time between false alarms, at the shift that must be detected; the delay of the "
    "estimator adds to it"
)


def statistics(diagnosis: Diagnosis) -> dict[str, list[Limit]]:
    """Traces that decision rules compare, with their thresholds; several rules may share a trace."""
    found: dict[str, list[Limit]] = {}
    for each in diagnosis.decisions:
        trace = diagnosis.traces.get(each.statistic)
        if trace is not None and np.isfinite(trace.mean).any():
            limits = [(level, each.below or level < 0.0) for level in each.levels]
            found[each.statistic] = list(dict.fromkeys((*found.get(each.statistic, ()), *limits)))
    return found


def most_relevant(diagnosis: Diagnosis) -> list[str]:
    """Statistics that decided the verdict, then others beyond a threshold; all statistics where there are none."""
    decisive = {name for finding in diagnosis.findings for name in finding.decided_by}
    known = [each for each in diagnosis.decisions if each.statistic in statistics(diagnosis)]
    ordered = [
        *(each.statistic for each in known if each.name in decisive),
        *(each.statistic for each in known if each.passed is not None),
    ]
    return list(dict.fromkeys(ordered)) or list(statistics(diagnosis))


def decision_figure(diagnosis: Diagnosis) -> Figure | None:
    """The most relevant statistics over time with dashed thresholds, red where a threshold is exceeded."""
    return _statistics(diagnosis, most_relevant(diagnosis), "decisions", "What was decided on")


def quiet_figure(diagnosis: Diagnosis) -> Figure | None:
    """Statistics that stayed within their thresholds, if others did not."""
    said = most_relevant(diagnosis)
    quiet = [name for name in statistics(diagnosis) if name not in said]
    return _statistics(diagnosis, quiet, "quiet", "What stayed within its thresholds")


def _statistics(diagnosis: Diagnosis, names: list[str], name: str, title: str) -> Figure | None:
    if not names:
        return None
    limits = statistics(diagnosis)
    first, last = span(diagnosis)
    per_second, clock = time_scale(last - first)
    height = _STRIP * len(names) + 70
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    shapes, notes = verdict_marks(diagnosis, per_second, 1.0 - 30.0 / height)
    rows = []
    for index, each in enumerate(names):
        trace = merged(diagnosis.traces[each])
        factor, label = shown(trace.unit)
        suffix = "" if index == 0 else str(index + 1)
        domain = [1.0 - (index + 1) / len(names), 1.0 - index / len(names) - 26.0 / height]
        axes[f"yaxis{suffix}"] = axis("", domain=domain, nticks=4)
        data += _strip(trace, per_second, factor, label, limits[each], f"y{suffix}")
        shapes += [across(level * factor, RED, 1.2, yref=f"y{suffix}") for level, _ in limits[each]]
        notes.append(strip_title(_titled(each, label, factor, limits[each]), domain[1]))
        rows.append(summary(words(each), trace, factor, label))
    bottom = f"y{len(names)}" if len(names) > 1 else "y"
    axes["xaxis"] = axis(f"time [{clock}]", range=[per_second * first, per_second * last], anchor=bottom)
    return Figure(
        name=name,
        title=title,
        caption="Statistics of the stopping rules over time. Dashed: thresholds. Red: beyond one.",
        alternative=f"{', '.join(map(words, names))} over time, with thresholds; ranges in the table beneath.",
        data=data,
        layout=layout(height, hovermode="x", showlegend=False, shapes=shapes, annotations=notes, **axes),
        height=height,
        summary=rows,
        timed=True,
    )


def looks_chart(diagnosis: Diagnosis) -> Chart | None:
    """Statistics of rules that evaluate the whole recording once, relative to their thresholds."""
    seen = [(each, share) for each in diagnosis.decisions if (share := _over_threshold(each)) is not None]
    if not seen:
        return None
    rows = tuple(
        (words(each.name), f"{number(each.reached, 3)}, {alarm_from(each.levels, each.below)}") for each, _ in seen
    )
    marks = [
        Points(
            name,
            [row[0] for row, (_, share) in zip(rows, seen, strict=True) if (share >= 1.0) is beyond],
            [min(share, _WIDEST) for _, share in seen if (share >= 1.0) is beyond],
        )
        for name, beyond in (("within", False), ("beyond the threshold", True))
    ]
    panel = Panel("", "", "over the threshold", tuple(marks), (("threshold", 1.0),), sideways=True)
    return Chart(
        "looks",
        "Statistics judged at the end",
        "Statistics of the rules that judge the whole recording once, over the threshold of each. Dashed: threshold.",
        "; ".join(f"{name}: {text}" for name, text in rows) + ".",
        (panel,),
        ("decision", "saw", "", ""),
        tuple((*row, "", "") for row in rows),
    )


def _over_threshold(each: Decided) -> float | None:
    """Ratio of a single evaluation to its threshold, 1 or more for an alarm; None where there was none."""
    if each.statistic or each.reached is None or not each.levels:
        return None
    if each.below:
        return each.levels[0] / max(each.reached, 1e-9)
    return max((each.reached / level for level in each.levels), default=0.0)


def _titled(name: str, label: str, factor: float, limits: list[Limit]) -> str:
    below = all(low and level > 0.0 for level, low in limits)
    limit = alarm_from(tuple(level * factor for level, _ in limits), below)
    return bracketed(words(name), label) + (f", {limit}" if limit else "")


def _strip(
    trace: Trace, per_second: float, factor: float, label: str, limits: list[Limit], axis_name: str
) -> list[dict[str, Any]]:
    """Curve of the statistic, with a red mark over every bin beyond one of the thresholds."""
    # The extremes of each bin are tested, because its mean can hide an exceedance.
    lower, upper = np.asarray(trace.lower, float), np.asarray(trace.upper, float)
    extreme = np.full(len(upper), np.nan)
    for level, low in limits:
        side = lower if low else upper
        extreme = np.where(np.isnan(extreme) & ((side <= level) if low else (side >= level)), side, extreme)
    drawn = strip(trace, per_second, factor, label, axis_name)
    if np.isfinite(extreme).any():
        marks = {"mode": "markers", "marker": {"color": RED, "size": 4}, "hoverinfo": "skip", "yaxis": axis_name}
        marks |= drawn_as("beyond", trace, per_second, factor, limits=[list(each) for each in limits])
        drawn.append(line(centres(trace, per_second), factor * extreme, RED, "alarm", **marks))
    return drawn


def design_charts(diagnosis: Diagnosis) -> list[Chart]:
    """One chart per rule design; rules with the same design share it."""
    drawn: dict[Curve, list[Decided]] = {}
    for each in diagnosis.decisions:
        if each.curve is not None and each.curve.along:
            drawn.setdefault(each.curve, []).append(each)
    return [_design(index, curve, group) for index, (curve, group) in enumerate(drawn.items())]


def _design(index: int, curve: Curve, group: list[Decided]) -> Chart:
    marks: list[Lines | Points] = [Lines("design", curve.along, curve.up)]
    if curve.chosen is not None:
        marks.append(Points("in effect", curve.chosen[:1], curve.chosen[1:]))
    guides = (("in effect", curve.chosen[0]),) if curve.chosen is not None and curve.chance else ()
    meaning = "Probability that one test detects a change of that size" if curve.chance else DELAY
    panel = Panel("", curve.along_title, curve.up_title, tuple(marks), (), guides, not curve.chance, not curve.chance)
    return Chart(
        f"design-{index}",
        f"Rule of: {'; '.join(each.name for each in group)}",
        f"{meaning}. Red: in effect; {group[0].false_alarms}.",
        f"{curve.up_title} over {curve.along_title}.",
        (panel,),
    )
