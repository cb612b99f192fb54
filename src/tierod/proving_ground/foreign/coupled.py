"""A unit beside our driver, in a process of its own: where it crashes or hangs, the drive up to there stays."""

from __future__ import annotations

import contextlib
import json
import pickle
import select
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.errors import InputError
from tierod.proving_ground.foreign.host import JOB, OUTPUTS, PROGRESS, SAMPLES, shared
from tierod.proving_ground.parts import Plant

PATIENCE = 120.0
"""How long a unit may take to begin, or for one step [s]."""


class Coupled:
    """The unit of a car for one run.

    Args:
        car: whose unit runs
        path: of the unit
        block: the car, or the car with some of its parameters as inputs
        usual: of what the unit is given before the first step, by signal
        seconds: duration of the run [s]
        shape: (rows of the longest piece, inputs, outputs)

    Attributes:
        failure: why it could not go on; "" while it can

    Raises:
        InputError: the unit cannot be loaded, or refuses to begin
    """

    def __init__(
        self,
        car: Plant,
        path: Path,
        block: Plant,
        usual: Mapping[str, float],
        seconds: float,
        shape: tuple[int, int, int],
    ):
        self.path, self.step_time, self.failure = path, car.step_time, ""
        self.folder = Path(tempfile.mkdtemp(prefix="tierod-unit-"))
        self._process: subprocess.Popen[bytes] | None = None
        try:
            rows, inputs, outputs = shape
            self.samples = shared(self.folder, SAMPLES, (rows, inputs), "w+")
            self.outputs = shared(self.folder, OUTPUTS, (rows, outputs), "w+")
            self.progress = shared(self.folder, PROGRESS, (1,), "w+", "<i8")
            (self.folder / JOB).write_bytes(pickle.dumps((car, block, dict(usual), seconds, rows)))
            self._start()
        except BaseException:
            self.close()
            raise

    def _start(self) -> None:
        command = [sys.executable, "-m", "tierod.proving_ground.foreign.host", str(self.folder)]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            # An interrupt ends the run here, and the unit with it.
            start_new_session=True,
        )
        answer = self._answer()
        if "ready" not in answer:
            reason = answer.get("refused") or f"the unit {self.path.name} {answer['failure']}"
            raise InputError(f"{reason}; export it anew, or look at the values that it begins with")

    def scan(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> int:
        """Run over samples into outputs, as a kernel does.

        Args:
            memory: not used: that of our side lives beside the unit
            samples: (n, inputs)
            outputs: (n, outputs)
            count: steps that came before

        Returns:
            rows that are good; fewer than n where the unit failed, see `failure`
        """
        rows = len(samples)
        self.samples[:rows] = samples
        self.progress[0] = 0
        answer = self._asked(f"{rows} {count}\n")
        good = min(int(self.progress[0]), rows)
        outputs[:good] = self.outputs[:good]
        if answer["failure"]:
            self.failure = f"the unit {self.path.name} {answer['failure']}"
            if answer.get("gone"):
                self.failure += f" in the step at {(count + good) * self.step_time:g} s"
        return good

    def _asked(self, line: str) -> dict[str, Any]:
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(line.encode())
            self._process.stdin.flush()
        except OSError:
            return self._gone()
        return self._answer()

    def _answer(self) -> dict[str, Any]:
        """The next answer; a failure where the process is gone, or makes no step for long."""
        assert self._process is not None
        assert self._process.stdout is not None
        since, seen = time.monotonic(), -1
        while not select.select([self._process.stdout], [], [], 1.0)[0]:
            if int(self.progress[0]) != seen:
                since, seen = time.monotonic(), int(self.progress[0])
            if time.monotonic() - since > PATIENCE:
                self._process.kill()
                return {"failure": f"has made no step for {PATIENCE:g} s", "gone": True}
        line = self._process.stdout.readline()
        answer: dict[str, Any] = json.loads(line) if line.endswith(b"\n") else self._gone()
        return answer

    def _gone(self) -> dict[str, Any]:
        assert self._process is not None
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(5.0)
        code = self._process.returncode
        how = f"by signal {-code}" if code is not None and code < 0 else f"with exit code {code}"
        return {"failure": f"has crashed ({how})", "gone": True}

    def close(self) -> None:
        """End the unit, and remove what it was unpacked to."""
        if self._process is not None:
            assert self._process.stdin is not None
            assert self._process.stdout is not None
            with contextlib.suppress(OSError):
                self._process.stdin.close()
            try:
                self._process.wait(2.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
            self._process.stdout.close()
            self._process = None
        shutil.rmtree(self.folder, ignore_errors=True)
