"""Short display of an object, as text for a terminal and as HTML for a notebook."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass

ROWS = 20  # Largest number of table rows that a screen shows
WIDEST = 60  # Largest number of characters of a cell


@dataclass(frozen=True)
class Screen:
    title: str
    lines: tuple[str, ...] = ()  # below it; empty ones are left out
    header: tuple[str, ...] = ()  # header of a table; empty without a table
    rows: Sequence[tuple[str, ...]] = ()  # rows of the table, of which the first `ROWS` are shown

    def text(self) -> str:
        table = [self.header, *self._cells()] if self.rows else []
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        lines = [
            "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
            for row in table
        ]
        return "\n".join([self.title, *(f"  {line}" for line in self._lines()), *lines, *self._rest()])

    def html(self) -> str:
        """The display as HTML for a notebook."""
        parts = [f"<b>{html.escape(self.title)}</b>", *(f"<div>{html.escape(line)}</div>" for line in self._lines())]
        if self.rows:
            head = "".join(f"<th>{html.escape(cell)}</th>" for cell in self.header)
            body = "".join(
                f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in self._cells()
            )
            parts.append(f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")
        return f"<div>{''.join(parts)}{''.join(f'<div>{line}</div>' for line in self._rest())}</div>"

    def _lines(self) -> list[str]:
        return [line for line in self.lines if line]

    def _cells(self) -> list[tuple[str, ...]]:
        return [tuple(_shortened(cell) for cell in row) for row in self.rows[:ROWS]]

    def _rest(self) -> list[str]:
        return [f"  ... and {len(self.rows) - ROWS} more"] if len(self.rows) > ROWS else []


def printable(text: str) -> str:
    """A text with "?" for characters that end a line or move the cursor of a terminal."""
    return "".join(each if each.isprintable() else "?" for each in text)


def _shortened(cell: str) -> str:
    return cell if len(cell) <= WIDEST else f"{cell[: WIDEST - 3]}..."
