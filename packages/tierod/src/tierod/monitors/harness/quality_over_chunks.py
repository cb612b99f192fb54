"""Data quality of a recording that is read piece by piece."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

import numpy as np

from tierod.core.errors import InputError
from tierod.core.findings import ChannelQuality
from tierod.core.recording import Channel, Recording
from tierod.core.series import Rows
from tierod.core.shown import in_words
from tierod.io.quality import Figures, Pace
from tierod.io.readings import Readings, held_remark, too_slow
from tierod.io.signs import COMPARED, sign_warnings, turn_warnings
from tierod.monitors.harness.pieces import joined

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
