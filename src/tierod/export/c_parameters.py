"""The parameter file of an export: every parameter with its value, unit and meaning."""

from __future__ import annotations

from tierod.export.c_header import banner, comment, note
from tierod.export.interface import Interface
from tierod.export.members import Member


def parameters(face: Interface) -> str:
    """C of the parameters."""
    prefix, subject = face.prefix, face.subject
    rows = "".join(_row(face, each) for each in face.parameters)
    return (
        f'{banner(face, "parameters")}#include "{prefix}.h"\n\n#include <math.h>\n\n'
        f"const {prefix}_parameters_t {prefix}_parameters = {{\n"
        f"    .hash = 0x{subject.digest:08x}UL,\n{rows}}};\n"
    )


def _row(face: Interface, each: Member) -> str:
    known = face.subject.tuning[each.places[0]]
    return f"{comment([note(known)], '    ')}    .{each.name} = {_braced(face, each, each.shape, each.places)},\n"


def _braced(face: Interface, each: Member, shape: tuple[int, ...], places: tuple[int, ...]) -> str:
    if not shape:
        return face.spelling.number(face.subject.values[places[0]])
    width = len(places) // shape[0]
    parts = [_braced(face, each, shape[1:], places[k * width : (k + 1) * width]) for k in range(shape[0])]
    return "{" + ", ".join(parts) + "}"
