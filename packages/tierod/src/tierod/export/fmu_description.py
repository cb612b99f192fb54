"""Variables of a unit, with consecutive value references, and its model description in the schema of FMI 2.0."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from tierod.core.errors import InputError
from tierod.core.fields import ANY, Range, numbers
from tierod.core.graph.operations import OUTPUT, SAMPLE, TUNING, Program
from tierod.core.signals import SIGNALS
from tierod.core.statuses import STATUSES
from tierod.core.units import dimensions
from tierod.core.version import __version__
from tierod.export.c_header import plain
from tierod.export.interface import Interface
from tierod.export.subject import Described, elements

Kind = Literal["time", "input", "output", "status", "fixed", "tunable"]

# Parameters that hold the sampling interval; the description of a unit fixes it, so they are not exposed
CLOCKS = ("sample_time", "step_time")


@dataclass(frozen=True)
class Variable:
    name: str  # in structured notation, such as "filter.gain[1]"
    reference: int
    kind: Kind  # causality; "fixed" and "tunable" are parameters
    unit: str = ""  # in the notation of pint; "" for none
    meaning: str = ""
    start: float = 0.0  # value before the first step; NaN for a missing input
    limits: Range = ANY
    place: str = ""  # C code of its number within an instance; "" for time


@dataclass(frozen=True)
class Model:
    face: Interface
    starts: dict[str, float]  # start values of inputs that count as present before they are set, by name
    present: bool = False  # whether outputs depend on the inputs at the same instant, as those of a plant do

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """All variables; the position in this tuple is the value reference."""
        rows = [Variable("time", 0, "time", "s", "Time of the run")]
        rows += [self._input(k, each) for k, each in enumerate(self.face.subject.sample)]
        rows += [self._output(k, each) for k, each in enumerate(self.face.subject.output)]
        rows += self._parameters()
        return tuple(_distinct(rows))

    def of(self, *kinds: Kind) -> tuple[Variable, ...]:
        return tuple(each for each in self.variables if each.kind in kinds)

    def _input(self, position: int, each: Described) -> Variable:
        place = f"sample.{elements(self.face.sample)[position]}"
        start = self.starts.get(each.path, math.nan)
        return Variable(structured(each.path), 0, "input", _unit(each), each.meaning, start, place=place)

    def _output(self, position: int, each: Described) -> Variable:
        kind: Kind = "status" if position in self.face.statuses else "output"
        place = f"output.{elements(self.face.output)[position]}"
        return Variable(structured(each.path), 0, kind, _unit(each), _meaning(each), place=place)

    def _parameters(self) -> list[Variable]:
        stepped, begun = _taken(self.face.program, TUNING), _taken(self.face.initial, 0)
        known = numbers(self.face.subject.block)
        rows = []
        for k, (each, value) in enumerate(zip(self.face.subject.tuning, self.face.subject.values, strict=True)):
            if k not in stepped | begun or each.path.rpartition(".")[2] in CLOCKS:
                continue
            kind: Kind = "tunable" if k in stepped else "fixed"
            limits = known[each.path].limits if each.path in known else None
            place = f"parameters.{elements(self.face.parameters)[k]}"
            # FMI requires start values within the range, so a range that the present value violates is dropped.
            own = limits if limits is not None and limits.holds(value) else ANY
            rows.append(Variable(structured(each.path), 0, kind, _unit(each), each.meaning, value, own, place))
        return rows

    def inputs_of(self, variable: Variable) -> tuple[int, ...]:
        """Value references of the inputs on which an output depends at the same instant; none for a sampled output."""
        if not self.present:
            return ()
        outputs = self.of("output", "status")
        first = self.of("input")[0].reference if self.of("input") else 0
        position = outputs.index(variable)
        return tuple(first + each for each in sorted(_reached(self.face.program, position)))


def structured(path: str) -> str:
    """A dotted path in the structured notation of the standard; numbers become array indices, counted from 1."""
    parts = path.split(".")
    found = ""
    places: list[str] = []
    for part in parts:
        if part.isdigit():
            places.append(str(int(part) + 1))
            continue
        found += f"[{','.join(places)}]" if places else ""
        places = []
        found += f".{part}" if found else part
    return found + (f"[{','.join(places)}]" if places else "")


def _distinct(rows: list[Variable]) -> Iterator[Variable]:
    """Variables with their references; a repeated name gets its kind as prefix."""
    taken: set[str] = set()
    for reference, each in enumerate(rows):
        name = each.name
        while name in taken:
            name = f"{each.kind}_{name}"
        taken.add(name)
        yield replace(each, name=name, reference=reference)


def _meaning(each: Described) -> str:
    """Meaning in words; from the signal catalogue if the field has none of its own."""
    last = each.path.rpartition(".")[2]
    signal = SIGNALS.get(last)
    return each.meaning or (signal.meaning.rstrip(".") if signal else "")


def _unit(each: Described) -> str:
    try:
        dimensions(each.unit)
    except InputError:
        return ""
    return each.unit


def _taken(program: Program, group: int) -> set[int]:
    return {each.constant[1] for each in program.operations if each.name == "input" and each.constant[0] == group}


def _reached(program: Program, position: int) -> set[int]:
    waiting, seen, found = [program.outputs[OUTPUT, position]], set[int](), set[int]()
    while waiting:
        index = waiting.pop()
        if index not in seen:
            seen.add(index)
            operation = program.operations[index]
            if operation.name == "input" and operation.constant[0] == SAMPLE:
                found.add(operation.constant[1])
            waiting += operation.arguments
    return found


STATUS_TYPE = "Status"
LOG_CATEGORIES = (
    ("logEvents", "Course of a run"),
    ("logStatusError", "What was given, what was expected, and what to do"),
)
_CAUSALITY = {
    "time": "independent", "input": "input", "output": "output", "status": "output",
    "fixed": "parameter", "tunable": "parameter",
}  # fmt: skip
_BASE_ORDER = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


def token(model: Model) -> str:
    """Token that must be equal in the description and the binary."""
    subject = model.face.subject
    return f"{{tierod-{subject.name}-{subject.digest:08x}-{len(model.variables)}}}"


def model_description(model: Model, sources: Iterable[str]) -> str:
    subject = model.face.subject
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": plain(subject.title),
            "guid": token(model),
            "description": plain(f"{subject.title}; vehicle {subject.vehicle or 'none'}; {subject.version}"),
            "version": f"{subject.digest:08x}",
            "generationTool": f"tierod {__version__}",
            "variableNamingConvention": "structured",
        },
    )
    _co_simulation(root, model, sources)
    _units(root, model)
    _types(root, model)
    logs = SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES:
        SubElement(logs, "Category", {"name": name, "description": text})
    SubElement(root, "DefaultExperiment", {"startTime": "0", "stepSize": repr(subject.sample_time)})
    listed = SubElement(root, "ModelVariables")
    for each in model.variables:
        _variable(listed, each, model.present)
    _structure(root, model)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _co_simulation(root: Element, model: Model, sources: Iterable[str]) -> None:
    given = {
        "modelIdentifier": model.face.prefix,
        "canHandleVariableCommunicationStepSize": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }
    files = SubElement(SubElement(root, "CoSimulation", given), "SourceFiles")
    for name in sources:
        SubElement(files, "File", {"name": name})


def _units(root: Element, model: Model) -> None:
    listed = SubElement(root, "UnitDefinitions")
    for unit in sorted({each.unit for each in model.variables if each.unit}):
        known = dimensions(unit)
        base = {name: str(known.exponents[name]) for name in _BASE_ORDER if name in known.exponents}
        size = {} if known.factor == 1.0 else {"factor": repr(known.factor)}
        SubElement(SubElement(listed, "Unit", {"name": unit}), "BaseUnit", base | size)


def _types(root: Element, model: Model) -> None:
    if not model.of("status"):
        return
    types = SubElement(root, "TypeDefinitions")
    meaning = {"description": "State of what is monitored, or why it could not be judged"}
    kind = SubElement(SubElement(types, "SimpleType", {"name": STATUS_TYPE, **meaning}), "Enumeration")
    for code, each in enumerate(STATUSES):
        SubElement(kind, "Item", {"name": str(each), "value": str(code)})


def _about(each: Variable, present: bool) -> dict[str, str]:
    continuous = each.kind in ("time", "input") or (each.kind == "output" and present)
    variability = each.kind if each.kind in ("fixed", "tunable") else "continuous" if continuous else "discrete"
    meaning = {"description": plain(each.meaning)} if each.meaning else {}
    return {
        "name": each.name,
        "valueReference": str(each.reference),
        "causality": _CAUSALITY[each.kind],
        "variability": variability,
        **meaning,
    }


def _number(each: Variable) -> dict[str, str]:
    found = {"unit": each.unit} if each.unit else {}
    found |= {"min": repr(each.limits.low)} if math.isfinite(each.limits.low) else {}
    found |= {"max": repr(each.limits.high)} if math.isfinite(each.limits.high) else {}
    if each.kind in ("input", "fixed", "tunable"):
        found["start"] = "NaN" if math.isnan(each.start) else repr(each.start)
    return found


def _variable(listed: Element, each: Variable, present: bool) -> None:
    row = SubElement(listed, "ScalarVariable", _about(each, present))
    if each.kind == "status":
        SubElement(row, "Enumeration", {"declaredType": STATUS_TYPE})
    else:
        SubElement(row, "Real", _number(each))


def _structure(root: Element, model: Model) -> None:
    """Model structure, which refers to variables by their index from 1 on."""
    structure = SubElement(root, "ModelStructure")
    outputs = model.of("output", "status")
    for name in ("Outputs", "InitialUnknowns"):
        group = SubElement(structure, name)
        for each in outputs:
            depends = {"dependencies": " ".join(str(k + 1) for k in model.inputs_of(each))} if name == "Outputs" else {}
            SubElement(group, "Unknown", {"index": str(each.reference + 1), **depends})
