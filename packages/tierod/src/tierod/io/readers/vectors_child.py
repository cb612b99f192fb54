"""Reader of MATLAB 5 files through SciPy, and of MATLAB 7.3 and HDF5 files through h5py; imports nothing of tierod."""

from __future__ import annotations

import contextlib
import math
import tempfile
from collections.abc import Iterator
from typing import Any

MOST = 20_000  # data sets of an HDF5 file
AT_ONCE = 1 << 25  # bytes of variables that are loaded at a time
STRUCTURE = 1 << 16  # allowance for each [bytes], since structures have no size


class Reader:
    def __init__(self, path: str):
        self._path = path
        self._file: Any = None
        self._listing: Iterator[dict[str, Any]] = iter(())

    @staticmethod
    def prepare() -> None:
        import scipy.io  # noqa: F401

        with contextlib.suppress(ImportError):
            import h5py  # noqa: F401

    def answer(self, request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        if self._file is None:
            with open(self._path, "rb") as file:
                head = file.read(520)
            hdf5 = head.startswith((b"\x89HDF", b"MATLAB 7.3")) or head[512:516] == b"\x89HDF"
            self._file = (_Hdf5 if hdf5 else _Matlab)(self._path)
            self._listing = self._file.listing()
        if "names" not in request:
            found = next(self._listing, None)
            return {}, {"end": True} if found is None else {"end": False, **found}
        begin, end = request["begin"], request["end"]
        return {str(place): self._file.part(name, begin, end) for place, name in enumerate(request["names"])}, {}


class _Matlab:
    """A MATLAB 5 file, whose vectors are kept in a temporary file, since it has no random access."""

    def __init__(self, path: str):
        self._path = path
        self._kept = tempfile.TemporaryFile()  # noqa: SIM115
        self._places: dict[str, tuple[int, int]] = {}
        self._units: dict[str, str] = {}

    def listing(self) -> Iterator[dict[str, Any]]:
        import scipy.io

        for names in _portions(scipy.io.whosmat(self._path)):
            found: list[dict[str, Any]] = []
            loaded = scipy.io.loadmat(self._path, squeeze_me=True, struct_as_record=False, variable_names=names)
            for name, value in loaded.items():
                if not name.startswith("__"):
                    self._list(f"/{name}", value, found)
            yield {"found": found}
        yield {"found": [], "units": self._units}

    def _list(self, path: str, value: Any, found: list[dict[str, Any]]) -> None:
        import numpy as np

        timed = _timed_structure(path, value)
        if timed:
            for name, entry, unit in timed:
                before = len(found)
                self._list(name, entry, found)
                for each in found[before:]:
                    each["unit"] = unit
        elif hasattr(value, "_fieldnames"):
            for name in value._fieldnames:
                self._list(f"{path}/{name}", getattr(value, name), found)
        elif isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 1:
            for number, entry in enumerate(value):
                self._list(f"{path}{number}", entry, found)
        elif isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "fiub" and len(value) > 1:
            self._places[path] = self._kept.seek(0, 2), len(value)
            self._kept.write(np.ascontiguousarray(value, dtype="<f8").data.cast("B"))
            found.append({"path": path, "count": len(value), "unit": ""})
        elif isinstance(value, str) and path.startswith("/units/"):
            self._units[path.removeprefix("/units/")] = value
        elif isinstance(value, int | float | np.integer | np.floating) and math.isfinite(value):
            found.append({"path": path, "count": 1, "unit": "", "value": float(value)})

    def part(self, path: str, begin: int, end: int) -> Any:
        import numpy as np

        at, count = self._places[path]
        self._kept.seek(at + 8 * begin)
        return np.frombuffer(self._kept.read(8 * max(min(end, count) - begin, 0)), dtype="<f8")


def _timed_structure(path: str, value: Any) -> list[tuple[str, Any, str]]:
    """(path, vector, unit) of the signals and times of a structure that names its signals in fields; else empty.

    Simulink: `time` beside one or several `signals` with `values` and `label`, or `Time` beside `Data`.
    ControlDesk: `X` beside several `Y` with `Name`, `Data`, `Unit` and the number `XIndex` of their time.
    """
    fields = set(getattr(value, "_fieldnames", ()))
    if {"time", "signals"} <= fields:
        own = path.rsplit("/", 1)[-1]
        named = [each for each in _structures(value.signals) if hasattr(each, "values")]
        listed: list[tuple[str, Any, str]] = [(f"{path}/time", value.time, "")]
        for at, each in enumerate(named):
            name = _text(getattr(each, "label", "")) or (own if len(named) == 1 else f"{own}{at}")
            taken = any(before == f"{path}/{name}" for before, _, _ in listed)
            listed += _by_column(f"{path}/{name}{at}" if taken else f"{path}/{name}", each.values, "")
        return listed
    if {"Time", "Data"} <= fields or {"time", "data"} <= fields:  # a time series, or the like of it
        time, data = (value.Time, value.Data) if "Time" in fields else (value.time, value.data)
        own = path.rsplit("/", 1)[-1]
        return [(f"{path}/time", time, ""), *_by_column(f"{path}/{own}", data, _text(getattr(value, "Units", "")))]
    if {"X", "Y"} <= fields:
        times, signals = ([each for each in _structures(part) if hasattr(each, "Data")] for part in (value.X, value.Y))
        made = [(f"{path}/X{at}/time", each.Data, "") for at, each in enumerate(times, 1)]
        for number, signal in enumerate(signals, 1):
            clock, name = getattr(signal, "XIndex", 1), _text(getattr(signal, "Name", "")) or f"Y{number}"
            made.append((f"{path}/X{clock:.0f}/{name}", signal.Data, _text(getattr(signal, "Unit", ""))))
        return made
    return []


def _by_column(path: str, values: Any, unit: str) -> list[tuple[str, Any, str]]:
    """A vector, or the columns of a matrix under their numbers."""
    if getattr(values, "ndim", 1) != 2:
        return [(path, values, unit)]
    return [(f"{path}{number}", column, unit) for number, column in enumerate(values.T, 1)]


def _structures(value: Any) -> list[Any]:
    import numpy as np

    return [each for each in np.atleast_1d(np.array(value, dtype=object)) if hasattr(each, "_fieldnames")]


def _portions(variables: list[tuple[str, tuple[int, ...], str]]) -> list[list[str]]:
    """The names of the variables in portions that fit into memory."""
    parts: list[list[str]] = [[]]
    size = 0
    for name, shape, _ in variables:
        parts[-1].append(name)
        size += 8 * math.prod(shape) + STRUCTURE
        if size > AT_ONCE:
            parts.append([])
            size = 0
    return [part for part in parts if part]


class _Hdf5:
    def __init__(self, path: str):
        import h5py

        self._file = h5py.File(path, "r")

    def listing(self) -> Iterator[dict[str, Any]]:
        found: list[dict[str, Any]] = []
        self._list(self._file, "", found)
        yield {"found": found}

    def _list(self, group: Any, prefix: str, found: list[dict[str, Any]]) -> None:
        """List every vector of numbers, every column of a table, and every single number."""
        import h5py

        for name in group:
            # A link to another file would read what the user did not name.
            if name == "#refs#" or isinstance(group.get(name, getlink=True), h5py.ExternalLink | h5py.SoftLink):
                continue
            if len(found) >= MOST:
                raise ValueError(f"it holds more than {MOST} data sets")
            item, path = group[name], f"{prefix}/{name}"
            if isinstance(item, h5py.Group):
                if path.count("/") < 32:
                    self._list(item, path, found)
            elif isinstance(item, h5py.Dataset) and not item.external and not item.is_virtual:
                found += _data(item, path)

    def part(self, name: str, begin: int, end: int) -> Any:
        import numpy as np

        path, _, field = name.partition("\0")
        item = self._file[path]
        rows = item[tuple(slice(begin, end) if size != 1 else 0 for size in item.shape)]
        return np.ascontiguousarray(np.asarray(rows[field] if field else rows).ravel(), dtype="<f8")


def _data(item: Any, path: str) -> list[dict[str, Any]]:
    shape = [size for size in (item.shape or ()) if size != 1]
    if _text(item.attrs.get("MATLAB_class", b"")) in ("char", "cell", "function_handle"):
        return []
    if item.dtype.names and len(shape) == 1:
        plain = [name for name in item.dtype.names if item.dtype[name].kind in "fiub" and not item.dtype[name].shape]
        return [{"path": f"{path}\0{name}", "count": int(shape[0]), "unit": ""} for name in plain]
    if item.dtype.kind in "fiub" and len(shape) == 1:
        unit = next((_text(item.attrs[key]) for key in ("unit", "units", "Unit", "Units") if key in item.attrs), "")
        return [{"path": path, "count": int(shape[0]), "unit": unit}]
    if item.dtype.kind in "fiu" and not shape and item.size == 1:
        return [{"path": path, "count": 1, "unit": "", "value": float(item[()].ravel()[0])}]
    return []


def _text(value: Any) -> str:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value if isinstance(value, str) else ""
