"""A recording bit by bit: pieces of any length become slices of equal length."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tierod.errors import InputError
from tierod.recording import Channel

Piece = dict[str, Channel]


def regrouped(pieces: Iterable[list[Channel]], seconds: float) -> Iterator[Piece]:
    """Consecutive slices of `seconds` from pieces in the order of time; slices without a sample are left out.

    Args:
        pieces: every one holds all channels of a stretch of time, later than the stretches before
        seconds: length of the slices [s], counted from the first stamp of all

    Raises:
        InputError: a piece begins before the one ahead of it ended
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
        until = max(float(parts[-1].time[-1]) for parts in held)
        while start + seconds <= until:
            ready = _cut(waiting, start + seconds)
            start += seconds
            if any(len(channel.time) for channel in ready.values()):
                yield ready
    rest = _cut(waiting, float("inf"))
    if any(len(channel.time) for channel in rest.values()):
        yield rest


def _append(waiting: dict[str, list[Channel]], piece: list[Channel]) -> None:
    for channel in piece:
        parts = waiting.setdefault(channel.name, [])
        if not len(channel.time) and parts:
            continue
        if parts and len(parts[-1].time) and channel.time[0] < parts[-1].time[-1]:
            raise InputError(
                f"the time of '{channel.name}' jumps back from {parts[-1].time[-1]:.6f} s to {channel.time[0]:.6f} s; "
                "cut the recording there and read the parts one by one"
            )
        if parts and not len(parts[-1].time):
            parts.pop()
        parts.append(channel)


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
        ready[name] = replace(parts[0], time=time[:last], values=values[:last])
        waiting[name] = [replace(parts[-1], time=time[last:], values=values[last:])]
    return ready
