"""Reader of HDF5 and MATLAB 7.3 files through h5py for the process of `tierod.io.readers.child`; imports no tierod."""

from __future__ import annotations

from typing import Any

MOST = 20_000  # Largest number of data sets in a file


class Reader:
    """Reads one file."""

    def __init__(self, path: str):
        self._path = path
        self._file: Any = None

    @staticmethod
    def prepare() -> None:
        """Import what is needed, before memory is limited."""
        import h5py  # noqa: F401

    def answer(self, request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """(arrays, further metadata) in answer to a request for the content, or for a stretch of some data sets."""
        import h5py

        if self._file is None:
            self._file = h5py.File(self._path, "r")
        if "names" in request:
            begin, end = request["begin"], request["end"]
            parts = {str(place): self._part(name, begin, end) for place, name in enumerate(request["names"])}
            return parts, {}
        found: list[dict[str, Any]] = []
        self._list(self._file, "", found)
        return {}, {"found": found}

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
                self._list_data(item, path, found)

    def _list_data(self, item: Any, path: str, found: list[dict[str, Any]]) -> None:
        shape = [size for size in (item.shape or ()) if size != 1]
        if _text(item.attrs.get("MATLAB_class", b"")) in ("char", "cell", "function_handle"):
            return
        if item.dtype.names and len(shape) == 1:
            for name in item.dtype.names:
                if item.dtype[name].kind in "fiub" and not item.dtype[name].shape:
                    found.append({"path": f"{path}\0{name}", "count": int(shape[0]), "unit": ""})
        elif item.dtype.kind in "fiub" and len(shape) == 1:
            unit = next((_text(item.attrs[key]) for key in ("unit", "units", "Unit", "Units") if key in item.attrs), "")
            found.append({"path": path, "count": int(shape[0]), "unit": unit})
        elif item.dtype.kind in "fiu" and not shape and item.size == 1:
            found.append({"path": path, "count": 1, "unit": "", "value": float(item[()].ravel()[0])})

    def _part(self, name: str, begin: int, end: int) -> Any:
        import numpy as np

        path, _, field = name.partition("\0")
        item = self._file[path]
        place = tuple(slice(begin, end) if size != 1 else 0 for size in item.shape)
        rows = item[place]
        return np.ascontiguousarray(np.asarray(rows[field] if field else rows).ravel(), dtype="<f8")


def _text(value: Any) -> str:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value if isinstance(value, str) else ""
