"""Evidence page of the fault memory in C: comparison with the one in Python, and power loss at every write."""

from __future__ import annotations

import re
from pathlib import Path

from tierod.core.content import Heading, Item, Table
from tierod.export.evidence.checks import REASONS, Checked, checked, checks, misra, ran, there, version
from tierod.export.evidence.comparison import COMPILERS, FLAGS, LEVELS
from tierod.export.evidence.coverage import covered
from tierod.export.evidence.targets import GCC, M7, R5
from tierod.export.fault_memory.files import NAMES
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
