"""Source file of an export: helper functions, constants computed once, initial state and step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from tierod.core.graph.operations import OUTPUT, PUSH, Program, drop_unused, is_constant
from tierod.export.c_header import banner, declared, index_type, reason_name, reasons
from tierod.export.c_maths import helpers
from tierod.export.clocks import Clock
from tierod.export.cut_printer import CutPrinter
from tierod.export.interface import PARAMETER, Interface
from tierod.export.statements import Body, Gathered, Group, Reach


def source(face: Interface) -> str:
    """C code of the source file."""
    return assembled(face, "".join((prepare(face), "\n", init(face), "\n", step(face))))


def assembled(face: Interface, own: str) -> str:
    """The complete source file around the functions of a monitor."""
    prefix = face.prefix
    called = helpers(face.spelling, own, face.options.libm)
    includes = f'#include "{prefix}.h"\n\n#include <math.h>\n'
    includes += "#include <string.h>\n\n" if "memcpy(" in called else "\n"
    return "".join((banner(face, "the monitor"), includes, _STRICT, called, _identity(face), own, _reason(face)))


_STRICT = """\
#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && (__FINITE_MATH_ONLY__ > 0))
#error "NaN means that a value is missing: compile without -ffast-math, -Ofast and -ffinite-math-only"
#endif

"""


def _identity(face: Interface) -> str:
    prefix = face.prefix
    return (
        f'const char *{prefix}_version(void)\n{{\n    return "{face.subject.version}";\n}}\n\n'
        f"uint32_t {prefix}_parameter_hash({declared(face, 'p')})\n{{\n    return p->hash;\n}}\n\n"
    )


def prepare(face: Interface, name: str = "prepare", static: bool = False) -> str:
    """Function that computes the values depending on parameters only."""
    arguments = {"p": declared(face, "p"), "c": declared(face, "c", writes=True)}
    return constants(face, range(len(face.program.carried())), name, arguments, static)


def constants(face: Interface, slots: Iterable[int], name: str, arguments: Mapping[str, str], static: bool) -> str:
    """Function that computes some of the values depending on parameters only."""
    carried = face.program.carried()
    begun = _alone(face.program, {(OUTPUT, slot): carried[slot] for slot in slots})
    reach = Reach(face.taken, lambda target: face.carried(target[1]), face.carried, {}, {})
    return printed(face, begun, reach, {}, name, arguments, static)


def init(face: Interface) -> str:
    """Function that sets the state before the first sample; a compound literal clears every member first."""
    arguments = {"p": declared(face, "p"), "x": declared(face, "x")}
    return initial(face, "init", arguments, f"    *x = ({face.prefix}_state_t){{0}};\n")


def initial(face: Interface, name: str, arguments: Mapping[str, str], zeroed: str, static: bool = False) -> str:
    """Function that sets the non-zero members of the initial state.

    Args:
        face: interface of the block that holds the state
        arguments: C of the declaration of each argument, by its name
        zeroed: C code that clears the other members; "" where they are zero already
    """
    first = face.initial
    kept = face.lines.kept
    outputs = {
        target: value
        for target, value in first.outputs.items()
        if not is_constant(first.operations[value], 0.0) and (target[0] != PUSH or target[1] in kept)
    }
    reach = Reach(face.taken, face.given, face.carried, {}, {})
    text = printed(face, _alone(first, outputs), reach, {}, name, arguments, static)
    # A delay line is filled with its initial value: the program pushes a single number.
    more = ""
    for line, own in (face.lines.row(position) for group, position in outputs if group == PUSH):
        begun = f"    for ({index_type(line.size)} k = 1U; k < {line.size}U; k++) {{\n"
        more += f"{begun}        x->{own}[k] = x->{own}[0];\n    }}\n" if line.size > 1 else ""
    signature = f"void {face.prefix}_{name}({', '.join(arguments.values())})\n{{\n"
    begun_text, _, rest = text.rpartition(signature)
    return f"{begun_text}{signature}{zeroed}{rest.removesuffix('}' + chr(10))}{more}}}\n"


def step(
    face: Interface,
    name: str = "step",
    arguments: Mapping[str, str] | None = None,
    gathered: Gathered | None = None,
) -> str:
    """Function that advances the state by one sample.

    Args:
        arguments: C of the declaration of each argument, by its name, of a static function; None for the exported step
    """
    notes = {(OUTPUT, k): path for k, path in enumerate(face.graph.output)}
    types = {(OUTPUT, k): f"{face.prefix}_status_t" for k in face.statuses}
    reach = Reach(face.taken, face.given, face.carried, notes, types)
    words = arguments or {word: declared(face, word) for word in "cxuy"}
    text = printed(face, face.program, reach, face.clocks, name, words, arguments is not None, gathered)
    more = "".join(
        f"    {head} = (({head} + 1U) < {line.size}U) ? ({index_type(line.size)})({head} + 1U) : 0U;\n"
        for line in face.lines.arrays
        for head in [f"x->{line.name}_head"]
    )
    return f"{text.removesuffix('}' + chr(10))}{more}}}\n"


def _alone(operations: Program, outputs: Mapping[Group, int]) -> Program:
    kept, moved = drop_unused(operations.operations, dict(outputs))
    renamed = [each._replace(constant=(PARAMETER, each.constant[1])) if each.name == "input" else each for each in kept]
    return Program(tuple(renamed), moved, frozenset())


def printed(
    face: Interface,
    operations: Program,
    reach: Reach,
    clocks: Mapping[int, Clock],
    name: str,
    arguments: Mapping[str, str],
    static: bool = False,
    gathered: Gathered | None = None,
) -> str:
    """C functions of a program."""
    body = Body(face.graph, operations, face.spelling, reach, gathered)
    return CutPrinter(body, clocks).functions(f"{face.prefix}_{name}", arguments, static)


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
