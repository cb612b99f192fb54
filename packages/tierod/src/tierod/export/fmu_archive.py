"""A functional mock-up unit as one file: description, binary for the present platform, sources and documentation."""

from __future__ import annotations

import html
import math
import platform
import sys
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from tierod.core.errors import CompileError, MissingExtra
from tierod.core.files import expanded, replacing
from tierod.core.graph.compiler import compiler
from tierod.export.c_header import header, rendered
from tierod.export.c_source import parameters, source
from tierod.export.evidence.checks import ran
from tierod.export.fmu_description import Model, Variable, model_description, token

# Header files of the FMI standard, under the 2-clause BSD licence; taken from the installed package fmpy
HEADERS = ("fmi2FunctionTypes.h", "fmi2Functions.h", "fmi2TypesPlatform.h")

_KINDS = {"time": "TIME", "input": "INPUT", "output": "OUTPUT", "status": "STATUS", "fixed": "FIXED"}


def compiled_names(model: Model) -> tuple[str, ...]:
    prefix = model.face.prefix
    return ("fmi2.c", "model.c", f"{prefix}.c", f"{prefix}_parameters.c")


def sources(model: Model) -> dict[str, str]:
    face = model.face
    values = _values(model)
    own = {f"{face.prefix}.h": header(face), f"{face.prefix}.c": source(face)}
    own[f"{face.prefix}_parameters.c"] = parameters(face)
    made = {name: rendered(f"{name}.j2", values) for name in ("model.h", "model.c", "fmi2.c")}
    return own | made | standard_headers()


def standard_headers() -> dict[str, str]:
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


# Compiler flags for any processor of the platform, not only the present one
FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-fno-math-errno", "-ffp-contract=off")

_PLACES = {"linux": ("linux64", ".so"), "darwin": ("darwin64", ".dylib"), "win32": ("win64", ".dll")}


def place_of_binary() -> tuple[str, str]:
    """Folder and file suffix of a binary for this platform."""
    intel = platform.machine().lower() in ("amd64", "x86_64")
    place = _PLACES.get(sys.platform)
    if place is None or not (intel or sys.platform == "darwin"):
        raise CompileError(
            f"FMI 2.0 has no name for the platform '{platform.machine()}, {sys.platform}'; export on a computer with "
            "an x86-64 processor"
        )
    return place


def built(texts: Mapping[str, str], names: Sequence[str]) -> bytes:
    """Shared library compiled from sources."""
    command = compiler()
    if command is None:
        raise CompileError(
            "a functional mock-up unit holds a binary, and no C compiler was found (looked for cc, gcc, clang and the "
            "wheel ziglang); install one, or pip install 'tierod[compiler]'"
        )
    with tempfile.TemporaryDirectory(prefix="tierod-") as name:
        folder = Path(name)
        for file, text in texts.items():
            (folder / file).write_text(text, encoding="utf-8")
        done = ran([*command, *FLAGS, *names, "-o", "unit.bin", "-lm"], folder)
        if done.code != 0 or not (folder / "unit.bin").is_file():
            raise CompileError(f"the C compiler '{' '.join(command)}' refused a generated unit ({done.first})")
        return (folder / "unit.bin").read_bytes()


MOMENT = (1980, 1, 1, 0, 0, 0)  # Time stamp of every file in the archive, fixed so that equal units have equal bytes


def write_unit(model: Model, path: str | Path) -> Path:
    folder, ending = place_of_binary()
    texts, names = sources(model), compiled_names(model)
    binary = built(texts, names)
    documents = {
        "modelDescription.xml": model_description(model, names),
        "documentation/index.html": documentation(model),
        "licenses/fmi-headers.txt": _licence(),
        **{f"sources/{name}": text for name, text in texts.items()},
    }
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in documents.items():
            archive.writestr(_entry(name), text.encode())
        archive.writestr(_entry(f"binaries/{folder}/{model.face.prefix}{ending}"), binary)
    return expanded(path)


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, MOMENT)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
    return entry


def _licence() -> str:
    text = standard_headers()[HEADERS[1]]
    stated = text[text.find("Copyright") : text.find("*/", text.find("Copyright"))]
    return f"The headers {', '.join(HEADERS)} are of the FMI standard:\n\n{stated.strip()}\n"


def documentation(model: Model) -> str:
    """HTML page with the variables of the unit."""
    subject = model.face.subject
    kind = (
        "Outputs belong to the present instant: state and inputs as they are. A communication step is a whole number "
        f"of steps of {subject.sample_time:g} s."
        if model.present
        else f"A sample is taken every {subject.sample_time:g} s, with the inputs as they were set at the start of the "
        "communication step in which it falls. Outputs are those of the last sample. An input that is NaN is missing."
    )
    titles = (
        ("Inputs", model.of("input")), ("Outputs", model.of("output", "status")),
        ("Parameters, tunable", model.of("tunable")), ("Parameters, fixed at the start", model.of("fixed")),
    )  # fmt: skip
    tables = "".join(_table(title, rows) for title, rows in titles if rows)
    title = html.escape(subject.title)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title></head><body>\n'
        f"<h1>{title}</h1>\n<p>{html.escape(subject.version)}; vehicle {html.escape(subject.vehicle or 'none')}; "
        f"parameters {subject.digest:08x}.</p>\n<p>{kind}</p>\n{tables}</body></html>\n"
    )


def _table(title: str, rows: tuple[Variable, ...]) -> str:
    lines = "".join(
        f"<tr><td>{html.escape(each.name)}</td><td>{html.escape(each.unit or '-')}</td><td>{_start(each)}</td>"
        f"<td>{html.escape(each.meaning)}</td></tr>\n"
        for each in rows
    )
    return (
        f"<h2>{title}</h2>\n<table><tr><th>name</th><th>unit</th><th>start</th><th>meaning</th></tr>\n{lines}</table>\n"
    )


def _start(each: Variable) -> str:
    return "" if each.kind in ("output", "status") else "missing" if math.isnan(each.start) else f"{each.start:g}"
