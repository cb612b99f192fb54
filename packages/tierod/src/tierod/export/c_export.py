"""A C export as a folder: header, source, parameters, test vectors, comparison program, Makefile and README."""

from __future__ import annotations

import errno
from collections.abc import Mapping
from pathlib import Path

from tierod.core.errors import OutputError, ParameterError
from tierod.core.files import expanded, require_folder, write_text
from tierod.core.graph.bank import BankGraph
from tierod.export.bank import BankInterface, bank_parameter_rows, bank_source, bank_structs
from tierod.export.c_header import header
from tierod.export.c_source import parameters, source
from tierod.export.c_test import comparing_program
from tierod.export.interface import Interface, Options
from tierod.export.subject import Subject
from tierod.export.vectors import ROWS_BEYOND, SPACING, TOLERANCE, Vectors, input_table, output_table, tolerances

FLAGS = "-std=c99 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -ffp-contract=off"


def makefile(face: Interface) -> str:
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


BITS = 32  # Bits of the mask of valid inputs


def files(face: Interface, vectors: Vectors) -> Mapping[str, str]:
    """All files of an export: path in its folder -> text; equal exports give equal bytes."""
    subject = face.subject
    beyond = ROWS_BEYOND[face.options.precision]
    return {
        **monitor_files(face),
        "Makefile": makefile(face),
        "README.md": readme(face, vectors),
        "test/compare.c": comparing_program(face, tolerances(face, vectors), beyond),
        "test/inputs.csv": input_table(subject, vectors),
        "test/expected.csv": output_table(subject, vectors),
    }


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
