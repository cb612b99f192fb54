"""Run a matrix of virtual drives and judge them all; compare two such campaigns."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tierod.cli.terminal import (
    Counting,
    command_line,
    counting,
    output,
    print_json,
    print_remark,
    rows,
    say,
    say_where,
    show,
)

if TYPE_CHECKING:
    from tierod.core.content import Item
    from tierod_lab.campaign.campaign import Campaign
    from tierod_lab.campaign.report.running import Outcome
    from tierod_lab.campaign.running import Progress


def campaign(
    file: Annotated[
        str | None, typer.Argument(help="A campaign file, or a shipped one; all are listed if none.")
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for recordings, verdicts, table and report.")
    ] = Path("runs"),
    compare: Annotated[
        tuple[Path, Path] | None, typer.Option(help="Folders of two campaigns, to be compared drive by drive.")
    ] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes; one per core where not given.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, as tcp://host:8786; its workers share the folder.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Check the file; show the matrix and its cost.")] = False,
    summary_only: Annotated[
        bool, typer.Option("--summary-only", help="Write table and report of the finished drives; simulate none.")
    ] = False,
    toml: Annotated[bool, typer.Option("--toml", help="Print the campaign file, to begin one of your own.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> int:
    """Run or resume a campaign: all gates met (0), one missed (1), could not judge (2), bad input (3)."""
    from tierod.core.errors import ParameterError
    from tierod_lab.campaign.campaign import load, shipped

    if compare is not None:
        if file is not None or dry_run or toml or summary_only:
            raise ParameterError("--compare takes two folders and no campaign file; leave the others out")
        return _compare(compare, output, as_json)
    if file is None:
        _list(shipped())
        return 0
    from tierod.work.pool import cores
    from tierod_lab.ground.scenarios.plants import native_code

    chosen = load(file)
    if toml:
        say(chosen.document.text, end="")
        return 0
    for caution in native_code(cell.scenario for cell in chosen.plan.cells):
        print_remark(caution)
    processes = workers or cores()
    if dry_run:
        return _dry(chosen, output, processes, as_json)
    return _run(chosen, output, workers, scheduler, summary_only, as_json)


def _list(names: tuple[str, ...]) -> None:
    from tierod_lab.campaign.campaign import load

    console = output()
    found = [load(name) for name in names]
    cells = [
        (name, each.file.description, str(len(each.plan.cells)), f"{each.hours:.1f}")
        for name, each in zip(names, found, strict=True)
    ]
    console.print(rows(("campaign", "what it is", "drives", "hours"), cells, right=(2, 3)))
    console.print("\nRun one with 'tierod campaign NAME -o runs/'; begin your own with 'tierod campaign NAME --toml'.")


def _dry(chosen: Campaign, folder: Path, processes: int, as_json: bool) -> int:
    import dataclasses

    from tierod.report.display import duration
    from tierod_lab.campaign.campaign import estimate
    from tierod_lab.campaign.store import Store

    cost = estimate(chosen, Store(folder), processes)
    if as_json:
        places = [dict(cell.point.place) for cell in chosen.plan.cells]
        print_json({"name": chosen.file.name, "axes": chosen.axes, "drives": places} | dataclasses.asdict(cost))
        return 0
    console = output()
    console.print(f"{chosen.file.name}: {chosen.file.description}\n", markup=False)
    names = list(chosen.axes)
    console.print(rows(names, [[cell.point.place[name] for name in names] for cell in chosen.plan.cells]))
    labels = "; ".join(judge.label for judge in chosen.plan.judges)
    console.print(
        f"\n{cost.cells} drives, {chosen.hours:.1f} h of driving, judged by {labels}; {cost.missing} of them are still "
        f"to be driven or judged: about {duration(cost.seconds)} on {processes} cores, {cost.bytes / 1e9:.2g} GB",
        markup=False,
    )
    return 0


def _run(
    chosen: Campaign, folder: Path, workers: int | None, scheduler: str | None, summary_only: bool, as_json: bool
) -> int:
    from tierod.core.errors import OutputError
    from tierod.core.processes import stopped_by_sigterm
    from tierod_lab.campaign.report import shown_items
    from tierod_lab.campaign.report.running import campaign as run

    command = command_line()
    if summary_only:
        found = run(chosen, folder, summary_only=True, command=command)
    else:
        total = len(chosen.plan.cells)
        with counting("drives", "compiling", chosen.file.name, total) as count, stopped_by_sigterm():
            try:
                shown = partial(_show_progress, count)
                found = run(chosen, folder, workers, scheduler=scheduler, command=command, progress=shown)
            except (KeyboardInterrupt, OSError, OutputError):
                _say_what_is_kept(chosen, folder)
                raise
    _show(found, shown_items, as_json)
    return found.exit_code


def _say_what_is_kept(chosen: Campaign, folder: Path) -> None:
    from tierod_lab.campaign.store import Store

    if not folder.is_dir():
        return
    store = Store(folder)
    done = sum(chosen.plan.done(cell, store) for cell in chosen.plan.cells)
    print_remark(
        f"{done} of {len(chosen.plan.cells)} drives are finished and kept in {folder}; the same command goes on "
        "from there"
    )


def _show_progress(count: Counting, made: Progress) -> None:
    if made.outcome not in ("", "driven"):
        count.say(f"{made.outcome}: {made.name}")
    count.show(made.done, made.total)


def _show(found: Outcome, items: Callable[[Mapping[str, Any]], Iterator[Item]], as_json: bool) -> None:
    if as_json:
        print_json(found.content)
    else:
        show(items(found.content))
    say_where(as_json, "report", found.page)


def _compare(folders: tuple[Path, Path], target: Path, as_json: bool) -> int:
    from tierod_lab.campaign.comparison import shown_comparison
    from tierod_lab.campaign.report.running import compare

    found = compare(*folders, target, command=command_line())
    _show(found, shown_comparison, as_json)
    return found.exit_code
