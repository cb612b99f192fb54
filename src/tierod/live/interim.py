"""HTML page of the drive so far, made from its log by a separate process while the drive goes on."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import IO

from tierod.core.processes import interpreter
from tierod.live.events import Hub

WRITTEN = (0, 1, 2)
"""Exit codes of `tierod diagnose` after which its page exists."""


class Interim:
    """Makes one page at a time, and reports its completion or failure.

    Args:
        hub: receives the outcome

    `words` are the options of `tierod diagnose` after the log; `log` and `time` are those of the drive.
    """

    def __init__(self, hub: Hub):
        self.words: Sequence[str] = ()
        self.log: Path | None = None
        self.time = 0.0
        self._hub = hub
        self._page: Path | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._errors: IO[bytes] | None = None

    def make(self) -> None:
        """Start a page; refused, with a problem reported, while another one is being made."""
        if self._process is not None:
            self._hub.say("problem", {"text": f"the report {self._page} is being made; ask again when it is finished"})
            return
        if self.log is None:
            text = "a report of the drive so far needs its log; start with --log"
            self._hub.say("problem", {"text": text})
            return
        page = self.log.with_name(f"{self.log.stem}-{int(self.time)}s.html")
        # Closed after the process has ended, in a later call.
        self._page, self._errors = page, tempfile.TemporaryFile()  # noqa: SIM115
        command = interpreter("-m", "tierod", "diagnose", str(self.log), *self.words, "-o", str(page))
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._errors
        )
        self._hub.say("making", {"path": str(page), "text": f"a report of the drive so far is made: {page}"})

    def look(self, wait: bool = False) -> None:
        """Report the outcome of a page if its process has ended.

        Args:
            wait: whether to wait for the end of the process
        """
        if self._process is None or self._errors is None:
            return
        code = self._process.wait() if wait else self._process.poll()
        if code is None:
            return
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        self._errors.close()
        page, self._process, self._errors = self._page, None, None
        if code in WRITTEN and page is not None and page.exists():
            self._hub.say("report", {"path": str(page)})
        else:
            why = said[-1].removeprefix("tierod: ") if said else f"it ended with {code}"
            self._hub.say("problem", {"text": f"the report {page} was not made: {why}"})

    def close(self) -> None:
        """End with the session, after waiting for a page that is being made."""
        self.look(wait=True)
