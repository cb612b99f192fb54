"""Sources of a unit: the exported C code, and an instance layer."""

from __future__ import annotations

import math
from importlib.util import find_spec
from pathlib import Path

from tierod.core.errors import MissingExtra
from tierod.export.c_header import header, rendered
from tierod.export.c_source import parameters, source
from tierod.export.fmu.description import Model, Variable, token

TEMPLATES = Path(__file__).parent / "templates"

HEADERS = ("fmi2FunctionTypes.h", "fmi2Functions.h", "fmi2TypesPlatform.h")
"""Header files of the FMI standard, under the 2-clause BSD licence; taken from the installed package fmpy."""

_KINDS = {"time": "TIME", "input": "INPUT", "output": "OUTPUT", "status": "STATUS", "fixed": "FIXED"}


def compiled_names(model: Model) -> tuple[str, ...]:
    prefix = model.face.prefix
    return ("fmi2.c", "model.c", f"{prefix}.c", f"{prefix}_parameters.c")


def sources(model: Model) -> dict[str, str]:
    """Name -> text of all sources, including the headers of the standard.

    Raises:
        MissingExtra: fmpy, which provides the headers, is not installed
    """
    face = model.face
    values = _values(model)
    own = {f"{face.prefix}.h": header(face), f"{face.prefix}.c": source(face)}
    own[f"{face.prefix}_parameters.c"] = parameters(face)
    made = {name: rendered(TEMPLATES, f"{name}.j2", values) for name in ("model.h", "model.c", "fmi2.c")}
    return own | made | standard_headers()


def standard_headers() -> dict[str, str]:
    """Name -> text of the headers of the standard.

    Raises:
        MissingExtra: fmpy is not installed
    """
    found = find_spec("fmpy")
    if found is None or found.origin is None:
        raise MissingExtra("fmpy", "fmi", "the export of functional mock-up units")
    folder = Path(found.origin).parent / "c-code"
    return {name: (folder / name).read_text(encoding="utf-8", errors="replace") for name in HEADERS}


def _values(model: Model) -> dict[str, object]:
    face = model.face
    started = [each for each in model.of("input") if each.start != 0.0]
    return {
        "prefix": face.prefix,
        "guard": face.prefix.upper(),
        "token": token(model),
        "step": repr(face.subject.sample_time),
        "present": model.present,
        "count": len(model.variables),
        "variables": "".join(f"    {_row(each)},\n" for each in model.variables),
        "starts": "".join(f"    memory->{each.place} = {_c(each.start)};\n" for each in started),
        "status": _statuses(model),
    }


def _row(each: Variable) -> str:
    kind = _KINDS.get(each.kind, "TUNABLE")
    place = f"PLACE({each.place})" if each.place else "0U"
    limits = each.limits
    opened = "true" if limits.open_low else "false"
    return f'{{{kind}, {place}, {_c(limits.low)}, {_c(limits.high)}, {opened}, "{each.name}"}}'


def _statuses(model: Model) -> str:
    rows = "".join(
        f"    case {each.reference}U:\n        *value = (int64_t)instance->memory.{each.place};\n        break;\n"
        for each in model.of("status")
    )
    return f"    switch (reference) {{\n{rows}    default:\n        *value = 0;\n        break;\n    }}"


def _c(value: float) -> str:
    if math.isnan(value):
        return "(double)NAN"
    if math.isinf(value):
        return "(double)INFINITY" if value > 0.0 else "(-(double)INFINITY)"
    return repr(value) if value >= 0.0 else f"({value!r})"
