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
from tierod.io.quality import (
    Pace,
    assumes_unit,
    channel_quality,
    figure_remarks,
    follows_from_figures,
    is_about_implausible_values,
    too_slow,
)
from tierod.io.signs import COMPARED, sign_warnings, turn_warnings
from tierod.monitors.harness.pieces import joined

REDUCED_RATE = 10.0
"""Rate [Hz] at which signals are kept to compare their signs."""

FEWEST = 3
"""Samples from which on a channel may be called constant."""


class Qualities:
    """Qualities of the channels of one piece, which several monitors look at, each worked out once."""

    def __init__(self) -> None:
        # With the objects themselves: what is gone leaves its identity to another one.
        self._paces: dict[int, tuple[np.ndarray, Pace]] = {}
        self._found: dict[int, tuple[Channel, ChannelQuality]] = {}

    def of(self, channel: Channel) -> ChannelQuality:
        """Quality of a channel, its note left out."""
        if id(channel) not in self._found:
            time = channel.time
            _, pace = self._paces.get(id(time)) or self._paces.setdefault(id(time), (time, Pace.of(time)))
            self._found[id(channel)] = channel, channel_quality(dataclasses.replace(channel, note=""), pace=pace)
        return self._found[id(channel)][1]


class Shared:
    """A piece as several monitors take it, and the qualities of its channels.

    Args:
        before: end of the piece before; None for the first
        piece: of the recording

    `whole` has the end of the piece before in front.
    """

    def __init__(self, before: Recording | None, piece: Recording):
        self._piece, self.whole, self.qualities = piece, joined(before, piece), Qualities()

    def with_channels_of_piece(self, cut: Recording) -> Recording:
        """A recording cut out of `whole`, whose channels are those of the piece where they hold the same samples."""
        same = {
            name: each
            for name, each in self._piece.channels.items()
            if name in cut and len(cut[name].time) == len(each.time)
        }
        return dataclasses.replace(cut, channels={**cut.channels, **same})


class QualityOverChunks:
    """Collects the quality of the named channels over consecutive pieces of one recording."""

    def __init__(self, names: Iterable[str]):
        self.names = tuple(names)
        self.units: dict[str, str] = {}
        self._rows: dict[str, ChannelQuality] = {}
        self._notes: dict[str, str] = {}
        self._spans: dict[str, float] = {}
        self._last: dict[str, float] = {}
        self._reduced = Rows(1 + len(self.names))

    def add(self, piece: Recording, qualities: Qualities | None = None) -> None:
        """The next piece.

        Args:
            piece: follows on the one before
            qualities: of its channels, where others look at them too
        """
        qualities = qualities or Qualities()
        for name in self.names:
            if name in piece:
                self._merge(piece[name], qualities.of(piece[name]))
        kept = len(self._reduced) / REDUCED_RATE
        if kept < COMPARED and any(name in piece for name in self.names):
            # No more than is compared: a piece may be a whole recording with a pause of days in it.
            first = piece.slice(stop=piece.span[0] + COMPARED + 1.0)
            aligned = first.align(self.names, REDUCED_RATE, maximum_age=2.0 / REDUCED_RATE)
            self._reduced.add(np.column_stack([aligned.time, aligned.values]))

    def rows(self) -> tuple[ChannelQuality, ...]:
        """One row per channel that the recording has; notes on a channel are those of the last piece."""
        return tuple(
            dataclasses.replace(row, remarks=(*row.remarks, *filter(None, [self._notes[name]])))
            for name, row in self._rows.items()
        )

    def rates(self) -> dict[str, float]:
        """At which rate each channel comes [Hz]; NaN where a single sample came."""
        return {name: row.rate for name, row in self._rows.items()}

    def contradictions(self) -> tuple[str, ...]:
        """Signals that have probably the wrong sign, or the wrong unit, beside the others."""
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
        """Signals that leave their plausible range: with a wrong unit no verdict is worth anything."""
        return tuple(
            f"{name}: {remark}"
            for name, row in self._rows.items()
            for remark in row.remarks
            if is_about_implausible_values(remark)
        )

    def refuse_slow(self, required: Iterable[str], minimum_rate: float) -> bool:
        """Stop where a signal comes too slowly.

        Args:
            required: names of signals
            minimum_rate: of each [Hz]

        Returns:
            whether the rate of every required signal is known; of no sample or a single one there is none

        Raises:
            InputError: a required signal comes at less than the minimum rate [Hz]
        """
        names = tuple(required)
        for name in (name for name in names if name in self._rows):
            rate = self._rows[name].rate
            if too_slow(rate, minimum_rate):
                milliseconds = not too_slow(1e3 * rate, minimum_rate) and rate < 1.0
                raise InputError(
                    f"{name} comes at {rate:.3g} Hz; at least {minimum_rate:g} Hz are needed: record it faster"
                    + (', or, if its time counts milliseconds, call that column "time [ms]"' if milliseconds else "")
                )
        return all(name in self._rows and np.isfinite(self._rows[name].rate) for name in names)

    def refuse_unusable(self, required: Iterable[str]) -> None:
        """Stop where a signal has no valid value in the whole recording.

        Raises:
            InputError: a required signal is missing or constant throughout
        """
        for name in required:
            row = self._rows.get(name)
            if row is None:
                raise InputError(f"no sample of {name} could be read; check that the file is whole, or record again")
            if row.missing_share == 1.0:
                raise InputError(f"every sample of {name} is missing; check the sensor, its source and the channel map")
            if row.samples < FEWEST:
                raise InputError(
                    f"{name} has {row.samples} sample{'s' if row.samples > 1 else ''}, too few to judge anything; "
                    "check that the file is whole, or give a longer recording"
                )
            if row.minimum == row.maximum:
                raise InputError(
                    f"{name} is constant at {in_words(row.minimum, row.unit)} throughout; check the sensor and the "
                    "channel map, or give a recording in which the vehicle is driven"
                )

    def _merge(self, channel: Channel, new: ChannelQuality) -> None:
        name = channel.name
        self._notes[name] = channel.note
        self.units[name] = channel.unit
        if not len(channel.time):
            return
        pause = float(channel.time[0]) - self._last.get(name, float(channel.time[0]))
        span = float(channel.time[-1] - channel.time[0])
        self._last[name] = float(channel.time[-1])
        old = self._rows.get(name)
        self._rows[name] = new if old is None else _merged(old, new, self._spans[name], span, pause)
        self._spans[name] = self._spans.get(name, 0.0) + span


def _merged(old: ChannelQuality, new: ChannelQuality, old_span: float, new_span: float, pause: float) -> ChannelQuality:
    samples = old.samples + new.samples
    weight = new_span / (old_span + new_span) if old_span + new_span > 0.0 else 0.5
    rates = [rate for rate in (old.rate, new.rate) if np.isfinite(rate)]
    # Of single samples so far apart that each is a piece of its own, the pause between them is the step.
    between = 1.0 / pause if pause > 0.0 else np.nan
    missing = (old.samples * old.missing_share + new.samples * new.missing_share) / samples
    gap = float(np.fmax(np.fmax(old.longest_gap, new.longest_gap), pause))
    extremes = float(np.fmin(old.minimum, new.minimum)), float(np.fmax(old.maximum, new.maximum))
    assumed = any(assumes_unit(remark) for remark in (*old.remarks, *new.remarks))
    mean = samples / (old_span + new_span) if old_span + new_span > 0.0 else np.nan
    return dataclasses.replace(
        old,
        samples=samples,
        rate=(1.0 - weight) * old.rate + weight * new.rate if len(rates) == 2 else (rates or [between])[0],
        missing_share=missing,
        longest_gap=gap,
        minimum=extremes[0],
        maximum=extremes[1],
        remarks=(*figure_remarks(old.name, old.unit, missing, gap, mean, extremes, assumed), *_remarks(old, new)),
    )


def _remarks(old: ChannelQuality, new: ChannelQuality) -> tuple[str, ...]:
    """Every kind of remark once; that a channel is constant or missing only where it holds throughout."""
    constant = old.minimum == old.maximum == new.minimum == new.maximum
    missing = old.missing_share == new.missing_share == 1.0
    kept: dict[str, str] = {}
    for remark in (*old.remarks, *new.remarks):
        throughout = remark.startswith(("constant at", "every sample is missing", "holds a single sample"))
        if not follows_from_figures(remark) and (not throughout or constant or missing):
            kept.setdefault(remark.split(":")[0].rstrip("0123456789. %sHz"), remark)
    return tuple(kept.values())
