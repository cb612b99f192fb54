"""ASAM measurement files (MDF 3, MF4) through asammdf: recorded channels, and CAN bus logs decoded with a DBC."""

from __future__ import annotations

import contextlib
import gc
import io
import logging
import sys
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tierod.errors import InputError, MissingExtra
from tierod.readers.frames import EXTENDED, Frames, joined
from tierod.readers.source import Column, Source
from tierod.readers.written import metadata_in
from tierod.recording import Channel
from tierod.user_files import json_document

_FRAME = "CAN_DataFrame"
_BUS_GROUP = 2
"""Flag of a channel group that holds bus events (ASAM MDF 4.1)."""


def open_mdf(path: Path) -> Source | Frames:
    """A measurement file: its channels, or its frames where it is a bus log without channels.

    Raises:
        MissingExtra: asammdf is not installed
        InputError: the file is damaged, or holds neither channels nor CAN frames
    """
    try:
        from asammdf import MDF
    except ImportError:
        raise MissingExtra("asammdf", "mdf", "reading an MDF file") from None
    with _quiet():
        try:
            return _opened(MDF(path))
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        except Exception as error:
            reason = " ".join(str(error).split())[:160] or type(error).__name__
            traceback.clear_frames(error.__traceback__)
        gc.collect()
    raise InputError(f"{path} is damaged or cut off and cannot be read as MDF ({reason}); export it again")


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Without what asammdf warns, logs and prints, on stdout too, over a damaged file."""
    hook, logger = sys.unraisablehook, logging.getLogger("asammdf")
    sys.unraisablehook, silent = lambda _: None, logger.disabled
    logger.disabled = True
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            yield
    finally:
        sys.unraisablehook, logger.disabled = hook, silent


def _opened(file: Any) -> Source | Frames:
    places = _channels(file)
    frames = _frames(file)
    if places:
        notes = (f"the file holds {len(frames)} CAN frames too, which were left out",) if frames else ()
        return _source(file, places, notes)
    if frames is None:
        raise InputError("the MDF file holds neither channels nor CAN frames; export it again with the channels chosen")
    return frames


def _channels(file: Any) -> dict[str, tuple[int, int, Any]]:
    """(group, index, channel) of every recorded channel, by a name that is unique in the file."""
    found = []
    for number, group in enumerate(file.groups):
        if not group.channel_group.cycles_nr or getattr(group.channel_group, "flags", 0) & _BUS_GROUP:
            continue
        label = str(getattr(group.channel_group, "acq_name", "") or number)
        master = file.masters_db.get(number)
        found += [
            (item.name, label, number, place, item) for place, item in enumerate(group.channels) if place != master
        ]
    often = Counter(name for name, *_ in found)
    places: dict[str, tuple[int, int, Any]] = {}
    for name, label, number, place, item in found:
        unique = name if often[name] == 1 else f"{label}.{name}"
        unique = unique if unique not in places else f"{label}.{number}.{place}.{name}"
        places[unique] = (number, place, item)
    return places


def _source(file: Any, places: dict[str, tuple[int, int, Any]], notes: tuple[str, ...]) -> Source:
    columns = tuple(Column(name, _unit(item), item.name, name != item.name) for name, (_, _, item) in places.items())

    def load(names: Sequence[str]) -> list[Channel]:
        picks = [(None, *places[name][:2]) for name in names]
        with _quiet():
            signals = file.select(picks, copy_master=False, ignore_value2text_conversions=True)
        made = [_channel(name, signal) for name, signal in zip(names, signals, strict=True)]
        return [channel for channel in made if channel is not None]

    start = file.header.start_time
    known = {"format": f"MDF {file.version}", "start_time": start.isoformat() if start else ""}
    return Source(columns, load, {**_told(file), **known}, _origin(start), notes)


def _told(file: Any) -> dict[str, Any]:
    """Metadata that tierod wrote into the comment of the file; none where another program wrote it."""
    try:
        root = ElementTree.fromstring(str(getattr(file.header, "comment", "")))
        return metadata_in(json_document(root.findtext(".//common_properties/e[@name='tierod']") or "{}"))
    except (ElementTree.ParseError, ValueError):
        return {}


def _origin(start: datetime | None) -> float:
    """Seconds since 1970; a start in local time whose zone the file does not tell counts as UTC, on every machine."""
    if start is None:
        return 0.0
    return (start if start.tzinfo else start.replace(tzinfo=UTC)).timestamp()


def _unit(item: Any) -> str:
    conversion = getattr(item, "conversion", None)
    return item.unit or getattr(conversion, "unit", "") or ""


def _channel(name: str, signal: Any) -> Channel | None:
    samples = signal.samples
    if samples.ndim != 1 or samples.dtype.kind not in "fiub":
        return None
    values = samples.astype(float)
    invalid = signal.invalidation_bits
    if invalid is not None:
        values = np.where(np.asarray(invalid, dtype=bool), np.nan, values)
    comment = " ".join(str(signal.comment or "").split())
    source, _, note = comment.partition(" |") if comment.startswith("tierod:") else (name, "", "")
    return Channel(
        name, signal.timestamps, values, signal.unit or "", source.removeprefix("tierod:").strip(), note.strip()
    )


def _frames(file: Any) -> Frames | None:
    parts = []
    for number, group in enumerate(file.groups):
        names = {item.name for item in group.channels}
        if group.channel_group.cycles_nr and _FRAME in names:
            parts.append(_part(file.get(_FRAME, group=number), file.header.start_time))
    return joined([part for part in parts if len(part)]) if any(len(part) for part in parts) else None


def _part(signal: Any, start: Any) -> Frames:
    samples = signal.samples
    count = len(samples)

    def column(name: str) -> np.ndarray:
        if f"{_FRAME}.{name}" in samples.dtype.names:
            return np.asarray(samples[f"{_FRAME}.{name}"])
        return np.zeros(count)

    data = np.ascontiguousarray(column("DataBytes"), dtype=np.uint8).reshape(count, -1)
    length = np.minimum(column("DataLength").astype(int), data.shape[1])
    data = np.where(np.arange(data.shape[1]) < length[:, None], data, 0).astype(np.uint8)
    identifier = column("ID").astype(np.uint32)
    wide = (column("IDE") > 0) | ((identifier & EXTENDED) != 0)
    numbers = column("BusChannel").astype(int)
    buses, bus = np.unique(numbers, return_inverse=True)
    return Frames(
        np.asarray(signal.timestamps, dtype=float),
        (identifier & np.uint32(0x1FFFFFFF)) | np.where(wide, np.uint32(EXTENDED), np.uint32(0)),
        bus.astype(np.uint16),
        data,
        length,
        tuple(f"CAN{number}" for number in buses),
        _origin(start),
    )
