"""Mapping of the columns of a file to canonical signals in SI: by the channel map, and by name where there is none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from tierod.core.errors import InputError, nearest
from tierod.core.signals import SIGNALS, Signal, match, plain
from tierod.core.units import COUNT, Scale, scale, split_suffix, tidy
from tierod.io.derive import ingredients
from tierod.io.readers.channel_map import ChannelMap, Entry
from tierod.io.readers.source import Column

TRUTH = "truth_"  # Prefix of the true value of a signal in a simulation; a file may hold such columns, but need not


@dataclass(frozen=True)
class Pick:
    name: str  # canonical name, or that of the column
    columns: tuple[str, ...]  # columns of the file, which are summed
    unit: str  # unit of the channel
    entry: Entry  # sign, factor and offset
    scale: Scale  # conversion from the unit of the columns
    notes: tuple[str, ...] = ()  # notes on guesses and changes
    assumed: bool = False  # whether the file has no unit, so that the canonical one was assumed
    sign_from: str = ""  # column that is not 0 where the sum is that of a negative value


@dataclass(frozen=True)
class Plan:
    picks: tuple[Pick, ...]  # the channels to be made
    warnings: tuple[str, ...] = ()  # warnings about guesses and absent columns
    channel_map: str = ""  # path of the map that was used; "" where none was
    # by signal, a sentence on the column that the map names for it and the file lacks
    lacking: Mapping[str, str] = field(default_factory=dict)

    @property
    def columns(self) -> tuple[str, ...]:
        needed = (name for pick in self.picks for name in (*pick.columns, pick.sign_from))
        return tuple(dict.fromkeys(filter(None, needed)))


def plan(
    columns: Sequence[Column],
    channel_map: ChannelMap | None,
    names: Iterable[str] | None,
    silent: Sequence[str] = (),
) -> Plan:
    """Plan of the columns that become channels."""
    by_name = {column.name: column for column in columns}
    wanted = None if names is None else _wanted(tuple(names), by_name)
    picks, warnings = [], []
    if channel_map and not _fits(channel_map, by_name):
        warnings.append(
            f"{channel_map.path} names no column of this file and is not used: the signals have their names already"
        )
        channel_map = None
    entries = channel_map.entries if channel_map else {}
    lacking = _lacking(channel_map, by_name, silent, wanted) if channel_map else {}
    taken: set[str] = set()
    for name, entry in entries.items():
        if name in lacking:
            if wanted is None or name in wanted:
                warnings.append(_left_out(name, lacking[name]))
            continue
        unheard = [source for source in entry.columns if source in silent and _find(source, by_name) is None]
        if unheard:
            if not entry.optional and (wanted is None or name in wanted):
                warnings.append(f"{name} is not in the recording: {', '.join(unheard)} was never received on the bus")
            continue
        pick = _mapped(name, entry, by_name, channel_map)
        if pick is not None:
            taken.update(pick.columns)
            if wanted is None or name in wanted:
                picks.append(pick)
    guesses, doubles = _guesses(columns, set(entries), taken)
    warnings += [text for name, text in doubles.items() if wanted is None or name in wanted]
    for column in columns:
        found = guesses.get(column.name)
        if wanted is None or (found and found.name in wanted) or column.name in wanted:
            asked = wanted is not None and found is not None and found.name in wanted
            pick, warning = _guessed(column, found, asked)
            raw = wanted is not None and column.name in wanted and column.name not in entries
            if column.name not in taken or raw:
                picks.append(pick)
            warnings.append(warning)
    used = channel_map.path if channel_map else ""
    return Plan(tuple(picks), tuple(filter(None, warnings)), used, lacking)


def _lacking(
    channel_map: ChannelMap, columns: dict[str, Column], silent: Sequence[str], wanted: set[str] | None
) -> dict[str, str]:
    """By signal, a sentence on the column that a map requires for it and the file lacks."""
    there = {source: _find(source, columns) for entry in channel_map.entries.values() for source in entry.columns}
    found = {column.name for column in there.values() if column is not None}
    fits = bool(found) or any(source in silent for source in there)
    free = [name for name in columns if name not in found]
    lacking = {}
    for name, entry in channel_map.entries.items():
        absent = [source for source in entry.columns if there[source] is None and source not in silent]
        if not absent or entry.optional:
            continue
        near = nearest(absent[0], free) if free else "."
        if not fits and (wanted is None or name in wanted):
            where = f"{channel_map.path}: [signals.{name}]"
            raise InputError(f"{where} source '{absent[0]}' is not in the file{near}")
        lacking[name] = f"{channel_map.path} names '{absent[0]}' for {name}, which is not a column of the file{near}"
    return lacking


def _left_out(name: str, why: str) -> str:
    return (
        f"{name} is left out: {why} Correct the map, or write optional = true below [signals.{name}] where recordings "
        "may lack it"
    )


def _fits(channel_map: ChannelMap, columns: dict[str, Column]) -> bool:
    """Whether a map fits a file: it names one of its columns, or no column has the canonical name of its signals."""
    if any(_find(source, columns) for entry in channel_map.entries.values() for source in entry.source):
        return True
    return not any((column.title or column.name) in channel_map.entries for column in columns.values())


def _wanted(names: tuple[str, ...], columns: dict[str, Column]) -> set[str]:
    for name in names:
        # A monitor reads the truth of a simulation by name; recordings of cars have none.
        if name not in columns and name not in SIGNALS and not name.startswith(TRUTH):
            raise InputError(
                f"'{name}' is neither a signal nor a column of the file{nearest(name, [*SIGNALS, *columns])}"
            )
    return set(ingredients(names))


def _mapped(name: str, entry: Entry, columns: dict[str, Column], origin: ChannelMap | None) -> Pick | None:
    where = f"{origin.path if origin else 'the channel map'}: [signals.{name}]"
    sources = []
    for source in entry.source:
        found = _find(source, columns)
        if found is None:
            return None
        sources.append(found)
    bit = _find(entry.sign_from, columns) if entry.sign_from else None
    if entry.sign_from and bit is None:
        return None
    units = dict.fromkeys(source.unit or split_suffix(source.name)[1] for source in sources)
    if entry.unit is None and len(units) > 1:
        raise InputError(f"{where} the units of the sources differ ({', '.join(units)}) and cannot be summed")
    written = next(iter(units)) if entry.unit is None else entry.unit
    try:
        unit, conversion = _conversion(written, SIGNALS[name])
    except InputError as error:
        raise InputError(f"{where} {error}{_after_factor(entry, name)}") from None
    notes = [entry.note, _turned(entry), _raw(unit), f"negative where {bit.name} is not 0" if bit else ""]
    assumed = not written and bool(SIGNALS[name].unit)
    if assumed:
        notes.append(f"unit not given, taken as {unit}")
    read = tuple(column.name for column in sources)
    return Pick(name, read, unit, entry, conversion, tuple(notes), assumed, bit.name if bit else "")


def _after_factor(entry: Entry, name: str) -> str:
    """A half-sentence on a factor that changes the kind of the quantity; "" without a factor."""
    if entry.factor == 1.0:
        return ""
    return (
        f'; the unit is that of sign * factor * source + offset: give unit = "{SIGNALS[name].unit}" '
        "if the result has that unit"
    )


def _find(source: str, columns: dict[str, Column]) -> Column | None:
    if source in columns:
        return columns[source]
    alike = [column for column in columns.values() if plain(source) in (plain(column.name), plain(column.title))]
    return alike[0] if len(alike) == 1 else None


def _guesses(columns: Sequence[Column], mapped: set[str], taken: set[str]) -> tuple[dict[str, Signal], dict[str, str]]:
    """The signal of every recognised column, and by signal a warning where several columns could be it."""
    candidates: dict[str, list[Column]] = {}
    for column in columns:
        found = meant(column)
        if found is not None and found.name not in mapped and column.name not in taken:
            candidates.setdefault(found.name, []).append(column)
    chosen, doubles = {}, {}
    for name, alike in candidates.items():
        best = next((column for column in alike if column.name == name), alike[0])
        chosen[best.name] = SIGNALS[name]
        if len(alike) > 1:
            others = ", ".join(f"'{column.name}'" for column in alike if column is not best)
            doubles[name] = (
                f"{name} is taken from '{best.name}'; {others} could be this signal too: choose one in a channel map"
            )
    return chosen, doubles


def meant(column: Column) -> Signal | None:
    """The signal that name and unit of a column stand for; None where none is known."""
    bare, ending = split_suffix(column.name)
    unit = column.unit or ending
    found = SIGNALS.get(column.name) or match(column.title or column.name, unit, column.qualified)
    return found or match(bare, unit)


def _guessed(column: Column, found: Signal | None, asked: bool) -> tuple[Pick, str]:
    written = column.unit or split_suffix(column.name)[1]
    entry = Entry((column.name,))
    if found is None:
        return _as_found(column, entry, column.unit), ""
    try:
        unit, conversion = _conversion(written, found)
    except InputError as error:
        sentence = f"'{column.name}' could be {found.name}, but {error}: give its unit in a channel map"
        if asked:
            raise InputError(sentence) from None
        return _as_found(column, entry, column.unit), sentence
    notes = [_raw(unit)]
    assumed = not written and bool(found.unit)
    if assumed:
        notes.append(f"unit not given, taken as {unit}")
    return Pick(found.name, (column.name,), unit, entry, conversion, tuple(notes), assumed), ""


def as_recorded(column: Column) -> Pick:
    return _as_found(column, Entry((column.name,)), column.unit)


def _as_found(column: Column, entry: Entry, written: str) -> Pick:
    try:
        return Pick(column.name, (column.name,), tidy(written), entry, Scale(1.0))
    except InputError:
        note = f"the unit '{written}' is not known"
        return Pick(column.name, (column.name,), written.strip(), entry, Scale(1.0), (note,))


def _conversion(written: str, found: Signal) -> tuple[str, Scale]:
    if not written:
        return found.unit, Scale(1.0)
    if tidy(written, found.unit) == COUNT:
        return COUNT, Scale(1.0)
    return found.unit, scale(written, found.unit)


def _raw(unit: str) -> str:
    return "raw counts, not calibrated" if unit == COUNT else ""


def _turned(entry: Entry) -> str:
    parts = ["sign turned" if entry.sign < 0.0 else ""]
    parts.append(f"times {entry.factor:g}" if entry.factor != 1.0 else "")
    parts.append(f"offset {entry.offset:+g} {entry.unit or ''}".strip() if entry.offset else "")
    return ", ".join(part for part in parts if part)
