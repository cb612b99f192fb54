"""Assignment of a unit's variables to the signals of tierod by a file: names, units, signs."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.fields import POSITIVE
from tierod.core.toml import Document, Location, build
from tierod.core.units import scale
from tierod.proving_ground.foreign.description import Unit, Variable, read_unit
from tierod.proving_ground.foreign.offers import channels, offered, port_of


@dataclass(frozen=True)
class Entry:
    """Relation of a variable to a signal: the signal in `unit` is sign * factor * variable + offset.

    Args:
        variable: name in the unit; that of the entry where empty
        signal: name in tierod; that of the entry where empty
        unit: unit of the result; if None that of the unit's description, or SI if it has none
        sign: 1 or -1
        factor: factor of the variable
        offset: offset that is added after sign and factor
    """

    variable: str = ""
    signal: str = ""
    unit: str | None = None
    sign: float = 1.0
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class PlantFile:
    """Content of the file of a unit that replaces a plant.

    Args:
        fmu: path of the unit, relative to this file
        inputs: signal of tierod, or an entry, by variable of the unit
        outputs: variable of the unit, or an entry, by signal of tierod
        values: values of parameters before the first step, in the unit's own units, by variable
        start_speed: parameter that is the initial speed, or an entry; None keeps the unit's own initial speed
        step: communication step [s]; that of the unit's description if None
        break_loops: whether the driver may use outputs one step old where they depend directly on its own outputs
        title: title for readers
    """

    fmu: str
    inputs: Mapping[str, Any] = field(default_factory=dict)
    outputs: Mapping[str, Any] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    start_speed: Any = None
    step: Annotated[float, "s", POSITIVE] | None = None
    break_loops: bool = False
    title: str = ""


class Wire(NamedTuple):
    """A variable and its signal: signal [SI] = gain * variable + offset."""

    variable: str
    reference: int
    signal: str
    unit: str
    gain: float = 1.0
    offset: float = 0.0


class Tunable(NamedTuple):
    """A parameter of a unit that may change during the run, with a dotted path."""

    path: str
    reference: int
    unit: str
    value: float
    low: float
    high: float


class Setting(NamedTuple):
    """A parameter that is set before the first step."""

    reference: int
    value: float


class Wiring(NamedTuple):
    """Connection of a unit.

    Args:
        digest: SHA-256 of the unit
        inputs: inputs of the unit, in order
        outputs: outputs of the unit, in order
        tunable: parameters that faults and scatter can change
        settings: parameters that are set once
        start: the parameter that is the initial speed, if there is one
        step: communication step [s]
        present: whether an output may depend on an input at the same instant
        loops: (output, input) of the algebraic loops that driver or assist unit would close
    """

    digest: str
    inputs: tuple[Wire, ...]
    outputs: tuple[Wire, ...]
    tunable: tuple[Tunable, ...]
    settings: tuple[Setting, ...]
    start: tuple[Wire, ...]
    step: float
    present: bool
    loops: tuple[tuple[str, str], ...]

    def text(self) -> str:
        """The wiring as JSON, for another process."""
        return json.dumps(self)

    @classmethod
    def from_text(cls, text: str) -> Wiring:
        """The wiring from the text of `text`."""
        digest, inputs, outputs, tunable, settings, start, step, present, loops = json.loads(text)
        given, shown, speed = (tuple(Wire(*each) for each in rows) for rows in (inputs, outputs, start))
        parameters = tuple(Tunable(*each) for each in tunable)
        first = tuple(Setting(*each) for each in settings)
        return cls(digest, given, shown, parameters, first, speed, step, present, tuple((a, b) for a, b in loops))


USUAL_STEP, LONGEST_STEP = 1e-3, 2e-2
"""Communication step if a unit recommends none, and the longest one that the driver model tolerates [s]."""

START_SPEED = "start.speed"
"""Name of the initial speed of a course."""

CLOSED = ("hand_torque", "steering_wheel_angle", "steering_wheel_rate", "motor_torque")
"""Signals that driver and assist unit compute from outputs of the same instant."""

STEERED_BY = ("steering_wheel_angle", "steering_wheel_rate", "driver_torque")
"""Outputs from which these signals are computed."""


def wiring_of(document: Document) -> tuple[Unit, Wiring]:
    """The unit to which a file refers, and its connection.

    Args:
        document: a plant file

    Raises:
        ParameterError: an invalid file, a variable that the unit does not have, or one of another kind
        InputError: the unit cannot be used
    """
    file: PlantFile = build(PlantFile, document.content, document)
    path = Path(file.fmu).expanduser()
    unit = read_unit(path if path.is_absolute() else document.path.parent / path)
    return unit, connected(unit, file, document)


def connected(unit: Unit, file: PlantFile, document: Document) -> Wiring:
    """Connect a unit.

    Args:
        unit: description of the unit
        file: assignment of its variables
        document: document of the file

    Raises:
        ParameterError: a variable or signal that does not exist or does not fit
    """
    inputs = tuple(_input(unit, name, given, document) for name, given in file.inputs.items())
    outputs = tuple(_output(unit, name, given, document) for name, given in file.outputs.items())
    if not outputs:
        raise document.error(("outputs",), "the plant file reads no output of the unit; name at least the speed")
    depends = {each.signal: unit.depends.get(each.variable) for each in outputs}
    taken = {each.variable: each.signal for each in inputs}
    loops = tuple(
        (signal, taken[name])
        for signal, names in depends.items()
        if signal in STEERED_BY
        for name in sorted(names or ())
        if taken.get(name) in CLOSED
    )
    if loops and not file.break_loops:
        raise document.error(("outputs", loops[0][0]), _loop(*loops[0]))
    present = any(names is None or names & set(taken) for names in depends.values())
    start = () if file.start_speed is None else (_start(unit, file.start_speed, document),)
    tunable = tuple(_tunable(unit, file.values, {each.variable for each in start}))
    settings, step = tuple(_settings(unit, file, document)), _step(unit, file, document)
    return Wiring(unit.digest, inputs, outputs, tunable, settings, start, step, present, loops)


def _loop(output: str, given: str) -> str:
    return (
        f"an algebraic loop: '{output}' of the unit depends at the same instant on '{given}', which is worked out from "
        "it; give the unit a state between the two, or write break_loops = true to use values that are one step old"
    )


def _start(unit: Unit, given: object, document: Document) -> Wire:
    location = ("start_speed",)
    entry = _entry(given, document, location, "variable")
    variable = _variable(unit, entry.variable, "parameter", document, location)
    return _wire(variable, START_SPEED, "m/s", entry, document, location)


def _entry(given: object, document: Document, location: Location, short: str) -> Entry:
    table = {short: given} if isinstance(given, str) else given
    entry: Entry = build(Entry, table, document, location)
    if entry.sign not in (1.0, -1.0) or entry.factor == 0.0 or not math.isfinite(entry.factor * entry.offset):
        raise document.error(location, "'sign' has to be 1 or -1, 'factor' finite and not zero, 'offset' finite")
    return entry


def _input(unit: Unit, name: str, given: object, document: Document) -> Wire:
    location = ("inputs", name)
    entry = _entry(given, document, location, "signal")
    variable = _variable(unit, entry.variable or name, "input", document, location)
    known = offered()
    signal = entry.signal
    if signal not in known and not port_of(signal):
        raise document.error(location, f"nothing that a unit can be given is called '{signal}'{nearest(signal, known)}")
    return _wire(variable, signal, known.get(signal), entry, document, location)


def _output(unit: Unit, name: str, given: object, document: Document) -> Wire:
    location = ("outputs", name)
    entry = _entry(given, document, location, "variable")
    known = channels()
    if name not in known and not (name.startswith("truth_") and name.isidentifier()):
        raise document.error(location, f"no signal is called '{name}'{nearest(name, known)}")
    variable = _variable(unit, entry.variable or name, "output", document, location)
    return _wire(variable, name, known.get(name), entry, document, location)


def _variable(unit: Unit, name: str, causality: str, document: Document, location: Location) -> Variable:
    found = unit.variables.get(name)
    if found is None or found.causality not in (causality, "local" if causality == "output" else causality):
        known = unit.of(causality)
        is_what = "" if found is None else f" ('{name}' is of the kind {found.causality})"
        raise document.error(
            location, f"the unit {unit.path.name} has no {causality} '{name}'{is_what}{nearest(name, known)}"
        )
    if not found.is_number:
        raise document.error(location, f"'{name}' of the unit is not a 64-bit number; leave it out")
    return found


def _wire(
    variable: Variable, signal: str, wanted: str | None, entry: Entry, document: Document, location: Location
) -> Wire:
    stated = variable.unit if entry.unit is None else entry.unit
    unit = stated if wanted is None else wanted
    gain = offset = 0.0
    try:
        size = scale(stated or unit, unit)
        gain, offset = size.factor, size.offset
    except InputError as error:
        if entry.unit is not None or wanted != "":
            raise document.error(location, f"'{variable.name}': {error}") from None
        gain = 1.0
    gain, offset = gain * entry.sign * entry.factor, gain * entry.offset + offset
    return Wire(variable.name, variable.reference, signal, unit, gain, offset)


def _step(unit: Unit, file: PlantFile, document: Document) -> float:
    """Communication step [s]."""
    stated = unit.step if math.isfinite(unit.step) and unit.step > 0.0 else USUAL_STEP
    if file.step is None:
        step = stated if stated <= LONGEST_STEP or unit.fixed else LONGEST_STEP
    else:
        step = file.step
        if unit.fixed and math.isfinite(unit.step) and abs(step - stated) > 1e-9 * stated:
            raise document.error(("step",), f"the unit takes no other step than its own {stated:g} s, not {step:g} s")
    if not 1e-5 <= step <= LONGEST_STEP:
        raise document.error(
            ("step",),
            f"a step of {step:g} s is outside the range of the driver model, 1e-05 to {LONGEST_STEP:g} s; export the "
            "unit "
            "with a shorter one",
        )
    return step


def _settings(unit: Unit, file: PlantFile, document: Document) -> Iterable[Setting]:
    for name, value in file.values.items():
        found = unit.of("parameter").get(name)
        if found is None or not found.is_number:
            known = unit.of("parameter")
            raise document.error(("values", name), f"the unit has no parameter '{name}'{nearest(name, known)}")
        if not found.limits.holds(float(value)):
            raise document.error(("values", name), f"'{name}' is {value:g}, but has to be {found.limits}")
        yield Setting(found.reference, float(value))


def _tunable(unit: Unit, values: Mapping[str, float], without: set[str]) -> Iterable[Tunable]:
    """Tunable parameters whose names are valid paths, where no path is a prefix of another one."""
    taken: set[str] = set()
    for name, each in unit.of("parameter").items():
        if name in without:
            continue
        path = name.replace("[", ".item_").replace("]", "").replace(",", "_")
        parts = path.split(".")
        fits = all(part.isidentifier() and not part.startswith("__") for part in parts)
        above = {".".join(parts[:depth]) for depth in range(1, len(parts))}
        if each.variability != "tunable" or not each.is_number or not fits or parts[0] in OWN or path in taken:
            continue
        if above & taken or any(other.startswith(f"{path}.") for other in taken) or math.isnan(each.start):
            continue
        taken.add(path)
        value = float(values.get(name, each.start))
        yield Tunable(path, each.reference, _known_unit(each.unit), value, each.limits.low, each.limits.high)


OWN = ("path", "wiring", "driver", "assist", "start", "step_time")
"""Fields of `ForeignCar`, which no parameter of a unit can have as the first part of its name."""


def _known_unit(text: str) -> str:
    try:
        return text if not text or scale(text, text) else ""
    except InputError:
        return ""


def refuse_changed(path: Path, digest: str) -> Unit:
    """The unit of a file, which must not have changed since it was connected.

    Raises:
        ParameterError: the file has changed
    """
    unit = read_unit(path)
    if unit.digest != digest:
        raise ParameterError(f"{path} has changed since it was connected; read the scenario again")
    return unit
