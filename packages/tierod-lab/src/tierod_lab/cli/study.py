"""Measure on virtual cars the claims of papers and of tierod, claim by claim."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tierod.core.claims import Claim
    from tierod_lab.studies.effort import Effort
    from tierod_lab.studies.registry import Study


NO_CAUSE = "not known"  # Text in place of the cause if a claim does not hold and no cause is stated
QUICK = "This is of a quick run over a few minutes of driving, and not reliable."  # Note of page and claims


def study(
    name: Annotated[str | None, typer.Argument(help="Which study; every one where not given.")] = None,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", help="Folder for report.html and claims.json; one subfolder each if all run."),
    ] = Path("out"),
    quick: Annotated[
        bool, typer.Option("--quick", help="A few minutes of driving only: a trial, whose figures are not reliable.")
    ] = False,
    processes: Annotated[int | None, typer.Option(min=1, help="Worker processes; one per core.")] = None,
    scheduler: Annotated[str | None, typer.Option(help="Address of a Dask scheduler, as tcp://host:8786.")] = None,
    thorough: Annotated[
        bool,
        typer.Option(
            "--thorough", help="Simulate hours more of driving where rare events are counted; takes up to an hour."
        ),
    ] = False,
) -> int:
    """Run a study: tables and claims to the terminal as Markdown, a page and claims.json to a folder."""
    from tierod.cli.terminal import print_remark
    from tierod.core.errors import ParameterError, nearest
    from tierod_lab.studies.effort import Effort
    from tierod_lab.studies.registry import STUDIES

    if name is not None and name not in STUDIES:
        raise ParameterError(f"there is no study '{name}'{nearest(name, STUDIES)}")
    with Effort(quick, processes, thorough, scheduler=scheduler).kept(_results_folder()) as effort:
        for chosen in STUDIES.values() if name is None else [STUDIES[name]]:
            folder = output / chosen.name if name is None else output
            for path in _run(chosen, effort, folder):
                print_remark(f"written: {path}")
    return 0


def _results_folder() -> Path | None:
    """Folder for the drives of studies, so that an interrupted study resumes; None for a user without a home."""
    from tierod.core.graph.compiler import cache_folder

    try:
        return cache_folder() / "studies"
    except RuntimeError:  # a user without a home folder
        return None


def _run(chosen: Study, effort: Effort, folder: Path) -> list[Path]:
    import sys
    from dataclasses import replace

    from tierod.core.claims import Claim, claims_document
    from tierod.core.content import Item, Table
    from tierod.core.files import write_text
    from tierod.core.version import __version__
    from tierod.report.html import Origin
    from tierod_lab.studies.metrics import Frame
    from tierod_lab.studies.page import StudyPage, render_study

    _require_writable(folder)
    items: list[Item] = []
    written: list[Path] = []
    with _shown_progress(chosen.name) as progress:
        for item in chosen.items(effort, progress):
            if isinstance(item, Frame):
                written += [item.write(folder)] if len(item) else []
                continue
            items.append(item)
            if isinstance(item, Table):
                sys.stdout.write(item.markdown() + "\n")
                sys.stdout.flush()
    claims = [item for item in items if isinstance(item, Claim)]
    _print(claims)
    command = f"tierod study {chosen.name}" + " --quick" * effort.quick + " --thorough" * effort.thorough
    sys.stdout.write(f"\nPrinted by `{command}` of tierod {__version__}\n")
    remark = QUICK if effort.quick else ""
    origin = Origin.now(command)
    page = StudyPage(chosen.name, chosen.title, chosen.summary, chosen.groups, items, origin, remark)
    claims = [replace(claim, note=f"{remark} {claim.note}".strip()) for claim in claims]
    texts = {"report.html": render_study(page), "claims.json": claims_document(claims)}
    return [*written, *(write_text(folder / file, text) for file, text in texts.items())]


def _require_writable(folder: Path) -> None:
    import os

    from tierod.core.errors import OutputError

    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):
        raise OutputError(f"{folder} cannot be written to; check its permissions or name another folder with --output")


@contextmanager
def _shown_progress(name: str) -> Iterator[Callable[[float, str], None]]:
    from tierod.cli.terminal import messages, progress

    last = ""
    with progress(f"study {name}") as advance:

        def advance_to(share: float, what: str) -> None:
            nonlocal last
            if what != last:
                messages().print(f"measuring: {what}", markup=False)
                last = what
            advance(share)

        yield advance_to


def _print(claims: Sequence[Claim]) -> None:
    import sys

    from tierod.core.claims import counted
    from tierod.core.content import Table

    judged = [claim for claim in claims if not claim.describes]
    described = [claim for claim in claims if claim.describes]
    if described:
        rows = [tuple(_cells(claim)[name] for name in ("claim", "printed", "ours", "unit")) for claim in described]
        table = Table(
            "Figures of description", ("figure", "printed", "ours", "unit"), tuple(rows), "Nothing is claimed."
        )
        sys.stdout.write(table.markdown() + "\n")
    derived = ("derived",) * any(claim.derived is not None for claim in judged)
    header = ("claim", "printed", *derived, "ours", "goal", "unit", "holds")
    listed = tuple(tuple(_cells(claim)[name] for name in header) for claim in judged)
    if missed := [claim for claim in judged if claim.met is False]:
        why = tuple((claim.id, _cells(claim)["ours"], str(claim.goal), claim.cause or NO_CAUSE) for claim in missed)
        table = Table("What does not hold, and why", ("claim", "ours", "goal", "cause, and what would mend it"), why)
        sys.stdout.write(table.markdown() + "\n")
    sys.stdout.write(Table("Claims", header, listed, counted(claims)).markdown())


def _cells(claim: Claim) -> dict[str, str]:
    from tierod.core.claims import Outcome
    from tierod.core.shown import written
    from tierod.report.display import number

    holds = {Outcome.HOLDS: "yes", Outcome.FAILS: "**no**", Outcome.IRREPRODUCIBLE: "does not come out"}
    return {
        "claim": claim.id,
        "printed": claim.printed if isinstance(claim.printed, str) else _number_or_nothing(claim.printed),
        "derived": _number_or_nothing(claim.derived),
        "ours": number(claim.figure),
        "goal": "" if claim.goal is None else str(claim.goal),
        "unit": written(claim.unit),
        "holds": holds.get(claim.outcome, "") if claim.outcome else "",
    }


def _number_or_nothing(value: float | None) -> str:
    from tierod.report.display import number

    return "" if value is None else number(value)
