"""A recording bit by bit: pieces of any length become slices of equal length."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable, Iterator
from dataclasses import replace

import numpy as np

from tierod.errors import InputError
from tierod.recording import Channel
from tierod.timestamps import LATE, Order, order

Piece = dict[str, Channel]

FEWEST = 0.1
"""Samples per second [Hz] that a slice has at least; every slice costs some milliseconds, however little it holds."""


def regrouped(pieces: Iterable[list[Channel]], seconds: float) -> Iterator[Piece]:
    """Consecutive slices of `seconds` from pieces in the order of time; slices without a sample are left out.

    A slice of fewer than `FEWEST` samples a second goes on until it has them: work follows the samples, whatever their
    stamps are.

    Args:
        pieces: every one holds all channels of a stretch of time, later than the stretches before
        seconds: length of the slices [s], counted from the first stamp of all

    Raises:
        InputError: a piece begins more than LATE before the one ahead of it ended
    """
    waiting: dict[str, list[Channel]] = {}
    start: float | None = None
    for piece in pieces:
        _append(waiting, piece)
        held = [parts for parts in waiting.values() if sum(len(part.time) for part in parts)]
        if not held:
            continue
        if start is None:
            start = min(float(parts[0].time[0]) for parts in held if len(parts[0].time))
        # The next piece may bring samples that belong before the last of this one.
        until = max(float(parts[-1].time[-1]) for parts in held) - LATE
        start = yield from _drained(waiting, start, seconds, until)
    yield from _drained(waiting, start or 0.0, seconds, float("inf"))
    rest = _cut(waiting, float("inf"))
    if any(len(channel.time) for channel in rest.values()):
        yield rest


def _drained(
    waiting: dict[str, list[Channel]], start: float, seconds: float, until: float
) -> Generator[Piece, None, float]:
    """The slices that end before `until`; returns where the next one begins, which is after any gap."""
    while (
        start < start + seconds <= until and (stop := max(start + seconds, _filled(waiting, FEWEST * seconds))) <= until
    ):
        stamps = [float(parts[0].time[0]) for parts in waiting.values() if len(parts[0].time)]
        if not stamps:
            return start
        start += seconds * max(math.floor((min(stamps) - start) / seconds), 0)
        stop = max(stop, start + seconds)
        if stop > until:
            return start
        ready = _cut(waiting, stop)
        start = stop
        if any(len(channel.time) for channel in ready.values()):
            yield ready
    return start


def _filled(waiting: dict[str, list[Channel]], samples: float) -> float:
    """The time at which the densest of the waiting channels has so many samples; infinite where none has yet."""
    times = []
    for parts in waiting.values():
        left = math.floor(samples)
        for part in parts:
            if left < len(part.time):
                times.append(float(part.time[left]))
                break
            left -= len(part.time)
    return min(times, default=math.inf)


def _append(waiting: dict[str, list[Channel]], piece: list[Channel]) -> None:
    orders: dict[tuple[int, int], Order] = {}
    for channel in piece:
        parts = waiting.setdefault(channel.name, [])
        if not len(channel.time) and parts:
            continue
        if parts and not len(parts[-1].time):
            parts.pop()
        if parts and channel.time[0] < parts[-1].time[-1]:
            parts.append(_put_in_order(parts.pop(), channel, orders))
        else:
            parts.append(channel)


def _put_in_order(before: Channel, channel: Channel, orders: dict[tuple[int, int], Order]) -> Channel:
    """Two parts of a channel whose stamps overlap, as one; stamps that channels share stay shared."""
    if before.time[-1] - channel.time[0] > LATE:
        raise InputError(
            f"the time of '{channel.name}' jumps back from {before.time[-1]:.6f} s to {channel.time[0]:.6f} s; "
            "cut the recording there and read the parts one by one"
        )
    key = (id(before.time), id(channel.time))
    if key not in orders:
        orders[key] = order(np.concatenate((before.time, channel.time)), f"'{channel.name}'")
    values = orders[key](np.concatenate((before.values, channel.values)))
    return replace(before, time=orders[key].time, values=values).noted(*channel.note.split("; "), *orders[key].notes)


def _cut(waiting: dict[str, list[Channel]], stop: float) -> Piece:
    """Everything before `stop`, taken out of what waits; stamps that channels share stay shared."""
    clocks: dict[tuple[int, ...], np.ndarray] = {}
    ready: Piece = {}
    for name, parts in waiting.items():
        key = tuple(id(part.time) for part in parts)
        if key not in clocks:
            clocks[key] = np.concatenate([part.time for part in parts]) if len(parts) > 1 else parts[0].time
        time = clocks[key]
        values = np.concatenate([part.values for part in parts]) if len(parts) > 1 else parts[0].values
        last = int(np.searchsorted(time, stop, side="left"))
        notes = [note for part in parts[1:] for note in part.note.split("; ")]
        ready[name] = replace(parts[0], time=time[:last], values=values[:last]).noted(*notes)
        waiting[name] = [replace(parts[-1], time=time[last:], values=values[last:])]
    return ready
