"""A recording piece by piece, and how the pieces are joined again so that no cut is seen."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.io.readers import SHARE_READ
from tierod.vehicles import Vehicle

CHUNK = 600.0
"""Seconds of recording in memory at a time."""

LEAP = 86400.0
"""Seconds that a recording may be silent, a night between two drives; a clock that leaps further was set."""

OVERLAP = 1.0
"""Seconds kept of the piece before: longer than any sample may be old and any derived signal looks back."""


def pieces_of(
    source: Recording | str | Path, needs: Iterable[str], vehicle: Vehicle, dbc: Any, channel_map: Any
) -> Iterator[Recording]:
    """The pieces of a file, one after the other; a recording in memory is a single one.

    Args:
        source: a recording, or the path of one
        needs: channels that are read
        vehicle: whose CAN databases and channel map are taken where none are given
        dbc: path(s) of CAN databases
        channel_map: path of a channel map

    Raises:
        InputError: the file cannot be read
    """
    if isinstance(source, Recording):
        yield source
        return
    from tierod.io.readers import open_chunks

    yield from open_chunks(
        source,
        seconds=CHUNK,
        names=needs,
        dbc=vehicle.database if dbc is None else dbc,
        channel_map=vehicle.channel_map if channel_map is None else channel_map,
    )


def refuse_leap(last: float, following: float) -> None:
    """Refuse a pause in which a clock was set.

    Args:
        last: time of the last sample before the pause [s]
        following: time of the first sample after it [s]

    Raises:
        InputError: more than `LEAP` lies between
    """
    if following - last > LEAP:
        raise InputError(
            f"the time leaps ahead from about {last:.6g} s by {(following - last) / 86400.0:.3g} days; "
            "cut the recording there and judge the parts one by one"
        )


def share_read(piece: Recording) -> float:
    """Of the recording, up to the end of a piece, 0 to 1."""
    return float(piece.metadata.get(SHARE_READ, 1.0))


def joined(before: Recording | None, piece: Recording) -> Recording:
    """The piece with the end of the one before in front of it."""
    if before is None:
        return piece
    channels = dict(piece.channels)
    for name, old in before.channels.items():
        new = channels.get(name)
        if new is None:
            channels[name] = old
        else:
            channels[name] = dataclasses.replace(
                new, time=np.concatenate([old.time, new.time]), values=np.concatenate([old.values, new.values])
            )
    return Recording(channels, piece.metadata)
