"""Log of a drive as MCAP while it is driven: signals, estimates and findings, for Foxglove and Lichtblick.

Topics: `/signals/NAME` with every sample of a signal, `/estimates/MONITOR` with the estimates of a monitor ten times a
second, and `/findings` with verdicts, problems and marks as log entries (`foxglove.Log`). Chunks are small and written
when they are full, so that a kill loses less than a second of a drive with signals.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from tierod.core.files import expanded, require_folder
from tierod.core.recording import Channel
from tierod.io.libraries import require_library
from tierod.live.log import refused

CHUNK: Annotated[int, "byte"] = 1 << 14
"""Size from which a chunk of the file is written."""

RATE: Annotated[float, "Hz"] = 10.0
"""Rate at which estimates are written."""

FLUSHED: Annotated[int, "ns"] = 250_000_000
"""Time of the drive between two flushes of the file buffer to the operating system."""

LEVELS = {"watch": 3, "bad": 4}
"""Levels of `foxglove.Log` by the colour of a status: 3 warning, 4 error; others are 2, information."""

LOG_SCHEMA = {
    "title": "foxglove.Log",
    "type": "object",
    "properties": {
        "timestamp": {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
        "level": {"type": "integer"},
        "message": {"type": "string"},
        "name": {"type": "string"},
        "file": {"type": "string"},
        "line": {"type": "integer"},
    },
}


class McapLog:
    """Writes signals, estimates and findings of a drive.

    Args:
        path: path of the file, which is replaced
        origin: calendar time of zero in the drive [s]

    Raises:
        MissingExtra: mcap is not installed
        OutputError: the file cannot be written
    """

    def __init__(self, path: str | Path, origin: float):
        require_library("mcap", "live", "writing an MCAP log")
        from mcap.writer import CompressionType, Writer

        require_folder(path)
        self.path, self.origin = expanded(path), origin
        self._channels: dict[str, int] = {}
        self._written: dict[str, float] = {}
        self._next: dict[str, float] = {}
        self._flushed = 0
        self._found = -math.inf
        try:
            self._file = self.path.open("wb")
            self._writer = Writer(self._file, chunk_size=CHUNK, compression=CompressionType.ZSTD)
            self._writer.start(library="tierod")
        except OSError as error:
            raise refused(self.path, error) from None

    def signals(self, channels: Sequence[Channel]) -> None:
        """Log samples of signals; samples already logged through another monitor are skipped.

        Raises:
            OutputError: the disk is full or gone
        """
        for each in channels:
            last = self._written.get(each.name, -math.inf)
            at = int(np.searchsorted(each.time, last, side="right"))
            if at == len(each.time):
                continue
            self._written[each.name] = float(each.time[-1])
            topic = self._topic(f"/signals/{each.name}", {"value": each.unit})
            for time, value in zip(each.time[at:].tolist(), each.values[at:].tolist(), strict=True):
                self._add(topic, time, {"value": value if math.isfinite(value) else None})

    def estimates(
        self, monitor: str, units: Mapping[str, str], time: np.ndarray, values: Mapping[str, np.ndarray]
    ) -> None:
        """Log the estimates of a monitor over one piece.

        Args:
            monitor: name of the monitor
            units: units of the estimates, by name
            time: time in the drive [s], (n,)
            values: values by name, (n,) each; names without an entry in `units` are skipped

        Raises:
            OutputError: the disk is full or gone
        """
        topic = self._topic(f"/estimates/{monitor}", units)
        for place, stamp in enumerate(time.tolist()):
            if stamp < self._next.get(monitor, -math.inf):
                continue
            # A microsecond less than the period: rounding must not skip the sample that is due.
            self._next[monitor] = stamp + 1.0 / RATE - 1e-6
            row = {name: float(values[name][place]) for name in units if name in values}
            self._add(topic, stamp, {name: value if math.isfinite(value) else None for name, value in row.items()})

    def finding(self, time: float, level: int, name: str, message: str) -> None:
        """Log a verdict, a problem or a mark.

        Args:
            time: time in the drive [s]
            level: level as in `LEVELS`
            name: name of the monitor, or kind of the event
            message: text of the entry

        Raises:
            OutputError: the disk is full or gone
        """
        if "/findings" not in self._channels:
            self._register("/findings", "foxglove.Log", LOG_SCHEMA)
        whole, part = divmod(self._stamp(time), 10**9)
        stamp = {"sec": whole, "nsec": part}
        entry = {"timestamp": stamp, "level": level, "message": message, "name": name, "file": "", "line": 0}
        # A verdict may be reported after one that began later, but readers need entries in the order of their log time.
        self._found = max(self._found, time)
        self._add(self._channels["/findings"], self._found, entry)

    def _topic(self, name: str, units: Mapping[str, str]) -> int:
        if name not in self._channels:
            properties = {each: {"type": ["number", "null"], "unit": unit} for each, unit in units.items()}
            self._register(name, name.strip("/").replace("/", "."), {"type": "object", "properties": properties})
        return self._channels[name]

    def _register(self, topic: str, name: str, schema: Mapping[str, Any]) -> None:
        number = self._writer.register_schema(name=name, encoding="jsonschema", data=json.dumps(schema).encode())
        self._channels[topic] = self._writer.register_channel(topic, "json", number)

    def _stamp(self, time: float) -> int:
        return max(round(self.origin) * 10**9 + round(time * 1e9), 0)

    def _add(self, channel: int, time: float, content: Mapping[str, Any]) -> None:
        stamp = self._stamp(time)
        try:
            self._writer.add_message(channel, stamp, json.dumps(content).encode(), stamp)
            if stamp - self._flushed > FLUSHED:
                self._flushed = stamp
                self._file.flush()
        except OSError as error:
            raise refused(self.path, error) from None

    def finish(self) -> None:
        """Write the index and close the file.

        Raises:
            OutputError: the disk is full or gone; what was written before stays readable
        """
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]  # the library has no annotation there
        except OSError as error:
            raise refused(self.path, error) from None
        finally:
            with contextlib.suppress(OSError):
                self._file.close()
