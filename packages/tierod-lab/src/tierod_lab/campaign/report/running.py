"""Running a campaign, or comparing two, with table, document and page written to a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError
from tierod.core.files import write_text
from tierod.work.cluster import workers_of
from tierod_lab.campaign import comparison
from tierod_lab.campaign.campaign import Campaign, load
from tierod_lab.campaign.report import render_campaign
from tierod_lab.campaign.running import Progress, run
from tierod_lab.campaign.store import Store
from tierod_lab.campaign.summary import document, summarise, text, write_table


@dataclass(frozen=True)
class Outcome:
    """Result of a campaign or of a comparison."""

    content: Mapping[str, Any]  # content of the JSON document
    page: Path
    exit_code: int = 0  # 0 if all pass criteria are met, 1 if one is missed, 2 if not everything could be judged


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
    """Run the missing drives of a campaign, and write cells.parquet, campaign.json and report.html.

    Args:
        folder: for recordings, verdicts and report; a partly completed campaign in it is continued
        workers: number of processes; None for one per core
        scheduler: address of a Dask scheduler whose workers run the drives; they must have access to the folder
    """
    chosen = campaign if isinstance(campaign, Campaign) else load(campaign)
    # Workers of a cluster have working directories of their own.
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
        # The page is written last, because it links to the other files.
        page = write_text(store.folder / "report.html", render_campaign(content))
    return Outcome(content, page, summary.exit_code)


def compare(first: str | Path, second: str | Path, folder: str | Path, *, command: str = "") -> Outcome:
    """Compare two campaigns drive by drive, and write comparison.json and comparison.html."""
    folders, target = (Path(first), Path(second)), Path(folder)
    content = comparison.document(comparison.compare(*folders), folders, command)
    target.mkdir(parents=True, exist_ok=True)
    write_text(target / "comparison.json", text(content))
    return Outcome(content, write_text(target / "comparison.html", comparison.render_comparison(content)))
