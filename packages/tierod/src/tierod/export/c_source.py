"""Source file of an export: helper functions, constants computed once, initial state and step."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from tierod.core.graph.c_functions import definitions
from tierod.core.graph.operations import OUTPUT, PUSH, Program, drop_unused, is_constant
from tierod.export.c_header import banner, comment, declared, index_type, note, reason_name, reasons
from tierod.export.cut_printer import Body, CutPrinter, Gathered, Group, Reach
from tierod.export.interface import PARAMETER, Clock, Interface, Spelling
from tierod.export.subject import Described, Member

_OF_TWO = ("atan2", "pow", "hypot")

# C library functions for which the kernels may have implementations of their own
_OF_ONE = frozenset(
    ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "expm1", "log", "log1p"]
)

_BEGINNING = re.compile(r"^(?=/\* |TIEROD_INLINE |typedef |#define |static const )", re.MULTILINE)
_NAME = re.compile(r"\b(?:tierod|TIEROD)_\w+")
_DEFINED = re.compile(r"^(?:TIEROD_INLINE \w+|typedef \w+|#define|static const \w+) (\w+)", re.MULTILINE)


def helpers(spelling: Spelling, text: str, libm: bool = True) -> str:
    """C code of the helper functions that a piece of C code calls."""
    wanted = sorted(set(re.findall(rf"\b{spelling.prefix}_(\w+)\(", text)))
    if libm:
        return "".join(f"{spelling.literals(made)}\n" for name in wanted if (made := _helper(spelling, name)))
    own = [name for name in wanted if name in _OF_ONE or name in _OF_TWO]
    functions = _renamed(spelling, _reached(definitions(own, spelling.precision == "single"), own))
    basic = [name for name in ("fma", "sign") if f"{spelling.prefix}_{name}(" in text + functions]
    return "".join(f"{spelling.literals(_helper(spelling, name))}\n" for name in basic) + functions


def _reached(text: str, wanted: list[str]) -> str:
    parts: list[str] = []
    for part in _BEGINNING.split(text):
        # A comment belongs to the definition that follows it.
        if parts and parts[-1].startswith("/*") and parts[-1].rstrip().endswith("*/"):
            parts[-1] += part
        else:
            parts.append(part)
    named = {found[1]: part for part in parts if (found := _DEFINED.search(part))}
    waiting, needed = [f"tierod_{name}" for name in wanted], set()
    while waiting:
        name = waiting.pop()
        if name in named and name not in needed:
            needed.add(name)
            waiting += _NAME.findall(named[name])
    return "".join(f"{part.rstrip()}\n\n" for part in parts if (f := _DEFINED.search(part)) and f[1] in needed)


def _renamed(spelling: Spelling, text: str) -> str:
    text = text.replace("#ifdef TIEROD_FAST_FMA", f"#if {_fast(spelling)}").replace("TIEROD_INLINE ", "static ")
    text = re.sub(r"\bTIEROD_(\w+)", lambda found: f"{spelling.prefix.upper()}_{found[1]}", text)
    text = re.sub(r"\btierod_(\w+)", lambda found: f"{spelling.prefix}_{found[1]}", text)
    return spelling.literals(re.sub(r"\breal\b", spelling.real, text))


def _fast(spelling: Spelling) -> str:
    """C condition that the target has a fused multiply-add; newlib does not define the macro of the C standard."""
    name = "FP_FAST_FMA" if spelling.precision == "double" else "FP_FAST_FMAF"
    return f"defined {name} || defined __{name}"


def _helper(spelling: Spelling, name: str) -> str:
    """C code of a helper function; "" for an unknown name."""
    prefix, real = spelling.prefix, spelling.real
    if name == "fma":
        plain = f"#if {_fast(spelling)}\n    return M(fma)(a, b, c);\n#else\n    return (a * b) + c;\n#endif\n"
        body = "    return M(fma)(a, b, c);\n" if spelling.fused else plain
        return f"static {real} {prefix}_fma({real} a, {real} b, {real} c)\n{{\n{body}}}\n"
    if name == "sign":
        return (
            f"static {real} {prefix}_sign({real} a)\n{{\n"
            f"    return (a > R(0.0)) ? R(1.0) : ((a < R(0.0)) ? -R(1.0) : a);\n}}\n"
        )
    if name in _OF_TWO:
        return f"static {real} {prefix}_{name}({real} a, {real} b)\n{{\n    return M({name})(a, b);\n}}\n"
    if name in _OF_ONE:
        return f"static {real} {prefix}_{name}({real} a)\n{{\n    return M({name})(a);\n}}\n"
    return ""


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
    face: Interface, name: str = "step", arguments: Mapping[str, str] | None = None, gathered: Gathered | None = None
) -> str:
    """Function that advances the state by one sample.

    Args:
        arguments: C of the declaration of each argument, by its name, of a static function; None for the exported
            step
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
