"""An export on emulated target processors: agreement with the vectors, instructions, stack and sizes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tierod.core.content import Table
from tierod.core.files import write_text
from tierod.export.c_header import template
from tierod.export.evidence.checks import Outcome, ran, there, version
from tierod.export.interface import Interface
from tierod.export.vectors import Vectors

STEPS = 1000  # Number of measured steps


def measuring_program(face: Interface, vectors: Vectors) -> str:
    """C code that counts instructions and stack use of a step over the last test vectors.

    Args:
        vectors: test vectors; the last inputs are used
    """
    taken = vectors.inputs[-STEPS:]
    numbers = ",\n".join(", ".join(_written(value) for value in row) for row in taken.tolist())
    prefix = face.prefix
    return (
        '#define TIEROD_NO_MAIN\n#include "../test/compare.c"\n\n#include <stdio.h>\n\n'
        f"#define STEPS {len(taken)}\n#define STEP {prefix}_step\n#define SAMPLE_T {prefix}_sample_t\n"
        f"#define OUTPUT_T {prefix}_output_t\n\nstatic const float drive[STEPS * INPUTS] = {{\n{numbers}\n}};\n\n"
        f"{template('measure.c')}"
    )


def _written(value: float) -> str:
    return "NAN" if np.isnan(value) else f"{value!r}f" if np.isfinite(value) else "INFINITY"


GCC = "arm-none-eabi-gcc"
FLAGS = ("-std=c99", "-O2", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off", "-I.")
COMMON = (*FLAGS, "--specs=rdimon.specs")
M7 = ("-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-mthumb")
R5 = ("-mcpu=cortex-r5", "-mfpu=vfpv3-d16", "-mfloat-abi=hard")
# Emulated board with a Cortex-M7 and two memories of 4 MB
BOARD = ("qemu-system-arm", "-M", "mps2-an500", "-cpu", "cortex-m7", "-nographic")


class Measured(NamedTuple):
    """Measurements of the program on the Cortex-M7."""

    mean: float  # mean, most: mean and largest number of instructions per step
    most: int
    stack: int  # use below the call of the step, measured by painting [B]
    state: int  # state, constants: sizes [B]
    constants: int


def targets(face: Interface, folder: Path, vectors: Vectors) -> Table:
    """Agreement and cost on Cortex-M7 and Cortex-R5."""
    header = ("target", "what", "result")
    if not there(GCC):
        return Table("Targets", header, (("Cortex-M7, Cortex-R5", "all", version(GCC)),))
    for name, text in (
        ("start.c", template("start.c")),
        ("m7.ld", template("m7.ld")),
        ("measure.c", measuring_program(face, vectors)),
    ):
        write_text(folder / "build" / name, text)
    rows = [
        ("Cortex-M7", "vectors", _compared_on_m7(face, folder)),
        ("Cortex-R5", "vectors", _compared_on_r5(face, folder)),
        *_measured(face, folder),
        *_sized(face, folder),
    ]
    tools = ", ".join(map(version, (GCC, "qemu-system-arm", "qemu-arm")))
    return Table("Targets", header, tuple(rows), f"{tools}; {' '.join(FLAGS[1:-1])}, {' '.join(M7)}; {' '.join(R5)}.")


def _sources(face: Interface) -> list[str]:
    return [f"{face.prefix}.c", f"{face.prefix}_parameters.c"]


def _on_m7(face: Interface, folder: Path, program: str, words: tuple[str, ...]) -> Outcome:
    script = ["-T", "build/m7.ld"]
    built = ran(
        [GCC, *M7, *COMMON, "build/start.c", *_sources(face), program, *script, "-o", "build/m7.elf", "-lm"], folder
    )
    if built.code != 0:
        return built
    given = ",".join(["enable=on,target=native,arg=m7", *(f"arg={word}" for word in words)])
    # One instruction per nanosecond of virtual time, so that the tick counter counts instructions.
    return ran([*BOARD, "-icount", "shift=0", "-semihosting-config", given, "-kernel", "build/m7.elf"], folder)


def _compared_on_m7(face: Interface, folder: Path) -> str:
    if not there(BOARD[0]):
        return version(BOARD[0])
    return _last(_on_m7(face, folder, "test/compare.c", ("test/inputs.csv", "test/expected.csv")))


def _compared_on_r5(face: Interface, folder: Path) -> str:
    if not there("qemu-arm"):
        return version("qemu-arm")
    built = ran([GCC, *R5, *COMMON, *_sources(face), "test/compare.c", "-o", "build/r5.elf", "-lm"], folder)
    if built.code != 0:
        return f"not run: {built.first}"
    return _last(
        ran(["qemu-arm", "-cpu", "cortex-r5f", "build/r5.elf", "test/inputs.csv", "test/expected.csv"], folder)
    )


def _last(done: Outcome) -> str:
    lines = done.text.strip().splitlines()
    return f"not run: {done.first}" if done.code not in (0, 1) or not lines else lines[-1]


def _measured(face: Interface, folder: Path) -> list[tuple[str, str, str]]:
    if not there(BOARD[0]):
        return [("Cortex-M7", "instructions and stack", version(BOARD[0]))]
    done = _on_m7(face, folder, "build/measure.c", ())
    found = re.search(r"mean ([\d.]+) most (\d+) stack (\d+) state (\d+) constants (\d+)", done.text)
    if not found:
        return [("Cortex-M7", "instructions and stack", f"not run: {done.first}")]
    measured = Measured(float(found[1]), *map(int, found.groups()[1:]))
    return [
        ("Cortex-M7", "instructions of a step, mean over the vectors", f"{measured.mean:.0f}"),
        ("Cortex-M7", "instructions of a step, most (counted in steps of 40)", f"{measured.most}"),
        ("Cortex-M7", "stack of a step, painted", f"{measured.stack} B"),
        ("Cortex-M7", "state of an instance", f"{measured.state} B"),
        ("Cortex-M7", "constants, shared by instances", f"{measured.constants} B"),
    ]


def _sized(face: Interface, folder: Path) -> list[tuple[str, str, str]]:
    flags = [*FLAGS, "-fstack-usage", "-c"]
    objects = [f"build/{name}.o" for name in ("monitor", "parameters")]
    for name, made in zip(_sources(face), objects, strict=True):
        built = ran([GCC, *M7, *flags, name, "-o", made], folder)
        if built.code != 0:
            return [("Cortex-M7", "sizes", f"not run: {built.first}")]
    sizes = re.findall(r"^\s*(\d+)\s+(\d+)\s+(\d+)", ran(["arm-none-eabi-size", *objects], folder).text, re.MULTILINE)
    usage = (folder / "build/monitor.su").read_text(encoding="utf-8")
    found = re.findall(rf":{face.prefix}_(\w+)\t(\d+)\t", usage)
    step = next((int(size) for name, size in found if name == "step"), 0)
    below = max((int(size) for name, size in found if name.startswith("step_")), default=0)
    return [
        ("Cortex-M7", "text of the monitor; of the parameters", f"{sizes[0][0]} B; {sizes[1][0]} B"),
        ("Cortex-M7", "data and bss", f"{int(sizes[0][1]) + int(sizes[0][2])} B"),
        ("Cortex-M7", "stack by -fstack-usage: step; its deepest part", f"{step} B; {below} B"),
    ]
