"""Requirements on a detector, and the tables and charts of its design."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.content import Chart, Lines, Panel, Points, Table
from tierod.methods.detectors.measured import MeasuredDesign
from tierod.methods.detectors.rule_design import Designed
from tierod.report.display import duration, number


@dataclass(frozen=True)
class Wish:
    """Requirements on a detector.

    Args:
        deviation: standard deviation of the residual [its unit]
        shift: smallest shift to be detected [same unit]
        interval: mean time between false alarms [s]
        rate: sampling rate of the residual [Hz]
        sides: direction of the shift: "both", "upper" or "lower"
    """

    deviation: Annotated[float, "unit of the signal"]
    shift: Annotated[float, "unit of the signal"]
    interval: Annotated[float, "s"]
    rate: Annotated[float, "Hz"]
    sides: str = "both"

    @property
    def samples(self) -> float:
        """Mean number of samples between false alarms."""
        return self.interval * self.rate


def rules_beside(wish: Wish, found: Mapping[str, Designed]) -> Table:
    """Comparison of rules for white residuals: thresholds and delays."""
    rows = []
    for name, each in found.items():
        threshold = each.threshold * each.rule.scale(wish.deviation)
        delays = [each.delay_at(scale * wish.shift / wish.deviation) / wish.rate for scale in (1.0, 0.5, 2.0)]
        rows.append((name, each.rule.name, number(threshold), *(time_in_words(delay) for delay in delays)))
    header = ("rule", "with its constant", "threshold", "delay at the shift", "at half of it", "at twice")
    return Table(
        f"Rules with {time_in_words(wish.interval)} between false alarms",
        header,
        tuple(rows),
        "Thresholds in the unit of the residual, of the sequential test as evidence. Mean delays of a shift that is "
        "there from the start on.",
    )


def measurement(wish: Wish, found: MeasuredDesign, delays: Sequence[float]) -> list[Table | Chart]:
    """Table and chart of a threshold measured on fault-free residuals."""
    unit = found.rule.scale(found.deviation)
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
    """Mean delay of the rules against the time between false alarms, up to the required one."""
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
    """Mean delay of the rules against the size of the shift."""
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
    """Delays with those beyond a month removed from the chart."""
    return [value if value < 2.6e6 else math.nan for value in values]


def time_in_words(seconds: float) -> str:
    """A time as text; "never" beyond a century."""
    if not math.isfinite(seconds) or seconds > 3.2e9:
        return "never"
    if seconds < 1.0:
        return f"{number(1e3 * seconds, 3)} ms"
    return f"{number(seconds, 3)} s" if seconds < 100.0 else duration(seconds)
