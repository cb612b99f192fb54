"""A functional mock-up unit that runs in this process through fmpy, beside the kernel of its driver."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Mapping
from typing import Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph.kernel import kernel
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.recorder import COMMANDS
from tierod_lab.ground.units.plant_file import Wire, first_line


class Instance:
    """The unit of a car for one run; `failure` is the reason of its failure, "" if there is none.

    Args:
        seconds: duration of the run [s]

    Raises:
        InputError: the unit cannot be loaded or does not initialise
    """

    def __init__(self, car: Any, block: Plant, usual: Mapping[str, float], seconds: float):
        self.car, self.kernel, self.failure, self._said = car, kernel(block), "", ""
        inputs, outputs, start, values = json.loads(car.wiring)
        self.given = _columns(self.kernel.graph.sample, "unit.")
        self.shown, self.taken = (_columns(self.kernel.graph.output, prefix) for prefix in ("unit.", COMMANDS))
        self.takes, self.gives = _Scaled(inputs), _Scaled(outputs)
        first = dict(values) | {each.reference: (car.start.speed - each.offset) / each.gain for each in _wires(start)}
        self.folder = tempfile.TemporaryDirectory(prefix="tierod-unit-")
        self.fmu: Any = None
        try:
            self._begin(first, [usual.get(each.signal, 0.0) for each in _wires(inputs)], seconds)
        except Exception as error:  # fmpy raises Exception itself
            self.close()
            why = self._said or first_line(error)
            raise InputError(f"the unit {car.path.name} does not begin: {why}; export it anew") from None

    def _begin(self, values: Mapping[int, float], inputs: list[float], seconds: float) -> None:
        import fmpy
        from fmpy.simulation import instantiate_fmu

        def log(environment: Any, name: Any, status: int, category: Any, message: Any) -> None:
            if status > 0 and message:
                self._said = message.decode(errors="replace").strip().splitlines()[0][:200]

        folder = fmpy.extract(str(self.car.path), self.folder.name)
        described: Any = fmpy.read_model_description(folder, validate=False)
        # fmpy changes to the folder of the library, and stays there where loading fails.
        with contextlib.chdir(os.getcwd()):
            self.fmu = fmu = instantiate_fmu(folder, described, "CoSimulation", debug_logging=True, logger=log)
        fmu.setupExperiment(startTime=0.0, stopTime=seconds)
        fmu.setReal(list(values), list(values.values()))
        fmu.enterInitializationMode()
        self.takes.write(fmu, np.array(inputs))
        fmu.exitInitializationMode()

    def scan(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> int:
        """Run over samples into outputs, as a kernel does, and return the number of steps that the unit made."""
        step = self.car.step_time
        for row in range(len(samples)):
            now, out, self._said = samples[row : row + 1], outputs[row : row + 1], ""
            try:
                now[0, self.given] = self.gives.read(self.fmu)
                self.kernel.scan(memory, now, out, count + row)
                self.takes.write(self.fmu, out[0, self.taken])
                # Outputs that depend directly on inputs have changed by writing them.
                out[0, self.shown] = self.gives.read(self.fmu)
                self.fmu.doStep((count + row) * step, step)
            except Exception as error:
                why = self._said or first_line(error)
                self.failure = f"the unit {self.car.path.name} at {(count + row) * step:g} s fails in a step: {why}"
                return row
        return len(samples)

    def close(self) -> None:
        """End the unit, and remove the folder with its files; errors no longer matter then."""
        for end in ("terminate", "freeInstance"):
            with contextlib.suppress(Exception):
                getattr(self.fmu, end)()
        self.folder.cleanup()


class _Scaled:
    def __init__(self, rows: list[Any]):
        wires = _wires(rows)
        self.references = [each.reference for each in wires]
        self.gain, self.offset = np.array([[each.gain, each.offset] for each in wires]).reshape(-1, 2).T

    def read(self, fmu: Any) -> np.ndarray:
        return np.asarray(self.gain * np.array(fmu.getReal(self.references)) + self.offset)

    def write(self, fmu: Any, values: np.ndarray) -> None:
        fmu.setReal(self.references, ((values - self.offset) / self.gain).tolist())


def _wires(rows: list[Any]) -> list[Wire]:
    return [Wire(*each) for each in rows]


def _columns(names: tuple[str, ...], prefix: str) -> slice:
    places = [k for k, name in enumerate(names) if name.startswith(prefix)]
    return slice(places[0], places[-1] + 1) if places else slice(0, 0)
