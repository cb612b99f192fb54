"""CAN frames as arrays, their identifiers and meaning in J1939, and a CAN log that is read more than once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from tierod.core.errors import InputError
from tierod.core.series import LATE, Repairs
from tierod.io.readers.content import Kept

if TYPE_CHECKING:
    pass


EXTENDED = 1 << 31  # Flag of a 29-bit identifier in `Frames.identifier`
MOST_BUSES = 64  # Largest number of buses of a log: with more names in their place, the log is damaged, or is none
IDENTIFIERS = 1 << 29  # Number of possible identifiers: those of extended frames have 29 bits
_STANDARD = 0x7FF  # The largest identifier of 11 bits; a damaged log may hold larger ones of three digits


@dataclass(frozen=True)
class Frames:
    time: np.ndarray  # [s] since origin, shape (n,)
    identifier: np.ndarray  # shape (n,), uint32, EXTENDED added for 29-bit identifiers
    bus: np.ndarray  # number of the bus in `buses`, shape (n,)
    payload: np.ndarray  # bytes, shape (n, width), zero beyond the length
    length: np.ndarray  # number of bytes of the payload, shape (n,)
    buses: tuple[str, ...]  # names of the buses
    origin: float = 0.0  # calendar time of the stamp zero [s]
    notes: tuple[str, ...] = field(default=())  # notes on losses and repairs while reading

    def __len__(self) -> int:
        return len(self.time)


class Message(NamedTuple):
    """The rows of one identifier on one bus."""

    identifier: int
    bus: int
    rows: np.ndarray


def messages(frames: Frames) -> Iterator[Message]:
    """The frames grouped by bus and identifier, rows in the order of time."""
    keys = frames.bus.astype(np.uint64) << np.uint64(32) | frames.identifier
    rows = np.argsort(_codes(frames, keys), kind="stable")
    keys = keys[rows]
    edges = np.concatenate(([0], np.flatnonzero(keys[1:] != keys[:-1]) + 1, [len(keys)]))
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        if end > begin:
            key = int(keys[begin])
            yield Message(key & 0xFFFFFFFF, key >> 32, rows[begin:end])


def _codes(frames: Frames, keys: np.ndarray) -> np.ndarray:
    """Numbers in the order of the keys, in 16 bits where they fit, because NumPy sorts those in linear time."""
    if len(frames.buses) <= 32 and (frames.identifier <= _STANDARD).all():
        return (frames.bus << np.uint16(11)) | frames.identifier.astype(np.uint16)
    found = np.unique(keys)
    return np.searchsorted(found, keys).astype(np.uint16) if len(found) <= 1 << 16 else keys


def taken(frames: Frames, index: np.ndarray | slice) -> Frames:
    return replace(
        frames,
        time=frames.time[index],
        identifier=frames.identifier[index],
        bus=frames.bus[index],
        payload=frames.payload[index],
        length=frames.length[index],
    )


def only_notes(frames: Frames, notes: tuple[str, ...]) -> Frames:
    return replace(taken(frames, slice(0, 0)), notes=notes)


def stacked(
    time: np.ndarray, identifier: Sequence[int], bus: Sequence[int], data: Sequence[bytes], buses: tuple[str, ...],
    origin: float,
) -> Frames:  # fmt: skip
    length = np.array([len(each) for each in data], dtype=int)
    width = max(int(length.max(initial=0)), 8)
    payload = np.frombuffer(b"".join(each.ljust(width, b"\0") for each in data), dtype=np.uint8)
    return Frames(
        time,
        np.array(identifier, dtype=np.uint32),
        np.array(bus, dtype=np.uint16),
        payload.reshape(-1, width),
        length,
        buses,
        origin,
    )


def joined(parts: Sequence[Frames]) -> Frames:
    if len(parts) == 1:
        return _in_order(parts[0])
    buses = tuple(dict.fromkeys(name for part in parts for name in part.buses))
    width = max((part.payload.shape[1] for part in parts), default=8)
    payloads = [np.pad(part.payload, ((0, 0), (0, width - part.payload.shape[1]))) for part in parts]
    numbers = [np.array([buses.index(name) for name in part.buses] or [0], dtype=np.uint16)[part.bus] for part in parts]
    together = Frames(
        np.concatenate([part.time for part in parts]),
        np.concatenate([part.identifier for part in parts]),
        np.concatenate(numbers),
        np.concatenate(payloads),
        np.concatenate([part.length for part in parts]),
        buses,
        parts[0].origin,
        tuple(note for part in parts for note in part.notes),
    )
    return _in_order(together)


def _in_order(frames: Frames) -> Frames:
    if (frames.time[1:] >= frames.time[:-1]).all():
        return frames
    return taken(frames, np.argsort(frames.time, kind="stable"))


Name = TypeVar("Name", int, str)


def bus_number(buses: dict[Name, int], name: Name) -> int:
    """The number of a bus; a new name gets the next number."""
    number = buses.setdefault(name, len(buses))
    if number >= MOST_BUSES:
        raise InputError(f"the log names more than {MOST_BUSES} buses, so it is damaged; record or export it again")
    return number


def identifier_text(identifier: int) -> str:
    return f"0x{identifier & ~EXTENDED:08X}" if identifier & EXTENDED else f"0x{identifier:03X}"


# Delay of frames from which there is a remark, though they can be sorted [s]: drivers of buses are faster
LATE_ENOUGH = 0.005


@dataclass(frozen=True)
class Log:
    name: str  # name of its file, for messages
    # gives the frames from the beginning, in blocks; several lanes where the log keeps its buses apart
    lanes: Callable[[], list[Iterator[Frames]]]


class Remembered:
    """The frames of a log that is slow to read, kept in a temporary file after they were read to the end."""

    def __init__(self, read: Callable[[], Iterator[Frames]]):
        self._read = read
        self._kept: Kept | None = None
        self._blocks: list[tuple[int, Frames]] = []

    def __call__(self) -> list[Iterator[Frames]]:
        return [self._first() if self._kept is None else self._again(self._kept)]

    def _first(self) -> Iterator[Frames]:
        kept, blocks = Kept(), []
        for frames in self._read():
            columns = (frames.time, frames.identifier, frames.bus, frames.length, frames.payload)
            # An index copies, but an empty slice would keep all frames in memory.
            blocks.append((len(frames), taken(frames, np.arange(0))))
            for column, kind in zip(columns, _KINDS, strict=True):
                kept.append(column.astype(kind).tobytes())
            yield frames
        self._kept, self._blocks = kept, blocks

    def _again(self, kept: Kept) -> Iterator[Frames]:
        at = 0
        for count, empty in self._blocks:
            columns = []
            for kind, width in zip(_KINDS, (1, 1, 1, 1, empty.payload.shape[1]), strict=True):
                size = count * width * np.dtype(kind).itemsize
                columns.append(np.frombuffer(kept.read(size, at), dtype=kind))
                at += size
            time, identifier, bus, length, payload = columns
            payload = payload.reshape(count, empty.payload.shape[1])
            yield replace(empty, time=time, identifier=identifier, bus=bus, length=length.astype(int), payload=payload)


_KINDS = ("f8", "u4", "u2", "u2", "u1")  # Types in which time, identifier, bus, length and payload of a frame are kept


@dataclass
class Heard:
    # number of frames by (number of the bus, identifier), in the order of both
    counts: dict[tuple[int, int], int] = field(default_factory=dict)
    buses: tuple[str, ...] = ()  # names of the buses, in the order of their first frames
    frames: int = 0  # number of all frames
    origin: float = 0.0  # calendar time of the stamp zero [s]
    newest: float = 0.0  # time of the last frame [s]
    notes: tuple[str, ...] = ()  # notes on losses and repairs


class InOrder:
    """The frames of all lanes of a log together, in the order of time."""

    def __init__(self, log: Log):
        self.buses: dict[str, int] = {}
        self.notes: dict[str, None] = {}
        self.behind = 0.0
        self._lanes = log.lanes()
        self._repairs = [Repairs(f"the log {log.name}") for _ in self._lanes]

    def __iter__(self) -> Iterator[Frames]:
        waiting: list[Frames | None] = [None] * len(self._lanes)
        reach = np.full(len(self._lanes), -np.inf)
        while (until := reach.min()) < np.inf:
            lane = int(np.argmin(reach))
            block = next(self._lanes[lane], None)
            if block is None:
                reach[lane] = np.inf
            else:
                self.notes |= dict.fromkeys(block.notes)
                kept = self._repairs[lane].arrived(block.time)
                old, block = waiting[lane], block if kept is None else taken(block, kept)
                # Sorted by time, since a block may hold frames that belong before the last one of the block before.
                waiting[lane] = joined([old, block] if old else [block])
                reach[lane] = self._repairs[lane].newest - LATE
            until = reach.min()
            ready = [self._ready(waiting, each, until) for each in range(len(waiting))] if until > -np.inf else []
            if any(len(part) for part in ready if part):
                yield self._numbered(joined([part for part in ready if part]))
        self.behind = max((each.behind for each in self._repairs), default=0.0)

    @staticmethod
    def _ready(waiting: list[Frames | None], lane: int, until: float) -> Frames | None:
        frames = waiting[lane]
        if frames is None:
            return None
        last = int(np.searchsorted(frames.time, until, side="left"))
        waiting[lane] = taken(frames, slice(last, None))
        return taken(frames, slice(0, last))

    def _numbered(self, frames: Frames) -> Frames:
        numbers, first = np.unique(frames.bus, return_index=True)
        for number in numbers[np.argsort(first)].tolist():
            self.buses.setdefault(frames.buses[number], len(self.buses))
        table = np.array([self.buses.get(name, 0) for name in frames.buses], dtype=np.uint16)
        return replace(frames, bus=table[frames.bus], buses=tuple(self.buses))


def heard(log: Log) -> Heard:
    """Content of a log, read once from its beginning to its end."""
    found = Heard()
    counts: dict[tuple[int, int], int] = {}
    blocks = InOrder(log)
    for frames in blocks:
        found.origin = found.origin if found.frames else frames.origin
        found.frames += len(frames)
        found.newest = float(frames.time[-1])
        for identifier, bus, rows in messages(frames):
            counts[bus, identifier] = counts.get((bus, identifier), 0) + len(rows)
    if not found.frames:
        raise InputError(f"the log {log.name} holds no frame with data; record or export it again")
    found.counts = dict(sorted(counts.items()))
    found.buses, found.notes = tuple(blocks.buses), tuple(blocks.notes)
    if blocks.behind > LATE_ENOUGH:
        late = f"frames of the log come up to {blocks.behind:.2g} s late and were put in order"
        found.notes = (*found.notes, f"{late}: was a clock set back there?")
    return found
