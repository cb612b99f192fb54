"""One change in a copy of the checkout, and the tests that concern it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from scripts.mutants.changes import Change

BATCH = 6
"""Test files of one run of pytest: few, so that the nearest tests answer soon."""

HUNG = 300
"""A process of a batch that computes longer [s] hangs because of the change; waiting for other work does not count."""

FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)


@dataclass(frozen=True)
class Outcome:
    """Of one change.

    Args:
        change: the change
        diff: lines before and after
        found_by: the test that failed; None where all passed
        tests: how many test files were run, of how many that concern the file
        seconds: how long that took [s]
    """

    change: Change
    diff: str
    found_by: str | None
    tests: tuple[int, int]
    seconds: float


@dataclass
class Copy:
    """A copy of a checkout in which single changes are tried.

    Args:
        root: of the checkout
        folder: of the copy
    """

    root: Path
    folder: Path
    passing: set[str] = field(default_factory=set)

    def make(self) -> Copy:
        """Copy what git knows, and link the environment."""
        listed = subprocess.run(
            ["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=self.root, capture_output=True, check=True
        )
        for name in filter(None, listed.stdout.decode().split("\0")):
            target = self.folder / name
            if (self.root / name).is_file():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(self.root / name, target)
        (self.folder / ".venv").symlink_to((self.root / ".venv").resolve())
        return self

    def tried(self, change: Change, tests: list[Path], limit: float) -> Outcome:
        """Whether a test finds a change; a test that fails without it too does not count.

        Args:
            change: the change
            tests: files, nearest first
            limit: no further batch begins after so long [s]
        """
        path = self.folder / "src" / change.path
        source, begin, run = path.read_bytes(), time.monotonic(), 0
        found: str | None = None
        try:
            while run < len(tests) and found is None and time.monotonic() - begin < limit:
                batch = tests[run : run + (2 if run == 0 else BATCH)]
                run += len(batch)
                path.write_bytes(change.applied(source))
                found = self._first_failure([str(test) for test in batch])
                path.write_bytes(source)
                if found is not None and not self._passes(found):
                    tests, found = [test for test in tests if not found.startswith(str(test))], None
                    run -= len(batch)
        finally:
            path.write_bytes(source)
        return Outcome(change, change.diff(source), found, (run, len(tests)), time.monotonic() - begin)

    def _passes(self, test: str) -> bool:
        """Whether a test passes without any change."""
        if test not in self.passing and self._first_failure([test]) is None:
            self.passing.add(test)
        return test in self.passing

    def _first_failure(self, what: list[str]) -> str | None:
        shared = self.root.parent / "shared" / "data"
        given = {"TIEROD_DATA": str(shared)} if shared.exists() else {}
        environment = given | os.environ | {"PYTHONPATH": str(self.folder / "src"), "CI": "1"}
        command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", *what]
        limited = ["bash", "-c", f'ulimit -t {HUNG}; exec "$@"', "limited", *command]
        done = subprocess.run(limited, cwd=self.folder, env=environment, capture_output=True, text=True)
        if done.returncode in (0, 5):
            return None
        failed = FAILED.search(done.stdout)
        return failed[1] if failed else what[0]
