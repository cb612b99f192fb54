"""The process in which native code reads a file, with limits of memory and time; its crash becomes one error."""

from __future__ import annotations

import atexit
import contextlib
import functools
import json
import math
import os
import select
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import weakref
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, BinaryIO

import numpy as np

from tierod.core.errors import DamagedFile
from tierod.core.processes import THREADS, interpreter, runs
from tierod.io.formats import require_library
from tierod.io.readers import child, mdf_child
from tierod.io.readers.content import VARIABLE, Limits, limits

REPLY = 256  # Size of the buffer for a reply of a template [bytes]
PAUSE: Annotated[float, "s"] = 0.01  # Polling interval for the end of a reader [s]
GRACE: Annotated[float, "s"] = 5.0  # Time that a template has to end after its socket is closed [s]


class TemplateEnded(Exception):
    """A template ended before it could start a reader."""

    def __init__(self, code: int):
        super().__init__(f"the process ended with {code}")
        self.code = code


class Template:
    """A process that has imported a library and starts readers; it ends with the process that made it.

    The import takes half a second, a fork a hundredth of that, so that many small files of a fleet are read in the time
    of one.
    """

    def __init__(self, script: str):
        self.owner, self._lock = os.getpid(), threading.Lock()
        self._line, other = socket.socketpair()
        threads = dict.fromkeys((*THREADS, "NUMEXPR_MAX_THREADS"), "1")
        with other:
            self._process = subprocess.Popen(
                interpreter(str(child.__file__), script),
                stdin=other.fileno(),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=os.environ | threads,
            )

    def start(self, path: str, memory: int, folder: Path | None, line: socket.socket) -> int:
        """Start a reader that answers on a socket, and return its process identifier."""
        about = {"path": path, "memory": memory, "folder": folder and str(folder)}
        return int(self._ask(about, [line.fileno()])["pid"])

    def code(self, pid: int) -> int | None:
        """Exit code of a reader: its exit status, a negative signal, or None while it runs."""
        code = self._ask({"ended": pid}, [])["code"]
        return None if code is None else int(code)

    def _ask(self, request: dict[str, object], ends: list[int]) -> dict[str, Any]:
        reply = b""
        with self._lock, contextlib.suppress(OSError):
            socket.send_fds(self._line, [json.dumps(request).encode()], ends)
            reply = self._line.recv(REPLY)
        if not reply:
            raise TemplateEnded(self.end())
        found: dict[str, Any] = json.loads(reply)
        return found

    def end(self) -> int:
        self._line.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self._process.wait(GRACE)
        self._process.kill()
        return self._process.wait()


_templates: dict[str, Template] = {}
_starting = threading.Lock()


@dataclass(frozen=True)
class Started:
    template: Template  # that it was forked from
    pid: int
    line: socket.socket  # requests to it; it ends where this one is closed
    answers: BinaryIO  # of the same socket

    def code(self, patience: float) -> int | None:
        """Exit code, awaited for some time [s]; None where the reader still runs or the code is unknown."""
        until = time.monotonic() + patience
        while True:
            try:
                code = self.template.code(self.pid)
            except TemplateEnded:
                return None
            if code is not None or time.monotonic() > until:
                return code
            time.sleep(PAUSE)

    def end(self) -> None:
        with contextlib.suppress(OSError, TemplateEnded):
            if self.template.code(self.pid) is None:
                os.kill(self.pid, signal.SIGKILL)
                self.code(1.0)
        with contextlib.suppress(OSError):
            self.line.shutdown(socket.SHUT_RDWR)
        self.answers.close()
        self.line.close()


def started(script: str, path: str, memory: int, folder: Path | None) -> Started:
    """A reader of one file, forked from the template of its library; one that was ended from outside starts again."""
    ours, theirs = socket.socketpair()
    try:
        with theirs, _starting:
            template = _templates.get(script)
            # One of the process that this one was forked from is not ours.
            if template is not None and template.owner == os.getpid():
                with contextlib.suppress(TemplateEnded):
                    return Started(template, template.start(path, memory, folder, theirs), ours, ours.makefile("rb"))
            template = _templates[script] = Template(script)
            return Started(template, template.start(path, memory, folder, theirs), ours, ours.makefile("rb"))
    except BaseException:
        ours.close()
        raise


@atexit.register
def _end_all() -> None:
    for template in _templates.values():
        if template.owner == os.getpid():
            template.end()


@dataclass(frozen=True)
class Budget:
    # memory beyond that at its start and the size of the file [bytes]; recordings of cars take a tenth
    memory: Annotated[int, "byte"] = 10**9
    seconds: Annotated[float, "s"] = 5.0  # computing time for all answers together [s], to which the next two are added
    per_answer: Annotated[float, "s"] = 0.1  # additional computing time per answer [s]; a small file takes half of it
    # additional computing time per answer and byte of the file [s]; reading a disk once takes a tenth
    per_byte: Annotated[float, "s/byte"] = 5e-8
    # ratio of the longest wait for an answer to the computing time, for a machine with other work
    patience: Annotated[float, ""] = 8.0


BUDGET = Budget()

# Beginning of the name of a temporary folder; the identifier of the process that removes it follows
PREFIX = "tierod-reading-"

_KINDS = {kind: kind for kind in ("<f8", "<i8", "<u4", "|u1")}  # Types of numbers that an answer may hold


class ReaderProcess:
    """A process that reads one file; it ends with this object, and with the process that made it."""

    def __init__(self, path: Path, script: ModuleType, library: str, kind: str):
        self.path, self._library, self._kind = path, library, kind
        size = path.stat().st_size
        self._memory = int(BUDGET.memory * max(limits().largest / Limits.largest, 1.0))
        self._seconds, self._more = BUDGET.seconds, BUDGET.per_answer + BUDGET.per_byte * size
        # The library unpacks into a folder of its own, which is removed here: a killed process removes nothing.
        folder = reading_folder()
        try:
            self._reader = started(str(script.__file__), str(path.absolute()), self._memory + size, folder)
        except TemplateEnded as end:
            _remove(folder)
            raise self._ended(end.code) from None
        self.close = weakref.finalize(self, _end, self._reader, folder)

    def ask(self, request: Mapping[str, object]) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        self._seconds += self._more
        try:
            about, arrays = self._answer(json.dumps({**request, "seconds": self._seconds}).encode() + b"\n")
        except (OSError, ValueError, TypeError, KeyError):
            raise self._died() from None
        if "memory" in about:
            raise self._refused(f"it takes over {self._memory / 1e9:.3g} GB of memory; {VARIABLE} raises the limit")
        if "error" in about:
            raise self._refused(about["error"])
        return about, arrays

    def answers(self, request: Mapping[str, object]) -> Iterator[tuple[dict[str, Any], dict[str, np.ndarray]]]:
        """Answers, as of `ask`, to the same request until the process says that there are no more."""
        while not (answer := self.ask(request))[0]["end"]:
            yield answer

    def _answer(self, request: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        self._reader.line.sendall(request)
        if not select.select([self._reader.line], [], [], BUDGET.patience * self._seconds)[0]:
            raise self._refused(f"it gives no answer within {BUDGET.patience * self._seconds:.0f} s")
        about = json.loads(self._reader.answers.readline())
        arrays = {}
        for name, (kind, shape) in about["arrays"].items():
            dtype, size = np.dtype(_KINDS[kind]), math.prod(shape)
            data = self._reader.answers.read(size * dtype.itemsize)
            arrays[name] = np.frombuffer(data, dtype, size).reshape(shape)
        return about, arrays

    def _refused(self, reason: str) -> DamagedFile:
        self.close()
        return self._damaged(reason)

    def _damaged(self, reason: str) -> DamagedFile:
        return DamagedFile(
            f"{self.path} is damaged or cut off and cannot be read as {self._kind} ({reason}); export it again"
        )

    def _died(self) -> DamagedFile:
        code = self._reader.code(BUDGET.patience)
        if code is None:
            return self._refused(f"the answer of {self._library} makes no sense")
        self.close()
        return self._ended(code)

    def _ended(self, code: int) -> DamagedFile:
        if code == -signal.SIGXCPU:
            return self._damaged(f"it takes more than {self._seconds:.0f} s of computing")
        name = signal.Signals(-code).name if code < 0 else str(code)
        return self._damaged(f"{self._library} ended with {name} on it")


class MdfProcess(ReaderProcess):
    def __init__(self, path: Path):
        require_library("asammdf", "mdf", "reading an MDF file")
        super().__init__(path, mdf_child, "asammdf", "MDF")
        self._lanes = 0

    def lane(self, group: int, channels: list[int] | None) -> Iterator[dict[str, np.ndarray]]:
        """Arrays of some channels of a group, or of its frames, from the beginning."""
        self._lanes += 1
        request = {"lane": self._lanes, "group": group, "channels": channels}
        yield from (arrays for _, arrays in self.answers(request))


def reading_folder() -> Path | None:
    """A new temporary folder that the caller removes; None where none can be written."""
    try:
        folder = tempfile.gettempdir()
        _sweep(folder)
        return Path(tempfile.mkdtemp(prefix=f"{PREFIX}{os.getpid()}-", dir=folder))
    except OSError:
        return None


@functools.cache
def _sweep(folder: str) -> None:
    """Remove the folders that killed programs left, once per program."""
    for each in Path(folder).glob(f"{PREFIX}*"):
        number = each.name.removeprefix(PREFIX).partition("-")[0]
        if number.isdigit() and not runs(int(number)):
            shutil.rmtree(each, ignore_errors=True)


def _end(reader: Started, folder: Path | None) -> None:
    reader.end()
    _remove(folder)


def _remove(folder: Path | None) -> None:
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)
