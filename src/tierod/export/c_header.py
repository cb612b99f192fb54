"""The header of an export: types with unit, meaning and range of every number, and the functions."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from tierod.core.findings import Status
from tierod.core.statement import STATUSES
from tierod.export.described import Described
from tierod.export.interface import Interface
from tierod.export.members import Member, identifier

WIDTH = 116


def header(face: Interface) -> str:
    """C of the header."""
    guard = f"{face.prefix.upper()}_H"
    parts = [
        banner(face, "types and functions"),
        f"#ifndef {guard}\n#define {guard}\n\n#include <stdbool.h>\n#include <stdint.h>\n\n",
        f"/* The type of all numbers: {face.options.precision} precision. */\n"
        f"typedef {'float' if face.options.precision == 'single' else 'double'} {face.spelling.real};\n\n",
        _statuses(face),
        _reasons(face),
        _structs(face),
        _functions(face),
        f"#endif /* {guard} */\n",
    ]
    return "".join(parts)


def banner(face: Interface, what: str) -> str:
    """The comment at the head of a file."""
    subject = face.subject
    lines = [
        f"{face.prefix}: {what}",
        "",
        f"{subject.title} ({subject.version}), vehicle {subject.vehicle or 'none'}.",
        f"One step every {subject.sample_time:g} s. {face.options.precision.capitalize()} precision. "
        f"Parameters {subject.digest:08x}.",
        "Generated; do not edit. Change the vehicle file and export again.",
    ]
    return comment(lines) + "\n"


def comment(lines: Sequence[str], indent: str = "") -> str:
    """A comment of one or more lines; nothing in it can end it."""
    safe = [plain(each) for each in lines]
    if len(safe) == 1 and len(safe[0]) + len(indent) + 6 <= WIDTH:
        return f"{indent}/* {safe[0]} */\n"
    wrapped = [part for each in safe for part in (textwrap.wrap(each, WIDTH - len(indent) - 3) or [""])]
    return f"{indent}/*\n" + "".join(f"{indent} * {each}".rstrip() + "\n" for each in wrapped) + f"{indent} */\n"


def plain(text: str) -> str:
    """A text of plain ASCII without the marks that begin or end a comment."""
    ascii_ = text.replace("²", "**2").encode("ascii", "replace").decode("ascii")
    return ascii_.replace("*/", "* /").replace("/*", "/ *").replace("//", "/ /").replace("??", "?")


def note(each: Described) -> str:
    """Unit, meaning and range of a number as a comment states them."""
    unit = f"[{each.unit}]" if each.unit else "[-]"
    limits = f"; {each.limits}" if each.limits else ""
    meaning = f" {each.meaning}" if each.meaning else ""
    return f"{unit}{meaning}{limits}"


def status_name(face: Interface, status: Status) -> str:
    """The constant of a status."""
    return f"{face.prefix}_{identifier(str(status))}".upper()


def _statuses(face: Interface) -> str:
    if not face.statuses:
        return ""
    rows = ",\n".join(f"    {status_name(face, each)} = {code}" for code, each in enumerate(STATUSES))
    return _enumeration(face, "status", "State of what is monitored, or why it could not be judged.", rows)


def _enumeration(face: Interface, name: str, text: str, rows: str) -> str:
    return f"{comment([text])}typedef enum {{\n{rows}\n}} {face.prefix}_{name}_t;\n\n"


def reasons(face: Interface) -> tuple[tuple[int, Described], ...]:
    """Outputs that are reasons to withhold a verdict, with their positions; the first that holds decides."""
    return tuple((k, each) for k, each in enumerate(face.subject.output) if each.holder == "Obstacles")


def reason_name(face: Interface, each: Described | None) -> str:
    """The constant of a reason."""
    word = "none" if each is None else each.path.rpartition(".")[2]
    return f"{face.prefix}_reason_{identifier(word)}".upper()


def _reasons(face: Interface) -> str:
    found = reasons(face)
    if not found:
        return ""
    rows = [f"    {reason_name(face, None)} = 0"]
    rows += [f"    {reason_name(face, each)} = {number}" for number, (_, each) in enumerate(found, 1)]
    return _enumeration(face, "reason", "Why a verdict is withheld; the first reason that holds.", ",\n".join(rows))


def _structs(face: Interface) -> str:
    subject, real = face.subject, face.spelling.real
    positions, plain_members = face.plain
    state = [_member(each, real, tuple(subject.state[positions[k]] for k in each.places)) for each in plain_members]
    state += [
        comment([f"clock: steps of {note(subject.state[k])}"], "    ") + f"    uint32_t {name};\n"
        for k, name in face.counted.items()
    ]
    for name, size in face.rings:
        state.append(f"    /* delay line, and its place that is read and written next */\n    {real} {name}[{size}];\n")
        state.append(f"    uint16_t {name}_head;\n")
    kinds = dict.fromkeys(face.statuses, f"{face.prefix}_status_t")
    sample = [_member(each, real, tuple(subject.sample[k] for k in each.places)) for each in face.sample]
    output = [_member(each, kinds.get(each.places[0], real), _of(subject.output, each)) for each in face.output]
    parameters = ["    /* stands for version, names and values of all parameters */\n    uint32_t hash;\n"]
    parameters += [_member(each, real, _of(subject.tuning, each)) for each in face.parameters]
    validity = _bits(face) if face.options.validity else ""
    if face.options.validity:
        sample.insert(
            0, f"    /* bits {face.prefix.upper()}_VALID_... of the inputs that are valid */\n    uint32_t valid;\n"
        )
    missing = "an input whose bit is 0 is missing" if face.options.validity else "NaN where an input is missing"
    carried = len(face.program.carried())
    constants = [f"    {real} value[{max(carried, 1)}];\n"]
    return validity + "".join(
        _struct(face, name, text, rows)
        for name, text, rows in (
            ("sample", f"What is measured at one step; {missing}. SI units; left is positive (ISO 8855).", sample),
            ("output", "What is stated after one step.", output),
            ("parameters", "Of the vehicle and of the monitor.", parameters),
            ("constants", "What depends on the parameters alone; shared by all instances.", constants),
            ("state", "Memory of one instance; it belongs to the caller.", state or ["    uint8_t none;\n"]),
        )
    )  # fmt: skip


def _of(known: Sequence[Described], each: Member) -> tuple[Described, ...]:
    return tuple(known[k] for k in each.places)


def _member(each: Member, kind: str, known: tuple[Described, ...]) -> str:
    return comment([note(known[0])], "    ") + f"    {kind} {each.declarator};\n"


def _struct(face: Interface, name: str, text: str, rows: Sequence[str]) -> str:
    return f"{comment([text])}typedef struct {{\n{''.join(rows)}}} {face.prefix}_{name}_t;\n\n"


def _bits(face: Interface) -> str:
    upper = face.prefix.upper()
    rows = [f"#define {upper}_VALID_{face.bit(k)} (1UL << {k}U)\n" for k in range(len(face.sample))]
    return "".join(rows) + f"#define {upper}_VALID_ALL ({(1 << len(rows)) - 1}UL)\n\n"


def _functions(face: Interface) -> str:
    prefix = face.prefix
    p, c = declared(face, "p"), declared(face, "c", writes=True)
    given = ", ".join(declared(face, word) for word in "cxuy")
    texts = (
        ("The parameters of the vehicle.", f"extern const {prefix}_parameters_t {prefix}_parameters;"),
        ("Version of the generator, monitor and variant.", f"const char *{prefix}_version(void);"),
        ("Stands for names and values of the parameters.", f"uint32_t {prefix}_parameter_hash({p});"),
        ("Works out the constants; once, before anything else.", f"void {prefix}_prepare({p}, {c});"),
        ("Nothing has been measured yet.", f"void {prefix}_init({p}, {declared(face, 'x')});"),
        (f"One step on, every {face.subject.sample_time:g} s.", f"void {prefix}_step({given});"),
    )
    rows = [f"{comment([text])}{line}\n\n" for text, line in texts]
    if reasons(face):
        rows.append(
            f"{comment(['Why the verdict of an output is withheld.'])}"
            f"{prefix}_reason_t {prefix}_reason(const {prefix}_output_t *y);\n\n"
        )
    return "".join(rows)


def declared(face: Interface, word: str, writes: bool = False) -> str:
    """C of an argument: p parameters, c constants, x state, u sample, y output."""
    kinds = {"p": "parameters", "c": "constants", "x": "state", "u": "sample", "y": "output"}
    const = "" if word in "xy" or writes else "const "
    return f"{const}{face.prefix}_{kinds[word]}_t *{word}"
