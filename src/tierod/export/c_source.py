"""The source of an export: helpers, what is worked out once, the first state, and the step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from tierod.core.graph.operations import NEXT_STATE, OUTPUT, PUSH, Program, drop_unused, invariant_of
from tierod.export.c_header import banner, declared, reason_name, reasons
from tierod.export.c_maths import helpers
from tierod.export.clocks import Clock
from tierod.export.cut_printer import CutPrinter, Group, Reach
from tierod.export.interface import PARAMETER, Interface


def source(face: Interface) -> str:
    """C of the source."""
    prefix = face.prefix
    own = "".join((_prepare(face), "\n", _init(face), "\n", _step(face)))
    called = helpers(face.spelling, own, face.options.libm)
    includes = f'#include "{prefix}.h"\n\n#include <math.h>\n'
    includes += "#include <string.h>\n\n" if "memcpy(" in called else "\n"
    return "".join((banner(face, "the monitor"), includes, called, _identity(face), own, _reason(face)))


def _identity(face: Interface) -> str:
    prefix = face.prefix
    return (
        f'const char *{prefix}_version(void)\n{{\n    return "{face.subject.version}";\n}}\n\n'
        f"uint32_t {prefix}_parameter_hash({declared(face, 'p')})\n{{\n    return p->hash;\n}}\n\n"
    )


def _prepare(face: Interface) -> str:
    """What depends on the parameters alone."""
    carried = face.program.carried()
    outputs = {(OUTPUT, slot): value for slot, value in enumerate(carried)}
    begun = _alone(face.program, outputs)
    reach = Reach(face.taken, lambda target: face.carried(target[1]), face.carried, {}, {})
    arguments = {"p": declared(face, "p"), "c": declared(face, "c", writes=True)}
    return _printed(face, begun, reach, {}, "prepare", arguments)


def _init(face: Interface) -> str:
    """The state before the first sample."""
    first = face.initial
    outputs = {t: v for t, v in first.outputs.items() if t[0] == NEXT_STATE and not _is_zero(first, v)}
    filled = {t: v for t, v in first.outputs.items() if t[0] == PUSH}
    begun = _alone(first, outputs)
    reach = Reach(face.taken, face.given, face.carried, {}, {})
    arguments = {"p": declared(face, "p"), "x": declared(face, "x")}
    text = _printed(face, begun, reach, {}, "init", arguments)
    more = ""
    for (_, position), value in filled.items():
        name, size = face.rings[position]
        number = face.spelling.number(float(first.operations[value].constant or 0.0))
        more += f"    for (uint16_t k = 0U; k < {size}U; k++) {{\n        x->{name}[k] = {number};\n    }}\n"
        more += f"    x->{name}_head = 0U;\n"
    # All else is zero; a compound literal leaves no member out.
    signature = f"void {face.prefix}_init({', '.join(arguments.values())})\n{{\n"
    begun_text, _, rest = text.rpartition(signature)
    zeroed = f"    *x = ({face.prefix}_state_t){{0}};\n"
    return f"{begun_text}{signature}{zeroed}{rest.removesuffix('}' + chr(10))}{more}}}\n"


def _is_zero(first: Program, value: int) -> bool:
    operation = first.operations[value]
    return operation.name == "constant" and operation.constant == 0.0


def _step(face: Interface) -> str:
    subject = face.subject
    notes = {(OUTPUT, k): each.path for k, each in enumerate(subject.output)}
    types = {(OUTPUT, k): f"{face.prefix}_status_t" for k in face.statuses}
    reach = Reach(face.taken, face.given, face.carried, notes, types)
    arguments = {word: declared(face, word) for word in "cxuy"}
    text = _printed(face, face.program, reach, face.clocks, "step", arguments)
    more = "".join(
        f"    x->{name}_head = ((x->{name}_head + 1U) < {size}U) ? (uint16_t)(x->{name}_head + 1U) : 0U;\n"
        for name, size in face.rings
    )
    return f"{text.removesuffix('}' + chr(10))}{more}}}\n"


def _alone(operations: Program, outputs: Mapping[Group, int]) -> Program:
    """A program that gives these outputs and is worked out as a whole."""
    kept, moved = drop_unused(operations.operations, dict(outputs))
    renamed = [each._replace(constant=(PARAMETER, each.constant[1])) if each.name == "input" else each for each in kept]
    return replace(operations, operations=tuple(renamed), outputs=moved, invariant=invariant_of(renamed))


def _printed(
    face: Interface,
    operations: Program,
    reach: Reach,
    clocks: Mapping[int, Clock],
    name: str,
    arguments: Mapping[str, str],
) -> str:
    printer = CutPrinter(face.subject.graph, operations, face.spelling, reach, clocks)
    return printer.functions(f"{face.prefix}_{name}", arguments)


def _reason(face: Interface) -> str:
    found = reasons(face)
    if not found:
        return ""
    prefix, members = face.prefix, face.given
    lines = "".join(
        f"    {'' if number == 0 else '} else '}if ({members((OUTPUT, k))} > {face.spelling.number(0.5)}) {{\n"
        f"        found = {reason_name(face, each)};\n"
        for number, (k, each) in enumerate(found)
    )
    return (
        f"\n{prefix}_reason_t {prefix}_reason(const {prefix}_output_t *y)\n{{\n"
        f"    {prefix}_reason_t found;\n\n{lines}    }} else {{\n"
        f"        found = {reason_name(face, None)};\n    }}\n    return found;\n}}\n"
    )
