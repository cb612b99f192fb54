"""Store of analysed recordings: folders named by the digest of their inputs, each complete or absent.

series/KE/KEY/      the signals of a recording
results/KE/KEY/     results of the monitors: findings, estimates, reports
known/STAMP.json    results that belong to a file, given by its path, size and time of change
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import secrets
import shutil
import threading
from pathlib import Path
from typing import Any

from tierod.core.errors import OutputError
from tierod.core.files import write_text
from tierod.core.processes import runs
from tierod.core.version import __version__
from tierod.web.errors import Absent

KINDS = ("series", "results")

KEY = re.compile(r"(?:p-)?[0-9a-f]{64}")
"""Form of the folder names; the key of a preview, made before a file is read to its end, begins with "p-"."""


class Store:
    """Stored results in one cache folder, which several processes may use.

    Args:
        folder: the cache folder, created if missing

    Raises:
        OutputError: the folder cannot be created
    """

    def __init__(self, folder: Path):
        self.folder = folder
        try:
            for name in (*KINDS, "known", "uploads"):
                (folder / name).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(
                f"{folder} cannot be written ({(error.strerror or '').lower()}); name another folder with --cache"
            ) from None
        self._lock = threading.Lock()
        self._known: dict[str, dict[str, Any]] = {}

    def path(self, kind: str, key: str) -> Path:
        """Path of a result, whether it exists or not."""
        if not KEY.fullmatch(key):
            raise Absent("no such result; open the recording from the list")
        return self.folder / kind / key[:4] / key

    def holds(self, kind: str, key: str) -> bool:
        """Whether a result exists; marks it as used now."""
        path = self.path(kind, key)
        with contextlib.suppress(OSError):
            os.utime(path)
            return True
        return False

    def begun(self, kind: str) -> Path:
        """A new folder for a result, which `settled` renames."""
        path = self.folder / kind / f".new-{os.getpid()}-{secrets.token_hex(6)}"
        path.mkdir()
        return path

    def settled(self, folder: Path, kind: str, key: str) -> Path:
        """Rename a folder to the key of its result; an existing result is kept."""
        target = self.path(kind, key)
        target.parent.mkdir(exist_ok=True)
        try:
            os.rename(folder, target)
        except OSError:
            shutil.rmtree(folder, ignore_errors=True)
            if not target.is_dir():
                raise
        return target

    def known(self, stamp: str) -> dict[str, Any]:
        """Results that belong to a file; empty if nothing is stored, or another version of tierod stored it."""
        with self._lock:
            found = self._known.get(stamp)
        if found is None:
            try:
                found = json.loads((self.folder / "known" / f"{stamp}.json").read_text(encoding="utf-8"))
            except (OSError, ValueError):
                return {}
            with self._lock:
                self._known[stamp] = found
        return dict(found) if found.get("version") == __version__ else {}

    def remember(self, stamp: str, facts: dict[str, Any]) -> None:
        """Store facts about a file; facts stored before under other names are kept."""
        together = self.known(stamp) | facts | {"version": __version__}
        write_text(self.folder / "known" / f"{stamp}.json", json.dumps(together), sweeps=False)
        with self._lock:
            self._known[stamp] = together

    def forget_read(self, stamp: str) -> None:
        """Discard the cached facts about a file, since another process has changed them."""
        with self._lock:
            self._known.pop(stamp, None)

    def sweep(self, limit: int) -> None:
        """Remove remains of killed processes, and the least recently used results until the rest is within a limit."""
        found: list[tuple[float, int, Path]] = []
        for kind in KINDS:
            for left in (self.folder / kind).glob(".new-*"):
                number = left.name.split("-")[1]
                if not (number.isdigit() and runs(int(number))):
                    shutil.rmtree(left, ignore_errors=True)
            for path in (self.folder / kind).glob("*/*"):
                with contextlib.suppress(OSError):
                    size = sum(each.stat().st_size for each in path.iterdir() if each.is_file())
                    found.append((path.stat().st_mtime, size, path))
        total = sum(size for _, size, _ in found)
        for _, size, path in sorted(found):
            if total <= limit:
                return
            shutil.rmtree(path, ignore_errors=True)
            total -= size


def stamp_of(path: Path) -> str:
    """Digest of a file's path, size and time of change, which identifies it without opening it."""
    try:
        status = path.stat()
    except OSError:
        raise Absent(f"{path.name} is gone; reload the list") from None
    return hashlib.sha256(
        f"{path}\0{status.st_size}\0{status.st_mtime_ns}".encode("utf-8", "surrogateescape")
    ).hexdigest()
