"""The HTML page of a fleet: list of cars, single cars, cohorts, fleet statistics, and recordings not judged."""

from __future__ import annotations

from pathlib import Path

from tierod.core.files import write_text
from tierod.core.version import __version__
from tierod.fleet import report_words as words
from tierod.fleet.ranking import date
from tierod.fleet.report import FleetReport
from tierod.fleet.report_document import text
from tierod.fleet.report_items import items
from tierod.report.html import Looks, Origin, rendered, sections


def render(report: FleetReport) -> str:
    """The page as HTML text."""
    return rendered(
        "analysis.html.j2",
        Origin(report.created, __version__, report.command),
        sections=sections(list(items(report))),
        looks=Looks(*words.verdict(report)),
        title=words.headline(report),
        summary=words.what_to_do(report),
        remarks=report.remarks,
        kind="fleet",
        facts_of=_facts(report),
    )


def write(report: FleetReport, folder: str | Path) -> tuple[Path, Path]:
    """Write fleet.html and fleet.json into a folder, and return the paths (page, document).

    Raises:
        OutputError: a file cannot be written
    """
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
