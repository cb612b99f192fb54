"""Reading a recording in pieces, joining them so that the cuts do not affect any result, and their quality."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.findings import ChannelQuality
from tierod.core.recording import Aligned, Channel, Recording
from tierod.core.series import Rows
from tierod.core.shown import in_words
from tierod.io.quality import Figures, Pace
from tierod.io.readers import SHARE_READ
from tierod.io.readers.reading import measured
from tierod.io.readings import Readings, held_remark, too_slow
from tierod.io.signs import COMPARED, sign_warnings, turn_warnings
from tierod.vehicles import Vehicle
from tierod.vehicles.vehicle import read_by

CHUNK = 120.0  # Duration of one piece in memory [s]; the outputs of a monitor over ten minutes would take 120 MB more

# Longest pause of a recording [s], a night between two drives; a longer leap means that the clock was set
LEAP = 86400.0

# Duration of the previous piece that is kept [s]: longer than any maximum age and any memory of a derived signal
OVERLAP = 1.0


def pieces_of(
    source: Recording | str | Path,
    needs: Iterable[str] | None,
    vehicle: Vehicle,
    dbc: Any = None,
    channel_map: Any = None,
    seconds: float = CHUNK,
) -> Iterator[Recording]:
    """Pieces of a recording in the order of time; a recording in memory is a single piece.

    Args:
        needs: channels to be read; None for all
        seconds: duration of a piece [s]
    """
    if isinstance(source, Recording):
        yield measured(source)
        return
    from tierod.io.readers import open_chunks

    databases, used = read_by(vehicle, dbc, channel_map)
    yield from open_chunks(source, seconds=seconds, names=needs, dbc=databases, channel_map=used)


def refuse_leap(last: float, following: float) -> None:
    """Refuse a pause in which the clock was set.

    Args:
        last: time of the last sample before the pause [s]
        following: time of the first sample after it [s]
    """
    if following - last > LEAP:
        raise InputError(
            f"the time jumps ahead from about {last:.6g} s by {(following - last) / 86400.0:.3g} days; cut the "
            "recording there and judge the parts one by one"
        )


def share_read(piece: Recording) -> float:
    """Share of the recording that has been read at the end of a piece, 0 to 1."""
    return float(piece.metadata.get(SHARE_READ, 1.0))


def joined(before: Recording | None, piece: Recording) -> Recording:
    """Piece with the end of the previous one in front of it."""
    if before is None:
        return piece
    channels = dict(piece.channels)
    clocks: dict[tuple[int, int], np.ndarray] = {}
    for name, old in before.channels.items():
        new = channels.get(name)
        if new is None:
            channels[name] = old
        else:
            key = id(old.time), id(new.time)
            if key not in clocks:  # channels of one message go on sharing one array, so that it is searched only once
                clocks[key] = np.concatenate([old.time, new.time])
            channels[name] = dataclasses.replace(new, time=clocks[key], values=np.concatenate([old.values, new.values]))
    return Recording(channels, piece.metadata)


def together(parts: Sequence[Aligned]) -> Aligned:
    """Join consecutive parts of one grid."""
    if len(parts) == 1:
        return parts[0]
    time, values = (np.concatenate(each) for each in zip(*((p.time, p.values) for p in parts), strict=True))
    return Aligned(time, values, parts[0].names)


PAUSE = 2.0  # Time without a sample from which a stretch counts as a pause [s]; all held values have expired by then

# Longest part of a pause that a monitor receives as missing samples [s]: variances grow and verdicts lapse in that
# time, and nothing changes afterwards
LONGEST = 600.0

# Total time of pauses, beyond the time with samples, that is judged with up to `LONGEST` each [s]; further pauses get
# `PAUSE` each, so that the work grows with the samples and not with their time stamps
MOST = 3600.0


class Stretch(NamedTuple):
    """Stretch of time to be judged [s]: from `skip_to`, or the end of the previous stretch if later, until `stop`."""

    skip_to: float
    stop: float


class Silence:
    """Follows the pauses in the signals of a monitor from piece to piece."""

    def __init__(self) -> None:
        self._first: float | None = None
        self._last_sample: float | None = None
        self._paused = 0.0
        self._judged = 0.0

    def stretches(self, stamps: Iterable[np.ndarray], begin: float, stop: float) -> Iterator[Stretch]:
        """Stretches of a piece to be judged, in the order of time.

        Args:
            stamps: time stamps of every signal of the piece [s]
            begin: begin of the piece [s]
            stop: end of the piece [s]
        """
        if self._first is None or self._last_sample is None:
            self._first = self._last_sample = begin
        resume = self._last_sample
        for pause, end in self._pauses(list(stamps), begin):
            refuse_leap(pause, end)
            limit = pause + self._allowed(pause)
            self._judged += min(limit, end) - pause
            self._paused += end - pause
            if limit < end:
                yield Stretch(resume, limit)
                resume = end
        yield Stretch(resume, min(stop, self._last_sample + self._allowed(self._last_sample)))

    def _allowed(self, pause: float) -> float:
        """Time after the begin of a pause that is still judged [s]."""
        assert self._first is not None
        sampled = pause - self._first - self._paused
        return LONGEST if self._judged + LONGEST <= MOST + sampled else PAUSE

    def _pauses(self, stamps: list[np.ndarray], begin: float) -> Iterator[tuple[float, float]]:
        """Last sample before and first sample after every pause that ends in a piece [s]."""
        assert self._last_sample is not None
        parts = [each[np.searchsorted(each, begin) :] for each in stamps]
        parts = [each for each in parts if len(each)]
        if not parts:
            return
        last = max(float(each[-1]) for each in parts)
        # Shortcut: a single signal without a gap rules out any pause, and spares the merging of all time stamps.
        gapless = (each for each in parts if each[0] - self._last_sample <= PAUSE and last - each[-1] <= PAUSE)
        if not any(float(np.diff(each).max(initial=0.0)) <= PAUSE for each in gapless):
            together = np.unique(np.concatenate([[self._last_sample], *parts]))
            at = np.flatnonzero(np.diff(together) > PAUSE)
            yield from zip(together[at].tolist(), together[at + 1].tolist(), strict=True)
        self._last_sample = last


REDUCED_RATE = 10.0  # Rate at which signals are stored for the comparison of their signs [Hz]
FEWEST = 3  # Fewest samples of a channel that can be called constant


class Qualities:
    """Cache of the qualities of one piece's channels, which several monitors share."""

    def __init__(self) -> None:
        # The objects are stored with their id: a deleted object could leave its id to a new one.
        self._paces: dict[int, tuple[np.ndarray, Pace]] = {}
        self._found: dict[int, tuple[Channel, Figures]] = {}

    def of(self, channel: Channel) -> Figures:
        if id(channel) not in self._found:
            time = channel.time
            _, pace = self._paces.get(id(time)) or self._paces.setdefault(id(time), (time, Pace.of(time)))
            self._found[id(channel)] = channel, Figures.of(channel, pace)
        return self._found[id(channel)][1]


class Shared:
    """A piece that several monitors share, and the qualities of its channels.

    `whole` is the piece with the end of the previous one in front.

    Args:
        before: end of the previous piece; None for the first piece
    """

    def __init__(self, before: Recording | None, piece: Recording):
        self._piece, self.whole, self.qualities = piece, joined(before, piece), Qualities()

    def with_channels_of_piece(self, cut: Recording) -> Recording:
        """Recording cut out of `whole`, with the channel objects of the piece if they hold the same samples."""
        same = {
            name: each
            for name, each in self._piece.channels.items()
            if name in cut and len(cut[name].time) == len(each.time)
        }
        return dataclasses.replace(cut, channels={**cut.channels, **same})


class QualityOverChunks:
    """Accumulates the quality of the named channels over consecutive pieces of one recording."""

    def __init__(self, names: Iterable[str]):
        self.names = tuple(names)
        self._figures: dict[str, Figures] = {}
        self._reduced = Rows(1 + len(self.names))
        self._readings = {name: Readings() for name in self.names}

    def add(self, piece: Recording, qualities: Qualities | None = None) -> None:
        """Add the next piece."""
        qualities = qualities or Qualities()
        for name in self.names:
            if name in piece:
                known, new = self._figures.get(name), qualities.of(piece[name])
                self._figures[name] = new if known is None else known.joined(new)
                self._readings[name].add(piece[name].values)
        kept = len(self._reduced) / REDUCED_RATE
        if kept < COMPARED and any(name in piece for name in self.names):
            # A piece may be a whole recording with a pause of days in it: align only the part that is compared.
            first = piece.slice(stop=piece.span[0] + COMPARED + 1.0)
            aligned = first.align(self.names, REDUCED_RATE, maximum_age=2.0 / REDUCED_RATE)
            self._reduced.add(np.column_stack([aligned.time, aligned.values]))

    @property
    def units(self) -> dict[str, str]:
        return {name: each.unit for name, each in self._figures.items()}

    @property
    def _seen(self) -> dict[str, Figures]:
        """Figures of the channels with a sample."""
        return {name: each for name, each in self._figures.items() if each.samples}

    def rows(self) -> tuple[ChannelQuality, ...]:
        """One row per channel of the recording; its note is that of the last piece."""
        return tuple(each.quality(self._readings[name].rows()) for name, each in self._seen.items())

    def rates(self) -> dict[str, float]:
        """Sampling rate of each channel [Hz]; NaN for a single sample."""
        return {name: each.pace.rate for name, each in self._seen.items()}

    def contradictions(self) -> tuple[str, ...]:
        """Sentences on signals that probably have the wrong sign or the wrong unit, compared with the others."""
        if not len(self._reduced):
            return ()
        table = self._reduced.values
        channels = {
            name: Channel(name, table[:, 0], table[:, 1 + column], self.units[name])
            for column, name in enumerate(self.names)
            if name in self.units
        }
        together = Recording(channels)
        return (*sign_warnings(together), *turn_warnings(together))

    def range_warnings(self) -> tuple[str, ...]:
        """Warnings of signals that leave their plausible range, as with a wrong unit, which invalidates any verdict."""
        return tuple(f"{name}: {remark}" for name, each in self._seen.items() if (remark := each.implausible()))

    def held_warnings(self) -> tuple[str, ...]:
        """Warnings of signals whose readings are repeated in many rows."""
        rates = self.rates()
        held = {name: each.rows() for name, each in self._readings.items()}
        return tuple(f"{name}: {held_remark(rates[name], rows)}" for name, rows in held.items() if rows > 1.0)

    def noise_warnings(self) -> tuple[str, ...]:
        """Warnings of signals whose readings scatter far more than those of usual sensors."""
        noises = (self._readings[name].noise(name, each.unit, each.pace.rate) for name, each in self._seen.items())
        return tuple(filter(None, noises))

    def refuse_slow(self, required: Iterable[str], minimum_rate: float) -> bool:
        """Refuse a required signal with a low sampling rate.

        Args:
            minimum_rate: minimum sampling rate of each [Hz]
        """
        names, rates = tuple(required), self.rates()
        for name in (name for name in names if name in rates):
            rate = rates[name]
            if too_slow(rate, minimum_rate):
                milliseconds = not too_slow(1e3 * rate, minimum_rate) and rate < 1.0
                raise InputError(
                    f"{name} is sampled at {rate:.3g} Hz; at least {minimum_rate:g} Hz are needed: record it faster"
                    + (', or, if its time counts milliseconds, call that column "time [ms]"' if milliseconds else "")
                )
        return all(np.isfinite(rates.get(name, np.nan)) for name in names)

    def refuse_unusable(self, required: Iterable[str], minimum_rate: float) -> None:
        """Refuse a required signal that holds too little information over the whole recording.

        Args:
            minimum_rate: minimum rate of the readings of each [Hz]
        """
        for name in required:
            row = self._seen.get(name)
            if row is None:
                raise InputError(f"no sample of {name} could be read; check that the file is whole, or record again")
            if row.missing_share == 1.0:
                raise InputError(f"every sample of {name} is missing; check the sensor, its source and the channel map")
            if row.samples < FEWEST:
                raise InputError(
                    f"{name} has {row.samples} sample{'s' if row.samples > 1 else ''}, too few to judge anything; "
                    "check that the file is whole, or give a longer recording"
                )
            if row.least == row.most:
                raise InputError(
                    f"{name} is constant at {in_words(row.least, row.unit)} throughout; check the sensor and the "
                    "channel map, or give a recording in which the vehicle is driven"
                )
            rows = self._readings[name].rows()
            if rows > 1.0 and too_slow(row.pace.rate / rows, minimum_rate):
                raise InputError(
                    f"{name}: {held_remark(row.pace.rate, rows)}; at least {minimum_rate:g} Hz are needed: record it "
                    "faster"
                )
