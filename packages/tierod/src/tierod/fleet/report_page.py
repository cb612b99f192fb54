"""The HTML page of a fleet: list of cars, single cars, cohorts, fleet statistics, and recordings not judged."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tierod.core.content import Band, Chart, Facts, Flag, Heading, Item, Lines, Panel, Points, Table, Verdict
from tierod.core.files import write_text
from tierod.core.shown import plus_minus, written
from tierod.core.statuses import Status
from tierod.core.version import __version__
from tierod.fleet import report_words as words
from tierod.fleet.ranking import Ranked, date
from tierod.fleet.report import TIMES, FleetReport, text
from tierod.fleet.trends import Trends
from tierod.report.display import INTERVAL, instant, number
from tierod.report.html import Origin, page

LISTED = 200  # Largest number of cars in the list on the page; the JSON document has all

CARDS = 12  # Number of cars with a section and a chart of their own

DOTS = 1500  # Largest number of cars in a chart of the fleet; of more cars an evenly spaced selection is shown

COHORTS = 15  # Largest number of cohorts in a table and chart


SHOWN = 20  # Largest number of cars in the terminal


def shown_items(report: FleetReport) -> Iterator[Item]:
    """What a terminal shows: the verdict on the fleet, cohorts that differ, and the worst cars with their reasons."""
    yield _head(report)
    cohorts = [
        (f"{each.kind} {each.name} ({each.cars} cars)", f"differs by {effect}, odds {words.odds(each.log_odds)}")
        for trends in report.trends
        for each in trends.cohorts.differing
        if (effect := plus_minus(each.effect, each.deviation, trends.series.watched.unit, signed=True))
    ]
    if cohorts:
        yield Facts(cohorts)
    if worst := report.cars[:SHOWN]:
        rows = ((car.vehicle, car.state, *words.followed(words.first_trend(car))[:2]) for car in worst)
        yield Table("", ("vehicle", "state", "level now (± 1 σ)", "time left (90 %)"), tuple(rows))
        yield Facts([(car.vehicle, car.why) for car in worst])


def _head(report: FleetReport) -> Verdict:
    symbol, colour, state = report.state
    reasons = tuple(("To know", remark) for remark in report.remarks)
    return Verdict(report.title, Flag(state, symbol, colour), (), report.advice, None, reasons)


def items(report: FleetReport) -> Iterator[Item]:
    """All items below the head of the page, in their order."""
    if report.cars:
        yield Heading("Worst first", (_how_often(report),))
        yield _list(report)
    for place, car in enumerate(report.cars[:CARDS]):
        yield from _card(report, car, place)
    for number_of, each in enumerate(report.trends):
        yield from _cohorts(each, number_of)
    for number_of, each in enumerate(report.trends):
        yield from _fleet(each, number_of)
    yield from _recovered(report)
    yield from _ledger(report)


def _how_often(report: FleetReport) -> str:
    design = report.design
    years = f"{design.vehicle_years:,.0f}".replace(",", "\N{NO-BREAK SPACE}")
    return (
        f"'Changed': at most one false alarm in {years} vehicle-years of fault-free cars, however many drives "
        f"were judged. 'Probably changed': on average at most {100.0 * design.discovery_rate:.0f} % of all changed "
        "cars in the list are fault-free. 'Limit soon': the limit is reached within 90 days with a probability of at "
        "least 50 %. 'To confirm': at least one of the last three judged drives is not healthy."
    )


def _list(report: FleetReport) -> Table:
    rows = []
    for place, car in enumerate(report.cars[:LISTED]):
        now, left, cohort = words.followed(words.first_trend(car))
        rows.append((str(place + 1), car.vehicle, car.state, car.why, now, left, cohort, car.inspect))
    more = len(report.cars) - LISTED
    return Table(
        "Cars to look at",
        ("rank", "vehicle", "state", "why", "level now (± 1 σ)", "time left (90 %)", "cohort", "what to do"),
        tuple(rows),
        f"{more} more are in the JSON document." if more > 0 else "",
    )


def _card(report: FleetReport, car: Ranked, place: int) -> Iterator[Item]:
    lines = [f"{reason.text[:1].upper()}{reason.text[1:]}. What to do: {reason.inspect}." for reason in car.reasons]
    found = words.first_trend(car)
    if found is not None:
        trends, number_of = found
        # Only figures that are in no column of the list.
        facts = [f"Change began {words.since(*found)}"] if trends.changed(number_of) else []
        facts.append(f"{'c' if facts else 'C'}hance of the limit within 90 days {words.shown_chance(*found)}")
        facts += [labels] if (labels := words.labels(*found)) != "–" else []
        lines.append(f"{'; '.join(facts)}.")
        yield Heading(f"{place + 1}. {car.vehicle}: {car.state}", tuple(lines))
        yield _trend_chart(trends, number_of, place)
    else:
        yield Heading(f"{place + 1}. {car.vehicle}: {car.state}", tuple(lines))
    yield _drives(report, car)


def _trend_chart(trends: Trends, car: int, place: int) -> Chart:
    series, unit = trends.series, written(trends.series.watched.unit)
    last = float(np.nanmax(series.drives.day))
    day, value, deviation = trends.band(car)
    there = series.drives.present[car]
    along = _rounded(day - last)
    without = ", without sensor gains" if series.shared[car] > 0.0 else ""
    marks = (
        Band(f"95 % of the level{without}", along, value - INTERVAL * deviation, value + INTERVAL * deviation),
        Lines("level at 15 °C", along, value),
        Points("drives", _rounded(series.drives.day[car, there] - last), series.drives.estimate[car, there]),
    )
    known = (("nominal", series.nominal[car]), ("limit", series.limit[car]))
    shown = {"step": trends.stepped(car)}
    if trends.listed[car] or np.isfinite(trends.alarmed[car]):
        shown |= {"alarm": trends.alarmed[car]}
        shown |= {"began": trends.began[car]} if trends.onset(car) != shown["step"] else {}
    panel = Panel(
        series.watched.quantity,
        f"days before {date(last)}",
        f"{series.watched.quantity} [{unit}]",
        marks,
        tuple((name, float(level)) for name, level in known if np.isfinite(level)),
        tuple((name, float(when - last)) for name, when in shown.items() if np.isfinite(when)),
    )
    vehicle = series.vehicles[car]
    return Chart(
        f"trend-{place + 1}",
        f"{series.watched.title}: {vehicle}",
        "Drives as measured; the level at 15 °C is estimated from those since its last step.",
        f"{series.watched.quantity} of {vehicle} over {along[-1] - along[0]:.0f} days, with its level and limit",
        (panel,),
    )


def _rounded(values: np.ndarray) -> np.ndarray:
    return np.round(values, 2)


def _drives(report: FleetReport, car: Ranked) -> Table:
    rows = list(dict.fromkeys(row for reason in car.reasons for row in reason.rows))[:8]
    part = report.findings.select(_OF_DRIVES)
    cells = []
    for row in part.take(rows).to_pylist():
        value, spread = row["estimate"], row["deviation"]
        estimate = "–" if value is None else plus_minus(value, spread or 0.0, row["unit"] or "")
        when = "no date" if row["start"] is None else f"{row['start']:%Y-%m-%d}"
        judged, status = row["judged"] or row["monitor"], Status(row["status"] or Status.NOT_AVAILABLE)
        times = (instant(row[name]) for name in TIMES)
        cells.append((when, row["recording_name"] or "–", judged, status, *times, estimate))
    return Table(
        f"Drives that show it: {car.vehicle}",
        ("date", "recording", "judged", "verdict of the drive", "from", "declared", "to", "estimate (± 1 σ)"),
        tuple(cells),
        "From, declared and to: times in the recording; a fault without an end lasts to the end of the recording.",
    )


_OF_DRIVES = ["start", "recording_name", "monitor", "judged", "status", *TIMES, "estimate", "deviation", "unit"]


def _cohorts(trends: Trends, place: int) -> Iterator[Item]:
    found = trends.cohorts.cohorts
    if found is None or not found.all:
        return
    unit = written(trends.series.watched.unit)
    differing = trends.cohorts.differing
    text = "; ".join(
        f"{each.kind} {each.name}: {plus_minus(each.effect, each.deviation, trends.series.watched.unit, signed=True)}, "
        f"odds {words.odds(each.log_odds)}"
        for each in differing
    )
    yield Heading(f"Cohorts: {trends.series.watched.title}", (text or "No cohort differs from the rest of the fleet.",))
    shown = found.all[:COHORTS]
    rows = tuple(
        (
            f"{each.kind} {each.name}",
            str(each.cars),
            f"{each.effect:+.3g}",
            f"{each.deviation:.2g}",
            words.odds(each.log_odds),
            ", ".join(f"{kind} {name}" for kind, name in each.alike) or "–",
        )
        for each in shown
    )
    note = (
        f"Prior odds of a cohort are 1 to 99. Cars differ by {found.between:.3g} {unit} from each other (one standard "
        f"deviation); the mean is {found.mean:.4g} {unit}. Cohorts of nearly the same cars cannot be separated."
    )
    yield Table(
        f"Cohorts, likeliest first, of {len(found.all)}",
        ("cohort", "cars", f"effect [{unit}]", "± (1 σ)", "odds that it differs", "not separated from"),
        rows,
        note,
    )
    names = [f"{each.kind} {each.name}" for each in shown][::-1]
    effect = np.array([each.effect for each in shown])[::-1]
    half = INTERVAL * np.array([each.deviation for each in shown])[::-1]
    marks = (Points("effect against the rest", names, effect, effect - half, effect + half),)
    panel = Panel("", "", f"effect [{unit}]", marks, (("none", 0.0),), sideways=True)
    yield Chart(
        f"cohorts-{place + 1}", "Effects of cohorts", "With 95 % intervals, shrunk towards no effect.",
        "Effects of the likeliest cohorts against the rest of the fleet", (panel,),
    )  # fmt: skip


def _fleet(trends: Trends, place: int) -> Iterator[Item]:
    series, known = trends.series, trends.learnt
    unit = written(series.watched.unit)
    scatter, wander = known.scatter, known.wander
    rows = (
        ("cars, drives", f"{len(series.vehicles)}, {int(series.drives.present.sum())}"),
        ("deviation from drive to drive beyond the stated one", f"{number(scatter.scatter, 2)} {unit}"),
        ("true error over the stated deviation", number(scatter.scale, 2)),
        ("share of wrong drives", f"{100.0 * scatter.wrong_share:.2g} %"),
        ("change per 10 K", f"{number(10.0 * float(scatter.effects[0]), 2)} {unit}"),
        ("change per 10 000 km", f"{number(float(known.prior.mean[..., 3].mean()), 2)} {unit}"),
        ("random walk of the level in 100 days", f"{number(10.0 * wander.level_walk, 2)} {unit}"),
    )
    yield Heading(f"The fleet: {series.watched.title}", known.remarks)
    yield Table("Learnt from all cars", ("what", "value"), rows)
    if (chart := _mileage_chart(trends, place, unit)) is not None:
        yield chart


def _mileage_chart(trends: Trends, place: int, unit: str) -> Chart | None:
    """Chart of the levels of all cars over mileage; None if fewer than two mileages are known."""
    series = trends.series
    along = 10.0 * (series.mileage + np.nanmax(series.drives.effects[:, :, 1], axis=1))
    known = np.isfinite(along)
    if known.sum() < 2:
        return None
    chosen = np.flatnonzero(known)
    chosen = chosen[np.linspace(0, len(chosen) - 1, min(DOTS, len(chosen))).round().astype(int)]
    changed = trends.listed | np.isfinite(trends.alarmed)
    usual, odd = chosen[~changed[chosen]], np.flatnonzero(known & changed)[:DOTS]
    marks = [Points("fault-free", np.round(along[usual], 1), np.round(trends.level[usual, 0], 4))]
    if len(odd):
        marks.append(Points("changed", np.round(along[odd], 1), np.round(trends.level[odd, 0], 4)))
    limit = float(np.nanmedian(series.limit)) if np.isfinite(series.limit).any() else np.nan
    levels = (("limit", limit),) if np.isfinite(limit) else ()
    panel = Panel("", "mileage [1000 km]", f"level now [{unit}]", tuple(marks), levels)
    return Chart(
        f"fleet-{place + 1}", "Levels of the fleet", f"{len(chosen)} of {int(known.sum())} cars, at 15 °C.",
        f"Level of {series.watched.quantity} over mileage", (panel,),
    )  # fmt: skip


def _recovered(report: FleetReport) -> Iterator[Item]:
    if report.recovered:
        yield Heading("Healthy again")
        rows = tuple(
            (each.vehicle, each.subject, each.history.partition(": ")[2]) for each in report.recovered[:LISTED]
        )
        yield Table("Cars that were not always healthy", ("vehicle", "judged", "history"), rows)


def _ledger(report: FleetReport) -> Iterator[Item]:
    if not report.ledger:
        return
    yield Heading("Recordings that were not judged")
    rows = tuple(
        (row.outcome, str(row.count), row.reason or "–", ", ".join(row.examples)) for row in report.ledger[:50]
    )
    yield Table("Skipped and failed", ("outcome", "recordings", "reason", "such as"), rows)


def render(report: FleetReport) -> str:
    """The page as HTML text."""
    head = _head(report)
    parts = [head, Facts(_facts(report)), *items(report)]
    return page(parts, Origin(report.created, __version__, report.command), head.headline, "fleet")


def write(report: FleetReport, folder: str | Path) -> tuple[Path, Path]:
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    document = write_text(target / "fleet.json", text(report))
    return write_text(target / "fleet.html", render(report)), document


def _facts(report: FleetReport) -> list[tuple[str, str]]:
    facts = [("Vehicles", str(report.vehicles)), ("Vehicles with a verdict", str(report.judged))]
    facts += [(f"Recordings {outcome}", str(count)) for outcome, count in sorted(report.outcomes.items())]
    drives = [each.series.drives.day for each in report.trends]
    finite = [day[day == day] for day in drives]
    if finite and any(len(day) for day in finite):
        first, last = min(float(day.min()) for day in finite), max(float(day.max()) for day in finite)
        facts.append(("Drives from", f"{date(first)} to {date(last)}"))
    facts.append(("Quantities followed", str(len(report.trends))))
    facts.append(("Cohorts that differ", str(sum(len(each.cohorts.differing) for each in report.trends))))
    return facts
