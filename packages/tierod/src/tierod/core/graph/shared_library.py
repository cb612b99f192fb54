"""Shared libraries loaded from memory: the verified code runs, whatever happens to the file that it came from."""

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

    Raises:
        OSError: it is no library, or one for another machine
    """
    if hasattr(os, "memfd_create"):
        # It fails without /proc, or where files in memory must not be executed; then the file below is used.
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
        # The loader takes equal paths for the same library, and descriptors are reused: the serial number makes every
        # path unique. It is written in binary with "./" for 0 and "/" for 1, which do not change where the path leads.
        serial = f"{next(_SERIAL):b}".replace("1", "/").replace("0", "./")
        return ctypes.PyDLL(f"/proc/self/fd/{serial}{handle}")
    finally:
        os.close(handle)
