"""One page, one table and one JSON document for several recordings and monitors."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from tierod.core.content import Facts, Item, Table, Verdict
from tierod.core.findings import Diagnosis, Finding, Trace
from tierod.core.statuses import Status, worst
from tierod.monitors.diagnose import ALL, Judged
from tierod.report.charts.decisions import decision_figure, looks_chart
from tierod.report.charts.elements import state_figure
from tierod.report.charts.figure import Figure
from tierod.report.charts.over_time import estimate_figures
from tierod.report.diagnosis import NOTHING_RAN, remarks, verdicts
from tierod.report.display import without_advice
from tierod.report.document import document
from tierod.report.html import Origin, page

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = "tierod.diagnoses/2"  # Name and version of the JSON document


def status_of(judged: Sequence[Judged]) -> Status:
    """Worst status of all; a recording without a verdict counts as not available."""
    # The worst of no diagnosis is "not available".
    return worst(worst(each.status for each in one.diagnoses.values()) for one in judged)


def decisive(judged: Sequence[Judged]) -> Finding | None:
    """The finding that gives the worst status; None where a recording without a verdict does."""
    status = status_of(judged)
    found = (each.decisive for one in judged for each in one.diagnoses.values() if each.status is status)
    return next((each for each in found if each), None)


def verdict_table(judged: Sequence[Judged]) -> Table:
    found = tuple(
        (one.path.name, name, each.status, each.decisive.headline if each.decisive else "")
        for one in judged
        for name, each in one.diagnoses.items()
    )
    return Table("Verdicts", ("recording", "monitor", "verdict", "why"), found)


def answer(judged: Sequence[Judged], console: Console) -> None:
    """Print the answer of all, then the verdicts, to a terminal."""
    from tierod.report.terminal import answer, show

    known, missed = _to_know(judged), sum(len(one.not_run) for one in judged)
    if (finding := decisive(judged)) is not None:
        answer(finding, len(known), console, missed)
    else:
        show([_head(judged)], console)
    without = tuple(each for each in not_run([one for one in judged if not one.diagnoses]) if finding is None)
    table = Table("Monitors that did not run", ("recording", "monitor", "why"), without)
    show([verdict_table(judged), *([table] if without else [])], console)


def tables(judged: Sequence[Judged], narrow: bool = False) -> Iterator[Table]:
    """Verdicts, warnings, and monitors that did not run; `narrow` leaves out the advice of a refusal."""
    yield verdict_table(judged)
    if narrow and (known := _to_know(judged)):
        yield Table("To know", ("recording", "monitor", "what"), tuple(known))
    if missed := not_run(judged):
        rows = tuple((where, name, without_advice(why) if narrow else why) for where, name, why in missed)
        yield Table("Monitors that did not run", ("recording", "monitor", "why"), rows)


def not_run(judged: Sequence[Judged]) -> list[tuple[str, str, str]]:
    """Rows of recordings, monitors and reason, with equal reasons grouped by monitors and by recordings."""
    rows: dict[tuple[str, str], list[str]] = {}
    for one in judged:
        monitors: dict[str, list[str]] = {}
        for monitor, reason in one.not_run:
            monitors.setdefault(reason, []).append(monitor)
        for reason, alike in monitors.items():
            whole = 1 < len(alike) == len(one.not_run) and not one.diagnoses
            rows.setdefault((ALL if whole else ", ".join(alike), reason), []).append(one.path.name)
    return [
        ("all" if len(names) == len(judged) else ", ".join(names), monitors, reason)
        for (monitors, reason), names in rows.items()
    ]


def _to_know(judged: Sequence[Judged]) -> list[tuple[str, str, str]]:
    """Rows of recording, monitors and warning, with equal warnings of several monitors grouped."""
    monitors: dict[tuple[str, str], list[str]] = {}
    for one in judged:
        for name, diagnosis in one.diagnoses.items():
            for warning in dict.fromkeys(each for finding in diagnosis.findings for each in finding.warnings):
                monitors.setdefault((one.path.name, warning), []).append(name)
    return [(where, ", ".join(names), warning) for (where, warning), names in monitors.items()]


def render(judged: Sequence[Judged], origin: Origin) -> str:
    """HTML page of several diagnoses."""
    vehicles = ", ".join(dict.fromkeys(one.vehicle for one in judged))
    head = _head(judged)
    parts: list[Item | Figure] = [head, *tables(judged)]
    parts.append(Facts([("Vehicle", vehicles), ("Recordings", ", ".join(one.path.name for one in judged))]))
    traces: dict[str, Trace] = {}
    for place, one in enumerate(judged):
        for name, each in one.diagnoses.items():
            traces |= {f"{place}-{name}/{key}": trace for key, trace in each.traces.items()}
            parts += _parts(each, one.path.name if len(judged) > 1 else "", f"{place}-{name}")
    return page(parts, origin, head.headline, "diagnosis", traces)


def _head(judged: Sequence[Judged]) -> Verdict:
    found = [each for one in judged for each in one.diagnoses.values()]
    missed = [one.path.name for one in judged if not one.diagnoses]
    status = status_of(judged)
    if (worst_of_all := decisive(judged)) is not None:
        over = f"{len(judged) - len(missed)} recordings" if len(judged) > 1 else "the recording"
        text = [f"The worst of {len(found)} verdicts on {over}."] if len(found) > 1 else []
        text += [f"Not judged: {', '.join(missed)}."] if missed else []
        return Verdict(worst_of_all.headline, status, text=tuple(text))
    if not found:
        return Verdict("No monitor ran on these recordings", status, reasons=(("What to do", NOTHING_RAN),))
    title = f"{len(missed)} of {len(judged)} recordings could not be judged: {', '.join(missed)}"
    return Verdict(title, status, text=("In the others no monitor declares a fault.",))


def _parts(diagnosis: Diagnosis, recording: str, suffix: str) -> Iterator[Item | Figure]:
    """Items of one diagnosis: verdicts, remarks on the data, and charts, whose names and series get a prefix."""
    yield from verdicts(diagnosis, recording)
    yield from remarks(diagnosis)
    charts = (state_figure(diagnosis), *estimate_figures(diagnosis), decision_figure(diagnosis))
    yield from (_apart(each, suffix) for each in charts if each)
    if looks := looks_chart(diagnosis):
        yield replace(looks, name=f"{looks.name}-{suffix}")


def _apart(figure: Figure, suffix: str) -> Figure:
    def own(meta: Mapping[str, Any]) -> dict[str, Any]:
        names = {key: f"{suffix}/{meta[key]}" for key in ("series", "deviation") if key in meta}
        rows = {"rows": [f"{suffix}/{name}" for name in meta["rows"]]} if "rows" in meta else {}
        return {**meta, **names, **rows}

    data = [mark | {"meta": own(mark["meta"])} if "meta" in mark else mark for mark in figure.data]
    return replace(figure, name=f"{figure.name}-{suffix}", data=data)


def to_json(judged: Sequence[Judged], origin: Origin) -> str:
    status = status_of(judged)
    content = {
        "schema": SCHEMA,
        **vars(origin),
        **status.document(),
        "exit_code": status.exit_code,
        "recordings": [
            {
                "path": str(one.path),
                "vehicle": one.vehicle,
                "diagnoses": {name: json.loads(document(each, False)) for name, each in one.diagnoses.items()},
                "not_run": [{"monitor": name, "reason": reason} for name, reason in one.not_run],
            }
            for one in judged
        ],
    }
    return json.dumps(content, ensure_ascii=False, indent=2, allow_nan=False)
