"""Folder of a campaign: one record per drive and per verdict, identified by the key of everything that determines it.

    drives/NAME-KEY.json         outcome of a drive, its provenance, and its recording
    recordings/NAME-KEY.parquet  recording of the drive, if it is kept
    verdicts/NAME-KEY.json       judgement of one monitor
    campaign.json, cells.parquet, report.html

Every file is written under a temporary name and renamed, so that files with their final name are complete. A record is
valid only if it contains the requested key; anything else is computed again.
"""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tierod.core.errors import InputError, OutputError
from tierod.core.files import sha256_of, write_text
from tierod.core.processes import alone
from tierod.core.recording import Recording
from tierod.core.user_files import MOST_DATA_BYTES, json_document, read_bytes

DRIVE_SCHEMA = "tierod.campaign-drive/1"
VERDICT_SCHEMA = "tierod.campaign-verdict/1"

LEFTOVER = re.compile(r"\..+\.[0-9a-f]{12}\.(json|parquet|html|toml)")
"""Names of files that were being written when a process was killed, see `tierod.core.files`."""

_SHOWN = 12  # Number of digits of a key in a file name; the complete key is in the file


@dataclass(frozen=True)
class Store:
    """Folder with the results of a campaign."""

    folder: Path

    def prepare(self) -> None:
        """Create the folders."""
        for path in self._folders():
            try:
                path.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise OutputError(
                    f"the folder {path} cannot be used ({(error.strerror or str(error)).lower()}); "
                    "name another one with --output"
                ) from error

    def _folders(self) -> tuple[Path, ...]:
        return (self.folder, *(self.folder / name for name in ("drives", "recordings", "verdicts")))

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Lock the prepared folder, and remove the incomplete files of killed processes.

        The lock ends with the process, however that ends.
        """
        lock = self.folder / ".lock"
        with ExitStack() as stack:
            lock.touch()
            try:
                stack.enter_context(alone(lock, patience=0.0))
            except TimeoutError:
                raise OutputError(
                    f"another campaign is running in {self.folder}; wait for it, or name another folder with --output"
                ) from None
            for path in self._folders():
                for left in path.iterdir():
                    if LEFTOVER.fullmatch(left.name):
                        left.unlink(missing_ok=True)
            yield

    def drive(self, name: str, key: str) -> dict[str, Any] | None:
        """The record of a drive, or None if there is no complete one of this key."""
        return _read(self._path("drives", name, key), DRIVE_SCHEMA, key)

    def verdict(self, name: str, key: str) -> dict[str, Any] | None:
        """The record of a verdict, or None if there is no complete one of this key."""
        return _read(self._path("verdicts", name, key), VERDICT_SCHEMA, key)

    def keep_drive(self, name: str, key: str, content: Mapping[str, object]) -> None:
        """Write the record of a drive."""
        _write(self._path("drives", name, key), DRIVE_SCHEMA, key, content)

    def keep_verdict(self, name: str, key: str, content: Mapping[str, object]) -> None:
        """Write the record of a verdict."""
        _write(self._path("verdicts", name, key), VERDICT_SCHEMA, key, content)

    def _path(self, kind: str, name: str, key: str, ending: str = "json") -> Path:
        return self.folder / kind / f"{name}-{key[:_SHOWN]}.{ending}"

    def keep_recording(self, name: str, key: str, recording: Recording) -> dict[str, Any]:
        """Write a recording, and return the file's entry for the record of its drive."""
        from tierod.io.writers import write

        path = self._path("recordings", name, key, "parquet")
        write(recording, path)
        file = path.relative_to(self.folder).as_posix()
        return {"file": file, "bytes": path.stat().st_size, "sha256": sha256_of(path)}

    def recording(self, drive: Mapping[str, Any]) -> Recording | None:
        """The recording of a drive, or None if it is missing, changed or unreadable."""
        from tierod.io.readers import read

        kept = drive.get("recording")
        if kept is None or not self.has_recording(drive):
            return None
        path = self.folder / kept["file"]
        with contextlib.suppress(OSError, InputError):
            return read(path) if sha256_of(path) == kept["sha256"] else None
        return None

    def has_recording(self, drive: Mapping[str, Any]) -> bool:
        """Whether the recording of a drive appears to exist; only its size is checked."""
        kept = drive.get("recording")
        try:
            return kept is not None and (self.folder / kept["file"]).stat().st_size == kept["bytes"]
        except OSError:
            return False


def slug(parts: Mapping[str, object], longest: int = 120) -> str:
    """A readable, safe file name from the place of a cell; if it is cut, the key keeps file names distinct."""
    text = "_".join(re.sub(r"[^A-Za-z0-9.+-]+", "-", str(part)).strip("-.") or "0" for part in parts.values())
    return text[:longest]


def _read(path: Path, schema: str, key: str) -> dict[str, Any] | None:
    with contextlib.suppress(InputError, ValueError):
        content = json_document(read_bytes(path, "the record", most=MOST_DATA_BYTES))
        if isinstance(content, dict) and (content.get("schema"), content.get("key")) == (schema, key):
            return content
    return None


def _write(path: Path, schema: str, key: str, content: Mapping[str, object]) -> None:
    document = {"schema": schema, "key": key, **content}
    write_text(path, json.dumps(document, ensure_ascii=False, indent=1, allow_nan=False) + "\n", sweeps=False)
