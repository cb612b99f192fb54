"""CAN frames as arrays, their identifiers, and their meaning in J1939."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from tierod.core.errors import InputError
from tierod.io.readers.bits import LONGEST

if TYPE_CHECKING:
    from cantools.database.can import Signal

EXTENDED = 1 << 31  # Flag of a 29-bit identifier in `Frames.identifier`
MOST_BUSES = 64  # Largest number of buses of a log: with more names in their place, the log is damaged, or is none
IDENTIFIERS = 1 << 29  # Number of possible identifiers: those of extended frames have 29 bits
_STANDARD = 0x7FF  # The largest identifier of 11 bits; a damaged log may hold larger ones of three digits


@dataclass(frozen=True)
class Frames:
    """CAN frames of a log."""

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
    """The frames of these rows."""
    return replace(
        frames,
        time=frames.time[index],
        identifier=frames.identifier[index],
        bus=frames.bus[index],
        payload=frames.payload[index],
        length=frames.length[index],
    )


def joined(parts: Sequence[Frames]) -> Frames:
    """The frames of several logs or groups with one origin, in the order of time."""
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
    """An identifier as logs write it: 0x260, or 0x18FEF100 for 29 bits."""
    return f"0x{identifier & ~EXTENDED:08X}" if identifier & EXTENDED else f"0x{identifier:03X}"


# J1939-21: below this PDU format the next byte is the address of the receiver, not part of the parameter group
_PGN_WITH_ADDRESS = 240

# Pattern of the names that databases give to states without a value
_SAYS_NOTHING = re.compile(
    r"not[ _-]*(avail|defin|install|support|used)|n/?a\b|sna\b|error|fault|invalid|reserved|undefined"
    r"|do ?n.?o?t[ _-]*care|no[ _-]*action",
    re.IGNORECASE,
)


def parameter_group(identifier: int) -> int:
    """The parameter group number (PGN) in a 29-bit identifier of J1939-21."""
    group = (identifier >> 8) & 0x3FFFF
    return group & 0x3FF00 if (group >> 8) & 0xFF < _PGN_WITH_ADDRESS else group


def without_value(item: Signal, raw: np.ndarray) -> np.ndarray | None:
    """Mask of values that the sender marks as not available or in error; None where the signal has no such code.

    J1939-71, ranges of transmitted signals: a parameter of one byte is in error at 0xFE and not available at 0xFF, a
    longer one where its highest byte is. Discrete parameters of two bits: 0b10 error (of a command: reserved),
    0b11 not available (of a command: take no action). Of four bits: 0xE error, 0xF not available (SPN 1675).
    Of 3, 5, 6 and 7 bits only all ones is not available: the value below may be a state (SPN 527, 0b110: accelerator
    override). One bit cannot code it. Commands that use all four states of two bits exist (SPN 695): a state that the
    database names otherwise than error or not available is kept.

    Args:
        raw: its raw values, shape (n,); unsigned for a signal that has such codes
    """
    if item.is_signed or item.is_float or not 2 <= item.length <= LONGEST:
        return None
    if item.length >= 8:
        return raw >= np.uint64(0xFE << (item.length - 8))
    ones = (1 << item.length) - 1
    states = (ones - 1, ones) if item.length in (2, 4) else (ones,)
    names: Mapping[int, object] = item.choices or {}
    silent = [state for state in states if state not in names or _SAYS_NOTHING.search(str(names[state]))]
    return np.isin(raw, np.array(silent, dtype=np.uint64)) if silent else None
