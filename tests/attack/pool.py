"""Runs commands in worker processes: restarts a worker that died, and judges what became of each command."""

from __future__ import annotations

import contextlib
import json
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .worker import MEMORY, SECONDS

WAIT = 12.0 * SECONDS
"""By the clock, after which a worker that waits is ended [s]: the machine may be busy with other things."""

LONGEST_SENTENCE = 4000
"""Characters of an error beyond which it is a flood."""

WORKER_LIFE = 1500
"""Commands after which a worker is replaced, so that what one leaves behind does not burden the others for ever."""

# A terminal acts on these; a line end and a tab are all that output needs.
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")

_SHORT = re.compile(r"not enough memory|MemoryError|malloc of size|bad_alloc|[Uu]nable to allocate|out of memory")


@dataclass(frozen=True)
class Result:
    """What became of a command."""

    kind: str
    code: int | None
    stdout: str
    stderr: str
    detail: str = ""
    seconds: float = 0.0
    memory: int = 0


class Pool:
    """One worker process, and the folder in which its commands run."""

    def __init__(self, wait: float = WAIT) -> None:
        self.wait = wait
        self.home = Path(tempfile.mkdtemp(prefix="tierod-attack-"))
        self.process: subprocess.Popen | None = None
        self.left = 0
        self.folder()

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()
        shutil.rmtree(self.home, ignore_errors=True)

    def folder(self) -> Path:
        """An empty folder for the files of a command."""
        folder = self.home / "case"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        return folder

    def run(self, arguments: list[str], encoding: str = "utf-8") -> Result:
        """Run a command in the folder that was asked for last."""
        if self.process is None or not self.left:
            self._end()
            self._begin()
        assert self.process is not None
        assert self.process.stdin is not None
        self.left -= 1
        wish = {"arguments": arguments, "folder": str(self.home / "case"), "encoding": encoding}
        try:
            self.process.stdin.write(json.dumps(wish).encode() + b"\n")
            self.process.stdin.flush()
            line = self._line(self.wait)
        except BrokenPipeError:
            line = b""
        if line is None:
            self._end()
            return self._result("hang", None, f"no end after {self.wait:g} s by the clock")
        if not line:
            return self._died()
        return self.judged(json.loads(line))

    def _begin(self) -> None:
        for name in ("stdout", "stderr"):
            (self.home / name).write_bytes(b"")
        package = f"{__package__}.worker"
        paths = [str(Path(__file__).resolve().parents[len(package.split(".")) - 1]), *sys.path]
        self.process = subprocess.Popen(
            [sys.executable, "-m", package, str(self.home)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), "COLUMNS": "120", "MALLOC_ARENA_MAX": "2"},
            cwd=self.home,
            start_new_session=True,
        )
        self.left = WORKER_LIFE
        if self._line(120.0) != b"ready\n":
            raise RuntimeError(f"the worker does not begin: {self._text('stderr')}")

    def _line(self, seconds: float) -> bytes | None:
        """The next line of the worker; empty where it has ended, None where it does not answer."""
        assert self.process is not None
        assert self.process.stdout is not None
        ready, _, _ = select.select([self.process.stdout], [], [], seconds)
        return self.process.stdout.readline() if ready else None

    def _end(self) -> None:
        """The worker's whole group goes: a reader may have children of its own."""
        if self.process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout):
            assert stream is not None
            with contextlib.suppress(BrokenPipeError):
                stream.close()
        self.process = None

    def _died(self) -> Result:
        assert self.process is not None
        status = self.process.wait()
        self._end()
        if status == -signal.SIGPROF:
            return self._result("hang", None, f"more than {SECONDS:g} s of processor time")
        reason = signal.Signals(-status).name if status < 0 else f"exit {status}"
        return self._result("crash", None, reason)

    def judged(self, answer: dict[str, Any]) -> Result:
        """What became of a command that came to an end."""
        figures = {"seconds": answer["seconds"], "memory": answer["memory"]}
        stdout, stderr = self._text("stdout"), self._text("stderr")
        both = stdout + stderr
        code = answer["code"]
        kind, detail = "", ""
        if answer["escaped"]:
            kind, detail = "traceback", answer["escaped"]
        elif code == 4:
            kind, detail = "defect", answer["where"]
        elif "Traceback (most recent call last)" in both:
            kind, detail = "traceback", both[both.index("Traceback (most") :][:2000]
        elif code not in (0, 1, 2, 3):
            kind, detail = "code", f"exit {code}"
        elif answer["memory"] > MEMORY or _SHORT.search(stderr):
            kind, detail = "memory", f"{answer['memory'] / 1e6:.0f} MB"
        elif answer["seconds"] > SECONDS:
            kind, detail = "hang", f"{answer['seconds']:.1f} s of processor time"
        elif control := _CONTROL.search(both):
            around = both[max(control.start() - 40, 0) : control.end() + 40]
            kind, detail = "escape", repr(around)
        elif code == 3 and len(stderr) > LONGEST_SENTENCE:
            kind, detail = "flood", f"{len(stderr)} characters: {stderr[:80]}"
        elif code == 3 and not stderr.strip():
            kind, detail = "silence", "exit 3 without a word"
        return self._result(kind, code, detail, **figures)

    def _result(self, kind: str, code: int | None, detail: str, **figures: Any) -> Result:
        return Result(kind, code, self._text("stdout"), self._text("stderr"), detail, **figures)

    def _text(self, name: str) -> str:
        return (self.home / name).read_bytes().decode("utf-8", "replace")
