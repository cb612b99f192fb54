"""A functional mock-up unit that runs in this process, of FMI version 2 or 3."""

from __future__ import annotations

import contextlib
import ctypes
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tierod.core.errors import InputError
from tierod.proving_ground.foreign.description import Unit, first_line


class UnitFailure(Exception):
    """Failure of a unit during a run; its message is for users."""


class Instance:
    """A running unit of FMI version 2 or 3.

    Args:
        unit: description of the unit
        folder: folder for the unpacked unit

    Raises:
        InputError: the unit cannot be loaded or does not initialise
    """

    def __init__(self, unit: Unit, folder: Path):
        import fmpy
        from fmpy import fmi2, fmi3

        self.unit, self.message = unit, ""
        self.fmu: Any = None
        try:
            unpacked = fmpy.extract(str(unit.path), str(folder))
            given = {
                "guid": unit.token, "unzipDirectory": str(unpacked), "modelIdentifier": unit.identifier,
                "instanceName": "plant",
            }  # fmt: skip
            self.fmu = (fmi3.FMU3Slave if unit.version == 3 else fmi2.FMU2Slave)(**given)
            if unit.version == 3:
                self.fmu.instantiate(logMessage=self._log_3, loggingOn=True)
            else:
                self.fmu.instantiate(callbacks=self._callbacks(fmpy, fmi2), loggingOn=True)
        except Exception as error:  # fmpy raises Exception itself
            raise InputError(self._words(f"the unit {unit.path.name} cannot be loaded", error)) from None
        prefix = f"fmi{unit.version}"
        kind = "Float64" if unit.version == 3 else "Real"
        self._set = getattr(self.fmu, f"{prefix}Set{kind}")
        self._get = getattr(self.fmu, f"{prefix}Get{kind}")
        self.sizes = 2 if unit.version == 3 else 1

    def _callbacks(self, fmpy: Any, fmi2: Any) -> Any:
        kept = fmi2.fmi2CallbackFunctions()
        kept.logger = fmi2.fmi2CallbackLoggerTYPE(self._log_2)
        kept.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        kept.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        # Log messages are format strings with variable arguments, which a Python callback cannot process.
        with contextlib.suppress(Exception):
            from fmpy.logging import addLoggerProxy

            addLoggerProxy(ctypes.byref(kept))
        return kept

    def _log_2(self, environment: Any, name: Any, status: int, category: Any, message: Any, *_: Any) -> None:
        self._log_3(environment, status, category, message)

    def _log_3(self, environment: Any, status: int, category: Any, message: Any) -> None:
        if status > 0 and message:
            self.message = message.decode(errors="replace").strip().splitlines()[0][:200]

    def _words(self, what: str, error: Exception) -> str:
        return f"{what}: {self.message or first_line(error)}"

    def begin(self, settings: dict[int, float], inputs: dict[int, float], stop: float) -> None:
        """Set parameters and inputs, and initialise the unit.

        Args:
            settings: parameters by value reference
            inputs: inputs by value reference
            stop: end of the run [s]

        Raises:
            InputError: the unit does not initialise
        """
        try:
            if self.unit.version == 3:
                self._set_all(settings)
                self.fmu.enterInitializationMode(startTime=0.0, stopTime=stop)
            else:
                self.fmu.setupExperiment(startTime=0.0, stopTime=stop)
                self._set_all(settings)
                self.fmu.enterInitializationMode()
            self._set_all(inputs)
            self.fmu.exitInitializationMode()
        except Exception as error:
            raise InputError(self._words(f"the unit {self.unit.path.name} refuses to begin", error)) from None

    def _set_all(self, values: dict[int, float]) -> None:
        if values:
            Exchange(self, self._set, list(values)).write(np.array(list(values.values())))

    def exchange(self, way: Literal["get", "set"], references: list[int]) -> Exchange:
        """Variables that are read or set together.

        Args:
            way: "get" to read, "set" to write
            references: value references of the variables
        """
        return Exchange(self, self._get if way == "get" else self._set, references)

    def step(self, time: float, size: float) -> None:
        """One communication step.

        Args:
            time: start of the step [s]
            size: length of the step [s]

        Raises:
            UnitFailure: the step fails, or the unit requests termination
        """
        self.message = ""
        try:
            done = self.fmu.doStep(time, size)
        except Exception as error:
            raise UnitFailure(self._words("fails in a step", error)) from None
        if self.unit.version == 3 and done[1]:
            raise UnitFailure(self._words("asks for the end of the run", Exception("without a reason")))

    def end(self) -> None:
        """Terminate and free the unit; errors no longer matter then."""
        with contextlib.suppress(Exception):
            self.fmu.terminate()
        with contextlib.suppress(Exception):
            self.fmu.freeInstance()


class Exchange:
    """Variables that are set or read together, over one preallocated buffer."""

    def __init__(self, instance: Instance, call: Any, references: list[int]):
        self.values = np.zeros(len(references))
        self._references = (ctypes.c_uint * len(references))(*references)
        pointer = self.values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        count = (len(references),)
        self._arguments = (instance.fmu.component, self._references, *count, pointer, *count * (instance.sizes - 1))
        self._call, self._instance = call, instance

    def read(self) -> np.ndarray:
        """Read the present values."""
        self._go()
        return self.values

    def write(self, values: np.ndarray) -> None:
        """Set the values."""
        self.values[:] = values
        self._go()

    def _go(self) -> None:
        if len(self.values):
            self._instance.message = ""
            try:
                self._call(*self._arguments)
            except Exception as error:
                raise UnitFailure(self._instance._words("refuses a value", error)) from None
