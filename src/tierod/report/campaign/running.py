"""Running a campaign, or comparing two, with table, document and page in a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError
from tierod.core.files import write_text
from tierod.experiments import compare as comparing
from tierod.experiments.campaign import Campaign, load
from tierod.experiments.doors import workers_of
from tierod.experiments.running import Progress, run
from tierod.experiments.store import Store
from tierod.experiments.summary import document, summarise, text
from tierod.experiments.table import write_table
from tierod.report.campaign.comparison import render_comparison
from tierod.report.campaign.page import render_campaign


@dataclass(frozen=True)
class Outcome:
    """Outcome of a campaign.

    Args:
        content: everything as data, as it stands in the JSON document
        page: the HTML page
        exit_code: 0 all pass criteria met, 1 one missed, 2 not everything could be judged
    """

    content: Mapping[str, Any]
    page: Path
    exit_code: int = 0


def campaign(
    campaign: Campaign | str | Path,
    folder: str | Path,
    workers: int | None = None,
    *,
    scheduler: str | None = None,
    summary_only: bool = False,
    command: str = "",
    progress: Callable[[Progress], None] = lambda progress: None,
) -> Outcome:
    """Drive and judge what a campaign lacks, and write cells.parquet, campaign.json and report.html.

    Args:
        campaign: a name that `tierod campaign` lists, the path of a campaign file, or a loaded campaign
        folder: of recordings, verdicts and report; one that holds a part of the campaign is gone on with
        workers: processes; one per core where not given
        scheduler: address of a Dask scheduler whose workers drive and judge; they have to reach the folder
        summary_only: write table and report of what is there, and drive nothing
        command: what the user typed, for the report
        progress: called as each drive ends

    Raises:
        ParameterError: no such campaign, one with a slip, or a cluster that cannot be used
        InputError: with `summary_only`, no verdict is there
        OutputError: the folder cannot be written
    """
    chosen = campaign if isinstance(campaign, Campaign) else load(campaign)
    store = Store(Path(folder) if scheduler is None else Path(folder).absolute())
    store.prepare()
    with store.alone():
        if not summary_only:
            run(chosen.plan, store, workers_of(workers, scheduler), progress)
        summary = summarise(chosen, store)
        if summary_only and not any(row.judged for row in summary.rows):
            raise InputError(
                f"{folder} holds no verdict of this campaign as it stands now (file, tierod and its code count); "
                "run it first, without --summary-only"
            )
        content = document(summary, command)
        write_table(summary.rows, store.folder / "cells.parquet")
        write_text(store.folder / "campaign.json", text(content))
        # Last, since it links to the others.
        page = write_text(store.folder / "report.html", render_campaign(content))
    return Outcome(content, page, summary.exit_code)


def compare(first: str | Path, second: str | Path, folder: str | Path, *, command: str = "") -> Outcome:
    """Compare two campaigns drive by drive, and write comparison.json and comparison.html.

    Args:
        first, second: folders of the campaigns
        folder: of the comparison
        command: what the user typed, for the report

    Raises:
        InputError: a folder holds no campaign, or they have no drive in common
    """
    folders, target = (Path(first), Path(second)), Path(folder)
    content = comparing.document(comparing.compare(*folders), folders, command)
    target.mkdir(parents=True, exist_ok=True)
    write_text(target / "comparison.json", text(content))
    return Outcome(content, write_text(target / "comparison.html", render_comparison(content)))
