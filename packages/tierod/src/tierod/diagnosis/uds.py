"""Fault memory as read by a tester: services 0x19 and 0x14 of the unified diagnostic services (UDS)."""

from __future__ import annotations

import math
import struct

from tierod.diagnosis.entry import Entry, FreezeFrame
from tierod.diagnosis.fault_memory import FaultMemory

READ, CLEAR = 0x19, 0x14
NEGATIVE, POSITIVE_OFFSET = 0x7F, 0x40
SUBFUNCTION_NOT_SUPPORTED, INCORRECT_LENGTH, OUT_OF_RANGE, SERVICE_NOT_SUPPORTED = 0x12, 0x13, 0x31, 0x11
AVAILABLE = 0xFF  # Status availability mask: all bits of the status byte are supported
FORMAT_14229 = 0x01
SUPPRESS_POSITIVE = 0x80
# Record numbers of the freeze frames of the first and latest failure, and the number that requests all records
FIRST, LAST, ALL = 1, 2, 0xFF
# Extended data records of one byte each, by number; the debounce counter is signed
EXTENDED = {1: "occurrences", 2: "counter", 3: "failed_cycles", 4: "passed_cycles"}


def answer(memory: FaultMemory, request: bytes) -> bytes:
    """Response of a control unit with this memory to a request. Source: ISO 14229-1:2020, 12.2 and 12.3."""
    service = request[0] if request else 0
    if service == CLEAR:
        return _cleared(memory, request)
    if service != READ:
        return _refusal(service, SERVICE_NOT_SUPPORTED)
    if len(request) < 2:
        return _refusal(READ, INCORRECT_LENGTH)
    found = _read(memory, request[1] & ~SUPPRESS_POSITIVE, request[2:])
    return b"" if request[1] & SUPPRESS_POSITIVE and found[0] != NEGATIVE else found


def _read(memory: FaultMemory, subfunction: int, data: bytes) -> bytes:
    lengths = {0x01: 1, 0x02: 1, 0x04: 4, 0x06: 4, 0x0A: 0}
    if subfunction not in lengths:
        return _refusal(READ, SUBFUNCTION_NOT_SUPPORTED)
    if len(data) != lengths[subfunction]:
        return _refusal(READ, INCORRECT_LENGTH)
    head = bytes([READ + POSITIVE_OFFSET, subfunction])
    if subfunction in (0x04, 0x06):
        found = _records(memory, subfunction, int.from_bytes(data[:3], "big"), data[3])
        return _refusal(READ, OUT_OF_RANGE) if found is None else head + found
    mask = 0 if subfunction == 0x0A else data[0]
    chosen = [name for name, entry in memory.entries.items() if subfunction == 0x0A or entry.status & mask]
    if subfunction == 0x01:
        return head + bytes([AVAILABLE, FORMAT_14229]) + len(chosen).to_bytes(2, "big")
    return head + bytes([AVAILABLE]) + b"".join(_code(memory, name) for name in chosen)


def _cleared(memory: FaultMemory, request: bytes) -> bytes:
    if len(request) != 4:
        return _refusal(CLEAR, INCORRECT_LENGTH)
    wanted = int.from_bytes(request[1:], "big")
    name = _named(memory, wanted)
    if name is None and wanted != 0xFFFFFF:
        return _refusal(CLEAR, OUT_OF_RANGE)
    memory.clear(name)
    return bytes([CLEAR + POSITIVE_OFFSET])


def _refusal(service: int, reason: int) -> bytes:
    return bytes([NEGATIVE, service, reason])


def _named(memory: FaultMemory, number: int) -> str | None:
    return next((name for name, code in memory.codes.codes.items() if code.number == number), None)


def _code(memory: FaultMemory, name: str) -> bytes:
    return memory.codes.codes[name].number.to_bytes(3, "big") + bytes([memory.entries[name].status])


def _records(memory: FaultMemory, subfunction: int, number: int, record: int) -> bytes | None:
    """Code, status and requested records; None if the code or the record does not exist."""
    name = _named(memory, number)
    if name is None:
        return None
    entry = memory.entries[name]
    found = _freeze_frames(memory, entry, record) if subfunction == 0x04 else _extended(entry, record)
    return None if found is None else _code(memory, name) + found


def _freeze_frames(memory: FaultMemory, entry: Entry, record: int) -> bytes | None:
    known = {FIRST: entry.first, LAST: entry.last}
    if record not in (*known, ALL):
        return None
    chosen = known if record == ALL else {record: known[record]}
    return b"".join(_freeze_frame(memory, number, frame) for number, frame in chosen.items() if frame is not None)


def _freeze_frame(memory: FaultMemory, number: int, frame: FreezeFrame) -> bytes:
    values = frame.at_instant()
    found = {identifier: values[name] for name, identifier in memory.codes.identifiers.items() if name in values}
    data = b"".join(struct.pack(">H", identifier) + _single(value) for identifier, value in found.items())
    return bytes([number, len(found)]) + data


def _single(value: float | None) -> bytes:
    """Number in single precision; infinite if it exceeds the range."""
    try:
        return struct.pack(">f", math.nan if value is None else value)
    except OverflowError:
        return struct.pack(">f", math.copysign(math.inf, value or 0.0))


def _extended(entry: Entry, record: int) -> bytes | None:
    if record not in (*EXTENDED, ALL):
        return None
    chosen = EXTENDED if record == ALL else {record: EXTENDED[record]}
    return b"".join(bytes([number]) + _byte(getattr(entry, name)) for number, name in chosen.items())


def _byte(value: int) -> bytes:
    # Counts are limited to one byte; a negative debounce counter is written as two's complement.
    return (min(value, 255) if value >= 0 else value + 256).to_bytes(1, "big")
