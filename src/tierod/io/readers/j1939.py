"""What SAE J1939 adds to a database: which frames a parameter group matches, and raw values that say nothing."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from tierod.io.readers.bits import LONGEST

_PGN_WITH_ADDRESS = 240
"""J1939-21: below this PDU format the next byte is the address of the receiver, not part of the parameter group."""

_SAYS_NOTHING = re.compile(
    r"not[ _-]*(avail|defin|install|support|used)|n/?a\b|sna\b|error|fault|invalid|reserved|undefined"
    r"|do ?n.?o?t[ _-]*care|no[ _-]*action",
    re.IGNORECASE,
)
"""How databases call the states that carry no value."""


def parameter_group(identifier: int) -> int:
    """The parameter group number (PGN) in a 29-bit identifier of J1939-21."""
    group = (identifier >> 8) & 0x3FFFF
    return group & 0x3FF00 if (group >> 8) & 0xFF < _PGN_WITH_ADDRESS else group


def without_value(item: Any, raw: np.ndarray) -> np.ndarray | None:
    """Where the sender says that it has no value, or only an error; None where it cannot say so.

    J1939-71, ranges of transmitted signals: a parameter of one byte is in error at 0xFE and not available at 0xFF, a
    longer one where its highest byte is. Discrete parameters of two bits: 0b10 error (of a command: reserved),
    0b11 not available (of a command: take no action). Of four bits: 0xE error, 0xF not available (SPN 1675).
    Of 3, 5, 6 and 7 bits only all ones is not available: the value below may be a state (SPN 527, 0b110: accelerator
    override). One bit cannot say it. Commands that use all four states of two bits exist (SPN 695): a state that the
    database calls otherwise than error or not available is kept.

    Args:
        item: the signal as cantools describes it
        raw: its raw values, unsigned where they can say it, shape (n,)
    """
    if item.is_signed or item.is_float or not 2 <= item.length <= LONGEST:
        return None
    if item.length >= 8:
        return raw >= np.uint64(0xFE << (item.length - 8))
    ones = (1 << item.length) - 1
    states = (ones - 1, ones) if item.length in (2, 4) else (ones,)
    names = item.choices or {}
    silent = [state for state in states if state not in names or _SAYS_NOTHING.search(str(names[state]))]
    return np.isin(raw, np.array(silent, dtype=np.uint64)) if silent else None
