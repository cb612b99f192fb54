"""Tables and charts of a detector's design."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.detectors.comparison import Designed
from tierod.detectors.measured import MeasuredDesign
from tierod.report.display import duration, number
from tierod.studies.content import Chart, Item, Lines, Panel, Points, Table


@dataclass(frozen=True)
class Wish:
    """What a detector must do.

    Args:
        deviation: of the residual [its unit]
        shift: that must be found [same unit]
        interval: between false alarms [s]
        rate: of the residual [Hz]
        sides: "both", "upper" or "lower"
    """

    deviation: Annotated[float, "unit of the signal"]
    shift: Annotated[float, "unit of the signal"]
    interval: Annotated[float, "s"]
    rate: Annotated[float, "Hz"]
    sides: str = "both"

    @property
    def samples(self) -> float:
        """Between false alarms."""
        return self.interval * self.rate


def of_rules(wish: Wish, found: dict[str, Designed]) -> list[Item]:
    """Rules for white residuals: thresholds, delays, and what each costs.

    Args:
        wish: what was asked for
        found: by the name of the rule
    """
    rows = []
    for name, each in found.items():
        unit = each.threshold if name == "sequential" else each.threshold * wish.deviation
        delays = [each.delay_at(scale * wish.shift / wish.deviation) / wish.rate for scale in (1.0, 0.5, 2.0)]
        rows.append((name, each.rule.name, number(unit), *(_time(delay) for delay in delays)))
    header = ("rule", "with its constant", "threshold", "delay at the shift", "at half of it", "at twice")
    table = Table(
        f"Rules with {_time(wish.interval)} between false alarms",
        header,
        tuple(rows),
        "Thresholds in the unit of the residual, of the sequential test as evidence. Mean delays from the start on.",
    )
    return [table, _against_false_alarms(wish, found), _against_shift(wish, found)]


def of_measurement(wish: Wish, found: MeasuredDesign, delays: Sequence[float]) -> list[Item]:
    """A threshold measured on healthy residuals.

    Args:
        wish: what was asked for
        found: the threshold
        delays: from a shift put into the healthy residuals to the alarm [s]; infinite where it was not found
    """
    unit = 1.0 if "likelihood" in found.rule.name or "sequential" in found.rule.name else found.deviation
    median, late = (float(np.quantile(delays, share)) for share in (0.5, 0.95))
    rows = (
        ("rule", found.rule.name),
        ("threshold", number(found.threshold * unit)),
        ("deviation of the residual", number(found.deviation)),
        ("wanted between false alarms", _time(wish.interval)),
        ("claim", found.claim(wish.rate)),
        ("delay, median of shifts put in", _time(median)),
        ("delay, 95 % of them", _time(late)),
    )
    measured = [point for point in found.points if point.alarms]
    lengths = [point.run_length / wish.rate for point in measured]
    spread = [1.96 / math.sqrt(point.alarms) for point in measured]
    chart = Chart(
        "run-length",
        "Time between false alarms, measured",
        "Each mark is a threshold tried on the healthy residuals, with the 95 % range of its count.",
        f"Run length over threshold, from {_time(lengths[0])} to {_time(lengths[-1])}.",
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
    return [Table("Threshold from healthy residuals", ("what", "figure"), rows), chart]


def _against_false_alarms(wish: Wish, found: dict[str, Designed]) -> Chart:
    change = wish.shift / wish.deviation * (-1.0 if wish.sides == "lower" else 1.0)
    marks = []
    for name, each in found.items():
        thresholds = [float(share) * each.threshold for share in np.linspace(0.4, 1.0, 9)]
        lengths = np.array([each.rule.run_length(threshold) for threshold in thresholds])
        delays = [each.rule.run_length(threshold, change) / wish.rate for threshold in thresholds]
        marks.append(Lines(name, np.log10(lengths / wish.rate / 3600.0), _drawable(delays)))
    return Chart(
        "delay-against-false-alarms",
        "What fewer false alarms cost",
        "Mean delay at the shift, against the time between false alarms, with the constants of the table.",
        "Mean delay of every rule over the time between false alarms.",
        (Panel("", "hours between false alarms, power of ten", "mean delay [s]", tuple(marks), logarithmic=True),),
    )


def _against_shift(wish: Wish, found: dict[str, Designed]) -> Chart:
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
    """Delays of more than a month are not drawn."""
    return [value if value < 2.6e6 else math.nan for value in values]


def _time(seconds: float) -> str:
    if not math.isfinite(seconds) or seconds > 3.2e9:
        return "never"
    if seconds < 1.0:
        return f"{number(1e3 * seconds, 3)} ms"
    return f"{number(seconds, 3)} s" if seconds < 100.0 else duration(seconds)
