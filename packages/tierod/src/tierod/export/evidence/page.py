"""All evidence for one export on a page, of a monitor or of the fault memory."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from tierod.core.content import Heading, Item, Table
from tierod.core.files import write_text
from tierod.core.graph.analysis import operation_count
from tierod.core.graph.operations import with_picks
from tierod.export.bank import BankInterface
from tierod.export.c_export import write_folder
from tierod.export.evidence.checks import (
    AT_ONCE,
    FURTHER,
    REASONS,
    SANITIZED,
    Checked,
    checked,
    checks,
    misra,
    of_monitor,
    ran,
    there,
    version,
)
from tierod.export.evidence.comparison import (
    COMPILERS,
    FLAGS,
    LEVELS,
    Difference,
    apart,
    beside_double,
    differences,
    table,
)
from tierod.export.evidence.coverage import Stepped, covered
from tierod.export.evidence.targets import GCC, M7, R5, targets
from tierod.export.fault_memory import NAMES
from tierod.export.interface import Interface
from tierod.export.subject import elements
from tierod.export.vectors import (
    FACTORS,
    MOST_SANITIZED,
    SANITIZED_WORK,
    SEED,
    Vectors,
    affordable,
    altered_inputs,
    disturbed_inputs,
    input_table,
    rounded,
)
from tierod.report.html import Analysis

SOURCE = NAMES[1]
VECTORS = ("test/inputs.csv", "test/expected.csv")
MEMORY = Checked(SOURCE, (SOURCE,), (VECTORS,), (VECTORS,), "", REASONS)


def memory_evidence(folder: Path) -> Analysis:
    """Compare, check and measure an export of the fault memory; results of missing tools are marked as such.

    Args:
        folder: of the export; build results go to its subfolder `build`
    """
    folder = folder.absolute()  # the compilers run inside it
    (folder / "build").mkdir(exist_ok=True)
    built = [_compared(folder, compiler, level) for compiler in COMPILERS for level in LEVELS]
    built.append(_on_r5(folder))
    items: list[Item] = [
        Heading("Beside the memory in Python, with power loss"),
        Table("Comparisons", ("build", "result", "warnings"), tuple(built)),
        Heading("Checks"),
        checked([call() for call in checks(MEMORY, folder)]),
        misra(MEMORY, folder),
        *covered(MEMORY, folder),
        Heading("Target"),
        Table("Cortex-M7", ("what", "result"), _sized(folder), f"{version(GCC)}; -O2, {' '.join(M7)}."),
    ]
    good = sum(" 0 different, 0 refused" in each[1] and each[1].endswith(" 0 broken") for each in built)
    summary = f"Of {len(built)} builds {good} agree with the memory in Python and survive every cut of the power."
    tables = {each.title: [list(row) for row in each.rows] for each in items if isinstance(each, Table)}
    document = {"schema": "tierod.evidence/1", "export": "tierod_fault_memory", "tables": tables}
    return Analysis("Evidence for tierod_fault_memory", (summary,), items, document)


def _compared(folder: Path, compiler: str, level: tuple[str, ...]) -> tuple[str, str, str]:
    build, program = f"{compiler} {' '.join(level)}", f"build/{compiler}{'_'.join(level)}"
    if not there(compiler):
        return build, version(compiler), ""
    made = ran([compiler, *FLAGS, *level, "-I.", *MEMORY.sources, "-o", program], folder)
    if made.code != 0:
        return build, f"not run: {made.first}", ""
    return build, ran([program, *VECTORS], folder).first, str(made.text.count("warning:"))


def _on_r5(folder: Path) -> tuple[str, str, str]:
    build = "Cortex-R5 -O2"
    missing = [name for name in (GCC, "qemu-arm") if not there(name)]
    if missing:
        return build, version(missing[0]), ""
    flags = ["-std=c99", "-O2", *R5, "-I.", "--specs=rdimon.specs"]
    made = ran([GCC, *flags, *MEMORY.sources, "-o", "build/r5.elf"], folder)
    if made.code != 0:
        return build, f"not run: {made.first}", ""
    return build, ran(["qemu-arm", "-cpu", "cortex-r5f", "build/r5.elf", *VECTORS], folder).first, ""


def _sized(folder: Path) -> tuple[tuple[str, str], ...]:
    if not there(GCC):
        return (("sizes", version(GCC)),)
    made = ran([GCC, *M7, "-std=c99", "-O2", "-I.", "-fstack-usage", "-c", SOURCE, "-o", "build/memory.o"], folder)
    if made.code != 0:
        return (("sizes", f"not run: {made.first}"),)
    sizes = re.search(r"^\s*(\d+)\s+(\d+)\s+(\d+)", ran(["arm-none-eabi-size", "build/memory.o"], folder).text, re.M)
    stacks = [int(each) for each in re.findall(r"\t(\d+)\t", (folder / "build/memory.su").read_text(encoding="utf-8"))]
    return (
        ("text", f"{sizes[1]} B" if sizes else "not run: no arm-none-eabi-size"),
        ("data and bss", f"{int(sizes[2]) + int(sizes[3])} B" if sizes else ""),
        ("largest stack of a single function", f"{max(stacks, default=0)} B"),
    )


CALIBRATION_FACTORS = (0.2, 5.0)  # Factors applied to the changed parameter

CALIBRATED_PROGRAM, SAMPLES = "build/calibrated.c", "build/calibrated.bin"

_RUNS = """\
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
        _RUNS.replace("PREFIX", face.prefix).replace("STEPS", str(len(inputs))).replace("COUNT", str(len(members)))
        .replace("FACTORS", ", ".join(map(repr, CALIBRATION_FACTORS))).replace("SAMPLES", SAMPLES)
        .replace("MEMBERS", ",\n                ".join(f"&p.{each}" for each in members))
    )  # fmt: skip
    write_text(
        folder / CALIBRATED_PROGRAM,
        f'#define TIEROD_NO_MAIN\n#include "../test/compare.c"\n\n#include <stdio.h>\n\n{text}',
    )
    (folder / SAMPLES).write_bytes(np.ascontiguousarray(inputs, dtype=float).tobytes())
    return CALIBRATED_PROGRAM


def evidence(face: Interface, folder: Path, vectors: Vectors, samples: Mapping[str, np.ndarray]) -> Analysis:
    """Compare, check and measure an export; results of missing tools are marked as such.

    Args:
        folder: of the export; build results go to its subfolder `build`
        samples: (n, inputs) by name, for the back-to-back comparison; the last ones random
    """
    folder = folder.absolute()  # the compilers run inside it
    last = list(samples.values())[-1]
    write_folder({"test/random.csv": input_table(face.subject, Vectors(last[:10_000], vectors.outputs, ""))}, folder)
    (folder / "build").mkdir(exist_ok=True)
    first = next(iter(samples.values()))
    driven = dict(list(samples.items())[:-1])
    parts = [*samples.values(), disturbed_inputs(first, 2 * len(first))]
    further = np.concatenate(parts)
    write_text(folder / FURTHER, input_table(face.subject, Vectors(rounded(further), vectors.outputs, "")))
    write_text(
        folder / SANITIZED, input_table(face.subject, Vectors(rounded(_short(face, parts)), vectors.outputs, ""))
    )
    export = of_monitor(face)
    with ThreadPoolExecutor(AT_ONCE) as pool:
        # The longest tasks first, so that none runs alone at the end; they are independent of each other.
        departures = pool.submit(misra, export, folder)
        missed = pool.submit(covered, _with_altered(face, folder, first), folder, *_stepped(face))
        rows = [pool.submit(each) for each in checks(export, folder)]
        cost = pool.submit(targets, face, folder, vectors)
    found = differences(face, folder, samples)
    items: list[Item] = [
        Heading("Back to back"),
        table(found, face.options.precision),
        *([beside_double(face, apart(face, folder, driven))] if face.options.precision == "single" else []),
        Heading("Checks"),
        checked([each.result() for each in rows]),
        departures.result(),
        *missed.result(),
        Heading("Targets"),
        cost.result(),
        Heading("Operations"),
        _operations(face),
    ]
    title = f"Evidence for {face.prefix}"
    return Analysis(title, (_summary(face, found),), items, _document(face, found, items))


def _short(face: Interface, parts: Sequence[np.ndarray]) -> np.ndarray:
    """Samples for the sanitizers, which slow a step down some twentyfold: the beginning of each part."""
    share = affordable(face.subject, MOST_SANITIZED, SANITIZED_WORK) / sum(map(len, parts))
    return np.concatenate([part[: math.ceil(min(share, 1.0) * len(part))] for part in parts])


def _stepped(face: Interface) -> tuple[Stepped, ...]:
    found = with_picks(face.program)
    if not isinstance(face, BankInterface):
        return (Stepped(found, face.graph.state),)
    lane = Stepped(with_picks(face.lane.program), face.lane.graph.state, ("_lane",))
    return Stepped(found, face.graph.state), lane


# Most samples of all altered drives together; fewest samples per altered drive for which a run is worthwhile
ALTERED, SHORTEST = 600_000, 500
# Operations that all altered drives may take; a step of a bank takes 1 ms where branches are counted
COVERED_WORK: Annotated[float, ""] = 16e9
FAILING = 20_000  # Samples with further failed signals, where a step is expensive
# Factor by which more samples are run with changed parameters, because verdicts take minutes of driving
CALIBRATED = 10


def _with_altered(face: Interface, folder: Path, drive: np.ndarray) -> Checked:
    export, subject = of_monitor(face), face.subject
    count = affordable(subject, ALTERED, COVERED_WORK) // (len(FACTORS) * max(len(subject.sample), 1))
    runs = list(export.runs)
    for number, values in enumerate(altered_inputs(drive, count) if count >= SHORTEST else ()):
        name = f"build/altered-{number}.csv"
        write_text(folder / name, input_table(subject, Vectors(rounded(values), drive[:0], "")))
        runs.append((name, "test/expected.csv"))
    if affordable(subject, ALTERED) < ALTERED:
        # With an expensive step the samples so far contained few failures.
        values = disturbed_inputs(drive, affordable(subject, FAILING, COVERED_WORK), SEED + 1)
        write_text(folder / "build/failing.csv", input_table(subject, Vectors(rounded(values), drive[:0], "")))
        runs.append(("build/failing.csv", "test/expected.csv"))
    each = CALIBRATED * affordable(subject, ALTERED) // (len(CALIBRATION_FACTORS) * max(len(face.graph.tuning), 1))
    varied = write_calibrated(face, folder, rounded(drive[:each])) if each >= SHORTEST else ""
    return export._replace(runs=tuple(runs), varied=varied)


def _summary(face: Interface, found: list[Difference]) -> str:
    run = [each for each in found if not each.trouble]
    if not run:
        reason = found[0].trouble if found else "no compiler is installed here"
        return f"Nothing was compared: {reason}."
    worst = max(run, key=lambda each: each.worst)
    warnings = sum(each.warnings for each in run)
    return (
        f"{face.subject.title}, {face.options.precision} precision: {len(run)} comparisons with scan, of which the "
        f"largest difference is {worst.worst:.2g} of the range of {worst.output or 'any output'} ({worst.build}, "
        f"{worst.samples}); {warnings} warnings of compilers."
    )


def _operations(face: Interface) -> Table:
    counted = asdict(operation_count(face.subject.block))
    rows = tuple((name, str(count)) for name, count in counted.items())
    rows += (("inputs", str(len(face.subject.sample))), ("outputs", str(len(face.subject.output))))
    return Table("Operations of one step, counted from the graph", ("operations", "count"), rows)


def _document(face: Interface, found: list[Difference], items: list[Item]) -> dict[str, Any]:
    tables = {each.title: [list(row) for row in each.rows] for each in items if isinstance(each, Table)}
    return {
        "schema": "tierod.evidence/1",
        "export": face.prefix,
        "version": face.subject.version,
        "precision": face.options.precision,
        "parameters": f"{face.subject.digest:08x}",
        "comparisons": [asdict(each) for each in found],
        "tables": tables,
    }
