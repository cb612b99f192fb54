"""Design of a detector, for terminal, page and JSON document."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from tierod.core.content import Chart, Lines, Panel, Points, Table
from tierod.core.errors import InputError
from tierod.methods.detectors.rule_design import (
    RULES,
    Designed,
    MeasuredDesign,
    delays_of,
    designed,
    threshold_from_records,
)
from tierod.report.display import duration, number
from tierod.report.html import Analysis


@dataclass(frozen=True)
class Measured:
    records: Sequence[np.ndarray]  # (n,) per recording [unit of the residual]; NaN where missing
    label: str

    @property
    def deviation(self) -> Annotated[float, "unit of the signal"]:
        """Root mean square of all finite residuals; zero where there are none."""
        whole = np.concatenate(self.records)
        return float(np.sqrt(np.nanmean(whole**2))) if np.isfinite(whole).any() else 0.0


def of_white(wish: Wish, rule: str | None = None) -> Analysis:
    change = wish.shift / wish.deviation
    found = {name: designed(name, change, wish.samples, wish.sides) for name in ([rule] if rule else RULES)}
    best = min(found.values(), key=lambda each: each.delay)
    summary = (
        f"For white Gaussian residuals of standard deviation {wish.deviation:g}, with {time_in_words(wish.interval)} "
        f"between false alarms, a shift of {wish.shift:g} is detected soonest by: {best.rule.name}, threshold "
        f"{best.threshold * wish.deviation:.4g}, after {time_in_words(best.delay / wish.rate)} on "
        "average.",
        "Autocorrelated residuals cause far more false alarms; for them, measure the threshold on a fault-free "
        "recording (--residual).",
    )
    rows = [
        {
            "rule": name,
            "constant": each.rule.name,
            "threshold": each.threshold * wish.deviation,
            "delay_s": each.delay / wish.rate,
            "seconds_between_false_alarms": wish.interval,
        }
        for name, each in found.items()
    ]
    items: list[Table | Chart] = [
        rules_beside(wish, found),
        against_false_alarms(wish, found),
        against_shift(wish, found),
    ]
    return Analysis("Design of a detector", summary, items, {"rules": rows})


def of_measured(wish: Wish, rule: str | None, given: Measured) -> Analysis:
    """Threshold measured on fault-free residuals, which may be autocorrelated."""
    deviation = given.deviation
    if not deviation > 0.0:
        raise InputError("the fault-free residual is zero or missing throughout; check --signal")
    wish = replace(wish, deviation=deviation)
    chosen = designed(rule or "cusum", wish.shift / wish.deviation, wish.samples, wish.sides).rule
    found = threshold_from_records(chosen, given.records, wish.samples)
    block = chosen.block(found.threshold, deviation)
    shift = -wish.shift if wish.sides == "lower" else wish.shift
    delays = delays_of(block, given.records, shift) / wish.rate
    document: dict[str, Any] = {
        "rule": chosen.name,
        "threshold": found.threshold * deviation,
        "deviation": deviation,
        "seconds_between_false_alarms": wish.interval,
        "interval_s": [found.low / wish.rate, found.high / wish.rate],
        "extrapolated": found.extrapolated,
        "claim": found.claim(wish.rate),
        "delay_median_s": float(np.quantile(delays, 0.5, method="higher")),
        "delay_p95_s": float(np.quantile(delays, 0.95, method="higher")),
    }
    summary = (
        f"Threshold {document['threshold']:.4g} of the {chosen.name}, measured on {given.label}. Time between false "
        f"alarms: {found.claim(wish.rate)}.",
    )
    return Analysis("Design of a detector", summary, measurement(wish, found, delays.tolist()), document)


@dataclass(frozen=True)
class Wish:
    deviation: Annotated[float, "unit of the signal"]  # standard deviation of the residual [its unit]
    shift: Annotated[float, "unit of the signal"]  # smallest shift to be detected [same unit]
    interval: Annotated[float, "s"]  # mean time between false alarms [s]
    rate: Annotated[float, "Hz"]  # sampling rate of the residual [Hz]
    sides: str = "both"  # direction of the shift: "both", "upper" or "lower"

    @property
    def samples(self) -> float:
        """Mean number of samples between false alarms."""
        return self.interval * self.rate


def rules_beside(wish: Wish, found: Mapping[str, Designed]) -> Table:
    """Comparison of rules for white residuals: thresholds and delays."""
    rows = []
    for name, each in found.items():
        threshold = each.threshold * wish.deviation
        delays = [each.delay_at(scale * wish.shift / wish.deviation) / wish.rate for scale in (1.0, 0.5, 2.0)]
        rows.append((name, each.rule.name, number(threshold), *(time_in_words(delay) for delay in delays)))
    header = ("rule", "with its constant", "threshold", "delay at the shift", "at half of it", "at twice")
    return Table(
        f"Rules with {time_in_words(wish.interval)} between false alarms",
        header,
        tuple(rows),
        "Thresholds in the unit of the residual. Mean delays of a shift that is there from the start on.",
    )


def measurement(wish: Wish, found: MeasuredDesign, delays: Sequence[float]) -> list[Table | Chart]:
    unit = found.deviation
    median, late = (float(np.quantile(delays, share, method="higher")) for share in (0.5, 0.95))
    rows = (
        ("rule", found.rule.name),
        ("threshold", number(found.threshold * unit)),
        ("deviation of the residual", number(found.deviation)),
        ("required time between false alarms", time_in_words(wish.interval)),
        ("claim", found.claim(wish.rate)),
        ("delay, median over injected shifts", time_in_words(median)),
        ("delay, 95 % quantile", time_in_words(late)),
    )
    measured = [point for point in found.points if point.alarms]
    lengths = [point.run_length / wish.rate for point in measured]
    spread = [1.96 / math.sqrt(point.alarms) for point in measured]
    chart = Chart(
        "run-length",
        "Time between false alarms, measured",
        "Each mark is a threshold tried on the fault-free residuals, with the 95 % interval of its count.",
        f"Run length over threshold, from {time_in_words(lengths[0])} to {time_in_words(lengths[-1])}.",
        (
            Panel(
                "",
                "threshold",
                "between false alarms [s]",
                (
                    Points(
                        "measured",
                        [point.threshold * unit for point in measured],
                        lengths,
                        [each * math.exp(-s) for each, s in zip(lengths, spread, strict=True)],
                        [each * math.exp(s) for each, s in zip(lengths, spread, strict=True)],
                    ),
                    Points(
                        "asked for",
                        [found.threshold * unit],
                        [found.wanted / wish.rate],
                        [found.low / wish.rate],
                        [found.high / wish.rate],
                    ),
                ),
                logarithmic=True,
            ),
        ),
    )
    return [Table("Threshold from fault-free residuals", ("what", "figure"), rows), chart]


def against_false_alarms(wish: Wish, found: Mapping[str, Designed]) -> Chart:
    change = wish.shift / wish.deviation * (-1.0 if wish.sides == "lower" else 1.0)
    marks = []
    for name, each in found.items():
        thresholds = [float(share) * each.threshold for share in np.linspace(0.4, 1.0, 9)]
        hours = [each.rule.run_length(threshold) / wish.rate / 3600.0 for threshold in thresholds]
        delays = [each.rule.run_length(threshold, change) / wish.rate for threshold in thresholds]
        marks.append(Lines(name, [hour if math.isfinite(hour) else math.nan for hour in hours], _drawable(delays)))
    return Chart(
        "delay-against-false-alarms",
        "What fewer false alarms cost",
        "Mean delay at the shift, against the time between false alarms, with the constants of the table.",
        "Mean delay of every rule over the time between false alarms.",
        (
            Panel(
                "",
                "between false alarms [h]",
                "mean delay [s]",
                tuple(marks),
                uprights=(("asked for", wish.interval / 3600.0),),
                logarithmic=True,
                logarithmic_along=True,
            ),
        ),
    )


def against_shift(wish: Wish, found: Mapping[str, Designed]) -> Chart:
    scales = np.geomspace(0.25, 4.0, 13)
    marks = [
        Lines(
            name,
            scales * wish.shift,
            _drawable([each.delay_at(float(s) * wish.shift / wish.deviation) / wish.rate for s in scales]),
        )
        for name, each in found.items()
    ]
    return Chart(
        "delay-against-shift",
        "How soon shifts of other sizes are found",
        "Mean delay of the thresholds in the table, against the size of the shift.",
        "Mean delay of every rule over the size of the shift.",
        (
            Panel(
                "",
                "shift, in the unit of the residual",
                "mean delay [s]",
                tuple(marks),
                uprights=(("designed for", wish.shift),),
                logarithmic=True,
            ),
        ),
    )


def _drawable(values: Sequence[float]) -> list[float]:
    return [value if value < 2.6e6 else math.nan for value in values]


def time_in_words(seconds: float) -> str:
    """A time as text; "never" beyond a century."""
    if not math.isfinite(seconds) or seconds > 3.2e9:
        return "never"
    if seconds < 1.0:
        return f"{number(1e3 * seconds, 3)} ms"
    return f"{number(seconds, 3)} s" if seconds < 100.0 else duration(seconds)
