"""Time columns of a table, and the columns that belong to each of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.errors import InputError, nearest
from tierod.core.recording import Channel
from tierod.core.signals import plain
from tierod.core.units import known, scale, split_name, split_suffix
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.source import Column

# The notation of dates to write; DD.MM.YYYY and DD-Mon-YYYY are read too, in others day and month may be confused
DATES = "YYYY-MM-DD hh:mm:ss.fff"

OF_DAY = "hh:mm:ss.fff"  # The only notation of times of a day that is read

_NAMES = (
    "time", "t", "timestamp", "timestamps", "zeit", "time_s", "times", "seconds", "sec", "ts", "date", "datetime",
    "uhrzeit", "heure", "hora", "gpstow", "tow",
)  # fmt: skip

_OF_DATES = ("date", "datum")

# Rate [Hz] below which seconds are doubtful where no unit is given: no recording of a steering system is so slow
SLOWEST = 1.0

USUAL = (5.0, 20e3)  # Range of usual sampling rates [Hz], from coarse telemetry of vehicles to phase currents of motors
FEWEST = 8  # Smallest number of stamps from which a rate is estimated
BLANK = 0.05  # Share of rows, blank between regular samples, from which a column has a rate of its own
REGULAR = 0.8  # Share of steps between samples that are alike in such a column; lost samples at random leave 0.5
LONGER = 1.5  # Ratio of two steps from which they are not alike
DAY, WEEK = 86400.0, 604800.0  # [s]
AS_DATES = (1.95e13, 2.1e13)  # Range of dates as digits yyyymmddhhmmss, in ms since 1970 after the year 2580
DAYS = (3e4, 6e4)  # Range of dates in days since 1900, of the years 1982 to 2064
FASTEST_STEP = 1e-5  # Step below which such stamps are no seconds: no such recording has a rate above 100 kHz [s]
PACKED = "hhmmss"  # Unit of a time of day whose hours, minutes and seconds are digits of one number


@dataclass(frozen=True)
class Clock:
    column: str  # name of the time column
    columns: tuple[str, ...]  # names of the columns whose time it is


def is_time(name: str) -> bool:
    words = [word for word in re.split(r"[^a-z]+", name.lower()) if word]
    return _is_called_time(name) or bool({"time", "timestamp"} & set(words))


def _is_called_time(name: str) -> bool:
    return plain(name) in _NAMES or plain(split_suffix(name)[0]) in _NAMES


def unread_clock(others: Sequence[Column], usable: Sequence[Column]) -> Column | None:
    """The column whose title indicates the time but that cannot be read, where no usable one is as certain.

    Otherwise another column ("lap_time", a counter) would take its place unnoticed. A date beside a time is no clock.
    """
    titles = [column.title or column.name for column in usable]
    clocks = [column for column in others if is_time(column.title or column.name)]
    if any(map(is_time, titles)):
        sure = [column for column in clocks if _is_called_time(column.title or column.name)]
        clocks = (
            [] if any(map(_is_called_time, titles)) else [column for column in sure if plain(column.name) != "date"]
        )
    return clocks[0] if clocks else None


def find_clocks(
    columns: Sequence[Column], increasing: Sequence[str] = (), given: TimeEntry = GUESSED
) -> tuple[Clock, ...]:
    """The clocks of a table: its first time column and every repetition ("time.2"), each for the columns after it."""
    timed = [column for column in columns if is_time(column.title or column.name)]
    # A date beside a time is no clock.
    timed.sort(key=lambda column: plain(column.title or column.name) in _OF_DATES)
    first = _named(given.column, columns) or next(iter(timed), None)
    if first is None:
        first = next((column for column in columns if column.name in increasing), None)
    if first is None and not columns:
        raise InputError("no column holds numbers; export time and signals as numbers")
    if first is None:
        names = ", ".join(f"'{column.name}'" for column in list(columns)[:8])
        raise InputError(
            f"there is no time column (columns: {names}); name one of them 'time', in seconds, or in a "
            'channel map (--map): time = { column = "COLUMN", unit = "ms" }'
        )
    base = _without_number(first)
    clocks: list[tuple[Column, list[str]]] = [(first, [])]
    grouped = _heads_group(columns, columns.index(first))
    for at, column in enumerate(columns):
        if column.name == first.name:
            continue
        own = (is_time(base) or given.column) and _without_number(column) == base
        if own or (grouped and _heads_group(columns, at)):
            clocks.append((column, []))
        else:
            clocks[-1][1].append(column.name)
    return tuple(Clock(column.name, tuple(members)) for column, members in clocks)


def _heads_group(columns: Sequence[Column], at: int) -> bool:
    """Whether a time has the name of the column after it: "Time_Speed" before "Speed"."""
    title = columns[at].title or columns[at].name
    own = plain(re.sub(r"timestamp|time|zeit|(?<![a-z])t(?![a-z])", "", split_suffix(title)[0].lower()))
    following = columns[at + 1] if at + 1 < len(columns) else columns[at]
    return is_time(title.replace("_", " ")) and bool(own) and plain(following.title or following.name).startswith(own)


def _without_number(column: Column) -> str:
    return re.sub(r"[._ ]?\d+$", "", column.title or column.name)


def _named(name: str | None, columns: Sequence[Column]) -> Column | None:
    if name is None:
        return None
    found = [column for column in columns if name in (column.name, column.title)]
    found = found or [column for column in columns if plain(name) in (plain(column.name), plain(column.title))]
    if not found:
        raise InputError(
            f"the channel map names the time column '{name}', but no column of numbers or dates has that name"
            f"{nearest(name, [column.name for column in columns])}"
        )
    return found[0]


def unit_of(column: Column, given: TimeEntry = GUESSED) -> str:
    """The unit of a time column: as the user gives it, the file states it, or its name ends; "" without one."""
    inside = split_name(column.name)[1]
    return given.unit or column.unit or (inside if known(inside) else "") or split_suffix(column.name)[1]


def period_of(clock: str) -> float:
    """Time [s] after which a clock of this name begins anew: the week of satellites, or the day."""
    return WEEK if re.search(r"(^|[^a-z])tow([^a-z]|$)|week", clock.lower()) else DAY


def is_packed(parts: Iterable[np.ndarray]) -> bool:
    """Whether every stamp is a time of day whose digits read hhmmss: seconds would pass through 60 to 99 as well.

    Args:
        parts: the stamps of a clock without a unit, as recorded, part by part
    """
    first = True
    for stamps in parts:
        stamps = stamps[np.isfinite(stamps)]
        if first and len(stamps) and stamps[0] < 1e2:  # a clock that counts from its start
            return False
        first = first and not len(stamps)
        if not ((stamps >= 0.0) & (stamps < 24e4) & (stamps % 1e4 < 6e3) & (stamps % 1e2 < 60.0)).all():
            return False
    return not first


def past_midnight(time: np.ndarray, last: float, period: float = DAY) -> np.ndarray:
    """Times of a day or week [s], (n,), continued past its end from the last one (NaN at first); dates unchanged."""
    there = np.flatnonzero(np.isfinite(time))
    if not len(there) or not (time[there] < period).all():
        return time
    first = [last] if np.isfinite(last) else []
    time = time.copy()
    time[there] = np.unwrap(np.concatenate((first, time[there])), period=period)[len(first) :]
    return time


class OwnRates:
    """Leaves out the blank rows of columns that have samples only in some rows, in regular steps of their own."""

    def __init__(self) -> None:
        self._groups: dict[str, int] | None = None  # of the columns with a rate of their own, by their first piece

    def __call__(self, channels: Sequence[Channel]) -> list[Channel]:
        """The channels of the next piece; those whose samples are in common rows share their stamps."""
        if self._groups is None:
            rows: dict[bytes, int] = {}
            filled = {each.name: np.isfinite(each.values).tobytes() for each in channels if _is_sparse(each)}
            self._groups = {name: rows.setdefault(which, len(rows)) for name, which in filled.items()}
        made = list(channels)
        for group in set(self._groups.values()):
            places = [at for at, each in enumerate(channels) if self._groups.get(each.name) == group]
            kept = np.any([np.isfinite(channels[at].values) for at in places], axis=0)
            time = channels[places[0]].time[kept]
            for at in places:
                made[at] = replace(channels[at], time=time, values=channels[at].values[kept])
        return made


def _is_sparse(channel: Channel) -> bool:
    rows = np.flatnonzero(np.isfinite(channel.values) & np.isfinite(channel.time))
    if len(rows) < FEWEST or len(rows) == len(channel.values):
        return False
    steps, blank = np.diff(channel.time[rows]), np.diff(rows) - 1
    usual = steps < LONGER * np.median(steps)
    regular = usual & (steps > np.median(steps) / LONGER)
    return bool(blank[usual].sum() > BLANK * (rows[-1] - rows[0]) and regular.mean() > REGULAR)


def require_plausible_rate(clocks: Iterable[tuple[str, str, np.ndarray]]) -> None:
    """Refuse time stamps without a unit whose rate is too low in seconds and usual in another unit.

    Args:
        clocks: (column, its unit by `unit_of`, its first stamps as recorded) of all clocks of a table; if one of
            them is fast enough, none is doubtful: the others may belong to slow signals
    """
    doubtful: list[tuple[float, float, str, str]] = []
    for column, unit, stamps in clocks:
        if not unit and len(stamps) and AS_DATES[0] < np.nanmin(stamps, initial=np.inf) < AS_DATES[1]:
            raise InputError(
                f"the time column '{column}' counts to {stamps[0]:.0f}, a date as digits; give seconds, or dates that "
                f"read {DATES}"
            )
        steps = np.diff(stamps[np.isfinite(stamps)])
        steps = steps[steps > 0.0]
        if not unit and len(steps) and DAYS[0] < stamps[0] < DAYS[1] and np.median(steps) < FASTEST_STEP:
            raise InputError(
                f"the time column '{column}' holds days as spreadsheets count them, such as {stamps[0]:.5f}; give "
                f"seconds, or dates that read {DATES}"
            )
        if unit == PACKED:
            return
        if len(steps) < FEWEST - 1:
            continue
        applied, step = unit or _calendar_unit(stamps) or "s", float(np.median(steps))
        rate = 1.0 / (step * scale(applied, "s").factor)
        if rate >= SLOWEST:
            return
        if not unit:
            doubtful.append((rate, step, column, applied))
    for rate, step, column, applied in sorted(doubtful, reverse=True):
        fitting = [
            unit for unit in ("ms", "us", "ns", "s") if USUAL[0] <= 1.0 / (step * scale(unit, "s").factor) <= USUAL[1]
        ]
        if fitting and applied not in fitting:
            raise InputError(_in_doubt(rate, step, column, applied, fitting))


def _in_doubt(rate: float, step: float, column: str, applied: str, fitting: Sequence[str]) -> str:
    usual = " or ".join(f"{1.0 / (step * scale(unit, 's').factor):.3g} Hz in {unit}" for unit in fitting)
    entry = f'time = {{ column = "{column}", unit = "{fitting[0]}" }}'
    return (
        f"the time column '{column}' has no unit; in {applied} its samples come at {rate:.3g} Hz, but at {usual}: call "
        f"it '{column} [{fitting[0]}]', or write {entry} into a channel map (--map); to confirm {applied}, give that "
        "unit"
    )


def seconds(stamps: np.ndarray, unit: str, column: str) -> tuple[np.ndarray, str]:
    """Time stamps in seconds, and the note on a guessed unit."""
    stamps = np.asarray(stamps, dtype=float)
    if unit == PACKED:
        hours, rest = np.divmod(stamps, 1e4)
        return 3600.0 * hours + 60.0 * (rest // 100.0) + rest % 100.0, "time stamps taken as a time of day, hhmmss"
    guess = "" if unit else _calendar_unit(stamps)
    note = f"time stamps taken as {guess} since 1970" if guess else ""
    try:
        return scale(unit or guess or "s", "s")(stamps), note
    except InputError as error:
        raise InputError(f"the time column '{column}': {error}") from None


def _calendar_unit(stamps: np.ndarray) -> str:
    """The unit in which stamps that are too large for seconds (beyond the year 5000) are dates after 1973, or ""."""
    finite = stamps[np.isfinite(stamps)]
    least = float(finite.min()) if len(finite) else 0.0
    return next((unit for limit, unit in ((1e17, "ns"), (1e14, "us"), (1e11, "ms")) if least > limit), "")
