"""Process in which a unit runs: a crash of its native code must not end the simulation.

Started by `Coupled` as `python -m tierod.proving_ground.foreign.host FOLDER`. The folder contains the job and the
arrays that both processes share; each line on standard input requests one piece and is answered by one line on standard
output.
"""

from __future__ import annotations

import json
import os
import pickle
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.block import tuning
from tierod.core.errors import TierodError
from tierod.core.graph.kernel import kernel
from tierod.core.graph.trace import initial_memory
from tierod.proving_ground.foreign.instance import Instance, UnitFailure
from tierod.proving_ground.foreign.wiring import refuse_changed
from tierod.proving_ground.recorder import COMMANDS

JOB, SAMPLES, OUTPUTS, PROGRESS, UNPACKED = "job", "samples", "outputs", "progress", "unit"
"""Names of the files in the folder."""


def shared(folder: Path, name: str, shape: tuple[int, ...], mode: str, kind: str = "<f8") -> np.ndarray:
    """An array in memory that both processes share.

    Args:
        folder: folder of the job
        name: name of the file
        shape: shape of the array
        mode: "w+" to create it, "r+" to open it
        kind: type of its numbers
    """
    opened: Any = mode
    return np.memmap(folder / name, dtype=kind, mode=opened, shape=tuple(max(size, 1) for size in shape))


class Host:
    """A unit with the kernel of driver and assist unit.

    Args:
        folder: folder of the job
    """

    def __init__(self, folder: Path):
        with (folder / JOB).open("rb") as file:
            self.car, block, usual, seconds, rows = pickle.load(file)
        self.kernel, self.memory = kernel(block), initial_memory(block)
        graph = self.kernel.graph
        self.samples = shared(folder, SAMPLES, (rows, len(graph.sample)), "r+")
        self.outputs = shared(folder, OUTPUTS, (rows, len(graph.output)), "r+")
        self.progress = shared(folder, PROGRESS, (1,), "r+", "<i8")
        self.given, self.shown = _columns(graph.sample, "unit."), _columns(graph.output, "unit.")
        commands = _columns(graph.output, COMMANDS)
        self.taken = slice(commands.start, commands.start + len(self.car.takes))
        self.tuned = slice(self.taken.stop, commands.stop)
        self.instance = Instance(refuse_changed(self.car.path, self.car.wires.digest), folder / UNPACKED)
        self._begin(usual, seconds)

    def _begin(self, usual: Mapping[str, float], seconds: float) -> None:
        wires, known = self.car.wires, dict(tuning(self.car))
        settings = {each.reference: each.value for each in wires.settings}
        settings |= {each.reference: known[each.path] for each in wires.tunable if known[each.path] != each.value}
        settings |= {each.reference: (self.car.start.speed - each.offset) / each.gain for each in wires.start}
        inputs = {each.reference: (usual.get(each.signal, 0.0) - each.offset) / each.gain for each in wires.inputs}
        self.instance.begin(settings, inputs, seconds)
        self.reader = self.instance.exchange("get", [each.reference for each in wires.outputs])
        self.writer = self.instance.exchange("set", [each.reference for each in wires.inputs])
        self.tuner = self.instance.exchange("set", [each.reference for each in wires.tunable])
        self.values = np.array([known[each.path] for each in wires.tunable])
        self.of_outputs = np.array([[each.gain, each.offset] for each in wires.outputs]).reshape(-1, 2).T
        self.of_inputs = np.array([[each.gain, each.offset] for each in wires.inputs]).reshape(-1, 2).T

    def piece(self, rows: int, count: int) -> str:
        """Simulate some steps; `progress` counts the successful ones.

        Args:
            rows: number of steps
            count: number of earlier steps

        Returns:
            reason of the unit's failure; "" if there is none
        """
        step = self.car.step_time
        self.progress[0] = 0
        for row in range(rows):
            try:
                self._row(row, count)
                self.instance.step((count + row) * step, step)
            except UnitFailure as failure:
                return f"at {(count + row) * step:g} s {failure}"
            self.progress[0] = row + 1
        return ""

    def _row(self, row: int, count: int) -> None:
        """Read the unit's outputs, decide, and write its inputs."""
        samples, outputs = self.samples[row : row + 1], self.outputs[row : row + 1]
        gain, offset = self.of_outputs
        samples[0, self.given] = gain * self.reader.read() + offset
        self.kernel.scan(self.memory, samples, outputs, count + row)
        self.writer.write((outputs[0, self.taken] - self.of_inputs[1]) / self.of_inputs[0])
        values = outputs[0, self.tuned]
        if not np.array_equal(values, self.values):
            self.values = values.copy()
            self.tuner.write(values)
        # An output that depends directly on inputs has changed by writing them: it is read once more for the recording.
        if self.car.wires.present:
            outputs[0, self.shown] = gain * self.reader.read() + offset


def _columns(names: tuple[str, ...], prefix: str) -> slice:
    places = [k for k, name in enumerate(names) if name.startswith(prefix)]
    return slice(places[0], places[-1] + 1) if places else slice(0, 0)


def main(folder: Path) -> None:
    """Answer requests until the input ends; then the folder is removed, since its maker may have been killed."""
    with os.fdopen(os.dup(1), "w") as answers:
        # Output of a unit must not mix with the answers.
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, 1)
        os.dup2(nothing, 2)

        def answer(**content: object) -> None:
            answers.write(json.dumps(content) + "\n")
            answers.flush()

        try:
            host = Host(folder)
        except TierodError as error:
            answer(refused=str(error))
            return
        answer(ready=True)
        for line in sys.stdin:
            rows, count = map(int, line.split())
            answer(failure=host.piece(rows, count))
        host.instance.end()


if __name__ == "__main__":
    place = Path(sys.argv[1])
    try:
        main(place)
    finally:
        shutil.rmtree(place, ignore_errors=True)
