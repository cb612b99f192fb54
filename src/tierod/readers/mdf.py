"""ASAM measurement files (MDF 3, MF4): recorded channels, and CAN bus logs decoded with a DBC."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tierod.arrow import floats
from tierod.errors import InputError
from tierod.readers.frames import EXTENDED, Frames
from tierod.readers.log import Log
from tierod.readers.mdf_process import MdfProcess
from tierod.readers.source import Column, Lane, Piece, Source
from tierod.recording import Channel


def open_mdf(path: Path) -> Source | Log:
    """A measurement file: its channels, or its frames where it is a bus log without channels.

    Raises:
        MissingExtra: asammdf is not installed
        InputError: the file is damaged, or holds neither channels nor CAN frames
    """
    process = MdfProcess(path)
    content = process.ask({})[0]
    frames = sum(content["records"][group] for group in content["frames"])
    if content["channels"]:
        notes = (f"the file holds {frames} CAN frames too, which were left out",) if frames else ()
        return _source(process, content, notes)
    if not frames:
        raise InputError(
            f"{path}: the MDF file holds neither channels nor CAN frames; export it again with the channels chosen"
        )
    origin = _origin(content["start"])
    return Log(path.name, lambda: [_frames(process.lane(group, None), origin) for group in content["frames"]])


def _source(process: MdfProcess, content: dict[str, Any], notes: tuple[str, ...]) -> Source:
    places = {each["name"]: each for each in content["channels"]}
    columns = tuple(Column(name, each["unit"], each["title"], name != each["title"]) for name, each in places.items())

    def lanes(names: Sequence[str]) -> list[Lane]:
        groups: dict[int, list[dict[str, Any]]] = {}
        for name in names:
            groups.setdefault(places[name]["group"], []).append(places[name])
        return [_lane(process, group, wanted, content["records"][group]) for group, wanted in groups.items()]

    known = {"format": f"MDF {content['version']}", "start_time": content["start"]}
    metadata = {**_told(content["comment"]), **known}
    return Source(columns, lanes, metadata, _origin(content["start"]), notes)


def _lane(process: MdfProcess, group: int, wanted: list[dict[str, Any]], records: int) -> Lane:
    """The wanted channels of a group; those whose samples are no numbers are left out."""
    done = 0
    for table in process.lane(group, [each["channel"] for each in wanted]):
        time = floats(table["time"])
        done += len(time)
        channels = []
        for each in wanted:
            if str(each["channel"]) in table.column_names:
                source, _, note = each["comment"].partition(" |") if each["comment"] else (each["name"], "", "")
                told = (source.removeprefix("tierod:").strip(), note.strip())
                values = floats(table[str(each["channel"])])
                channels.append(Channel(each["name"], time, values, each["unit"], *told))
        yield Piece(channels, min(done / records, 1.0))


def _told(comment: str) -> dict[str, Any]:
    """Metadata that tierod wrote into the comment of the file; none where another program wrote it."""
    try:
        root = ElementTree.fromstring(comment)
        told = json.loads(root.findtext(".//common_properties/e[@name='tierod']") or "{}")
    except (ElementTree.ParseError, ValueError):
        return {}
    return told if isinstance(told, dict) else {}


def _origin(start: str) -> float:
    """Seconds since 1970; a start in local time whose zone the file does not tell counts as UTC, on every machine."""
    if not start:
        return 0.0
    moment = datetime.fromisoformat(start)
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _frames(tables: Iterator[Any], origin: float) -> Iterator[Frames]:
    """The frames of one group."""
    for table in tables:
        count = table.num_rows
        if not count:
            continue
        packed = table["data"].chunk(0)
        data = np.frombuffer(packed.buffers()[1], dtype=np.uint8, count=count * packed.type.byte_width)
        data = data.reshape(count, packed.type.byte_width)
        length = np.minimum(floats(table["length"]).astype(int), data.shape[1])
        identifier = floats(table["identifier"]).astype(np.uint32)
        wide = (floats(table["extended"]) > 0.0) | ((identifier & EXTENDED) != 0)
        buses, bus = np.unique(floats(table["bus"]).astype(int), return_inverse=True)
        yield Frames(
            floats(table["time"]),
            (identifier & np.uint32(0x1FFFFFFF)) | np.where(wide, np.uint32(EXTENDED), np.uint32(0)),
            bus.astype(np.uint16),
            np.where(np.arange(data.shape[1]) < length[:, None], data, 0).astype(np.uint8),
            length,
            tuple(f"CAN{number}" for number in buses),
            origin,
        )
