"""Vehicle of another tool in place of a virtual car: a functional mock-up unit by fmpy, driven by our driver."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.block import Scalar, Tree, leaves, named_tuple, skeleton, units
from tierod.core.errors import InputError, MissingExtra, nearest
from tierod.core.fields import Range
from tierod.core.graph.kernel import kernel
from tierod.core.graph.maths import maximum
from tierod.core.toml import build
from tierod.core.toml_document import Document, Location
from tierod.core.units import scale
from tierod_lab.ground.courses.course import Start
from tierod_lab.ground.drivers import Driving, DrivingInputs, HumanDriver
from tierod_lab.ground.parts import Demand, Driver, Plant, Road, Wind
from tierod_lab.ground.recorder import COMMANDS

USUAL_STEP = 1e-3  # Communication step if neither plant file nor unit states one [s]


@dataclass(frozen=True)
class Entry:
    """The signal in `unit` (of the description if None, SI if it has none) is sign * variable."""

    variable: str = ""
    signal: str = ""
    unit: str | None = None
    sign: float = 1.0


@dataclass(frozen=True)
class PlantFile:
    """Content of a plant file."""

    fmu: str
    inputs: Mapping[str, Any]
    outputs: Mapping[str, Any]
    values: Mapping[str, float] = field(default_factory=dict)
    start_speed: Any = None  # parameter that is the initial speed, or an entry; None keeps the unit's own initial speed
    # communication step, within what the driver model tolerates; that of the unit's description if None
    step: Annotated[float, "s", Range(1e-5, 2e-2)] | None = None


class Wire(NamedTuple):
    """A variable and its signal: signal [SI] = gain * variable + offset."""

    reference: int
    signal: str
    unit: str
    gain: float
    offset: float


def described(path: Path) -> Any:
    """Description of a unit by fmpy."""
    try:
        import fmpy
    except ImportError:
        raise MissingExtra("fmpy", "fmi", "a functional mock-up unit as plant") from None
    if not path.is_file():
        raise InputError(f"there is no file {path}; name a functional mock-up unit (.fmu)")
    try:
        found: Any = fmpy.read_model_description(str(path), validate=False)
        platforms = set(fmpy.supported_platforms(str(path)))
    except Exception as error:  # fmpy and lxml raise many kinds of errors for a damaged file
        raise InputError(f"{path} is not a unit that fmpy can read ({first_line(error)}); export it anew") from None
    if found.fmiVersion != "2.0" or found.coSimulation is None or fmpy.platform not in platforms:
        held = f"FMI {found.fmiVersion} for {', '.join(sorted(platforms)) or 'no platform'}"
        raise InputError(f"{path} is a unit of {held}; export it for co-simulation by FMI 2.0 on {fmpy.platform}")
    return found


def first_line(error: BaseException) -> str:
    """First line of an error's message; the name of its class where it has none."""
    return next(iter(str(error).splitlines()), "") or type(error).__name__


class Variables(NamedTuple):
    """Variables of a unit, to which entries of the plant file refer; `assumed` lists those without a unit."""

    document: Document
    variables: Mapping[str, Any]
    assumed: list[str]

    def reference(self, location: Location, name: str, causality: str) -> int:
        known = {key for key, each in self.variables.items() if each.causality == causality and each.type == "Real"}
        if name not in known:
            raise self.document.error(location, f"the unit has no {causality} '{name}'{nearest(name, known)}")
        return int(self.variables[name].valueReference)

    def wire(self, location: Location, causality: str, given: object, known: Mapping[str, str | None]) -> Wire:
        """The wire of an entry; `known` has the unit of every signal that fits."""
        short = "signal" if causality == "input" else "variable"
        entry: Entry = build(Entry, {short: given} if isinstance(given, str) else given, self.document, location)
        name = str(location[-1])
        variable, signal = (name, entry.signal) if causality == "input" else (entry.variable, name)
        if signal not in known:
            raise self.document.error(location, f"no signal here is called '{signal}'{nearest(signal, known)}")
        reference, about = self.reference(location, variable, causality), self.variables[variable]
        stated = entry.unit or about.unit or getattr(about.declaredType, "unit", None) or ""
        wanted = known[signal] or stated
        if entry.sign not in (1.0, -1.0):
            raise self.document.error(location, "'sign' has to be 1 or -1")
        try:
            size = scale(stated or wanted, wanted)
        except InputError as error:
            raise self.document.error(location, f"'{variable}': {error}") from None
        self.assumed.extend([f"{variable} [{wanted}]"] if wanted and not stated else [])
        return Wire(reference, signal, wanted, size.factor * entry.sign, size.offset)


class Instance:
    """The unit of a car for one run; `failure` is the reason of its failure, "" if there is none.

    Args:
        seconds: duration of the run [s]
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


FROM_DRIVER: Mapping[str, str] = {
    "hand_torque": "N*m",
    "steering_wheel_angle": "rad",
    "steering_wheel_rate": "rad/s",
    "drive_force": "N",
    "traction_force": "N",
    "braking_force": "N",
}
"""Signals that our driver gives, with their units; the last two are the drive force's parts, both not negative."""
_AROUND: Mapping[str, Any] = {"road": Road, "wind": Wind, "demand": Demand}
_PLACE = {"truth_distance": "m", "truth_lateral_offset": "m", "truth_heading_error": "rad"}


@cache
def offered() -> dict[str, str]:
    """Unit of every signal that an input of a unit can be given, by name."""
    found = dict(FROM_DRIVER)
    for group, kind in _AROUND.items():
        found |= {f"{group}.{name}": unit for (name, _), unit in zip(leaves(skeleton(kind)), units(kind), strict=True)}
    return found


class Output(NamedTuple):
    unit: Tree
    driving: Tree
    commands: Tree


@dataclass(frozen=True)
class UnitCar:
    """Driver of a vehicle that a unit computes; a unit that takes nothing and gives its distance has its own."""

    path: Path
    wiring: str
    takes: tuple[str, ...]
    gives: tuple[tuple[str, str], ...]
    driver: Driver = field(default_factory=HumanDriver)
    start: Start = field(default_factory=Start)
    step_time: Annotated[float, "s", Range(1e-5, 2e-2)] = 1e-3

    @property
    def drives(self) -> bool:
        """Whether our driver is needed, to drive or to track the position on the path."""
        return bool(set(FROM_DRIVER) & set(self.takes)) or "truth_distance" not in dict(self.gives)

    @property
    def Sample(self) -> type:
        return _sample(self.gives)

    def lacking(self) -> list[str]:
        """Signals of which the driver needs one more each."""
        given = {name for name, _ in self.gives} | ({"steering_wheel_angle"} & set(self.takes))
        needed = ("truth_speed", "vehicle_speed"), ("yaw_rate",), ("steering_wheel_angle",)
        return [" or ".join(names) for names in needed if self.drives and not given & set(names)]

    def init(self) -> Tree:
        return Driving(self.driver, self.step_time).init() if self.drives else (), 0.0

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Output]:
        (driving, before), (*around, unit) = state, sample
        given = {
            f"{group}.{name}": getattr(part, name)
            for group, part in zip(_AROUND, around, strict=True)
            for name in part._fields
        }
        shown: dict[tuple[str, str], Scalar] = {}
        angle = getattr(unit, "steering_wheel_angle", before)
        if self.drives:
            sensed = self._sensed(unit, angle, (angle - before) / self.step_time, around[0], around[2])
            driving, done = Driving(self.driver, self.step_time).step(driving, sensed)
            turned, force = done.steering_wheel_angle, done.drive_force
            parts = force, maximum(force, 0.0), maximum(-force, 0.0)
            own = (done.hand_torque, turned, (turned - before) / self.step_time, *parts)
            given |= dict(zip(FROM_DRIVER, own, strict=True))
            angle = turned if "steering_wheel_angle" in self.takes else angle
            shown = dict(zip(_PLACE.items(), (done.distance, done.lateral_offset, done.heading_error), strict=True))
            shown |= {(f"truth_{name}", FROM_DRIVER[name]): given[name] for name in ("hand_torque", "drive_force")}
            shown |= {(name, FROM_DRIVER[name]): given[name] for name in self.takes if name.startswith("steering")}
        shown = {channel: value for channel, value in shown.items() if channel[0] not in dict(self.gives)}
        commands = _tuple(tuple((f"command_{k}", "") for k in range(len(self.takes))))
        channels = _tuple(tuple(shown))(*shown.values()) if shown else ()
        return (driving, angle), Output(unit, channels, commands(*(given[name] for name in self.takes)))

    def _sensed(self, unit: Any, angle: Scalar, rate: Scalar, road: Road, demand: Demand) -> DrivingInputs:
        def first(*names: str, otherwise: Scalar = 0.0) -> Scalar:
            return next((getattr(unit, name) for name in names if hasattr(unit, name)), otherwise)

        speed, lateral = first("truth_speed", "vehicle_speed"), first("truth_lateral_speed", "lateral_speed")
        return DrivingInputs(
            speed, lateral, first("yaw_rate"), angle, first("steering_wheel_rate", otherwise=rate), road, demand
        )

    def coupled(self, block: Plant, usual: Mapping[str, float], seconds: float) -> Instance:
        """The running unit, to be closed after use; arguments as in `Instance`."""
        return Instance(self, block, usual, seconds)


@cache
def _sample(gives: tuple[tuple[str, str], ...]) -> type:
    return named_tuple("Surroundings", [*_AROUND.items(), ("unit", _tuple(gives))])


@cache
def _tuple(channels: tuple[tuple[str, str], ...]) -> Any:
    return named_tuple("Channels", [(name, Annotated[Scalar, unit]) for name, unit in channels])
