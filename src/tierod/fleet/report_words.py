"""Texts and figures on the page of a fleet."""

from __future__ import annotations

import math

from tierod.core.shown import written
from tierod.fleet.ranking import Ranked, date
from tierod.fleet.trends import Trends
from tierod.report.display import INTERVAL, number, share


def odds(logarithm: float) -> str:
    """Odds in words, from their natural logarithm: "12 to 1", "1 to 40"."""
    size = abs(logarithm)
    text = f"{math.exp(size):.2g}" if size < math.log(1e4) else f"10^{size / math.log(10.0):.0f}"
    text = f"{float(text):g}" if "^" not in text else text
    return f"{text} to 1" if logarithm >= 0.0 else f"1 to {text}"


def level(trends: Trends, car: int) -> str:
    """Current level of a car with its 95 % interval and unit."""
    value, deviation = trends.level[car]
    half = INTERVAL * deviation
    return f"{number(value, 3)} ± {number(half, 2)} {written(trends.series.watched.unit)}"


def left(trends: Trends, car: int) -> str:
    """Time left until the limit, with its 90 % interval."""
    early, likely, late = trends.left[car]
    if not math.isfinite(trends.series.limit[car]):
        return "no limit known"
    if likely == 0.0:
        return "reached"
    if not math.isfinite(early):
        return "more than 10 years"
    return f"{days(likely)} ({days(early)} to {days(late)})"


def days(value: float) -> str:
    """A time in days, or in years from one year on; "never" if it is not finite."""
    if not math.isfinite(value):
        return "never"
    return f"{value:.0f} d" if value < 365.0 else f"{value / 365.25:.1f} a"


def cohort(trends: Trends, car: int) -> str:
    """Cohorts of a car that differ from the fleet; a dash if there are none."""
    labels = trends.series.labels
    mine = [each for each in trends.cohorts.differing if labels[each.kind][car] == each.name]
    return "; ".join(f"{each.kind} {each.name}" for each in mine) or "–"


def since(trends: Trends, car: int) -> str:
    """Onset of the change, as an interval."""
    return f"{date(trends.began[car])} ({date(trends.earliest[car])} to {date(trends.latest[car])})"


def headline(cars: int, vehicles: int, judged: int, counts: dict[str, int]) -> str:
    """First line of the page.

    Args:
        cars: number of cars to inspect
        vehicles: number of cars with findings
        judged: number of these with a verdict
        counts: number of cars to inspect by state
    """
    if not vehicles:
        return "There are no findings yet"
    if not (cars or judged):
        return f"No verdict on any of {vehicles} cars"
    if not cars and judged < vehicles:
        return f"No car of the {judged} with a verdict needs a look; {vehicles - judged} gave none"
    if not cars:
        return f"No car of {vehicles} needs a look"
    parts = ", ".join(f"{count} {word}" for word, count in counts.items())
    return f"{cars} of {vehicles} cars to look at: {parts}"


def what_to_do(cars: int, vehicles: int, judged: int) -> tuple[str, ...]:
    """Paragraphs on what the reader should do."""
    if not vehicles:
        return ("What to do: judge recordings with 'tierod fleet RECORDINGS -o RESULTS', then write this page anew.",)
    if cars:
        return ("What to do: call in the cars of the first table from its top; each row names the part to inspect.",)
    if judged < vehicles:
        return (
            "What to do: find out why cars gave no verdict: run 'tierod diagnose' on one of their recordings; its "
            "report shows what the drive, the recording or the vehicle file lacks.",
        )
    return ("What to do: nothing. Judge the next drives with 'tierod fleet', and write this page anew.",)


def shown_chance(trends: Trends, car: int) -> str:
    """Probability that the limit is reached within 90 days; a dash without a limit."""
    chance = float(trends.chance[car])
    return share(chance) if math.isfinite(chance) else "–"


def labels(trends: Trends, car: int) -> str:
    """All cohort labels of a car."""
    return ", ".join(f"{kind} {names[car]}" for kind, names in trends.series.labels.items() if names[car]) or "–"


def first_trend(car: Ranked) -> tuple[Trends, int] | None:
    """Trends, and index of the car in them, of the first reason that rests on a trend; None if there is none."""
    return next((reason.trends for reason in car.reasons if reason.trends is not None), None)


def followed(found: tuple[Trends, int] | None) -> tuple[str, str, str]:
    """(level, time left, cohort) of a car; dashes if no trend is given."""
    return ("–", "–", "–") if found is None else (level(*found), left(*found), cohort(*found))
