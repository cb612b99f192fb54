"""Check whether CAN databases that are used together describe the same messages alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tierod.io.readers.frames import EXTENDED, identifier_text

if TYPE_CHECKING:
    from cantools.database.can import Message, Signal

NAMED = 3
"""Number of messages that a sentence names; further ones are counted only."""


def disagreements(databases: Mapping[Path, Sequence[Message]]) -> str:
    """Sentence on the messages that two databases describe differently, and which description is used; "" if all agree.

    Args:
        databases: messages by file, in the order in which they were given
    """
    known: dict[int, tuple[Path, Message]] = {}
    found: list[str] = []
    for path, messages in databases.items():
        for message in messages:
            key = message.frame_id | (EXTENDED if message.is_extended_frame else 0)
            if key in known and known[key][0] != path and (what := _difference(known[key][1], message)):
                found.append(f"{identifier_text(key)} ({what}; {path.name} is used, not {known[key][0].name})")
            known[key] = (path, message)
    if not found:
        return ""
    others = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return (
        f"the databases disagree on {', '.join(found[:NAMED])}{others}; give the DBC that is right for this bus last, "
        "or leave the other one out"
    )


def _difference(first: Message, second: Message) -> str:
    """The first signal whose description differs, in words; "" if none does."""
    before, after = ({each.name: each for each in message.signals} for message in (first, second))
    for name in dict.fromkeys((*before, *after)):
        if name not in before or name not in after:
            return f"only one has {name}"
        if layout(before[name]) != layout(after[name]):
            return f"{name} differs in bits, sign, factor, offset or unit"
    return ""


def layout(item: Signal) -> tuple[object, ...]:
    """Position of a signal in its message and conversion of its bits into a value; equal for equal descriptions."""
    return (
        item.start, item.length, item.byte_order, item.is_signed, item.is_float, float(item.scale), float(item.offset),
        item.unit or "", tuple(item.multiplexer_ids or ()),
    )  # fmt: skip
