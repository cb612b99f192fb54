"""Reader of MDF files through asammdf for the process of `tierod.io.readers.child`; imports nothing of tierod."""

from __future__ import annotations

import shutil
import sys
import tempfile
import types
from collections import Counter
from collections.abc import Iterator
from typing import Any

FRAME = "CAN_DataFrame"
BUS_GROUP = 2  # Flag of a channel group that holds bus events (ASAM MDF 4.1)
FRAGMENT = 1 << 22  # Size of the records that are read at a time [bytes]


def import_asammdf() -> None:
    """Import asammdf without libraries that reading does not need, which take two thirds of its time and memory.

    One of them, sympy, would execute the text of a formula in the file.
    """
    for name in _NOT_NEEDED:
        sys.modules.setdefault(name, _StandIn(name))
    try:
        import asammdf
    except Exception:  # another version of the library may need more than a stand-in offers
        for name in [name for name in sys.modules if name in _NOT_NEEDED[1:] or name.startswith("asammdf")]:
            del sys.modules[name]
        import asammdf  # noqa: F401


# Frames of other buses by their name in the bus logging standard of ASAM
OTHERS = {
    "ETH_Frame": "Ethernet (SOME/IP and PDUs within)", "LIN_Frame": "LIN", "FLX_Frame": "FlexRay",
    "FLX_Pdu": "FlexRay PDU", "MOST_Message": "MOST",
}  # fmt: skip

_NOT_NEEDED = ("sympy", "pandas", "canmatrix", "canmatrix.canmatrix", "canmatrix.formats")


class _StandIn(types.ModuleType):
    """Stand-in for a module: it has every name, but each refuses to be called."""

    __path__: list[str] = []  # noqa: RUF012

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)

        def refuse(*_: Any, **__: Any) -> None:
            raise ValueError(f"it needs {self.__name__}.{name}, which is not used")

        made = type(name, (), {"__new__": refuse})
        setattr(self, name, made)
        return made


def _stream(path: str) -> Any:
    """The file; a nameless copy where the recorder did not finish it, since asammdf would finish it in place."""
    file = open(path, "rb")  # noqa: SIM115
    head = file.read(64)
    file.seek(0)
    # The bytes 60 to 63 are the flags of an unfinished file (ASAM MDF 4).
    if not head.startswith(b"UnFinMF") and not any(head[60:64]):
        return file
    copy = tempfile.TemporaryFile()  # noqa: SIM115
    with file:
        shutil.copyfileobj(file, copy, FRAGMENT)
    copy.seek(0)
    return copy


class Reader:
    def __init__(self, path: str):
        self._path = path
        self._file: Any = None
        self._lanes: dict[int, Iterator[dict[str, Any]]] = {}

    @staticmethod
    def prepare() -> None:
        import_asammdf()

    def answer(self, request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """(columns, further metadata) in answer to a request for the content, or for the next piece of a lane."""
        if self._file is None:
            from asammdf import MDF

            # Of a stream asammdf maps no file into memory: that would count as memory, and native code would read it.
            options: dict[str, Any] = {"process_bus_logging": False}
            self._file = MDF(_stream(self._path), **options)
            self._file.configure(read_fragment_size=FRAGMENT)
        if "lane" not in request:
            return {}, self._content()
        number = request["lane"]
        if number not in self._lanes:
            self._lanes[number] = self._lane(request["group"], request["channels"])
        columns = next(self._lanes[number], None)
        return columns or {}, {"end": columns is None}

    def _content(self) -> dict[str, Any]:
        start = self._file.header.start_time
        frames = [
            number
            for number, group in enumerate(self._file.groups)
            if group.channel_group.cycles_nr and FRAME in {item.name for item in group.channels}
        ]
        return {
            "version": str(self._file.version),
            "start": start.isoformat() if start else "",
            "comment": str(getattr(self._file.header, "comment", "")),
            "channels": self._channels(),
            "frames": frames,
            "others": self._other_buses(),
            "records": [int(group.channel_group.cycles_nr) for group in self._file.groups],
        }

    def _other_buses(self) -> dict[str, int]:
        """Number of recorded frames of buses other than CAN, by their kind."""
        counts: Counter[str] = Counter()
        for group in self._file.groups:
            names = {item.name for item in group.channels}
            counts.update(
                {kind: int(group.channel_group.cycles_nr) for frame, kind in OTHERS.items() if frame in names}
            )
        return {kind: count for kind, count in counts.items() if count}

    def _channels(self) -> list[dict[str, Any]]:
        found = []
        for number, group in enumerate(self._file.groups):
            if not group.channel_group.cycles_nr or getattr(group.channel_group, "flags", 0) & BUS_GROUP:
                continue
            label = str(getattr(group.channel_group, "acq_name", "") or number)
            master = self._file.masters_db.get(number)
            found += [
                (item.name, label, number, place, item) for place, item in enumerate(group.channels) if place != master
            ]
        often = Counter(name for name, *_ in found)
        places: dict[str, dict[str, Any]] = {}
        for name, label, number, place, item in found:
            unique = name if often[name] == 1 else f"{label}.{name}"
            unique = unique if unique not in places else f"{label}.{number}.{place}.{name}"
            unit = item.unit or getattr(getattr(item, "conversion", None), "unit", "") or ""
            comment = " ".join(str(item.comment or "").split())
            places[unique] = {
                "name": unique,
                "title": item.name,
                "unit": unit,
                "group": number,
                "channel": place,
                "comment": comment if comment.startswith("tierod:") else "",
            }
        return list(places.values())

    def _lane(self, group: int, channels: list[int] | None) -> Iterator[dict[str, Any]]:
        """The time and some channels of a group, or its frames, fragment by fragment."""
        file = self._file._mdf
        for fragment in file._load_data(file.groups[group]):
            if channels is None:
                yield self._frames(group, fragment)
            else:
                yield self._samples(group, channels, fragment)

    def _samples(self, group: int, channels: list[int], fragment: object) -> dict[str, Any]:
        import numpy as np

        file = self._file._mdf
        columns = {"time": np.asarray(file.get_master(group, data=fragment), dtype=float)}
        for channel in channels:
            # Without the last option asammdf drops samples whose invalidation bit is set, but not their time stamps.
            samples, invalid = file.get(
                group=group, index=channel, data=fragment, samples_only=True, raw=True, ignore_invalidation_bits=True
            )
            conversion = file.groups[group].channels[channel].conversion
            if conversion:
                samples = conversion.convert(samples, ignore_value2text_conversions=True)
            if samples.ndim != 1 or samples.dtype.kind not in "fiub":
                continue
            values = samples.astype(float)
            if invalid is not None:
                values = np.where(np.asarray(invalid, dtype=bool), np.nan, values)
            columns[str(channel)] = np.ascontiguousarray(values)
        return columns

    def _frames(self, group: int, fragment: object) -> dict[str, Any]:
        import numpy as np

        signal = self._file._mdf.get(FRAME, group=group, data=fragment, ignore_invalidation_bits=True)
        samples, count, invalid = signal.samples, len(signal.samples), signal.invalidation_bits

        def column(name: str) -> np.ndarray:
            if f"{FRAME}.{name}" in samples.dtype.names:
                return np.asarray(samples[f"{FRAME}.{name}"])
            return np.zeros(count)

        data = np.ascontiguousarray(column("DataBytes"), dtype=np.uint8).reshape(count, -1 if count else 8)
        return {
            "time": np.asarray(signal.timestamps, dtype=float),
            "identifier": column("ID").astype(np.uint32),
            "extended": (column("IDE") > 0).astype(np.uint8),
            "bus": column("BusChannel").astype(np.int64),
            "length": column("DataLength").astype(np.int64),
            "invalid": np.zeros(count, np.uint8) if invalid is None else np.asarray(invalid).astype(np.uint8),
            "data": data,
        }
