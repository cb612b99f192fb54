"""Reader of MATLAB 5 files through SciPy for the process of `tierod.io.readers.child`; imports nothing of tierod."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

# Size of the variables that are loaded at a time, and allowance for each, since structures have no size [bytes]
_AT_ONCE, _STRUCTURE = 1 << 25, 1 << 16

_LONGEST_TEXT = 80  # Largest number of characters of a text that is kept: units are short


class Reader:
    """Reads one file."""

    def __init__(self, path: str):
        self._path = path
        self._waiting: list[list[str]] | None = None

    @staticmethod
    def prepare() -> None:
        """Import what is needed, before memory is limited."""
        import scipy.io  # noqa: F401

    def answer(self, request: dict[str, object]) -> tuple[dict[str, Any], dict[str, Any]]:
        """(vectors by number, where they belong) of the next variables.

        Returns:
            the vectors as floats, and "variables" as nested dictionaries and lists, with {"vector": number} for a
            vector, numbers for numbers and None for all else; "end" where no variables are left
        """
        import scipy.io

        try:
            if self._waiting is None:
                self._waiting = _together(scipy.io.whosmat(self._path))
            if not self._waiting:
                return {}, {"end": True}
            names = self._waiting.pop(0)
            loaded = scipy.io.loadmat(self._path, squeeze_me=True, struct_as_record=False, variable_names=names)
        except NotImplementedError:
            return {}, {"newer": True}
        vectors: dict[str, np.ndarray] = {}
        members = {name: _plain(value, vectors) for name, value in loaded.items() if not name.startswith("__")}
        return vectors, {"end": False, "variables": members}


def _together(variables: list[tuple[str, tuple[int, ...], str]]) -> list[list[str]]:
    parts: list[list[str]] = [[]]
    size = 0
    for name, shape, _ in variables:
        parts[-1].append(name)
        size += 8 * math.prod(shape) + _STRUCTURE
        if size > _AT_ONCE:
            parts.append([])
            size = 0
    return [part for part in parts if part]


def _plain(value: object, vectors: dict[str, np.ndarray]) -> object:
    """A value in a form for JSON, its vectors moved to `vectors`."""
    import numpy as np

    if hasattr(value, "_fieldnames"):
        return {field: _plain(getattr(value, field), vectors) for field in value._fieldnames}
    if isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 1:
        return [_plain(entry, vectors) for entry in value]
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "fiub" and len(value) > 1:
        number = str(len(vectors))
        vectors[number] = np.ascontiguousarray(value, dtype="<f8")
        return {"vector": number}
    if isinstance(value, str):
        return value[:_LONGEST_TEXT]
    if isinstance(value, int | float | np.integer | np.floating) and math.isfinite(value):
        return float(value)
    return None
