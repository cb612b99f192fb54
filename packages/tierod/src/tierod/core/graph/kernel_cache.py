"""Cache of compiled kernels: only in a folder that no other user can write, each verified before it is loaded.

A file holds the digest of its own name and code, and the code. Exactly the bytes that were read and verified are
loaded, so that a file that is truncated or removed afterwards does not affect the process.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from tierod.core.errors import OutputError
from tierod.core.files import ABANDONED, replacing, temporary_name
from tierod.core.processes import alone

_HEAD = b"tierod-kernel/1\n"
_DIGEST = hashlib.sha256().digest_size

_OURS = re.compile(r"\w+-[0-9a-f]{24}\.(kernel|so)")
_HALF_WRITTEN = temporary_name(r"\w+-[0-9a-f]{24}", ".kernel")
_BUILD = "build-"


@dataclass(frozen=True)
class Bounds:
    # size of all kernels [B]; a thousand of the usual 70 kB and the largest of 2 MB fit
    bytes: Annotated[int, "B"] = 256 * 1024**2
    count: Annotated[int, ""] = 4096  # number of kernels [-]; the whole test suite makes about a thousand
    # time without use after which a kernel is removed [s]: its source or compiler has most likely changed
    unused: Annotated[float, "s"] = 90 * 86400.0
    # time since the last use within which a kernel is kept, whatever the other bounds [s]: running processes may load
    # it next
    recent: Annotated[float, "s"] = 3600.0
    # age from which a half-written file belongs to a killed process [s]; a running one needs milliseconds
    abandoned: Annotated[float, "s"] = ABANDONED
    # longest wait for another process that compiles the same kernel [s]; the largest takes about a minute
    waited: Annotated[float, "s"] = 300.0


@dataclass(frozen=True)
class KernelCache:
    folder: Path  # created where it is absent; it need not be usable
    bounds: Bounds = field(default_factory=Bounds)

    @property
    def where(self) -> str:
        """Place of the kernels, for the end of a sentence."""
        return f"in {self.folder}"

    def trouble(self) -> str:
        """Reason why the folder must not be used; "" where it may be used or does not exist yet."""
        with contextlib.suppress(OSError):
            if trouble := _trouble(self.folder.stat()):
                return f"the folder of compiled kernels {self.folder} is not used: {trouble}"
        return ""

    def kept(self, name: str) -> bytes | None:
        """The verified code of a kernel; None where there is none, or it must not be loaded."""
        try:
            place = os.open(self.folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
        except OSError:
            return None
        try:
            if _trouble(os.fstat(place)):
                return None
            digest, code = _read(place, f"{name}.kernel")
            return code if digest == _HEAD + _digest(name, code) else None
        except OSError:
            return None
        finally:
            os.close(place)

    def keep(self, name: str, code: bytes) -> None:
        """Write a kernel, completely or not at all, and remove kernels beyond the bounds."""
        target = self.folder / f"{name}.kernel"
        if target.is_dir() and not target.is_symlink():
            raise OutputError(f"there is a folder {target} where a compiled kernel belongs; remove it")
        if not target.is_file() or target.is_symlink():
            self.forget(name)  # `replacing` would follow a link, and refuses a pipe or a device
        with replacing(target, sweeps=False) as temporary:
            temporary.write_bytes(_HEAD + _digest(name, code) + code)
            temporary.chmod(0o600)
        with contextlib.suppress(OSError):
            self.prune()

    def forget(self, name: str) -> None:
        """Remove a kernel that cannot be loaded here."""
        with contextlib.suppress(OSError):
            (self.folder / f"{name}.kernel").unlink()

    @contextmanager
    def building(self, name: str) -> Iterator[Path]:
        """An empty folder to compile a kernel in, removed afterwards; one process at a time compiles a kernel."""
        build = self.folder / f"{_BUILD}{name}"
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if trouble := self.trouble():
                raise OutputError(trouble)
            with self._held(build) as private:
                yield private
        except TimeoutError:
            raise OutputError(
                f"another process has been compiling in {build} for {self.bounds.waited:g} s; end it if it hangs"
            ) from None
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise OutputError(
                f"the folder of compiled kernels {self.folder} cannot be used ({reason}); "
                "make room or give permission, or name another one with the environment variable TIEROD_CACHE"
            ) from None

    @contextmanager
    def _held(self, build: Path) -> Iterator[Path]:
        with contextlib.ExitStack() as stack:
            held = None
            while held is None:
                build.mkdir(mode=0o700, exist_ok=True)
                with contextlib.suppress(FileNotFoundError):  # the process that held it has removed it: make it again
                    held = stack.enter_context(alone(build, self.bounds.waited))
            try:
                # Not `build` itself: the compiler of a killed process may still be writing there.
                with tempfile.TemporaryDirectory(dir=build if held else self.folder, prefix=_BUILD) as private:
                    yield Path(private)
            finally:
                shutil.rmtree(build, ignore_errors=True)

    def prune(self) -> None:
        """Remove kernels unused for long, the oldest of too many, and leftovers of killed processes."""
        now = time.time()
        kernels = []
        for entry in os.scandir(self.folder):
            with contextlib.suppress(OSError):
                found = entry.stat(follow_symlinks=False)
                age = now - found.st_mtime
                if _OURS.fullmatch(entry.name) and stat.S_ISREG(found.st_mode):
                    kernels.append((age, found.st_size, entry.path))
                elif _HALF_WRITTEN.fullmatch(entry.name) and age > self.bounds.abandoned:
                    os.unlink(entry.path)
                elif entry.name.startswith(_BUILD) and stat.S_ISDIR(found.st_mode):
                    # Only folders of kernels are locked; earlier versions compile in others without a lock.
                    locked = _OURS.fullmatch(f"{entry.name.removeprefix(_BUILD)}.kernel") is not None
                    old = age > self.bounds.abandoned
                    if locked or old:
                        _sweep(Path(entry.path), old)
        held = 0
        for place, (age, size, path) in enumerate(sorted(kernels)):
            held += size
            beyond = held > self.bounds.bytes or place >= self.bounds.count or age > self.bounds.unused
            if beyond and age > self.bounds.recent:
                with contextlib.suppress(OSError):
                    os.unlink(path)


class NoCache:
    """Substitute for a cache where no folder can hold kernels: each is compiled in a temporary folder."""

    where = "nowhere: every process compiles its own"

    def trouble(self) -> str:
        """Always ""; there is no folder to refuse."""
        return ""

    def kept(self, name: str) -> bytes | None: ...

    def keep(self, name: str, code: bytes) -> None:
        """Nothing is kept."""

    def forget(self, name: str) -> None:
        """There is nothing to remove."""

    @contextmanager
    def building(self, name: str) -> Iterator[Path]:
        """An empty folder to compile a kernel in."""
        try:
            with tempfile.TemporaryDirectory(prefix="tierod-") as folder:
                yield Path(folder)
        except OSError as error:
            raise OutputError(f"no temporary folder can be used ({(error.strerror or str(error)).lower()})") from None


def _trouble(folder: os.stat_result) -> str:
    """Reason why a folder cannot be trusted, with the remedy; "" where it can."""
    if not hasattr(os, "getuid"):
        return ""
    other = "name another one with the environment variable TIEROD_CACHE"
    if folder.st_uid != os.getuid():
        return f"it belongs to another user, who could plant a program there; {other}"
    if folder.st_mode & 0o022:
        return f"other users may write there and could plant a program; remove that permission (chmod go-w), or {other}"
    return ""


def _read(place: int, name: str) -> tuple[bytes, bytes]:
    """Head and code of a file in an open folder; OSError where it is not regular or belongs to another user."""
    flags = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK  # opening a pipe in its place must not block
    handle = os.open(name, flags, dir_fd=place)
    with open(handle, "rb", buffering=0) as file:  # without a buffer a megabyte is copied once, not three times
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode) or _trouble(found):
            raise OSError("no kernel of ours")
        head, code = file.read(len(_HEAD) + _DIGEST), file.readall()
        with contextlib.suppress(OSError):
            os.utime(handle)  # `prune` removes the least recently used first
    return head, code


def _digest(name: str, code: bytes) -> bytes:
    digest = hashlib.sha256(name.encode() + b"\0")
    digest.update(code)
    return digest.digest()


def _sweep(build: Path, old: bool) -> None:
    """Remove the build folder of a killed process; where the system has no locks, once it is old."""
    with contextlib.suppress(TimeoutError), alone(build, 0.0) as held:
        if held or old:
            shutil.rmtree(build, ignore_errors=True)
