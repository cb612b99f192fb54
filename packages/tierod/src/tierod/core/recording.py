"""Recordings: named channels with units, each with its own time stamps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from tierod.core import frames
from tierod.core.errors import InputError, nearest
from tierod.core.series import Order, finite_or_missing, infinite_note, order, paced
from tierod.core.shown import Screen

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow as pa
    import xarray


Method = Literal["hold", "linear"]

# Largest number of grid points: a month at 100 Hz. A longer grid spans a step of the clock and exhausts the memory.
MOST_SAMPLES = 300_000_000

FREE_SAMPLES = 4_000_000  # Number of grid points that is always allowed: eleven hours at 100 Hz

# Largest number of points of a longer grid per sample of the densest channel: 1 kHz for telemetry of 10 Hz
MOST_PER_SAMPLE = 100


@dataclass(frozen=True)
class Channel:
    """One signal over time."""

    name: str  # canonical name, or the name in the source where it has none
    time: np.ndarray  # time stamps [s], shape (n,), not decreasing
    values: np.ndarray  # shape (n,); NaN where a sample is missing
    unit: str  # in the notation of pint; "" for a number, "count" for a raw count
    source: str = ""  # origin: message and signal, column or group
    note: str = ""  # changes made to it (sign, offset, guess of a unit)

    def noted(self, *notes: str) -> Channel:
        """The channel with notes added; empty ones and repetitions are left out."""
        if not any(notes):
            return self
        parts = [part for part in self.note.split("; ") if part]
        parts += [note for note in notes if note and note not in parts]
        return replace(self, note="; ".join(parts))

    def sliced(self, start: float, stop: float) -> Channel:
        """The samples with start <= time < stop [s]."""
        first, last = np.searchsorted(self.time, (start, stop), side="left")
        return replace(self, time=self.time[first:last], values=self.values[first:last])


def checked(channel: Channel, put: Order | None = None) -> Channel:
    """A recorded channel made usable: stamps finite, not decreasing; values finite or missing; repairs noted."""
    time, values = np.asarray(channel.time), np.asarray(channel.values)
    if time.shape != values.shape or time.ndim != 1:
        raise InputError(
            f"channel '{channel.name}' needs as many time stamps as values, not {time.shape} and {values.shape}"
        )
    put = put or order(time, f"'{channel.name}'")
    values, infinite = finite_or_missing(put(values))
    return replace(channel, time=put.time, values=values).noted(*put.notes, infinite_note(infinite))


def checked_together(channels: Iterable[Channel]) -> list[Channel]:
    """Channels made usable; time stamps that several channels share are checked once and stay shared."""
    orders: dict[int, Order] = {}
    fit = []
    for channel in channels:
        put = orders.get(id(channel.time))
        if put is None:
            put = orders[id(channel.time)] = order(channel.time, f"'{channel.name}'")
        fit.append(checked(channel, put))
    return fit


@dataclass(frozen=True)
class Aligned:
    time: np.ndarray  # uniform grid [s], shape (n,)
    values: np.ndarray  # shape (n, signals); NaN where a signal is missing or older than allowed
    names: tuple[str, ...]  # the signals, in the order of the columns

    @cached_property
    def columns(self) -> Mapping[str, np.ndarray]:
        """The signals by name, (n,) each, as contiguous copies, since a column of the table is slow to read."""
        return dict(zip(self.names, np.ascontiguousarray(self.values.T), strict=True))

    @cached_property
    def there(self) -> Mapping[str, np.ndarray]:
        """Whether each signal has a finite value, by name, (n,) each."""
        return dict(zip(self.names, np.ascontiguousarray(np.isfinite(self.values).T), strict=True))


@dataclass(frozen=True)
class Recording:
    """Channels by name, and metadata of the recording as a whole."""

    channels: Mapping[str, Channel]
    metadata: Mapping[str, Any] = field(default_factory=dict)  # origin of the file, start time, bus, comments

    def __getitem__(self, name: str) -> Channel:
        try:
            return self.channels[name]
        except KeyError:
            raise InputError(f"the recording has no channel '{name}'{nearest(name, self.channels)}") from None

    def __contains__(self, name: object) -> bool:
        return name in self.channels

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    @property
    def span(self) -> tuple[float, float]:
        """First and last time stamp of all channels [s]."""
        times = [channel.time for channel in self.channels.values() if len(channel.time)]
        if not times:
            raise InputError("the recording holds no samples; check that the file is whole and the channel map fits it")
        return float(min(time[0] for time in times)), float(max(time[-1] for time in times))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings for a reader of results: guessed units, repaired time stamps, lost parts of the file."""
        return tuple(self.metadata.get("warnings", ()))

    def warned(self, *warnings: str) -> Recording:
        together = tuple(dict.fromkeys((*self.warnings, *(warning for warning in warnings if warning))))
        return replace(self, metadata={**self.metadata, "warnings": together})

    def with_channels(self, channels: Iterable[Channel]) -> Recording:
        """The recording with channels added, or replaced where the name exists; they are checked first."""
        return replace(
            self, channels={**self.channels, **{channel.name: channel for channel in checked_together(channels)}}
        )

    def screen(self) -> Screen:
        """Display of the recording in a terminal or a notebook."""
        channels = list(self.channels.values())
        lengths = [float(each.time[-1] - each.time[0]) for each in channels if len(each.time)]
        span = f", {max(lengths):.6g} s" if lengths else ""
        return Screen(
            f"Recording {self.metadata.get('path', '')}".rstrip() + f": {len(channels)} channels{span}",
            self.warnings[:3],
            ("channel", "unit", "samples", "lowest", "highest"),
            [(each.name, each.unit, str(len(each.values)), *_extremes(each.values)) for each in channels],
        )

    def __repr__(self) -> str:
        return self.screen().text()

    def _repr_html_(self) -> str:
        return self.screen().html()

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The recording as a stream of the Arrow PyCapsule interface, for any library that reads one."""
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def to_arrow(self) -> pa.Table:
        """A pyarrow Table over all time stamps; null where a channel has no sample, NaN where its sample is missing."""
        return frames.to_arrow(self._columns())

    def to_pandas(self) -> pandas.DataFrame:
        """A pandas DataFrame over all time stamps [s]; NaN where a channel has no sample or a missing one."""
        return frames.to_pandas(self._columns())

    def to_polars(self) -> polars.DataFrame:
        """A Polars DataFrame with a column "time" [s]; null where a channel has no sample."""
        return frames.to_polars(self._columns())

    def to_xarray(self) -> xarray.Dataset:
        """An xarray Dataset over "time" [s]; unit, source and note are attributes of its variables."""
        return frames.to_xarray(self._columns())

    @classmethod
    def from_arrow(cls, table: object, time: str = frames.TIME, units: Mapping[str, str] | None = None) -> Recording:
        """The recording in any table with the Arrow PyCapsule interface (pyarrow, Polars, pandas, DuckDB).

        Args:
            table: a column of time stamps and one of numbers for every channel; a null is no sample
            time: name of the time column [s]
            units: by channel; those of the table where not given. Names and units are those of
                `tierod.core.signals`
        """
        return cls({})._with(frames.from_arrow(table, time, units))

    @classmethod
    def from_polars(
        cls, frame: polars.DataFrame, time: str = frames.TIME, units: Mapping[str, str] | None = None
    ) -> Recording:
        """The recording in a Polars DataFrame; arguments and errors as for `from_arrow`."""
        return cls.from_arrow(frame, time, units)

    @classmethod
    def from_pandas(
        cls, frame: pandas.DataFrame, units: Mapping[str, str] | None = None, sparse: bool | None = None
    ) -> Recording:
        """The recording in a pandas DataFrame whose index, or column "time", is the time.

        Args:
            frame: data frame of numbers; NaN is a missing sample
            units: by channel; those that `to_pandas` stored where not given
            sparse: whether NaN means that there is no sample, as in joined channels of different rates
        """
        return cls({})._with(frames.from_pandas(frame, units, sparse))

    @classmethod
    def from_xarray(
        cls, data: xarray.Dataset, units: Mapping[str, str] | None = None, sparse: bool | None = None
    ) -> Recording:
        """The recording in an xarray Dataset over "time"; arguments as for `from_pandas`."""
        return cls({})._with(frames.from_xarray(data, units, sparse))

    def _columns(self) -> list[frames.Column]:
        return [
            frames.Column(*(getattr(each, name) for name in frames.Column._fields)) for each in self.channels.values()
        ]

    def _with(self, columns: Iterable[frames.Column]) -> Recording:
        return self.with_channels(Channel(*column) for column in columns)

    def slice(self, start: float = float("-inf"), stop: float = float("inf")) -> Recording:
        """The samples of all channels with start <= time < stop [s]; time stamps stay as they are."""
        cuts: dict[int, tuple[np.ndarray, slice]] = {}
        channels = {}
        for name, each in self.channels.items():
            cut = cuts.get(id(each.time))
            if cut is None:
                first, last = np.searchsorted(each.time, (start, stop), side="left").tolist()
                cut = cuts[id(each.time)] = each.time[first:last], slice(first, last)
            channels[name] = Channel(each.name, cut[0], each.values[cut[1]], each.unit, each.source, each.note)
        return replace(self, channels=channels)

    def retime(self, period: float, names: Iterable[str] | None = None) -> Recording:
        """The recording with the sending times of channels that were delivered in bursts.

        Args:
            period: sampling interval of the sender [s]
            names: the channels; all where not given
        """
        note = f"time stamps regenerated, {1e3 * period:g} ms apart"
        again = [replace(self[name], time=paced(self[name].time, period)).noted(note) for name in names or self.names]
        return replace(self, channels={**self.channels, **{channel.name: channel for channel in again}})

    def require_grid(self, rate: float, first: float, count: int) -> None:
        """Check that a grid is not much longer than the recording, before memory is taken for it.

        Args:
            rate: sampling rate of the grid [Hz]
            first: its first time [s]
        """
        densest = max((len(channel.time) for channel in self.channels.values()), default=0)
        if count > min(MOST_SAMPLES, max(FREE_SAMPLES, MOST_PER_SAMPLE * densest)):
            raise InputError(
                f"a grid of {rate:g} Hz from {first:.6g} s to {first + count / rate:.6g} s is too long: does a clock "
                "jump ahead, or count milliseconds? Cut the recording there, or give start and stop"
            )

    def align(
        self,
        names: Iterable[str],
        rate: float,
        method: Method = "hold",
        maximum_age: float = 0.1,
        start: float | None = None,
        stop: float | None = None,
    ) -> Aligned:
        """The named signals on a uniform grid; gaps stay visible as NaN.

        Args:
            names: canonical names, which become the columns in this order; a channel that is absent becomes NaN
            rate: sampling rate of the grid [Hz]
            maximum_age: a value older than this [s] is missing
            start: first time of the grid [s]; the recording's own where not given
            stop: the grid ends before this time [s]; the recording's own end (inclusive) where not given
        """
        if not rate > 0.0 or not maximum_age > 0.0:
            raise InputError(f"alignment needs a positive rate and maximum age, not {rate} Hz and {maximum_age} s")
        first, last = self.span
        first = first if start is None else start
        count = (
            int(np.floor((last - first) * rate + 1e-6)) + 1
            if stop is None
            else int(np.ceil((stop - first) * rate - 1e-6))
        )
        self.require_grid(rate, first, count)
        grid = first + np.arange(max(count, 0)) / rate
        names = tuple(names)
        values = np.full((len(grid), len(names)), np.nan)
        found_places: dict[int, Places] = {}  # searched once for all channels that share their stamps
        for column, name in enumerate(names):
            channel = self.channels.get(name)
            if channel is None or not len(channel.time):
                continue
            found = found_places.get(id(channel.time))
            if found is None:
                found = found_places[id(channel.time)] = places(channel.time, grid, maximum_age, 0.5 / rate)
            values[:, column] = (
                held(channel.values, found)
                if method == "hold"
                else between(channel.time, channel.values, found, maximum_age)
            )
        return Aligned(grid, values, names)


def _extremes(values: np.ndarray) -> tuple[str, str]:
    seen = values[np.isfinite(values)]
    return (f"{seen.min():.6g}", f"{seen.max():.6g}") if len(seen) else ("", "")


class Places(NamedTuple):
    """Positions of the times of a grid among the time stamps of a channel, (n,) each."""

    before: np.ndarray | slice  # indices of the latest samples up to the times of the grid
    known: np.ndarray | bool
    age: np.ndarray  # time since that sample [s]
    held: np.ndarray  # whether the sample is recent enough to be held
    everywhere: bool
    rounding: float  # amount by which a stamp may lie after its time of the grid [s]


def places(time: np.ndarray, grid: np.ndarray, maximum_age: float, tolerance: float) -> Places:
    """Positions of the times of a grid among the time stamps of a channel.

    Args:
        time: stamps [s], not decreasing
        grid: times [s]
        maximum_age: age up to which a sample is held [s]
        tolerance: amount by which a stamp may lie after its time of the grid, at most a microsecond [s]
    """
    rounding = min(tolerance, 1e-6)
    until = grid + rounding
    known: np.ndarray | bool = True
    # With regular clocks a slice takes the samples without a search and without a copy.
    before: np.ndarray | slice | None = _evenly_spaced(time, until)
    if before is None:
        found = np.searchsorted(time, until, side="right") - 1
        known, before = found >= 0, np.maximum(found, 0)
    age = grid - time[before]
    held = known & (age <= maximum_age + rounding)
    return Places(before, known, age, held, bool(held.all()), rounding)


def _evenly_spaced(time: np.ndarray, until: np.ndarray) -> slice | None:
    """Slice of the last stamps up to given times, where these are every k-th stamp (regular clocks); else None."""
    if len(until) < 2:
        return None
    first, last = (np.searchsorted(time, until[[0, -1]], side="right") - 1).tolist()
    step, rest = divmod(last - first, len(until) - 1)
    if first < 0 or step < 1 or rest:
        return None
    before, following = slice(first, last + 1, step), time[first + 1 : last + 2 : step]
    fits = (time[before] <= until).all() and (following > until[: len(following)]).all()
    return before if fits else None


def held(values: np.ndarray, places: Places) -> np.ndarray:
    """The latest sample at each time of a grid; NaN where it is too old."""
    latest = values[places.before]
    return latest if places.everywhere else np.where(places.held, latest, np.nan)


def between(time: np.ndarray, values: np.ndarray, places: Places, maximum_age: float) -> np.ndarray:
    """Linear interpolation at each time of a grid; NaN where the two samples are too far apart.

    Args:
        time, values: stamps [s] and samples of the channel
        maximum_age: largest distance of two samples that are interpolated [s]
    """
    before, known, age, _, _, rounding = places
    before = np.arange(len(time))[before]
    after = np.minimum(before + 1, len(time) - 1)
    width = time[after] - time[before]
    share = np.divide(age, width, out=np.zeros_like(age), where=width > 0.0)
    between = values[before] + np.clip(share, 0.0, 1.0) * (values[after] - values[before])
    exact = age <= rounding
    within = (width <= maximum_age + rounding) & (age <= width + rounding)
    return np.where(known & exact, values[before], np.where(known & within & (width > 0.0), between, np.nan))
