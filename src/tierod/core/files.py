"""Output files: written beside the target and renamed, so that no reader ever finds a half-written one."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from tierod.core.errors import OutputError
from tierod.core.locks import PATIENCE, alone

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


ABANDONED: Annotated[float, "s"] = 3600.0
"""Temporary files that have not been written to for so long belong to a killed process: writing takes seconds."""


@contextmanager
def replacing(path: str | Path, sweeps: bool = True) -> Iterator[Path]:
    """A path beside the target to write to; it becomes the target when the block ends well and vanishes otherwise.

    Args:
        path: the target; its folder must exist
        sweeps: whether leftovers of killed processes are removed; a store of thousands of files does that once
            itself, since a look takes 2 ms there

    Raises:
        OutputError: the file cannot be written; the message states cause and remedy
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
    """Write a whole text file in UTF-8, or nothing.

    Args:
        path: the target; its folder must exist
        text: to be written
        sweeps: as of `replacing`

    Raises:
        OutputError: the file cannot be written; the message states cause and remedy
    """
    with replacing(path, sweeps) as temporary:
        # Half characters, as in names of files in no Unicode, are in no UTF-8.
        temporary.write_text(text, encoding="utf-8", errors="replace")
    return expanded(path)


def expanded(path: str | Path) -> Path:
    """The path with the home folder in place of "~"; as given where there is no such user."""
    try:
        return Path(path).expanduser()
    except RuntimeError:
        return Path(path)


def require_folder(path: str | Path) -> None:
    """See that a file can be written where it shall be, before work is done whose result goes there.

    Raises:
        OutputError: its folder is missing or cannot be written
    """
    folder = expanded(path).resolve().parent
    if not folder.is_dir():
        raise OutputError(f"{path} cannot be written: there is no folder {folder}; {_REMEDIES[errno.ENOENT]}")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{path} cannot be written: you may not write in {folder}; {_REMEDIES[errno.EACCES]}")


@contextmanager
def holding(path: str | Path) -> Iterator[Path]:
    """Hold a file, which need not exist, against other programs that read and change it in one; gives where it lies.

    Raises:
        OutputError: its folder is missing or cannot be written, or another program holds it without end
    """
    # A link is followed once: lock, temporary file and new name belong into one folder.
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
    """Target of a link: the file is replaced there, and the link stays; devices and pipes are never replaced."""
    target = target.resolve() if target.is_symlink() else target
    if target.exists() and not target.is_file() and not target.is_dir():
        raise OutputError(f"{target} cannot be written: it is a device or a pipe; name a file")
    return target


def _beside(target: Path) -> Path:
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    # Not tempfile: its files are the owner's alone, but a report is read by others as any new file is.
    path = target.with_name(f".{target.stem[:100]}.{secrets.token_hex(6)}{target.suffix}")
    os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    return path


def temporary_name(stem: str, suffix: str) -> re.Pattern[str]:
    """Pattern of the names of temporary files of `replacing`.

    Args:
        stem: of the target's name, as a regular expression
        suffix: of the target's name
    """
    return re.compile(rf"\.{stem}\.[0-9a-f]{{12}}{re.escape(suffix)}")


def sweep(target: Path, age: float = ABANDONED) -> None:
    """Remove what killed processes left beside a target.

    Args:
        target: as it is written with `replacing`
        age: of the files left behind, at least [s]
    """
    left = temporary_name(re.escape(target.stem[:100]), target.suffix)
    now = time.time()
    with contextlib.suppress(OSError), os.scandir(target.parent) as entries:
        for entry in filter(lambda each: left.fullmatch(each.name), entries):
            with contextlib.suppress(OSError):
                if now - entry.stat(follow_symlinks=False).st_mtime >= age:
                    os.unlink(entry.path)


def _settle(temporary: Path) -> None:
    """On the disk before it gets its name, so that a power cut leaves the old file or the whole new one."""
    with temporary.open("rb+") as file:
        os.fsync(file.fileno())


def _forget(temporary: Path | None) -> None:
    if temporary is not None:
        with contextlib.suppress(OSError):
            temporary.unlink()
