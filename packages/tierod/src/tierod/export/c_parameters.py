"""Parameter file of an export: every parameter with value, unit and meaning."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.export.c_header import banner, comment, note
from tierod.export.described import Described
from tierod.export.interface import Interface
from tierod.export.members import Member


def parameters(face: Interface, rows: str | None = None) -> str:
    """C code of the parameter file.

    Args:
        rows: C code of the members of a bank; None for those of a single block
    """
    prefix, subject = face.prefix, face.subject
    own = parameter_rows(face, face.parameters, subject.tuning, subject.values) if rows is None else rows
    return (
        f'{banner(face, "parameters")}#include "{prefix}.h"\n\n#include <math.h>\n\n'
        f"const {prefix}_parameters_t {prefix}_parameters = {{\n"
        f"    .hash = 0x{subject.digest:08x}UL,\n{own}}};\n"
    )


def parameter_rows(
    face: Interface, found: Sequence[Member], known: Sequence[Described], values: Sequence[float]
) -> str:
    """C code of members with their values.

    Args:
        known, values: description and value of every number, by its position
    """
    return "".join(
        f"{comment([note(known[each.places[0]])], '    ')}    .{each.name} = {braced(face, each, values)},\n"
        for each in found
    )


def braced(face: Interface, each: Member, values: Sequence[float]) -> str:
    """C code of a member's value: a number, or an array in braces."""
    return _braced(face, each.shape, [values[place] for place in each.places])


def _braced(face: Interface, shape: tuple[int, ...], values: Sequence[float]) -> str:
    if not shape:
        return face.spelling.number(values[0])
    width = len(values) // shape[0]
    return "{" + ", ".join(_braced(face, shape[1:], values[k * width : (k + 1) * width]) for k in range(shape[0])) + "}"
