"""Program that runs an export over test vectors and compares the outputs, with its row input and output."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.export.c_header import banner, reason_name, reasons, template
from tierod.export.interface import Interface
from tierod.export.storage import free_clocks
from tierod.export.subject import elements


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
