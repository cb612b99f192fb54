"""Judge the recordings of many vehicles, on all cores or a cluster; report which vehicle to inspect first."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tierod.cli.terminal import Counting, command_line, counting, output, print_json, rows, say_where, show

if TYPE_CHECKING:
    from tierod.fleet.fleet_file import Fleet
    from tierod.fleet.running import Progress, Summary
    from tierod.monitors.runner import Chosen

REPORT = "report"  # Word in place of the recordings that requests the report of a results folder

Recordings = Annotated[
    list[str],
    typer.Argument(
        help="Files, folders, patterns in quotes ('drives/**/*.mf4') or addresses (s3://bucket/2026-11/); or: report "
        "and a results folder."
    ),
]
VehicleName = Annotated[
    str | None, typer.Option(help="One vehicle for all: a name (see 'tierod vehicles') or the path of a TOML file.")
]
FleetPath = Annotated[
    Path | None, typer.Option("--vehicles", help="Fleet file: which recording is of which vehicle and cohort.")
]
Output = Annotated[
    str | None, typer.Option("--output", "-o", help="Results folder or its address; a run that is there is continued.")
]
Monitors = Annotated[
    list[str] | None,
    typer.Option(
        "--monitor",
        help="Monitor, as NAME or NAME:VARIANT; may be given more than once. If not given: all that can run.",
    ),
]
WorkerCount = Annotated[int | None, typer.Option(min=1, help="Processes; one per core where not given.")]
Scheduler = Annotated[str | None, typer.Option(help="Address of a Dask scheduler, as tcp://host:8786.")]
Span = Annotated[
    float | None, typer.Option(min=1.0, help="Of a long recording, also keep a verdict every so many minutes.")
]
Shortest = Annotated[float, typer.Option(min=0.0, help="Recordings that are shorter are skipped [s].")]


def fleet(
    recordings: Recordings,
    vehicle: VehicleName = None,
    vehicles: FleetPath = None,
    output: Output = None,
    monitor: Monitors = None,
    workers: WorkerCount = None,
    scheduler: Scheduler = None,
    span: Span = None,
    shortest: Shortest = 30.0,
    spread: Annotated[
        bool,
        typer.Option(
            help="Include the uncertainty of the parameters in intervals and verdicts; without it, the run "
            "is much faster."
        ),
    ] = True,
    again: Annotated[bool, typer.Option("--again", help="Judge failed recordings again.")] = False,
    levels: Annotated[bool, typer.Option(help="Keep estimates over time, decimated in levels.")] = True,
    prior: Annotated[
        Path | None, typer.Option(help="For report: vehicle file to update with the expected level of a new car.")
    ] = None,
    cohort: Annotated[
        list[str] | None,
        typer.Option(help="For report: cohort of the new car, as KIND=NAME; may be given more than once."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> int:
    """Judge the recordings of a fleet, or resume a run: done (0), nothing could be judged (2), bad input (3)."""
    from tierod.core.errors import ParameterError

    if recordings[0] == REPORT:
        return _report(recordings[1:], output, as_json, prior, cohort or ())
    if output is None:
        raise ParameterError("--output is missing; name the folder or address that takes the results")
    cars = _fleet(vehicle, vehicles)
    chosen = _chosen(monitor or ())
    from tierod.core.processes import stopped_by_sigterm
    from tierod.fleet.judging import Asked
    from tierod.fleet.running import document, run
    from tierod.work.cluster import workers_of

    asked = Asked(chosen, float("inf") if span is None else 60.0 * span, shortest, spread)
    with stopped_by_sigterm(), counting("recordings", "judging") as count:
        try:
            found = run(
                recordings, cars, output, asked, workers_of(workers, scheduler), again=again, with_levels=levels,
                progress=partial(_show_progress, count),
            )  # fmt: skip
        except BaseException:
            if count.total:
                finished = f"{count.done} of {count.total} recording{'s' * (count.total > 1)}"
                kept = f"{finished} {'is' if count.done == 1 else 'are'} finished and kept in {output}"
                count.say(f"{kept}; the same command goes on from there")
            raise
    if as_json:
        print_json(document(found))
    else:
        _show(found)
    return found.exit_code


def _report(given: Sequence[str], output: str | None, as_json: bool, prior: Path | None, cohort: Sequence[str]) -> int:
    """Write page and document of a fleet: no car to inspect (0), some (1), no verdict (2)."""
    from tierod.core.errors import ParameterError

    if len(given) != 1:
        raise ParameterError("'tierod fleet report' takes one results folder; name the one that --output named")
    from tierod.fleet.places import LOCAL, protocol_of
    from tierod.fleet.report import document, report
    from tierod.fleet.report_page import shown_items, write
    from tierod.fleet.statistics import written_prior

    usual = Path(given[0]) if protocol_of(given[0]) == LOCAL else Path()
    found = report(given[0], command=command_line())
    page, _ = write(found, usual if output is None else Path(output))
    if as_json:
        print_json(document(found))
    else:
        show(shown_items(found))
    if prior is not None:
        followed = [(each.series, each.cohorts) for each in found.trends]
        say_where(as_json, "prior", written_prior(followed, prior, cohort))
    say_where(as_json, "report", page)
    return 1 if found.cars else 0 if found.judged else 2


def _fleet(vehicle: str | None, vehicles: Path | None) -> Fleet:
    from tierod.core.errors import ParameterError
    from tierod.fleet import fleet_file
    from tierod.vehicles import load

    if (vehicle is None) == (vehicles is None):
        raise ParameterError("give either --vehicles with a fleet file, or --vehicle with one vehicle for all")
    if vehicles is not None:
        return fleet_file.load(vehicles)
    car = load(vehicle or "")
    return fleet_file.one_vehicle(str(car.path.absolute()) if (vehicle or "").endswith(".toml") else car.name)


def _chosen(names: Sequence[str]) -> tuple[Chosen, ...]:
    from tierod.core.errors import ParameterError
    from tierod.monitors.runner import Chosen, usual

    chosen = tuple(map(Chosen.parse, names)) or usual()
    if len({each.monitor for each in chosen}) < len(chosen):
        raise ParameterError("a monitor is named twice; choose one variant of it")
    return chosen


def _show(found: Summary) -> None:
    from tierod.core.shown import counted
    from tierod.core.statuses import Status
    from tierod.fleet.schema import FAILED, JUDGED, SKIPPED

    console = output()
    counts = found.outcomes
    parts = [f"{counts[each]} {each}" for each in (JUDGED, SKIPPED, FAILED) if counts[each]]
    kept = f", {found.kept} of them before" if found.kept else ""
    recordings = counted(len(found.recordings), "recording")
    console.print(f"{recordings}: {', '.join(parts)}{kept}; {found.hours:.4g} h of driving")
    cells = [
        (monitor, Status(status), str(count))
        for monitor, each in found.statuses.items()
        for status, count in each.items()
    ]
    if cells:
        console.print(rows(("monitor", "status", "findings"), cells, right=(2,)))
    missed = [
        (name, row["outcome"], _why(name, row["reason"]))
        for name in found.recordings
        if (row := found.rows[name])["outcome"] != JUDGED
    ]
    if missed:
        console.print("\n[bold]Not judged[/bold]")
        console.print(rows(("recording", "outcome", "why"), missed[:20]))
        if len(missed) > 20:
            console.print(f"and {len(missed) - 20} more; the ledger names all of them")
    console.print(f"\nresults: {found.results.root}", soft_wrap=True, markup=False)
    console.print(f"'tierod fleet report {shlex.quote(found.results.root)}' shows which vehicle to inspect first",
                  soft_wrap=True, markup=False)  # fmt: skip


def _why(name: str, reason: str) -> str:
    return reason.removeprefix(name).lstrip(": ")


def _show_progress(count: Counting, made: Progress) -> None:
    """Name a failed recording at once, and count the finished ones."""
    if made.outcome == "failed":
        count.say(f"failed: {made.name}: {_why(made.name, made.reason)}")
    count.show(made.done, made.total)
