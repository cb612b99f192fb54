"""Files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tierod.errors import OutputError, TierodError

_REASONS = {
    "ENOSPC": "the disk is full; free some space or write elsewhere",
    "EDQUOT": "the quota is used up; free some space or write elsewhere",
    "EACCES": "no permission; write elsewhere or change the rights of the folder",
    "EPERM": "no permission; write elsewhere or change the rights of the folder",
    "EROFS": "the disk is read-only; write elsewhere",
    "ENOENT": "there is no such folder; create it first",
    "ENOTDIR": "a part of the path is a file, not a folder; correct the path",
    "EISDIR": "this is a folder; give a file name",
    "ENAMETOOLONG": "the name is too long; shorten it",
}


@contextlib.contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """A temporary file beside the target, to be written; it becomes the target when all went well, else it is removed.

    Args:
        path: the target; an existing file is replaced only by a whole new one

    Raises:
        OutputError: no such folder, no permission, disk full
    """
    target = Path(path)
    temporary: Path | None = None
    try:
        if target.is_dir():
            raise OutputError(f"{target} cannot be written: {_REASONS['EISDIR']}")
        handle, name = tempfile.mkstemp(prefix=f".{target.stem[:100]}.", suffix=target.suffix, dir=target.parent)
        os.close(handle)
        temporary = Path(name)
        yield temporary
        _settle(temporary, target)
        temporary = None
    except TierodError:
        raise
    except OSError as error:
        raise OutputError(f"{target} cannot be written: {_reason(error)}") from None
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def _settle(temporary: Path, target: Path) -> None:
    mask = os.umask(0)
    os.umask(mask)
    with temporary.open("rb+") as file:
        os.fsync(file.fileno())
    temporary.chmod(0o666 & ~mask)
    os.replace(temporary, target)


def _reason(error: OSError) -> str:
    import errno

    code = errno.errorcode.get(error.errno or 0, "")
    return _REASONS.get(code, f"{error.strerror or error}; check the path and the disk")


def write_text(path: str | Path, text: str) -> None:
    """Write a text file, whole or not at all.

    Raises:
        OutputError: no such folder, no permission, disk full
    """
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
