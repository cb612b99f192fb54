"""A C export as a folder: header, source, parameters, test vectors, comparison program, Makefile and README."""

from __future__ import annotations

import errno
from collections.abc import Mapping, Sequence
from pathlib import Path

from tierod.core.errors import OutputError, ParameterError
from tierod.core.files import expanded, require_folder, write_text
from tierod.core.graph.bank import BankGraph
from tierod.export.bank import BankInterface, bank_parameter_rows, bank_source, bank_structs
from tierod.export.c_header import banner, header, reason_name, reasons, rendered, template
from tierod.export.c_source import parameters, source
from tierod.export.interface import Interface, Options, free_clocks
from tierod.export.subject import Subject, elements
from tierod.export.vectors import ROWS_BEYOND, SPACING, TOLERANCE, Vectors, input_table, output_table, tolerances

BITS = 32  # Bits of the mask of valid inputs


def files(face: Interface, vectors: Vectors) -> Mapping[str, str]:
    """All files of an export: path in its folder -> text; equal exports give equal bytes."""
    subject = face.subject
    beyond = ROWS_BEYOND[face.options.precision]
    return {
        **monitor_files(face),
        **{name: rendered(f"{name}.j2", _about(face, vectors)) for name in ("Makefile", "README.md")},
        "test/compare.c": comparing_program(face, tolerances(face, vectors), beyond),
        "test/inputs.csv": input_table(subject, vectors),
        "test/expected.csv": output_table(subject, vectors),
    }


def _about(face: Interface, vectors: Vectors) -> dict[str, object]:
    subject, precision = face.subject, face.options.precision
    beyond = ROWS_BEYOND[precision]
    rows = f", but for {beyond:.1%} of the rows: a decision may fall some steps earlier or later" if beyond else ""
    return {
        "prefix": face.prefix, "title": subject.title, "version": subject.version, "vehicle": subject.vehicle,
        "precision": precision, "digest": f"{subject.digest:08x}", "sample_time": f"{subject.sample_time:g}",
        "validity": face.options.validity, "clocks": list(face.counted.values()), "source": vectors.source,
        "steps": len(vectors.inputs), "spacing": SPACING, "tolerance": f"{TOLERANCE[precision]:g}", "beyond": rows,
    }  # fmt: skip


def monitor_files(face: Interface) -> dict[str, str]:
    prefix = face.prefix
    if isinstance(face, BankInterface):
        texts = (header(face, bank_structs(face)), bank_source(face), parameters(face, bank_parameter_rows(face)))
    else:
        texts = (header(face), source(face), parameters(face))
    return dict(zip((f"{prefix}.h", f"{prefix}.c", f"{prefix}_parameters.c"), texts, strict=True))


def interface_of(subject: Subject, options: Options) -> Interface:
    """Interface of an export: of a bank, or of a single block."""
    count = len(subject.graph.sample)
    if options.validity and count > BITS:
        raise ParameterError(
            f"{subject.title} takes {count} inputs, and a mask of valid ones has {BITS} bits; leave --validity out, so "
            "that NaN stands for a missing input"
        )
    kind = BankInterface if isinstance(subject.graph, BankGraph) else Interface
    return kind(subject, options)


def refuse_foreign(folder: str | Path, own: str) -> None:
    """Refuse a folder whose files do not come from an earlier export of this monitor."""
    place = expanded(folder)
    taken = next((name for name in ("README.md", "Makefile") if (place / name).exists()), None)
    if taken is not None and not (place / own).exists():
        raise OutputError(f"{place} holds a {taken} that is not of this export; name a folder of its own with --output")


def write_folder(texts: Mapping[str, str], folder: str | Path) -> Path:
    """Write files into a folder, created if missing; each file is written atomically."""
    place = expanded(folder)
    require_folder(place)
    for path in {place, *((place / name).parent for name in texts)}:
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            what = (
                "there is a file of that name"
                if error.errno == errno.EEXIST
                else (error.strerror or str(error)).lower()
            )
            raise OutputError(f"{path} cannot be made: {what}; name another folder with --output") from None
    for name, text in texts.items():
        write_text(place / name, text)
    return place


def comparing_program(face: Interface, tolerances: Sequence[float], beyond: float) -> str:
    prefix, subject = face.prefix, face.subject
    names = ",\n".join(f'    "{each.path}"' for each in subject.output)
    limits = ", ".join(repr(each) for each in tolerances)
    return (
        f"{banner(face, 'comparison with test vectors')}"
        f'#include "{prefix}.h"\n\n#include <math.h>\n#include <stdio.h>\n#include <stdlib.h>\n\n'
        f"#define INPUTS {len(subject.sample)}\n#define OUTPUTS {len(subject.output)}\n"
        f"#define TOLERANCES {{{limits}, 0.0}}\n#define ROWS_BEYOND {beyond!r}\n\n"
        f"static {prefix}_constants_t constants;\nstatic {prefix}_state_t state;\n\n"
        f'#ifndef TIEROD_NO_MAIN\nstatic const char *const names[OUTPUTS + 1] = {{\n{names},\n    ""\n}};\n\n'
        f"static const char *version(void)\n{{\n    return {prefix}_version();\n}}\n\n{_answers(face)}#endif\n\n"
        f"{_rows(face)}{_run(face)}{template('compare_main.c')}"
    )


def _answers(face: Interface) -> str:
    """C function that counts wrong results of the functions that no step calls: parameter hash and first reason."""
    prefix, found = face.prefix, reasons(face)
    named = elements(face.output)
    lines = [f"    wrong += ({prefix}_parameter_hash(&{prefix}_parameters) == {prefix}_parameters.hash) ? 0 : 1;\n"]
    if found:
        lines.append(f"    wrong += ({prefix}_reason(&y) == {reason_name(face, None)}) ? 0 : 1;\n")
    for place, each in reversed(found):
        lines.append(f"    y.{named[place]} = 1;\n")
        lines.append(f"    wrong += ({prefix}_reason(&y) == {reason_name(face, each)}) ? 0 : 1;\n")
    declared = f"    static {prefix}_output_t y;\n" if found else ""
    return (
        f"static int wrong_answers(void)\n{{\n{declared}    int wrong = 0;\n\n{''.join(lines)}    return wrong;\n}}\n\n"
    )


def _rows(face: Interface) -> str:
    prefix, real = face.prefix, face.spelling.real
    inputs = elements(face.sample)
    lines = [f"    sample.{text} = ({real})row[{k}];\n" for k, text in enumerate(inputs)]
    if face.options.validity:
        lines.append("    sample.valid = 0U;\n")
        lines += [
            f"    if (row[{k}] == row[{k}]) {{\n        sample.valid |= {prefix.upper()}_VALID_{face.bit(k)};\n"
            f"    }} else {{\n        sample.{text} = 0;\n    }}\n"
            for k, text in enumerate(inputs)
        ]
    outputs = [f"    out[{k}] = (double)output.{text};\n" for k, text in enumerate(elements(face.output))]
    return (
        f"static void begin(void)\n{{\n    {prefix}_prepare(&{prefix}_parameters, &constants);\n"
        f"    {prefix}_init(&{prefix}_parameters, &state);\n}}\n\n"
        f"static {prefix}_sample_t taken(const double *row)\n{{\n    {prefix}_sample_t sample;\n\n"
        f"{''.join(lines)}    return sample;\n}}\n\n"
        f"static void one(const double *row, double *out)\n{{\n"
        f"    const {prefix}_sample_t sample = taken(row);\n    {prefix}_output_t output;\n\n"
        f"    {prefix}_step(&constants, &state, &sample, &output);\n{''.join(outputs)}}}\n\n"
    )


def _run(face: Interface) -> str:
    free = [face.counted[k] for k in free_clocks(face.program, face.clocks)]
    clocks = "".join(f"        state.{name} = (uint32_t)steps;\n" for name in free)
    return (
        "#ifdef TIEROD_NO_MAIN\nvoid tierod_run(long n, const double *u, double *y, long anew, long steps);\n"
        "/* Runs over n rows; begins anew where that is asked for, with clocks that have counted so many steps. */\n"
        "void tierod_run(long n, const double *u, double *y, long anew, long steps)\n{\n    long k;\n\n"
        f"    if (anew != 0) {{\n        begin();\n{clocks}    }}\n    (void)steps;\n"
        "    for (k = 0; k < n; k++) {\n        one(&u[k * INPUTS], &y[k * OUTPUTS]);\n    }\n}\n#endif\n\n"
    )
