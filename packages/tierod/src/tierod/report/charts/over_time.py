"""Charts over time: estimates with bands and levels, signals of the drive, innovations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from tierod.core.decimation import bin_width, merged
from tierod.core.findings import Diagnosis, Trace
from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.report.charts.figure import (
    BLUE,
    GREEN,
    GREY,
    LABEL_GROUND,
    RED,
    TEXT,
    Figure,
    across,
    axis,
    band,
    centres,
    drawn_as,
    first_range,
    layout,
    level_colour,
    line,
    references,
    strip,
    strip_title,
    summary,
    upright,
)
from tierod.report.display import INTERVAL, alarm_from, bracketed, number, time_scale, words

DEVIATION = "_standard_deviation"
_CONSISTENT = (
    " If the estimator is consistent, the mean NIS is the number of measurements: above its band the estimator is "
    "overconfident, below it underconfident."
)
# Traces from 0 to 1 that are drawn below an estimate: name and explanation
STRIPS = {
    "enabled": ("enabled share", "share of the time in which the estimator was excited (enabled)"),
    "hands_on": ("hands on", "full where hands are on the wheel, half where that is uncertain, else off"),
}

_OF_ELEMENTS = ("state_of_", "supplied_", "deviation_of_supplied_")  # Prefixes of traces that have charts of their own
_INNOVATIONS = ("innovation", "normalised_innovation", "nis", "nees")


class Limit(NamedTuple):
    """A threshold, and whether the rule alarms below it."""

    level: float
    below: bool


def main_names(diagnosis: Diagnosis) -> list[str]:
    """Traces that are estimates: those with a standard deviation."""
    return [name for name in diagnosis.traces if name + DEVIATION in diagnosis.traces]


def estimate_figures(diagnosis: Diagnosis) -> list[Figure]:
    return [_estimate(diagnosis, name) for name in main_names(diagnosis)]


def signal_figure(diagnosis: Diagnosis) -> Figure | None:
    """All recorded signals of the drive, one strip each above a common time axis; None without signals."""
    recorded = [name for name, trace in diagnosis.traces.items() if name in SIGNALS and np.isfinite(trace.mean).any()]
    caption = "Line: mean of each bin. Shading: lowest to highest value: no peak is hidden. Gaps: missing samples."
    names = [name for name in recorded if name not in main_names(diagnosis)]
    return strips(diagnosis, names, ("signals", "The drive", caption, ""))


def result_figure(diagnosis: Diagnosis) -> Figure | None:
    mains = main_names(diagnosis)
    taken = {
        *(each.statistic for each in diagnosis.decisions),
        *(STRIPS if mains else ()),
        *mains,
        *(name + DEVIATION for name in mains),
        *(f"true_{name}" for name in mains),
    }
    others = [name for name in diagnosis.traces if name not in taken and name not in SIGNALS]
    title = "Further results over time" if mains else "Results over time"
    caption = "Line: mean of each bin. Shading: lowest to highest value. Gaps: not known."
    names = [name for name in others if not name.startswith((*_INNOVATIONS, *_OF_ELEMENTS))]
    return strips(diagnosis, names, ("results", title, caption, ""))


def innovation_figure(diagnosis: Diagnosis) -> Figure | None:
    caption = "Measured less predicted, over its own standard deviation (squared: NIS)."
    caption += "" if diagnosis.remarks.get("consistency") else _CONSISTENT
    names = [name for name in diagnosis.traces if name.startswith(_INNOVATIONS)]
    return strips(diagnosis, names, ("innovations", "Innovations over time", caption, ""))


def span(diagnosis: Diagnosis) -> tuple[float, float]:
    """Beginning and end of all traces [s]; the last bin is included completely."""
    known = [trace for trace in diagnosis.traces.values() if len(trace.time)]
    ends = [(float(trace.time[0]), float(trace.time[-1]) + bin_width(trace)) for trace in known]
    return (min(start for start, _ in ends), max(end for _, end in ends)) if ends else (0.0, 1.0)


def _estimate(diagnosis: Diagnosis, name: str) -> Figure:
    trace, deviation = merged(diagnosis.traces[name]), merged(diagnosis.traces[name + DEVIATION])
    factor, label = shown(trace.unit)
    per_second, clock = time_scale(span(diagnosis)[1] - span(diagnosis)[0])
    time, half = centres(trace, per_second), INTERVAL * np.asarray(deviation.mean, float)
    mean, lower, upper = (np.asarray(part, float) * factor for part in (trace.mean, trace.lower, trace.upper))
    half = half * factor
    levels = references(diagnosis, trace.unit)
    strip = next((each for each in STRIPS if each in diagnosis.traces), None)
    apart = drawn_as("interval", trace, per_second, factor, deviation=deviation.name, deviations=INTERVAL)
    within, middle = (drawn_as(part, trace, per_second, factor) for part in ("range", "mean"))
    text = {"hovertemplate": "%{y:.4g} " + label + "<extra>estimate</extra>"}
    data = [
        band(time, mean - half, mean + half, BLUE, opacity=0.2, name="95 % interval", showlegend=True, **apart),
        band(time, lower, upper, BLUE, opacity=0.45, name="lowest to highest", showlegend=False, **within),
        line(time, mean, BLUE, "estimate", **text, **middle),
        *_truth(diagnosis, name, per_second, factor),
        *([_beneath(merged(diagnosis.traces[strip]), per_second)] if strip else []),
    ]
    bottom = 0.16 if strip else 0.0
    top = first_range(mean, upper, mean + half, [value for _, value in levels])
    marks = verdict_marks(diagnosis, per_second)
    return Figure(
        name=f"estimate-{name}",
        title=f"{words(name)} over time",
        caption=_caption(strip, bool(levels)),
        alternative=_alternative(words(name), mean, label, levels),
        data=data,
        layout=layout(
            430,
            hovermode="x unified",
            xaxis=axis(
                f"time [{clock}]", range=[per_second * end for end in span(diagnosis)], anchor="y2" if bottom else "y"
            ),
            yaxis=axis(bracketed(words(name), label), range=top, domain=[bottom, 1.0]),
            yaxis2=axis("", range=[0, 1], domain=[0.0, bottom - 0.06], tickvals=[0, 1], ticktext=["0", "1"])
            if bottom
            else {},
            shapes=[across(value, level_colour(name), 1.3) for name, value in levels] + marks[0],
            annotations=_level_labels(levels, label, top[1] - top[0]) + marks[1],
        ),
        height=430,
        summary=[
            summary(words(name), trace, factor, label),
            summary("95 % interval, half width", _scaled(deviation), factor, label),
        ],
        timed=True,
    )


def _scaled(deviation: Trace) -> Trace:
    parts = (INTERVAL * np.asarray(part, float) for part in (deviation.lower, deviation.upper, deviation.mean))
    return Trace(deviation.name, deviation.unit, deviation.time, *parts)


def _truth(diagnosis: Diagnosis, name: str, per_second: float, factor: float) -> list[dict[str, Any]]:
    truth = diagnosis.traces.get(f"true_{name}")
    if truth is None:
        return []
    truth = merged(truth)
    values = np.asarray(truth.mean, float) * factor
    looks = {"line": {"color": TEXT, "width": 1.6, "dash": "dot"}} | drawn_as("mean", truth, per_second, factor)
    return [line(centres(truth, per_second), values, TEXT, "truth", **looks)]


def _beneath(trace: Trace, per_second: float) -> dict[str, Any]:
    values = np.asarray(trace.mean, float)
    known = np.where(np.isfinite(values), values, 0.0)
    area = {
        "fill": "tozeroy",
        "fillcolor": GREEN,
        "opacity": 0.5,
        "line": {"width": 0.8, "color": GREEN, "shape": "hvh"},
    }
    name = STRIPS[trace.name][0]
    text = {"hovertemplate": f"%{{y:.0%}}<extra>{name}</extra>"} | drawn_as("mean", trace, per_second, absent=0.0)
    return line(centres(trace, per_second), known, GREEN, name, yaxis="y2", **area, **text)


def _level_labels(levels: list[tuple[str, float]], label: str, height: float) -> list[dict[str, Any]]:
    """One label above each level; nearly equal levels share one, and close ones are placed side by side."""
    groups: list[list[tuple[str, float]]] = []
    for name, value in sorted(levels, key=lambda each: each[1]):
        if groups and value - groups[-1][-1][1] < 0.03 * height:
            groups[-1].append((name, value))
        else:
            groups.append([(name, value)])
    labels: list[dict[str, Any]] = []
    for group in groups:
        beside = labels and labels[-1]["x"] > 0.9 and group[-1][1] - labels[-1]["y"] < 0.09 * height
        labels.append(_level_label(group, label) | {"x": 0.5 if beside else 0.995})
    return labels


def _level_label(group: list[tuple[str, float]], label: str) -> dict[str, Any]:
    text = ", ".join(f"{words(name).lower()} {number(value, 3)}" for name, value in group)
    name, value = group[-1]
    place = {"xref": "paper", "xanchor": "right", "y": value, "yanchor": "bottom", "showarrow": False}
    looks = {"font": {"color": level_colour(name), "size": 12}, "bgcolor": LABEL_GROUND, "borderpad": 2}
    return {"text": f"{text} {label}"} | place | looks


def verdict_marks(
    diagnosis: Diagnosis, per_second: float, top: float = 0.99
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Lines and labels at onset and end of the change that led to the verdict and at the alarm, where known."""
    finding = diagnosis.findings[0] if diagnosis.findings else None
    if finding is None:
        return [], []
    passed = [
        each.passed for each in diagnosis.decisions if each.name in finding.decided_by and each.passed is not None
    ]
    first, last = span(diagnosis)
    began, alarm = finding.since, min(passed, default=finding.declared)
    moments = {"change began": began, "alarm": alarm}
    if began is not None and alarm is not None and abs(alarm - began) < 2e-3 * (last - first):
        moments = {"change began, alarm": alarm}
    moments["ended"] = finding.end
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    for name, moment in moments.items():
        if moment is None:
            continue
        at = moment * per_second
        shapes.append(upright(at, RED, 1.3, "dot" if name == "change began" else "solid"))
        # Both may be close together: the first label is placed on the left of its line, the second on the right.
        share = (moment - first) / (last - first)
        left = share > 0.85 or (name == "change began" and share > 0.15)
        side = "right" if left else "left"
        looks = {"showarrow": False, "xanchor": side, "font": {"color": RED, "size": 12}}
        place = {"text": name, "x": at, "yref": "paper", "y": top, "yanchor": "top", "xshift": -4 if left else 4}
        beneath = {"yshift": -18 * sum(each["xanchor"] == side for each in notes)}
        notes.append(place | looks | beneath | {"bgcolor": LABEL_GROUND})
    return shapes, notes


def _caption(strip: str | None, levels: bool) -> str:
    parts = ["Line: estimate. Light shading: 95 % interval."]
    if levels:
        parts.append("Dashed: its reference levels.")
    if strip:
        parts.append(f"Green strip beneath: {STRIPS[strip][1]}.")
    return " ".join(parts)


def _alternative(title: str, mean: np.ndarray, label: str, levels: list[tuple[str, float]]) -> str:
    seen = mean[np.isfinite(mean)]
    if not len(seen):
        return f"{title}: no value in the whole recording."
    judged = ", ".join(f"{words(name).lower()} {number(value, 3)} {label}" for name, value in levels)
    text = f"{title} begins at {number(float(seen[0]), 3)} {label}, ends at {number(float(seen[-1]), 3)} {label}"
    return text + (f"; levels: {judged}." if judged else ".")


def strips(
    diagnosis: Diagnosis,
    names: list[str],
    look: tuple[str, str, str, str],
    limits: Mapping[str, Sequence[Limit]] | None = None,
) -> Figure | None:
    """Traces above each other over a common time axis; None where there are none.

    Args:
        limits: thresholds of each trace; where given, bins beyond them and the times of the verdict are marked
    """
    if not names:
        return None
    first, last = span(diagnosis)
    per_second, clock = time_scale(last - first)
    each_height, above = (110, {}) if limits is None else (130, limits)
    height = each_height * len(names) + 70
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    shapes, notes = ([], []) if limits is None else verdict_marks(diagnosis, per_second, 1.0 - 30.0 / height)
    rows = []
    for index, each in enumerate(names):
        trace = merged(diagnosis.traces[each])
        factor, label = shown(trace.unit)
        place = f"y{'' if index == 0 else index + 1}"
        domain = [1.0 - (index + 1) / len(names), 1.0 - index / len(names) - 26.0 / height]
        axes[place.replace("y", "yaxis")] = axis("", domain=domain, nticks=4)
        data += [
            *strip(trace, per_second, factor, label, place),
            *_beyond(trace, per_second, factor, above.get(each, ()), place),
        ]
        edges = (-INTERVAL, INTERVAL) if each.startswith("normalised_innovation") else ()
        shapes += [across(edge, GREY, 1, yref=place) for edge in edges]
        shapes += [across(limit.level * factor, RED, 1.2, yref=place) for limit in above.get(each, ())]
        alarms = alarm_from(tuple(limit.level * factor for limit in above.get(each, ())), _lower(above.get(each, ())))
        notes.append(strip_title(", ".join(filter(None, (bracketed(words(each), label), alarms))), domain[1]))
        rows.append(summary(words(each), trace, factor, label))
    axes["xaxis"] = axis(f"time [{clock}]", range=[per_second * first, per_second * last], anchor=place)
    name, title, caption, alternative = look
    return Figure(
        name=name,
        title=title,
        caption=caption,
        alternative=f"{alternative or title}: {', '.join(map(words, names))} over time; ranges in the table beneath.",
        data=data,
        layout=layout(height, hovermode="x", showlegend=False, shapes=shapes, annotations=notes, **axes),
        height=height,
        summary=rows,
        timed=True,
    )


def _lower(limits: Sequence[Limit]) -> bool:
    return bool(limits) and all(limit.below and limit.level > 0.0 for limit in limits)


def _beyond(
    trace: Trace, per_second: float, factor: float, limits: Sequence[Limit], place: str
) -> list[dict[str, Any]]:
    # The extremes of each bin are tested, because its mean can hide an exceedance.
    lower, upper = np.asarray(trace.lower, float), np.asarray(trace.upper, float)
    extreme = np.full(len(upper), np.nan)
    for level, low in limits:
        side = lower if low else upper
        extreme = np.where(np.isnan(extreme) & ((side <= level) if low else (side >= level)), side, extreme)
    if not np.isfinite(extreme).any():
        return []
    marks = {"mode": "markers", "marker": {"color": RED, "size": 4}, "hoverinfo": "skip", "yaxis": place}
    marks |= drawn_as("beyond", trace, per_second, factor, limits=[list(each) for each in limits])
    return [line(centres(trace, per_second), factor * extreme, RED, "alarm", **marks)]
