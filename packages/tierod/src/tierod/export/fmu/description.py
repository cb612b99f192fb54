"""Model description of a unit, in the schema of FMI 2.0."""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from tierod.core.statement import STATUSES
from tierod.core.units import dimensions
from tierod.core.version import __version__
from tierod.export.c_header import plain
from tierod.export.fmu.variables import Model, Variable

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
