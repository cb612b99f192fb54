"""A process that has imported one library, from which the readers of single files are forked."""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import signal
import socket
import subprocess
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, BinaryIO

from tierod.core.processes import interpreter
from tierod.core.threads import THREADS
from tierod.io.readers import child

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

    def start(self, path: str, memory: int, folder: Path | None, ends: tuple[int, int, int]) -> int:
        """Start a reader and return its process identifier.

        Args:
            memory: memory that it may take beyond that of the template [bytes]
            folder: folder for its temporary files; None for the usual one
        """
        return int(self._ask({"path": path, "memory": memory, "folder": folder and str(folder)}, list(ends))["pid"])

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
        """End the process and return its exit status, a negative signal where one ended it."""
        self._line.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self._process.wait(GRACE)
        self._process.kill()
        return self._process.wait()


_templates: dict[str, Template] = {}
_starting = threading.Lock()


@dataclass(frozen=True)
class Started:
    """A reader and the pipes to it."""

    template: Template  # template that it was forked from
    pid: int  # its process identifier
    requests: BinaryIO  # pipe to it
    answers: BinaryIO  # pipe from it
    life: int  # end of the pipe whose closing ends it

    def code(self, patience: float) -> int | None:
        """Exit code; None where the reader still runs or the code is unknown.

        Args:
            patience: longest wait for its end [s]
        """
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
        """End the reader, close the pipes, and have the template collect its exit code."""
        with contextlib.suppress(OSError, TemplateEnded):
            if self.template.code(self.pid) is None:
                os.kill(self.pid, signal.SIGKILL)
                self.code(1.0)
        for stream in (self.requests, self.answers):
            with contextlib.suppress(OSError):
                stream.close()
        os.close(self.life)


def started(script: str, path: str, memory: int, folder: Path | None) -> Started:
    """A reader of one file, forked from the template of its library.

    Args:
        memory: memory that it may take [bytes]
        folder: folder for its temporary files; None for the usual one
    """
    requests, to_reader = os.pipe()
    from_reader, answers = os.pipe()
    life, line = os.pipe()
    try:
        template, pid = _forked(script, (path, memory, folder), (requests, answers, life))
    except BaseException:
        for end in (to_reader, from_reader, line):
            os.close(end)
        raise
    finally:
        for end in (requests, answers, life):
            os.close(end)
    return Started(template, pid, os.fdopen(to_reader, "wb"), os.fdopen(from_reader, "rb"), line)


def _forked(script: str, about: tuple[str, int, Path | None], ends: tuple[int, int, int]) -> tuple[Template, int]:
    """(template, identifier of a new reader); a template that was ended from outside is started again, once."""
    with _starting:
        template = _templates.get(script)
        if template is not None and template.owner != os.getpid():
            template = None  # it belongs to the process that this one was forked from
        if template is not None:
            with contextlib.suppress(TemplateEnded):
                return template, template.start(*about, ends)
        template = _templates[script] = Template(script)
        return template, template.start(*about, ends)


@atexit.register
def _end_all() -> None:
    for template in _templates.values():
        if template.owner == os.getpid():
            template.end()
