"""Makefile and README of an export."""

from __future__ import annotations

from tierod.export.interface import Interface
from tierod.export.vectors import ROWS_BEYOND, SPACING, TOLERANCE, Vectors

FLAGS = "-std=c99 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -ffp-contract=off"


def makefile(face: Interface) -> str:
    """Makefile that builds and runs the comparison."""
    prefix = face.prefix
    return (
        f"# Builds {prefix} with the comparison, and runs it over the test vectors.\n"
        "# For a target: make CC=arm-none-eabi-gcc CFLAGS='...' RUN='qemu-arm -cpu cortex-r5f'\n"
        f"CC ?= cc\nCFLAGS ?= {FLAGS}\nLDLIBS = -lm\nRUN ?=\n\n"
        "test: build/compare\n\t$(RUN) build/compare test/inputs.csv test/expected.csv\n\n"
        f"build/compare: {prefix}.c {prefix}_parameters.c test/compare.c {prefix}.h\n"
        "\tmkdir -p build\n"
        f"\t$(CC) $(CFLAGS) -I. {prefix}.c {prefix}_parameters.c test/compare.c -o $@ $(LDLIBS)\n\n"
        "clean:\n\trm -rf build\n\n.PHONY: test clean\n"
    )


def readme(face: Interface, vectors: Vectors) -> str:
    subject, prefix = face.subject, face.prefix
    precision = face.options.precision
    missing = (
        f"Set the bit `{prefix.upper()}_VALID_...` of every input that was received; the others count as missing, "
        "whatever their value. Inside, a missing value is NaN: the target needs IEEE 754 arithmetic all the same."
        if face.options.validity
        else "An input that was not received is NaN. Compile without `-ffast-math` and `-ffinite-math-only`, which "
        "break it."
    )
    clocks = (
        f"{len(face.clocks)} clocks count steps in whole numbers ({', '.join(face.counted.values())})."
        if face.clocks
        else "Clocks are numbers in seconds."
    )
    beyond = ROWS_BEYOND[precision]
    return f"""# {prefix}

{subject.title}. {subject.version}; vehicle {subject.vehicle}; {precision} precision; parameters {subject.digest:08x}.
Generated; change the vehicle file and export again.

| file | what |
|---|---|
| `{prefix}.h` | types with unit, meaning and range of every number, and the functions |
| `{prefix}.c` | the monitor: C99, no allocation, no recursion, no static data, no loop without a bound |
| `{prefix}_parameters.c` | the parameters of this vehicle |
| `test/` | a drive, what the monitor states about it, and a program that compares |
| `Makefile` | `make` builds and compares |

```c
static {prefix}_constants_t constants;
static {prefix}_state_t state;

{prefix}_prepare(&{prefix}_parameters, &constants);
{prefix}_init(&{prefix}_parameters, &state);
/* every {subject.sample_time:g} s: */
{prefix}_step(&constants, &state, &sample, &output);
```

The state belongs to the caller: several instances run side by side, and share the constants. {missing} {clocks}

The vectors are {vectors.source}: {len(vectors.inputs)} steps, compared at every {SPACING}th. An output passes within
{TOLERANCE[precision]:g} of its range of what the same monitor states in double precision{_rows(beyond)}.
"""


def _rows(beyond: float) -> str:
    return (
        "" if beyond == 0.0 else f", but for {beyond:.1%} of the rows: a decision may fall some steps earlier or later"
    )
