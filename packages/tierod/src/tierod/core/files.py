"""Output files, written beside the target and renamed, so that no reader sees a half-written file; digests of files."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import re
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from tierod.core.errors import OutputError
from tierod.core.processes import PATIENCE, alone

_REMEDIES = {
    errno.ENOSPC: "make room on the disk or name another place",
    errno.EDQUOT: "make room in your quota or name another place",
    errno.EACCES: "check the permissions of the folder or name another place",
    errno.EPERM: "check the permissions of the folder or name another place",
    errno.EROFS: "name a place that can be written",
    errno.ENOENT: "create the folder first",
    errno.ENOTDIR: "name a file in a folder that exists",
    errno.EISDIR: "name a file, not a folder",
    errno.ENAMETOOLONG: "shorten its name",
}


# Age from which a temporary file is a leftover of a killed process [s]; writing takes seconds
ABANDONED: Annotated[float, "s"] = 3600.0


@contextmanager
def replacing(path: str | Path, sweeps: bool = True) -> Iterator[Path]:
    """A temporary file beside the target; it replaces the target when the block ends without error, else it is removed.

    Args:
        path: the target; its folder must exist
        sweeps: whether leftovers of killed processes are removed; a store of thousands of files sweeps once by
            itself, since a sweep of its folder takes 2 ms
    """
    target = _final(expanded(path))
    temporary: Path | None = None
    try:
        temporary = _beside(target)
        if sweeps:
            sweep(target)
        yield temporary
        _settle(temporary)
        os.replace(temporary, target)
    except OSError as error:
        _forget(temporary)
        reason = (error.strerror or str(error)).lower()
        remedy = _REMEDIES.get(error.errno or 0, "check the disk or name another place")
        raise OutputError(f"{target} cannot be written: {reason}; {remedy}") from error
    except BaseException:
        _forget(temporary)
        raise


def write_text(path: str | Path, text: str, sweeps: bool = True) -> Path:
    """Write a text file in UTF-8, completely or not at all.

    Args:
        path: the target; its folder must exist
    """
    with replacing(path, sweeps) as temporary:
        # Lone surrogates, which stand for bytes of file names that are not Unicode, cannot be encoded.
        temporary.write_text(text, encoding="utf-8", errors="backslashreplace")
    return expanded(path)


def text_of(path: str | Path) -> str:
    """A path, or a text that names one, as text that every encoding of Unicode holds."""
    text = str(path)
    return text if text.isascii() else text.encode("utf-8", "backslashreplace").decode()


def expanded(path: str | Path) -> Path:
    """The path with the home folder in place of "~"; as given where there is no such user."""
    try:
        return Path(path).expanduser()
    except RuntimeError:
        return Path(path)


def sha256_of(path: Path) -> str:
    """SHA-256 of the content of a file, in hexadecimal; an OSError where it cannot be read."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def require_folder(path: str | Path) -> None:
    """Check that the folder of a file can be written, before the work whose result goes there."""
    folder = expanded(path).resolve().parent
    if not folder.is_dir():
        raise OutputError(f"{path} cannot be written: there is no folder {folder}; {_REMEDIES[errno.ENOENT]}")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{path} cannot be written: you may not write in {folder}; {_REMEDIES[errno.EACCES]}")


@contextmanager
def holding(path: str | Path) -> Iterator[Path]:
    """Lock the folder of a file, which need not exist, to read and change the file in one step; yields its path."""
    # A link is resolved once, so that lock, temporary file and new name are in one folder.
    place = expanded(path).resolve()
    require_folder(place)
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(alone(place.parent))
        except TimeoutError:
            raise OutputError(
                f"{path} cannot be written: another program has been writing in its folder for {PATIENCE:g} s; "
                "end that program if it hangs, and run again"
            ) from None
        yield place


def _final(target: Path) -> Path:
    """The path that is replaced: of a link its target, so that the link stays; devices and pipes are refused."""
    target = target.resolve() if target.is_symlink() else target
    if target.exists() and not target.is_file() and not target.is_dir():
        raise OutputError(f"{target} cannot be written: it is a device or a pipe; name a file")
    return target


def _beside(target: Path) -> Path:
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    # Not tempfile: only the owner may read its files, but others shall read a report like any new file.
    path = target.with_name(f".{target.stem[:100]}.{secrets.token_hex(6)}{target.suffix}")
    os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    return path


def temporary_name(stem: str, suffix: str) -> re.Pattern[str]:
    return re.compile(rf"\.{stem}\.[0-9a-f]{{12}}{re.escape(suffix)}")


def sweep(target: Path, age: float = ABANDONED) -> None:
    """Remove temporary files that killed processes left beside a target.

    Args:
        age: smallest age of the files that are removed [s]
    """
    left = temporary_name(re.escape(target.stem[:100]), target.suffix)
    now = time.time()
    with contextlib.suppress(OSError), os.scandir(target.parent) as entries:
        for entry in filter(lambda each: left.fullmatch(each.name), entries):
            with contextlib.suppress(OSError):
                if now - entry.stat(follow_symlinks=False).st_mtime >= age:
                    os.unlink(entry.path)


def _settle(temporary: Path) -> None:
    """Write a file to the disk before it is renamed, so that a power cut leaves the old file or the whole new one."""
    with temporary.open("rb+") as file:
        os.fsync(file.fileno())


def _forget(temporary: Path | None) -> None:
    if temporary is not None:
        with contextlib.suppress(OSError):
            temporary.unlink()
