"""Texts and figures on the page of a fleet."""

from __future__ import annotations

import math

from tierod.core.shown import plus_minus
from tierod.fleet.ranking import Ranked, Urgency, date
from tierod.fleet.trends import Trends
from tierod.report.display import share

LOOKS = {
    Urgency.FAULT: ("✕", "bad"),
    Urgency.CONFIRM: ("▲", "watch"),
    Urgency.SOON: ("▲", "bad"),
    Urgency.CHANGED: ("▲", "watch"),
    Urgency.LISTED: ("▲", "watch"),
    Urgency.NEAR: ("▲", "watch"),
}
"""Symbol and appearance of each state."""


BEYOND = "more than 10 years"  # Time until a limit that the extrapolation does not reach


def odds(logarithm: float) -> str:
    """Odds in words, from their natural logarithm: "12 to 1", "1 to 40"."""
    size = abs(logarithm)
    text = f"{math.exp(size):.2g}" if size < math.log(1e4) else f"10^{size / math.log(10.0):.0f}"
    text = f"{float(text):g}" if "^" not in text else text
    return f"{text} to 1" if logarithm >= 0.0 else f"1 to {text}"


def level(trends: Trends, car: int) -> str:
    """Current level of a car ± one standard deviation, which includes what its drives share."""
    included = " (sensor gains included)" if trends.series.shared[car] > 0.0 else ""
    return f"{plus_minus(*trends.stated(car), trends.series.watched.unit)}{included}"


def left(trends: Trends, car: int) -> str:
    """Time left until the limit, with its 90 % interval."""
    early, likely, late = trends.left[car]
    if not math.isfinite(trends.series.limit[car]):
        return "no limit known"
    if trends.reached[car]:
        return "limit reached"
    if math.isnan(likely):
        return "not known yet: too few drives at this level"
    return time_left(early, likely, late)


def time_left(early: float, likely: float, late: float) -> str:
    """Likeliest time until a limit with its 90 % interval, in words."""
    if not math.isfinite(likely):
        return BEYOND + (f", {days(early)} at the earliest" if math.isfinite(early) else "")
    return f"{days(likely)} ({days(early)} to {days(late) if math.isfinite(late) else BEYOND})"


def days(value: float) -> str:
    """A time in days, or in years from one year on."""
    return f"{value:.0f} d" if value < 365.0 else f"{value / 365.25:.1f} a"


def cohort(trends: Trends, car: int) -> str:
    """Cohorts of a car that differ from the fleet; a dash if there are none."""
    labels = trends.series.labels
    mine = [each for each in trends.cohorts.differing if labels[each.kind][car] == each.name]
    return "; ".join(f"{each.kind} {each.name}" for each in mine) or "–"


def since(trends: Trends, car: int) -> str:
    """Onset of the change, with its interval."""
    return f"{date(trends.onset(car))} ({date(trends.earliest[car])} to {date(trends.latest[car])})"


def shown_chance(trends: Trends, car: int) -> str:
    """Probability that the limit is reached within 90 days; a dash without a limit."""
    chance = float(trends.chance[car])
    return "–" if not math.isfinite(chance) else "below 0.1 %" if chance < 1e-3 else share(chance)


def labels(trends: Trends, car: int) -> str:
    return ", ".join(f"{kind} {names[car]}" for kind, names in trends.series.labels.items() if names[car]) or "–"


def first_trend(car: Ranked) -> tuple[Trends, int] | None:
    """Trends, and index of the car in them, of the first reason that rests on a trend; None if there is none."""
    return next((reason.trends for reason in car.reasons if reason.trends is not None), None)


def followed(found: tuple[Trends, int] | None) -> tuple[str, str, str]:
    """(level, time left, cohort) of a car; dashes if no trend is given."""
    return ("–", "–", "–") if found is None else (level(*found), left(*found), cohort(*found))
