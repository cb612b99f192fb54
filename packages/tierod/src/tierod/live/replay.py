"""Replay of a recording onto a bus: its frames unchanged, or its signals encoded by a DBC, with seeded disturbances."""

from __future__ import annotations

import heapq
import random
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tierod.io.readers.channel_map import ChannelMap
from tierod.io.readers.frames import EXTENDED, InOrder, Log
from tierod.io.readers.opening import frames_in
from tierod.live.clock import Frame
from tierod.live.encoding import Differences, encoded

if TYPE_CHECKING:
    import can
    from cantools.database.can import Message


@dataclass(frozen=True)
class Disturbance:
    """Disturbances of the transmission, drawn from a seeded generator."""

    seed: int = 0
    loss: float = 0.0
    doubled: float = 0.0
    # standard deviation of the normal distribution whose magnitude is the delay of a frame
    jitter: Annotated[float, "s"] = 0.0
    reordered: float = 0.0  # share of frames that are delayed by 20 ms, two periods of 10 ms
    bus_off: Annotated[float, "1/min"] = 0.0  # mean rate of bus-off states, half a second each


OFF: Annotated[float, "s"] = 0.5  # Duration of a bus-off state

HELD: Annotated[float, "s"] = 0.02  # Delay of a reordered frame


@dataclass
class Played:
    """Counts of frames: sent, lost, doubled, delayed and failed to send; and of bus-off states."""

    sent: int = 0
    lost: int = 0
    doubled: int = 0
    held: int = 0
    off: int = 0
    failed: int = 0


def frames_of_file(
    path: Path, database: Sequence[Message], channel_map: ChannelMap | None, differences: Differences | None = None
) -> Iterator[Frame]:
    """Frames of a bus log, or frames that carry the signals of another recording, in the order of time from 0 on.

    Args:
        database: messages by which signals are encoded; not needed for a bus log
        channel_map: assignment of canonical signals to signals of the databases
        differences: counts what frames made from signals do not carry

    Raises:
        InputError: the recording cannot be read, or `encoded` refuses it
    """
    log = frames_in(path)
    if log is not None:
        return _of_log(log)
    return encoded(path, database, channel_map, differences)


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


def disturbed(frames: Iterator[Frame], how: Disturbance, played: Played) -> Iterator[Frame]:
    """Frames as they arrive after the disturbances; reproducible for equal seeds."""
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
    say: Callable[[str], None] = lambda text: None,
) -> None:
    """Send frames at their times; a frame that a bus refuses is retried for a second, then dropped.

    Args:
        buses: targets; a frame of bus n goes to the n-th, frames of further buses to the last
        speed: multiple of real time; 0 sends as fast as the bus accepts
        say: receives a sentence on frames of a bus without a target
    """
    import can

    merged: set[int] = set()
    begin = time.monotonic()
    for frame in frames:
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
