"""A unit in its own process: if it crashes or hangs, the recording up to this instant is kept."""

from __future__ import annotations

import contextlib
import json
import pickle
import select
import shutil
import subprocess
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.processes import interpreter
from tierod.proving_ground.foreign.host import JOB, OUTPUTS, PROGRESS, SAMPLES, shared
from tierod.proving_ground.parts import Plant

PATIENCE = 120.0
"""Maximum time for the initialisation of a unit, or for one step [s]."""


class Coupled:
    """The unit of a car for one run.

    Args:
        car: car with the unit
        path: path of the unit
        block: the car, or the car with some of its parameters as inputs
        usual: values of the unit's inputs before the first step, by signal
        seconds: duration of the run [s]
        shape: (rows of the longest piece, inputs, outputs)

    Attributes:
        failure: reason of the unit's failure; "" if there is none

    Raises:
        InputError: the unit cannot be loaded or does not initialise
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
        command = interpreter("-m", "tierod.proving_ground.foreign.host", str(self.folder))
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            # An interrupt is handled by this process, which then ends the unit.
            start_new_session=True,
        )
        answer = self._answer()
        if "ready" not in answer:
            reason = answer.get("refused") or f"the unit {self.path.name} {answer['failure']}"
            raise InputError(f"{reason}; export it anew, or check its initial values")

    def scan(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> int:
        """Run over samples into outputs, as a kernel does.

        Args:
            memory: not used: the state of driver and assist unit is in the unit's process
            samples: inputs, (n, inputs)
            outputs: outputs, (n, outputs)
            count: number of earlier steps

        Returns:
            number of valid rows; fewer than n if the unit failed, see `failure`
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
        """The next answer; a failure if the process has ended, or has completed no step for `PATIENCE`."""
        assert self._process is not None
        assert self._process.stdout is not None
        since, seen = time.monotonic(), -1
        while not select.select([self._process.stdout], [], [], 1.0)[0]:
            # Progress restarts the timeout, since a piece of many steps may take longer.
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
        """End the unit, and remove the folder with its files."""
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
