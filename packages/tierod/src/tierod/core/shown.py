"""Units for display: angles in degrees, speeds in km/h, a point for a product."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass

DEGREES = 180.0 / math.pi

_SHOWN = {
    "rad": (DEGREES, "°"),
    "rad/s": (DEGREES, "°/s"),
    "rad/s**2": (DEGREES, "°/s²"),
    "m/s": (3.6, "km/h"),
    "count": (1.0, "counts"),
    "percent": (1.0, "%"),
    "": (1.0, ""),
}


def shown(unit: str) -> tuple[float, str]:
    """(factor, label) for the display of a value in this unit: angles in degrees, speeds in km/h."""
    return _SHOWN.get(unit, (1.0, written(unit)))


def written(unit: str) -> str:
    """A unit in the notation for display, which vehicle files and channel maps accept as well: N·m, kg·m²."""
    return unit.replace("**2", "²").replace("**3", "³").replace("**", "^").replace("*", "·")


def counted(number: int, one: str) -> str:
    """A number of things whose plural ends in s: "1 recording", "3 recordings"."""
    return f"{number} {one}{'' if number == 1 else 's'}"


def in_words(value: float, unit: str, digits: int = 3) -> str:
    factor, label = shown(unit)
    return f"{factor * value:z.{digits}g} {label}".rstrip()


def plus_minus(value: float, deviation: float, unit: str = "", signed: bool = False) -> str:
    """A value ± one standard deviation for display, with the label of its unit: "4.01 ± 0.35 N·m".

    Both have the decimals of the first digit of the standard deviation, or of its second where it is below 3.55 of that
    place, as particle physicists round; without one, the value has three digits.
    """
    factor, label = shown(unit)
    value, deviation, sign = factor * value, factor * deviation, "+" if signed else ""
    if not (math.isfinite(deviation) and deviation > 0.0):
        text = f"{value:{sign}z.3g}"
    else:
        decimals = min(max(-math.floor(math.log10(deviation / 3.55)), 0), 9)
        text = f"{value:{sign}z.{decimals}f} ± {deviation:.{decimals}f}"
    return f"{text.replace('-', chr(0x2212))} {label}".rstrip()


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
