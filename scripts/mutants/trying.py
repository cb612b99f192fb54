"""Trial of one change in a copy of the checkout, with the tests that concern it."""

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
"""Test files per run of pytest; few, so that the nearest tests report early."""

HUNG = 300
"""Processor time [s] after which a test process counts as hung because of the change; waiting does not count."""

FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)


@dataclass(frozen=True)
class Outcome:
    """Result of one change.

    Args:
        change: tried change
        diff: changed lines, before and after
        found_by: failed test; None if all passed
        tests: number of test files run, and of those that concern the file
        seconds: duration [s]
    """

    change: Change
    diff: str
    found_by: str | None
    tests: tuple[int, int]
    seconds: float


@dataclass
class Copy:
    """A copy of a checkout in which changes are tried one by one.

    Args:
        root: of the checkout
        folder: for the copy
    """

    root: Path
    folder: Path
    passing: set[str] = field(default_factory=set)

    def make(self) -> Copy:
        """Copy the files known to git, and link the virtual environment."""
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
        """Try whether a test detects a change; a test that also fails without it does not count.

        Args:
            change: to be tried
            tests: test files, nearest first
            limit: time after which no further batch is started [s]
        """
        path = self.folder / "src" / change.path
        source, begin, run = path.read_bytes(), time.monotonic(), 0
        found: str | None = None
        try:
            while run < len(tests) and found is None and time.monotonic() - begin < limit:
                # The first batch is smaller still, because the nearest tests are the likeliest to detect the change.
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
        """Whether a test passes without a change."""
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
        # Exit code 5 of pytest: no test was collected.
        if done.returncode in (0, 5):
            return None
        failed = FAILED.search(done.stdout)
        return failed[1] if failed else what[0]
