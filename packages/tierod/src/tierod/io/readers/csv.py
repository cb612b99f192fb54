"""Text tables (CSV): any delimiter, decimal comma, vendor headers, units in titles or in a row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.clocks import (
    DATES,
    OF_DAY,
    Clock,
    find_clocks,
    require_plausible_rate,
    seconds,
    unit_of,
    unread_clock,
)
from tierod.io.readers.content import Content
from tierod.io.readers.csv_cells import Rows, Table, calendar, counted, head_of, numbers
from tierod.io.readers.csv_layout import Layout, find_layout
from tierod.io.readers.source import Column, Format, Lane, Piece, Source

DAY = 86400.0  # Length of a day [s]


def open_csv(content: Content, time: TimeEntry = GUESSED) -> Source:
    """A text table.

    Args:
        time: time column as given by a user; ignored in a file that tierod wrote
    """
    path = content.path
    head = head_of(content)
    try:
        layout = find_layout(head)
    except InputError as error:
        raise InputError(f"{path} {error}") from None
    table = counted(content, layout, b"\n" if b"\n" in head else b"\r")
    usable = {*layout.numeric, *layout.dates}
    columns = [column for column in layout.columns if column.name in usable]
    time = GUESSED if "layout" in layout.about else time
    if time.column is None:
        _refuse_text_as_clock(path, layout, columns)
    clocks, units = _clocks(path, columns, _beginning(head, table), time)
    members = tuple(
        column
        for column in columns
        if any(column.name in clock.columns for clock in clocks) and column.name in layout.numeric
    )
    if not members:
        raise InputError(f"{path} holds a time column but no other column of numbers; export it with signals")
    broken: list[str] = []

    def lanes(names: Sequence[str]) -> list[Lane]:
        by_clock = {clock: [name for name in names if name in clock.columns] for clock in clocks}
        wanted = {clock: members for clock, members in by_clock.items() if members}
        found = [
            Lines(
                table,
                clock,
                units[clock.column],
                tuple(each),
                padded=len(clocks) > 1,
                broken=broken if place == 0 else None,
            )
            for place, (clock, each) in enumerate(wanted.items())
        ]
        return [each.pieces() for each in found]

    about = layout.about
    metadata = {**about.get("metadata", {}), "format": "CSV"}
    origin = float(about.get("origin", 0.0))
    return Source(members, lanes, metadata, origin, found=lambda: tuple(broken), texts=tuple(layout.texts))


def _clocks(
    path: Path, columns: Sequence[Column], head: dict[str, np.ndarray], time: TimeEntry
) -> tuple[tuple[Clock, ...], dict[str, str]]:
    """The clocks, and the unit of each, which is "" where none is given."""
    increasing = [name for name, part in head.items() if len(part) > 2 and bool((part[1:] > part[:-1]).all())]
    try:
        clocks = find_clocks(columns, increasing, time)
        by_name = {column.name: column for column in columns}
        units = {clock.column: unit_of(by_name[clock.column], time) for clock in clocks}
        # Only where all clocks are numbers: a date leaves no doubt about the time.
        if all(name in head for name in units):
            require_plausible_rate((name, unit, head[name]) for name, unit in units.items())
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return clocks, units


def _refuse_text_as_clock(path: Path, layout: Layout, usable: Sequence[Column]) -> None:
    clock = unread_clock([column for column in layout.columns if column.name in layout.texts], usable)
    if clock is not None:
        raise InputError(
            f"{path}: the time column '{clock.name}' is written as '{layout.texts[clock.name].strip()[:40]}'; "
            f"give it in seconds, as a date that reads {DATES}, or as a time of day {OF_DAY}"
        )


@dataclass
class Lines:
    """Reads the columns with one clock, block by block."""

    table: Table  # the text table
    clock: Clock  # clock of the columns
    unit: str  # unit of the clock; "" where none is given
    names: tuple[str, ...]  # names of the columns
    padded: bool  # whether rows without a stamp are only padding beside longer columns
    broken: list[str] | None  # list that receives the note on broken lines; None where another reader gives it
    bad: dict[str, int] = field(default_factory=dict)

    def pieces(self) -> Lane:
        """The channels block by block, from the first line to the last."""
        layout = self.table.layout
        columns = {column.name: column for column in layout.columns}
        about = {each["name"]: each for each in layout.about.get("channels", {}).values()}
        guess, lost, done, last = "", 0, 0, np.nan
        impossible, example = 0, ""
        for block in self.table.blocks():
            rows, values = self._read(block)
            lost, done = lost + rows.broken, done + len(block)
            if lost and self.broken is not None:
                self.broken[:] = [f"{lost} of {self.table.lines} lines are broken and were left out"]
            if self.clock.column in layout.dates:
                time, wrong = calendar(rows.table[self.clock.column], self.clock.column)
                impossible, example = impossible + len(wrong), example or "".join(wrong[:1])
                time = _past_midnight(time, last)
                last = time[there[-1]] if len(there := np.flatnonzero(np.isfinite(time))) else last
            else:
                time, found = seconds(values[self.clock.column], self.unit, self.clock.column)
                guess = guess or found
            kept = np.isfinite(time) if self.padded else np.ones(len(time), dtype=bool)
            time = time if kept.all() else time[kept]
            made = []
            for name in self.names:
                entry = about.get(name, {})
                column = values[name] if kept.all() else values[name][kept]
                channel = Channel(
                    name, time, column, columns[name].unit, entry.get("source", name), entry.get("note", "")
                )
                bad = f"{self.bad[name]} cells are not numbers" if self.bad.get(name) else ""
                made.append(channel.noted(guess, bad, self._bad_stamps(impossible, example)))
            yield Piece(made, done / self.table.size)

    def _bad_stamps(self, impossible: int, example: str) -> str:
        """The note on time stamps that are no number, or no date that exists; their rows are left out."""
        if impossible:
            return f"{impossible} time stamps do not exist, such as '{example.strip()[:40]}'"
        bad = self.bad.get(self.clock.column, 0)
        return f"{bad} time stamps are not numbers" if bad else ""

    def _read(self, block: bytes) -> tuple[Rows, dict[str, np.ndarray]]:
        """The rows of a block, and its columns of numbers as floats."""
        names = list(dict.fromkeys([self.clock.column, *self.names]))
        rows, values, bad = numbers(block, self.table, names)
        for name, count in bad.items():
            self.bad[name] = self.bad.get(name, 0) + count
        return rows, values


def _past_midnight(time: np.ndarray, last: float) -> np.ndarray:
    """Times of a day [s], (n,), continued past midnight from the last one (NaN at first); dates unchanged."""
    there = np.flatnonzero(np.isfinite(time))
    if not len(there) or not (time[there] < DAY).all():
        return time
    first = [last] if np.isfinite(last) else []
    time = time.copy()
    time[there] = np.unwrap(np.concatenate((first, time[there])), period=DAY)[len(first) :]
    return time


def _beginning(head: bytes, table: Table) -> dict[str, np.ndarray]:
    part = head[: table.layout.begin + (1 << 16)]
    part = part[: part.rfind(table.end) + 1] if len(part) < len(head) else part
    part = part[table.layout.begin :]
    return numbers(part, table, table.layout.numeric)[1] if part else {}


# It recognises no beginning: any text that is of no other format is read as a text table
FORMAT = Format(
    "csv",
    "CSV (.csv, .txt, .tsv)",
    (".csv", ".txt", ".tsv"),
    open_csv,
    lambda head, ending: False,
    text=True,
)
