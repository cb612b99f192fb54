"""Store of analysed recordings: folders named by the digest of what made them, whole or not there.

series/KE/KEY/      the signals of a recording
results/KE/KEY/     what monitors found in it: findings, estimates, reports
identified/KE/KEY/  parameters that were found from recordings: document, page, vehicle file
known/STAMP.json    which of them belong to a file, known by its path, size and time of change
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

KINDS = ("series", "results", "identified")

KEY = re.compile(r"(?:p-)?[0-9a-f]{64}")
"""What names of folders look like; a first picture, before a file is read to its end, begins with "p-"."""


class Store:
    """The kept results of one cache folder; several processes may use it.

    Args:
        folder: is made where it is not there

    Raises:
        OutputError: it cannot be made
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
        """Path of a result, whether it is there or not.

        Args:
            kind: one of `KINDS`
            key: digest

        Raises:
            Absent: the key is none
        """
        if not KEY.fullmatch(key):
            raise Absent("no such result; open the recording from the list")
        return self.folder / kind / key[:4] / key

    def holds(self, kind: str, key: str) -> bool:
        """Whether a result is there; it counts as used then."""
        path = self.path(kind, key)
        with contextlib.suppress(OSError):
            os.utime(path)
            return True
        return False

    def begun(self, kind: str) -> Path:
        """A new folder, which `settled` gives its name."""
        path = self.folder / kind / f".new-{os.getpid()}-{secrets.token_hex(6)}"
        path.mkdir()
        return path

    def settled(self, folder: Path, kind: str, key: str) -> Path:
        """Give a folder its name; one that is there already stays.

        Args:
            folder: as `begun` gave it
            kind, key: of the result
        """
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
        """Entries that belong to a file; empty where nothing of it is kept, or another version of tierod kept it."""
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
        """Note what belongs to a file; what was noted before under other names stays."""
        together = self.known(stamp) | facts | {"version": __version__}
        write_text(self.folder / "known" / f"{stamp}.json", json.dumps(together), sweeps=False)
        with self._lock:
            self._known[stamp] = together

    def forget_read(self, stamp: str) -> None:
        """Read again what belongs to a file: another process has noted something."""
        with self._lock:
            self._known.pop(stamp, None)

    def sweep(self, limit: int) -> None:
        """Remove what killed processes left, and what was used longest ago, until the rest has its room.

        Args:
            limit: of all [bytes]
        """
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
    """A file by its path, size and time of change, without opening it.

    Raises:
        Absent: it is gone
    """
    try:
        status = path.stat()
    except OSError:
        raise Absent(f"{path.name} is gone; reload the list") from None
    return hashlib.sha256(
        f"{path}\0{status.st_size}\0{status.st_mtime_ns}".encode("utf-8", "surrogateescape")
    ).hexdigest()
