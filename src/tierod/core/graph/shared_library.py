"""A shared library loaded from memory: the verified code runs, whatever becomes of the file it came from."""

from __future__ import annotations

import contextlib
import ctypes
import itertools
import os
import tempfile
from pathlib import Path

_SERIAL = itertools.count(1)


def loaded(code: bytes, name: str) -> ctypes.PyDLL:
    """The library of these bytes.

    Args:
        code: of the shared library
        name: for debuggers

    Raises:
        OSError: it is none, or not of this machine
    """
    if hasattr(os, "memfd_create"):
        # Without /proc, or where files in memory may not hold programs, the way below is left.
        with contextlib.suppress(OSError):
            return _from_memory(code, name)
    with tempfile.TemporaryDirectory(prefix="tierod-") as folder:
        path = Path(folder, f"{name}.so")
        path.write_bytes(code)
        return ctypes.PyDLL(str(path))


def _from_memory(code: bytes, name: str) -> ctypes.PyDLL:
    handle = os.memfd_create(name[:200])
    try:
        with open(handle, "wb", closefd=False) as file:
            file.write(code)
        # The loader takes equal paths for the same library, and handles are used again: the serial number makes every
        # path another one, written in binary with "./" for 0 and "/" for 1, which lead nowhere else.
        serial = f"{next(_SERIAL):b}".replace("1", "/").replace("0", "./")
        return ctypes.PyDLL(f"/proc/self/fd/{serial}{handle}")
    finally:
        os.close(handle)
