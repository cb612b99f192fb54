"""Presentation of a diagnosis: one HTML page, one JSON document, one table in the terminal.

All three use a `tierod.core.findings.Diagnosis` only. The names of its series decide where each one is drawn:

- a trace ``X`` beside a trace ``X_standard_deviation`` is an estimate, drawn with its band, with the reference levels
  of the decisive finding where the units agree; a trace ``true_X`` is drawn as the true value in a simulation;
- a trace ``enabled`` is the share of each bin in which the monitor learnt, a trace ``hands_on`` whether hands were on
  the wheel; both are drawn below the estimate;
- traces that begin with ``innovation``, ``normalised_innovation``, ``nis`` or ``nees`` belong to the consistency;
- traces that are canonical signals show the drive, and all others are further results.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tierod.core.findings import Diagnosis

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["print_table", "to_json", "write_html"]


def write_html(diagnosis: Diagnosis, path: str | Path) -> Path:
    """Write one self-contained page that opens without a network connection and can be printed.

    Args:
        path: of the page; an existing file is replaced
    """
    from tierod.core.files import write_text
    from tierod.report.diagnosis import render

    return write_text(path, render(diagnosis))


def to_json(diagnosis: Diagnosis, series: bool = False) -> str:
    """One JSON document; the schema is in docs/reference/json.md."""
    from tierod.report.document import document

    return document(diagnosis, series)


def print_table(diagnosis: Diagnosis, console: Console, details: bool = True) -> None:
    """Print the verdict to a terminal: with its evidence, or the answer alone in at most ten lines."""
    from tierod.report.diagnosis import shown_items
    from tierod.report.terminal import answer, show

    if details or diagnosis.decisive is None:
        show(shown_items(diagnosis), console)
    else:
        answer(diagnosis.decisive, len(diagnosis.decisive.warnings), console)
