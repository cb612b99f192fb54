"""Program that runs an export over test vectors and compares the outputs, with its row input and output."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.export.c_header import banner, reason_name, reasons
from tierod.export.interface import Interface
from tierod.export.storage import free_clocks
from tierod.export.subject import elements

_MAIN = """\
#ifndef TIEROD_NO_MAIN
static int read_row(FILE *file, double *row, int count)
{
    int k;

    for (k = 0; k < count; k++) {
        char text[64] = "nan";
        if (fscanf(file, " %63[^,\\n]%*[,]", text) != 1 && k == 0) {
            return 0;
        }
        row[k] = strtod(text, NULL);
    }
    return 1;
}

static FILE *opened(const char *name)
{
    FILE *file = fopen(name, "r");
    int letter;

    if (file == NULL) {
        (void)printf("%s cannot be read\\n", name);
        exit(3);
    }
    do {
        letter = fgetc(file);
    } while ((letter != '\\n') && (letter != EOF));
    return file;
}

/* Fails where an output is beyond its tolerance in more rows than it may be. */
int main(int count, char **words)
{
    static double u[INPUTS + 1], y[OUTPUTS + 1], wanted[OUTPUTS + 2], worst[OUTPUTS + 1];
    static long beyond[OUTPUTS + 1];
    static const double tolerance[OUTPUTS + 1] = TOLERANCES;
    FILE *inputs = opened((count > 1) ? words[1] : "inputs.csv");
    FILE *expected = opened((count > 2) ? words[2] : "expected.csv");
    int failed = 0, rows = 0, more;
    long step = 0, k;

    begin();
    failed += wrong_answers();
    more = read_row(expected, wanted, OUTPUTS + 1);
    while (read_row(inputs, u, INPUTS)) {
        one(u, y);
        if (more && ((long)wanted[0] == step)) {
            for (k = 0; k < OUTPUTS; k++) {
                const double difference = fabs(y[k] - wanted[k + 1]);
                const int same = (y[k] == wanted[k + 1]) || ((y[k] != y[k]) && (wanted[k + 1] != wanted[k + 1]));
                const double found = same ? 0.0 : (difference >= 0.0) ? difference : HUGE_VAL;
                worst[k] = (found > worst[k]) ? found : worst[k];
                beyond[k] += (found > tolerance[k]) ? 1 : 0;
            }
            rows++;
            more = read_row(expected, wanted, OUTPUTS + 1);
        }
        step++;
    }
    for (k = 0; k < OUTPUTS; k++) {
        if ((double)beyond[k] > (ROWS_BEYOND * (double)rows)) {
            (void)printf("%s differs by up to %g, beyond %g in %ld rows\\n", names[k], worst[k], tolerance[k], beyond[k]);
            failed++;
        }
    }
    (void)printf("%s: %ld steps, %d compared, %d of %d outputs beyond tolerance\\n", version(), step, rows, failed, OUTPUTS);
    return ((failed > 0) || (rows == 0)) ? 1 : 0;
}
#endif
"""  # noqa: E501


def comparing_program(face: Interface, tolerances: Sequence[float], beyond: float) -> str:
    """C code of the comparison program.

    Args:
        beyond: share of rows that may exceed the tolerances
    """
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
        f"{_rows(face)}{_run(face)}{_MAIN}"
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
