"""Runs of an export with one parameter changed by a large factor, to cover thresholds that no drive reaches."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tierod.core.files import write_text
from tierod.export.interface import Interface
from tierod.export.members import elements

FACTORS = (0.2, 5.0)
"""Factors applied to the changed parameter."""

PROGRAM, SAMPLES = "build/calibrated.c", "build/calibrated.bin"

_MAIN = """\
int main(void)
{
    static double rows[STEPS][INPUTS], out[OUTPUTS + 1];
    static const double factors[] = {FACTORS};
    FILE *file = fopen("SAMPLES", "rb");
    size_t n = (file == NULL) ? 0u : fread(rows, sizeof rows[0], STEPS, file);

    for (size_t i = 0; i < COUNT; i++) {
        for (size_t f = 0; f < sizeof factors / sizeof factors[0]; f++) {
            PREFIX_parameters_t p = PREFIX_parameters;
            PREFIX_real_t *const members[] = {
                MEMBERS
            };
            *members[i] = (PREFIX_real_t)(*members[i] * factors[f]);
            PREFIX_prepare(&p, &constants);
            PREFIX_init(&p, &state);
            for (size_t k = 0; k < n; k++) { one(rows[k], out); }
        }
    }
    return (n == 0u) ? 1 : 0;
}
"""


def write_calibrated(face: Interface, folder: Path, inputs: np.ndarray) -> str:
    """Write a program that runs over samples with each parameter changed in turn, and return its path.

    Args:
        inputs: (n, inputs), samples of every run
    """
    members = elements(face.parameters)
    text = (
        _MAIN.replace("PREFIX", face.prefix).replace("STEPS", str(len(inputs))).replace("COUNT", str(len(members)))
        .replace("FACTORS", ", ".join(map(repr, FACTORS))).replace("SAMPLES", SAMPLES)
        .replace("MEMBERS", ",\n                ".join(f"&p.{each}" for each in members))
    )  # fmt: skip
    write_text(
        folder / PROGRAM, f'#define TIEROD_NO_MAIN\n#include "../test/compare.c"\n\n#include <stdio.h>\n\n{text}'
    )
    (folder / SAMPLES).write_bytes(np.ascontiguousarray(inputs, dtype=float).tobytes())
    return PROGRAM
