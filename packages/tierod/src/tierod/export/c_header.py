"""Header file of an export: types with unit, meaning and range of every number, and function declarations."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tierod.core.findings import Status
from tierod.core.statuses import STATUSES
from tierod.export.interface import Interface
from tierod.export.subject import Described, Member, identifier

TEMPLATES = Path(__file__).parent / "templates"


def rendered(name: str, values: Mapping[str, object]) -> str:
    """Text of a template; a value that it names and that is missing is an error."""
    import jinja2

    # The templates produce C, where HTML escaping would do harm.
    environment: Any = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=False,
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
    )
    text: str = environment.get_template(name).render(values)
    return text


def template(name: str) -> str:
    """C that is the same for every export but for words in capitals."""
    return (TEMPLATES / name).read_text("utf-8")


WIDTH = 116


# Text around the declarations, so that a C++ program links to functions compiled as C
FROM_C, TO_CPP = (f"#ifdef __cplusplus\n{brace}\n#endif\n\n" for brace in ('extern "C" {', "}  /* extern C */"))


def header(face: Interface, own: str | None = None) -> str:
    """C code of the header.

    Args:
        own: C code of the structs of a bank; None for those of a single block
    """
    guard = f"{face.prefix.upper()}_H"
    parts = [
        banner(face, "types and functions"),
        f"#ifndef {guard}\n#define {guard}\n\n#include <stdbool.h>\n#include <stdint.h>\n\n{FROM_C}",
        f"/* The type of all numbers: {face.options.precision} precision. */\n"
        f"typedef {'float' if face.options.precision == 'single' else 'double'} {face.spelling.real};\n\n",
        _statuses(face),
        _reasons(face),
        structs(face) if own is None else own,
        _functions(face),
        f"{TO_CPP}#endif /* {guard} */\n",
    ]
    return "".join(parts)


def banner(face: Interface, what: str) -> str:
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
    """A C comment of one or more lines, escaped so that its text cannot end it."""
    safe = [plain(each) for each in lines]
    if len(safe) == 1 and len(safe[0]) + len(indent) + 6 <= WIDTH:
        return f"{indent}/* {safe[0]} */\n"
    wrapped = [part for each in safe for part in (textwrap.wrap(each, WIDTH - len(indent) - 3) or [""])]
    return f"{indent}/*\n" + "".join(f"{indent} * {each}".rstrip() + "\n" for each in wrapped) + f"{indent} */\n"


def plain(text: str) -> str:
    """A text in plain ASCII without comment delimiters and trigraphs."""
    ascii_ = text.replace("²", "**2").encode("ascii", "replace").decode("ascii")
    # A trigraph is replaced before comments are recognised: ??/ at the end of a line would continue it.
    return ascii_.replace("*/", "* /").replace("/*", "/ *").replace("//", "/ /").replace("??", "?")


def note(each: Described) -> str:
    """Unit, meaning and range of a number, as text of a comment."""
    unit = f"[{each.unit}]" if each.unit else "[-]"
    limits = f"; {each.limits}" if each.limits else ""
    meaning = f" {each.meaning}" if each.meaning else ""
    return f"{unit}{meaning}{limits}"


def status_name(face: Interface, status: Status) -> str:
    return f"{face.prefix}_{identifier(str(status))}".upper()


def _statuses(face: Interface) -> str:
    if not face.statuses:
        return ""
    rows = ",\n".join(f"    {status_name(face, each)} = {code}" for code, each in enumerate(STATUSES))
    return _enumeration(face, "status", "State of what is monitored, or why it could not be judged.", rows)


def _enumeration(face: Interface, name: str, text: str, rows: str) -> str:
    return f"{comment([text])}typedef enum {{\n{rows}\n}} {face.prefix}_{name}_t;\n\n"


def reasons(face: Interface) -> tuple[tuple[int, Described], ...]:
    """Outputs that are reasons to withhold a verdict, with their positions, in order of precedence."""
    return tuple((k, each) for k, each in enumerate(face.subject.output) if each.holder == "Obstacles")


def reason_name(face: Interface, each: Described | None) -> str:
    word = "none" if each is None else each.path.rpartition(".")[2]
    return f"{face.prefix}_reason_{identifier(word)}".upper()


def _reasons(face: Interface) -> str:
    found = reasons(face)
    if not found:
        return ""
    rows = [f"    {reason_name(face, None)} = 0"]
    rows += [f"    {reason_name(face, each)} = {number}" for number, (_, each) in enumerate(found, 1)]
    return _enumeration(face, "reason", "Why a verdict is withheld; the first reason that holds.", ",\n".join(rows))


def structs(face: Interface) -> str:
    """C code of the structs of a single block."""
    parameters = [HASH, *rows_of(face, face.parameters, face.subject.tuning)]
    constants = [f"    {face.spelling.real} value[{max(len(face.program.carried()), 1)}];\n"]
    return outer_structs(face) + "".join(
        struct(face, name, text, rows)
        for name, text, rows in (
            ("parameters", "Of the vehicle and of the monitor.", parameters),
            ("constants", "What depends on the parameters alone; shared by all instances.", constants),
            ("state", "Memory of one instance; it belongs to the caller.", state_rows(face)),
        )
    )  # fmt: skip


def outer_structs(face: Interface) -> str:
    """C code of the structs of the sample and the output."""
    kinds = dict.fromkeys(face.statuses, f"{face.prefix}_status_t")
    sample = rows_of(face, face.sample, face.subject.sample)
    missing = "NaN where an input is missing"
    if face.options.validity:
        missing = "an input whose bit is 0 is missing"
        known = f"bits {face.prefix.upper()}_VALID_... of the inputs that are valid"
        sample.insert(0, f"    /* {known} */\n    uint32_t valid;\n")
    measured = f"What is measured at one step; {missing}. SI units; left is positive (ISO 8855)."
    return (
        (_bits(face) if face.options.validity else "")
        + struct(face, "sample", measured, sample)
        + struct(
            face, "output", "What is stated after one step.", rows_of(face, face.output, face.subject.output, kinds)
        )
    )


HASH = "    /* stands for version, names and values of all parameters */\n    uint32_t hash;\n"


def state_rows(face: Interface, known: Sequence[Described] | None = None) -> list[str]:
    """C code of the members of a state: numbers, clocks and delay lines.

    Args:
        known: descriptions of the numbers; None for those of the subject's own state
    """
    (positions, plain_members), real = face.plain, face.spelling.real
    known = face.subject.state if known is None else known
    rows = rows_of(face, plain_members, [known[k] for k in positions])
    rows += [
        comment([f"clock: steps of {note(known[k])}"], "    ") + f"    uint32_t {name};\n"
        for k, name in face.counted.items()
    ]
    for line in face.lines.arrays:
        rows.append(f"    /* delay line, and its place that is written next */\n    {real} {line.declarator};\n")
        rows.append(f"    {index_type(line.size)} {line.name}_head;\n")
    return rows


def index_type(size: int) -> str:
    """Smallest C type that can index a delay line."""
    return "uint16_t" if size <= 0xFFFF else "uint32_t"


def rows_of(
    face: Interface, found: Sequence[Member], known: Sequence[Described], kinds: Mapping[int, str] | None = None
) -> list[str]:
    types, real = kinds or {}, face.spelling.real
    return [
        f"{comment([note(known[each.places[0]])], '    ')}    {types.get(each.places[0], real)} {each.declarator};\n"
        for each in found
    ]


def struct(face: Interface, name: str, text: str, rows: Sequence[str]) -> str:
    """C code of one struct; a struct without members gets one byte, because C allows no empty struct."""
    body = "".join(rows) or "    uint8_t none;\n"
    return f"{comment([text])}typedef struct {{\n{body}}} {face.prefix}_{name}_t;\n\n"


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
    """C code of an argument: p parameters, c constants, x state, u sample, y output."""
    kinds = {"p": "parameters", "c": "constants", "x": "state", "u": "sample", "y": "output"}
    const = "" if word in "xy" or writes else "const "
    return f"{const}{face.prefix}_{kinds[word]}_t *{word}"
