"""The process that reads an MDF file with asammdf, whose native code can end the process on a damaged file.

A script of its own that imports nothing of tierod, so that it starts fast. It takes requests, one JSON document a line,
and answers each with an Arrow stream whose schema carries a JSON document. `tierod.readers.mdf` is the other end.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import types
import warnings
from collections import Counter
from collections.abc import Iterator
from typing import Any

FRAME = "CAN_DataFrame"
BUS_GROUP = 2
"""Flag of a channel group that holds bus events (ASAM MDF 4.1)."""

FRAGMENT = 1 << 22
"""Bytes of records that are read at a time."""


def main() -> None:
    """Answer requests until the other end closes the pipe."""
    path, line, memory = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    end_with(line)
    # Prints of the library must not get between the answers.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    sys.modules["sympy"] = _without_formulas()
    import asammdf  # noqa: F401
    import pyarrow  # noqa: F401

    limit_memory(memory)
    warnings.simplefilter("ignore")
    reader = Reader(path)
    for request in sys.stdin:
        columns: dict[str, Any] = {}
        try:
            columns, answer = reader.answer(json.loads(request))
        except MemoryError:
            answer = {"memory": memory}
        except Exception as error:
            answer = {"error": " ".join(str(error).split())[:160] or type(error).__name__}
        _send(answers, columns, answer)


def end_with(line: int) -> None:
    """End when the other end of a pipe is closed, in native code too: the signal's default action is to end."""
    with contextlib.suppress(ImportError, AttributeError, OSError):
        import fcntl

        fcntl.fcntl(line, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(line, fcntl.F_SETFL, fcntl.fcntl(line, fcntl.F_GETFL) | os.O_ASYNC)


def limit_memory(more: int) -> None:
    """Take no more memory [bytes] than now and some more; 0 sets no limit."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        with open("/proc/self/statm") as file:
            now = int(file.read().split()[0]) * resource.getpagesize()
        if more:
            resource.setrlimit(resource.RLIMIT_AS, (now + more, now + more))


def limit_time(seconds: float) -> None:
    """Take no more computing time [s] than some more than now; the process is ended then."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (int(used.ru_utime + used.ru_stime + seconds) + 1, hard))


def _without_formulas() -> types.ModuleType:
    """In place of sympy, which takes half of the start, and would execute the text of a formula in the file."""

    def refuse(*_: Any, **__: Any) -> None:
        raise ValueError("the formula of a conversion cannot be evaluated")

    stand_in = types.ModuleType("sympy")
    stand_in.lambdify = stand_in.symbols = refuse  # type: ignore[attr-defined]
    return stand_in


def _send(answers: Any, columns: dict[str, Any], about: dict[str, Any]) -> None:
    import pyarrow as pa

    arrays = {name: pa.array(values) for name, values in columns.items()}
    schema = pa.schema([(name, array.type) for name, array in arrays.items()], {"about": json.dumps(about)})
    with pa.ipc.new_stream(answers, schema) as stream:
        stream.write_batch(pa.record_batch(list(arrays.values()), schema=schema))
    answers.flush()


class Reader:
    """One file.

    Args:
        path: of the file
    """

    def __init__(self, path: str):
        self._path = path
        self._file: Any = None
        self._lanes: dict[int, Iterator[dict[str, Any]]] = {}

    def answer(self, request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """(columns, what else there is to say) on a request for the content, or for the next piece of a lane."""
        limit_time(request["seconds"])
        if self._file is None:
            from asammdf import MDF

            self._file = MDF(self._path, process_bus_logging=False)
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
            "records": [int(group.channel_group.cycles_nr) for group in self._file.groups],
        }

    def _channels(self) -> list[dict[str, Any]]:
        """Every recorded channel, by a name that is unique in the file."""
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

    def _samples(self, group: int, channels: list[int], fragment: Any) -> dict[str, Any]:
        import numpy as np

        file = self._file._mdf
        columns = {"time": np.asarray(file.get_master(group, data=fragment), dtype=float)}
        for channel in channels:
            samples, invalid = file.get(group=group, index=channel, data=fragment, samples_only=True, raw=True)
            conversion = file.groups[group].channels[channel].conversion
            if conversion:
                samples = conversion.convert(samples, ignore_value2text_conversions=True)
            if samples.ndim != 1 or samples.dtype.kind not in "fiub":
                continue
            values = samples.astype(float)
            if invalid is not None:
                values = np.where(np.asarray(invalid, dtype=bool), np.nan, values)
            columns[str(channel)] = values
        return columns

    def _frames(self, group: int, fragment: Any) -> dict[str, Any]:
        import numpy as np
        import pyarrow as pa

        signal = self._file._mdf.get(FRAME, group=group, data=fragment)
        samples, count = signal.samples, len(signal.samples)

        def column(name: str) -> np.ndarray:
            if f"{FRAME}.{name}" in samples.dtype.names:
                return np.asarray(samples[f"{FRAME}.{name}"])
            return np.zeros(count)

        data = np.ascontiguousarray(column("DataBytes"), dtype=np.uint8).reshape(count, -1)
        packed = pa.Array.from_buffers(pa.binary(data.shape[1]), count, [None, pa.py_buffer(data)])
        return {
            "time": np.asarray(signal.timestamps, dtype=float),
            "identifier": column("ID").astype(np.uint32),
            "extended": column("IDE") > 0,
            "bus": column("BusChannel").astype(np.int64),
            "length": column("DataLength").astype(np.int64),
            "data": packed,
        }


if __name__ == "__main__":
    main()
