"""ASAM measurement files (MDF 3, MF4): recorded channels, and CAN bus logs decoded with a DBC."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.core.user_files import json_document
from tierod.io.formats import metadata_in
from tierod.io.readers.frames import EXTENDED, Frames, Log, only_notes
from tierod.io.readers.reader_process import MdfProcess
from tierod.io.readers.source import Column, Format, Lane, Piece, Source, begins_with


def open_mdf(path: Path) -> Source | Log:
    """An MDF file: its channels, or its frames where it is a bus log without channels."""
    process = MdfProcess(path)
    content, _ = process.ask({})
    frames = sum(content["records"][group] for group in content["frames"])
    if content["channels"]:
        notes = (f"the file holds {frames} CAN frames too, which were left out",) if frames else ()
        return _source(process, content, (*notes, *_left_out(content)))
    if not frames and content["others"]:
        raise InputError(f"{path}: {_others(content)} and no CAN frames nor channels; {_CURE}")
    if not frames:
        raise InputError(
            f"{path}: the MDF file holds neither channels nor CAN frames; export it again with the channels chosen"
        )
    origin = _origin(content["start"])
    records = {group: content["records"][group] for group in content["frames"]}
    remarks = _left_out(content)
    return Log(
        path.name,
        lambda: [_frames(process.lane(group, None), origin, count, remarks) for group, count in records.items()],
    )


_CURE = "tierod decodes CAN only: with a tool that has their ARXML or FIBEX, export the signals as channels of an MF4"


def _others(content: dict[str, Any]) -> str:
    counts = ", ".join(f"{count} frames of {kind}" for kind, count in content["others"].items())
    return f"the MDF file holds {counts}"


def _left_out(content: dict[str, Any]) -> tuple[str, ...]:
    """A remark on frames of other buses than CAN; none without such frames."""
    return (f"{_others(content)}, which were left out; {_CURE}",) if content["others"] else ()


def _source(process: MdfProcess, content: dict[str, Any], notes: tuple[str, ...]) -> Source:
    places = {each["name"]: each for each in content["channels"]}
    columns = tuple(Column(name, each["unit"], each["title"], name != each["title"]) for name, each in places.items())

    lost: list[str] = []

    def lanes(names: Sequence[str]) -> list[Lane]:
        groups: dict[int, list[dict[str, Any]]] = {}
        for name in names:
            groups.setdefault(places[name]["group"], []).append(places[name])
        lost.clear()
        return [_lane(process, group, wanted, content["records"][group], lost) for group, wanted in groups.items()]

    known = {"format": f"MDF {content['version']}", "start_time": content["start"]}
    metadata = {**_metadata_in(content["comment"]), **known}
    return Source(columns, lanes, metadata, _origin(content["start"]), notes, lambda: tuple(lost))


def _lane(process: MdfProcess, group: int, wanted: list[dict[str, Any]], records: int, lost: list[str]) -> Lane:
    """The wanted channels of a group; channels without numbers are left out, and lost records are noted in `lost`."""
    done = 0
    for arrays in process.lane(group, [each["channel"] for each in wanted]):
        time = arrays["time"]
        done += len(time)
        channels = []
        for each in wanted:
            if str(each["channel"]) in arrays:
                source, _, note = each["comment"].partition(" |") if each["comment"] else (each["name"], "", "")
                origin = (source.removeprefix("tierod:").strip(), note.strip())
                channels.append(Channel(each["name"], time, arrays[str(each["channel"])], each["unit"], *origin))
        yield Piece(channels, min(done / records, 1.0))
    if done < records:
        lost.append(f"the file is damaged: {records - done} of {records} samples of '{wanted[0]['name']}' are lost")


def _metadata_in(comment: str) -> dict[str, Any]:
    """Metadata that tierod wrote into the comment of the file; empty where another program wrote the file."""
    try:
        root = ElementTree.fromstring(comment)
        return metadata_in(json_document(root.findtext(".//common_properties/e[@name='tierod']") or "{}"))
    except (ElementTree.ParseError, ValueError):
        return {}


def _origin(start: str) -> float:
    """Seconds since 1970; a local time without a zone counts as UTC, so that every machine gives the same result."""
    if not start:
        return 0.0
    moment = datetime.fromisoformat(start)
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _frames(
    blocks: Iterator[dict[str, np.ndarray]], origin: float, records: int, notes: tuple[str, ...]
) -> Iterator[Frames]:
    """The frames of one group; the last block has the notes on omitted frames and on lost records."""
    done, invalid, frames = 0, 0, None
    for block in blocks:
        done += len(block["time"])
        valid = block["invalid"] == 0
        invalid += int(np.count_nonzero(~valid))
        arrays = {name: values[valid] for name, values in block.items()}
        data, identifier = arrays["data"], arrays["identifier"]
        length = np.clip(arrays["length"], 0, data.shape[1])
        # A 29-bit identifier is marked by the field IDE, by the highest bit of the identifier, or by both.
        wide = (arrays["extended"] > 0) | ((identifier & EXTENDED) != 0)
        buses, bus = np.unique(arrays["bus"], return_inverse=True)
        frames = Frames(
            arrays["time"],
            (identifier & np.uint32(0x1FFFFFFF)) | np.where(wide, np.uint32(EXTENDED), np.uint32(0)),
            bus.astype(np.uint16),
            np.where(np.arange(data.shape[1]) < length[:, None], data, 0).astype(np.uint8),
            length,
            tuple(f"CAN{number}" for number in buses),
            origin,
        )
        yield frames
    if invalid:
        notes = (*notes, f"{invalid} of {records} frames are marked as invalid and were left out")
    if done < records:
        notes = (*notes, f"the file is damaged: {records - done} of {records} frames are lost")
    if frames is not None and notes:
        yield only_notes(frames, notes)


FORMAT = Format(
    "mdf",
    "MDF 3 or 4 (.mf4, .mdf, .dat)",
    (".mf4", ".mdf", ".dat"),
    lambda content, time: open_mdf(content.path),
    begins_with(b"MDF ", b"UnFinMF "),
    whole=True,
)
