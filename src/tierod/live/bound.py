"""Decoders of single frames, each bound once to the bits of one signal; values equal those of `tierod.io.readers.dbc`.

Decoding arrays costs some twenty microseconds per signal, however few frames there are; this costs less than one.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from tierod.io.readers.bits import LONGEST, span
from tierod.io.readers.dbc import bytes_of
from tierod.io.readers.frames import without_value

if TYPE_CHECKING:
    from cantools.database.can import Message, Signal

Raw = Callable[[bytes], float]
Value = Callable[[bytes], float | None]

_REALS = {16: ("<H", "<e"), 32: ("<I", "<f"), 64: ("<Q", "<d")}


def bound(message: Message, item: Signal) -> Value:
    """Decoder that gives a signal's value in the unit of the database from one payload.

    Args:
        message: the message that carries the signal
        item: the signal

    Returns:
        a function that gives the value, NaN where the payload is too short or marks a missing value of a J1939
        sender, and None where it does not carry the multiplexed signal
    """
    raw, least = _raw(item), bytes_of(item)
    scale, offset = float(item.scale), float(item.offset)
    chosen, silent = _selected(message, item), _silent(message, item)

    def value(data: bytes) -> float | None:
        if chosen is not None and not chosen(data):
            return None
        if len(data) < least:
            return math.nan
        number = raw(data)
        if silent is not None and silent(number):
            return math.nan
        # As for arrays, neither multiply by 1 nor add 0, which would turn -0 into 0.
        found = float(number)
        found = found * scale if scale != 1.0 else found
        return found + offset if offset != 0.0 else found

    return value


def _raw(item: Signal) -> Raw:
    length, start = item.length, item.start
    if not 1 <= length <= LONGEST or start < 0 or (item.is_float and length not in _REALS):
        return lambda data: math.nan
    big_endian = item.byte_order == "big_endian"
    begin, end = span(start, length, big_endian)
    mask, highest = (1 << length) - 1, 1 << (length - 1)

    def unsigned(data: bytes) -> int:
        if big_endian:
            return (int.from_bytes(data, "big") >> (8 * len(data) - end)) & mask
        return (int.from_bytes(data, "little") >> begin) & mask

    if item.is_float:
        whole, real = _REALS[length]
        return lambda data: float(struct.unpack(real, struct.pack(whole, unsigned(data)))[0])
    if item.is_signed:
        # Two's complement: flipping the sign bit and subtracting its weight extends the sign.
        return lambda data: (unsigned(data) ^ highest) - highest
    return unsigned


def _selected(message: Message, item: Signal) -> Callable[[bytes], bool] | None:
    """Test whether a payload carries a multiplexed signal; None if every payload does."""
    if not item.multiplexer_ids or not item.multiplexer_signal:
        return None
    selector = message.get_signal_by_name(item.multiplexer_signal)
    raw, least, ids = _raw(selector), bytes_of(selector), frozenset(item.multiplexer_ids)
    above = _selected(message, selector)
    return lambda data: len(data) >= least and raw(data) in ids and (above is None or above(data))


def _silent(message: Message, item: Signal) -> Callable[[float], bool] | None:
    """Test whether a raw value means "not available" in J1939; None if the signal has no such value."""
    if message.protocol != "j1939" or without_value(item, np.zeros(1, np.uint64)) is None:
        return None

    def silent(number: float) -> bool:
        found = without_value(item, np.array([number], np.uint64))
        return found is not None and bool(found[0])

    return silent
