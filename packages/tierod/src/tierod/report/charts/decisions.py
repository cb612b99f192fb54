"""Charts of a monitor's decisions: statistics with thresholds over time, and the design curve of each rule."""

from __future__ import annotations

import numpy as np

from tierod.core.content import Bars, Chart, Lines, Panel, Points
from tierod.core.findings import Curve, Decided, Diagnosis
from tierod.core.shown import shown
from tierod.report.charts.figure import Figure, references
from tierod.report.charts.over_time import Limit, strips
from tierod.report.display import alarm_from, bracketed, number, words

_LOOK = ("Statistics of the stopping rules over time. Dashed: thresholds. Red: beyond one.", "With thresholds")
_WIDEST = 10.0  # Largest ratio to the threshold that is drawn
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
            limits = [Limit(level, each.below or level < 0.0) for level in each.levels]
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
    return strips(
        diagnosis, most_relevant(diagnosis), ("decisions", "What was decided on", *_LOOK), statistics(diagnosis)
    )


def quiet_figure(diagnosis: Diagnosis) -> Figure | None:
    said = most_relevant(diagnosis)
    quiet = [name for name in statistics(diagnosis) if name not in said]
    return strips(diagnosis, quiet, ("quiet", "What stayed within its thresholds", *_LOOK), statistics(diagnosis))


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


def histogram_chart(diagnosis: Diagnosis) -> Chart | None:
    """Histograms above each other on a common axis; None without histograms."""
    if not diagnosis.histograms:
        return None
    estimate = diagnosis.findings[0].estimate if diagnosis.findings else None
    factor, label = shown(estimate.unit if estimate else "")
    levels = tuple(references(diagnosis, estimate.unit)) if estimate else ()
    panels, rows = [], []
    for name, (edges, counts) in diagnosis.histograms.items():
        edges, counts = np.asarray(edges, float) * factor, np.asarray(counts, float)
        shares = counts / counts.sum() if counts.sum() > 0.0 else counts
        marks = (Bars("share", edges, shares),)
        panels.append(Panel(words(name), bracketed("estimate", label), "share", marks, uprights=levels))
        rows.append((words(name), *_quantiles(edges, shares, label)))
    return Chart(
        "histograms",
        "Stretch by stretch",
        "Distribution of the estimate in each stretch of the drive (share of its samples). Dashed: its reference "
        "levels.",
        "Histograms of the estimate for each stretch; medians and spreads in the table beneath.",
        tuple(panels),
        ("stretch", "5 % below", "median", "95 % below"),
        tuple(rows),
        shared_axes=True,
    )


def _quantiles(edges: np.ndarray, shares: np.ndarray, label: str) -> tuple[str, ...]:
    if not shares.sum() > 0.0:
        return "–", "–", "–"
    below = np.concatenate(([0.0], np.cumsum(shares)))
    return tuple(f"{number(float(np.interp(at, below, edges)), 3)} {label}".strip() for at in (0.05, 0.5, 0.95))


def loop_chart(diagnosis: Diagnosis) -> Chart | None:
    """Hysteresis loops above each other on common scales; None without loops."""
    if not diagnosis.loops:
        return None
    _, torque_label = shown(str(diagnosis.vehicle.get("torque_unit", "N*m")))
    to_degrees, angle_label = shown("rad")
    titles = (bracketed("steering wheel angle", angle_label), bracketed("torque", torque_label))
    panels, rows = [], []
    for name, (angle, torque) in diagnosis.loops.items():
        angle, torque = np.asarray(angle, float) * to_degrees, np.asarray(torque, float)
        panels.append(Panel(words(name), *titles, (Lines("torque", angle, torque),)))
        half = _half_height(angle, torque, torque_label)
        rows.append((words(name), _range(angle, angle_label), _range(torque, torque_label), half))
    return Chart(
        "loops",
        "Hysteresis",
        "Steering torque over steering wheel angle. Friction opens the loop: half its height in the middle is about "
        "the friction. A closed line means that there was no friction, or that the stroke was too small to show it.",
        f"Torque over angle for {', '.join(map(words, diagnosis.loops))}; sizes in the table beneath.",
        tuple(panels),
        ("loop", "angle", "torque", "half height in the middle"),
        tuple(rows),
        shared_axes=True,
    )


def _range(values: np.ndarray, label: str) -> str:
    seen = values[np.isfinite(values)]
    return f"{number(float(seen.min()), 3)} to {number(float(seen.max()), 3)} {label}" if len(seen) else "–"


def _half_height(angle: np.ndarray, torque: np.ndarray, label: str) -> str:
    """Half the vertical distance between increasing and decreasing angle, in the middle third of the angle range."""
    step = np.gradient(angle) if len(angle) > 1 else np.zeros(len(angle))
    low, high = (np.nanmin(angle), np.nanmax(angle)) if np.isfinite(angle).any() else (0.0, 0.0)
    middle = np.abs(angle - 0.5 * (low + high)) <= (high - low) / 6.0
    there, back = torque[middle & (step > 0.0)], torque[middle & (step < 0.0)]
    if not np.isfinite(there).any() or not np.isfinite(back).any():
        return "–"
    return f"{number(0.5 * float(np.nanmedian(there) - np.nanmedian(back)), 3)} {label}"
