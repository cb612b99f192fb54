"""Replay of a recording onto a bus: its frames unchanged, or its signals encoded by a DBC, with seeded disturbances."""

from __future__ import annotations

import contextlib
import heapq
import random
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tierod.core.errors import InputError
from tierod.io.readers.channel_map import ChannelMap
from tierod.io.readers.frames import EXTENDED
from tierod.io.readers.log import InOrder, Log
from tierod.io.readers.opening import frames_in, open_source
from tierod.io.readers.source import Column
from tierod.io.readers.streaming import Reading
from tierod.live.frame import Frame

if TYPE_CHECKING:
    import can
    from cantools.database.can import Message


@dataclass(frozen=True)
class Disturbance:
    """Disturbances of the transmission, drawn from a seeded generator.

    Args:
        seed: seed of the generator
        loss: share of frames that are lost
        doubled: share of frames that arrive twice
        jitter: standard deviation of the normal distribution whose magnitude is the delay of a frame
        reordered: share of frames that are delayed by 20 ms, two periods of 10 ms
        bus_off: mean rate of bus-off states, half a second each
    """

    seed: int = 0
    loss: float = 0.0
    doubled: float = 0.0
    jitter: Annotated[float, "s"] = 0.0
    reordered: float = 0.0
    bus_off: Annotated[float, "1/min"] = 0.0


OFF: Annotated[float, "s"] = 0.5
"""Duration of a bus-off state."""

HELD: Annotated[float, "s"] = 0.02
"""Delay of a reordered frame."""


@dataclass
class Played:
    """Counts of frames: sent, lost, doubled, delayed and failed to send; and of bus-off states."""

    sent: int = 0
    lost: int = 0
    doubled: int = 0
    held: int = 0
    off: int = 0
    failed: int = 0


def frames_of_file(path: Path, database: Sequence[Message], channel_map: ChannelMap | None) -> Iterator[Frame]:
    """Frames of a bus log, or frames that carry the signals of another recording, in the order of time from 0 on.

    Args:
        path: path of the recording
        database: messages by which signals are encoded; not needed for a bus log
        channel_map: assignment of canonical signals to signals of the databases

    Raises:
        InputError: the recording cannot be read, or holds no signal of the databases
    """
    log = frames_in(path)
    if log is not None:
        return _of_log(log)
    return encoded(path, database, channel_map)


def _of_log(log: Log) -> Iterator[Frame]:
    first = None
    for block in InOrder(log):
        first = float(block.time[0]) if first is None else first
        rows = zip(
            (block.time - first).tolist(), block.identifier.tolist(), block.bus.tolist(), block.payload,
            block.length.tolist(), strict=True,
        )  # fmt: skip
        for stamp, identifier, bus, payload, length in rows:
            yield Frame(stamp, identifier, bus + 1, payload[:length].tobytes())


def encoded(path: Path, database: Sequence[Message], channel_map: ChannelMap | None) -> Iterator[Frame]:
    """Frames of a recording's signals; a message is sent at each sample of its fastest signal, the others are held.

    Args:
        path: path of the recording, with columns of the databases or canonical signals
        database: messages of the databases
        channel_map: channel map of the vehicle, whose sign, factor and offset are inverted

    Raises:
        InputError: the recording holds no signal of the databases
    """
    from tierod.io.conversion import as_found

    source, kind = open_source(path)
    columns = {column.name: column for column in source.columns} | {column.title: column for column in source.columns}
    found = {message.name: wiring for message in database if (wiring := _wired(message, columns, channel_map))}
    if not found:
        raise InputError(
            f"{path} has no signal of the databases; give columns called Message.Signal, or a channel map with --map "
            "that assigns signals of the DBC to canonical names"
        )
    by_name = {message.name: message for message in database}
    first = None
    for piece in Reading(path, source, kind, as_found(source)).slices(10.0):
        queued: list[Iterator[Frame]] = [_sent(by_name[name], wiring, piece) for name, wiring in found.items()]
        for frame in heapq.merge(*queued):
            first = frame.time if first is None else first
            yield frame._replace(time=frame.time - first)


Wiring = dict[str, tuple[str, Callable[[float], float]]]
"""By signal of a message: its source channel, and the conversion of a value of that channel."""


def _wired(message: Message, columns: Mapping[str, Column], channel_map: ChannelMap | None) -> Wiring:
    wiring: Wiring = {}
    for item in message.signals:
        for name in (f"{message.name}.{item.name}", item.name):
            if name in columns:
                wiring[item.name] = (columns[name].name, float)
                break
        else:
            inverse = _inverse(f"{message.name}.{item.name}", item.unit or "", columns, channel_map)
            if inverse is not None:
                wiring[item.name] = inverse
    return wiring


def _inverse(
    name: str, unit: str, columns: Mapping[str, Column], channel_map: ChannelMap | None
) -> tuple[str, Callable[[float], float]] | None:
    """The canonical channel that a map makes from this signal alone, and the inverse conversion."""
    from tierod.core.units import scale

    for canonical, entry in (channel_map.entries if channel_map else {}).items():
        if entry.source != (name,) or canonical not in columns:
            continue
        written = entry.unit or unit
        try:
            own = columns[canonical].unit
            back = scale(own, written) if written and own and written != own else None
        except InputError:
            continue
        gain, offset = entry.sign * entry.factor, entry.offset

        def raw(value: float, back: Any = back, gain: float = gain, offset: float = offset) -> float:
            value = float(back(value)) if back is not None else value
            return (value - offset) / gain

        return columns[canonical].name, raw
    return None


def _sent(message: Message, wiring: Wiring, piece: Any) -> Iterator[Frame]:
    import numpy as np
    from cantools.database import EncodeError

    channels = {name: piece.channels[column] for name, (column, _) in wiring.items() if column in piece.channels}
    if not channels:
        return
    leader = max(channels.values(), key=lambda channel: len(channel.time))
    identifier = message.frame_id | (EXTENDED if message.is_extended_frame else 0)
    held = {}
    for name, channel in channels.items():
        at = np.maximum(np.searchsorted(channel.time, leader.time, side="right") - 1, 0)
        held[name] = channel.values[at] if len(channel.values) else np.full(len(leader.time), np.nan)
    rest = {item.name: _idle(item) for item in message.signals if item.name not in held}
    for place, stamp in enumerate(leader.time.tolist()):
        values = dict(rest)
        for name, column in held.items():
            item = message.get_signal_by_name(name)
            value = wiring[name][1](float(column[place]))
            values[name] = _within(item, value) if value == value else _idle(item)
        with contextlib.suppress(EncodeError, OverflowError, ValueError):  # what it cannot represent is not sent
            yield Frame(stamp, identifier, 1, message.encode(values, scaling=True, strict=False))


def _idle(item: Any) -> float:
    return float(item.offset) if not item.minimum or item.minimum <= item.offset else float(item.minimum)


def _within(item: Any, value: float) -> float:
    """The nearest value that the bits of a signal can represent."""
    if item.is_float:
        return value
    low, high = (-(1 << item.length - 1), (1 << item.length - 1) - 1) if item.is_signed else (0, (1 << item.length) - 1)
    raw = min(max(round((value - item.offset) / item.scale), low), high)
    return float(raw * item.scale + item.offset)


def disturbed(frames: Iterator[Frame], how: Disturbance, played: Played) -> Iterator[Frame]:
    """Frames as they arrive after the disturbances; reproducible for equal seeds.

    Args:
        frames: frames in the order of time
        how: the disturbances
        played: counter of the disturbances
    """
    chance = random.Random(how.seed)
    waiting: list[tuple[float, int, Frame]] = []
    off_until, next_off = -1.0, _next_off(chance, 0.0, how)
    for number, frame in enumerate(frames):
        while waiting and waiting[0][0] <= frame.time:
            yield heapq.heappop(waiting)[2]
        if frame.time >= next_off:
            off_until, next_off = frame.time + OFF, _next_off(chance, frame.time + OFF, how)
            played.off += 1
        draw = chance.random()
        if frame.time < off_until or draw < how.loss:
            played.lost += 1
            continue
        delay = abs(chance.gauss(0.0, how.jitter)) if how.jitter else 0.0
        if chance.random() < how.reordered:
            delay += HELD
            played.held += 1
        heapq.heappush(waiting, (frame.time + delay, number, frame._replace(time=frame.time + delay)))
        if chance.random() < how.doubled:
            played.doubled += 1
            heapq.heappush(waiting, (frame.time + delay, number, frame._replace(time=frame.time + delay)))
    while waiting:
        yield heapq.heappop(waiting)[2]


def _next_off(chance: random.Random, now: float, how: Disturbance) -> float:
    return now + chance.expovariate(how.bus_off / 60.0) if how.bus_off > 0.0 else float("inf")


def play(
    frames: Iterator[Frame],
    buses: Sequence[can.BusABC],
    speed: float,
    played: Played,
    wanted: Callable[[], bool] = lambda: True,
    say: Callable[[str], None] = lambda text: None,
) -> None:
    """Send frames at their times; a frame that a bus refuses is retried for a second, then dropped.

    Args:
        frames: frames in the order of time
        buses: targets; a frame of bus n goes to the n-th, frames of further buses to the last
        speed: multiple of real time; 0 sends as fast as the bus accepts
        played: counter of the frames
        wanted: called before every frame; replay ends if it returns false
        say: receives a sentence on frames of a bus without a target
    """
    import can

    merged: set[int] = set()
    begin = time.monotonic()
    for frame in frames:
        if not wanted():
            return
        if speed > 0.0 and (pause := begin + frame.time / speed - time.monotonic()) > 0.0:
            time.sleep(pause)
        message = can.Message(
            arbitration_id=frame.identifier & ~EXTENDED,
            is_extended_id=bool(frame.identifier & EXTENDED),
            data=frame.data,
            is_fd=len(frame.data) > 8,
            timestamp=frame.time,
            check=False,
        )
        if frame.bus > len(buses) and frame.bus not in merged:
            merged.add(frame.bus)
            say(f"frames of bus {frame.bus} of the recording go to bus {len(buses)} too; give a --channel for each bus")
        bus = buses[min(frame.bus, len(buses)) - 1]
        for attempt in range(20):
            try:
                bus.send(message)
                played.sent += 1
                break
            except can.CanError:
                if attempt == 19:
                    played.failed += 1
                time.sleep(0.05)
