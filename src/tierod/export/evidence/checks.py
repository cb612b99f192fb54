"""Checks of the C of an export: sanitizers, coverage, MISRA, instructions on this machine."""

from __future__ import annotations

import re
import sys
from collections import Counter
from pathlib import Path

from tierod.core.content import Table
from tierod.export.evidence.tools import ran, there, version
from tierod.export.interface import Interface

SANITIZERS = "address,undefined,float-cast-overflow"

REASONS = {
    "8.9": "advisory; the parameters have a file of their own, so that they can be replaced",
    "10.5": "advisory; a status that was computed as a number becomes its enumeration",
    "10.8": "a status that was computed as a number becomes its enumeration",
    "14.4": "the checker does not know the type bool of stdbool.h",
    "20.9": "macros of math.h that a C library may lack",
}
"""Why a rule of MISRA C:2012 is departed from, by its number."""

ADDONS = ("/usr/lib/x86_64-linux-gnu/cppcheck/addons", "/usr/share/cppcheck/addons", "/usr/lib/cppcheck/addons")
"""Folders in which Debian's and other packages keep the addon."""


def checks(face: Interface, folder: Path) -> list[Table]:
    """Tables of all checks.

    Args:
        face: of the export
        folder: that holds it, with `test/random.csv` beside the vectors
    """
    rows = [sanitized(face, folder, compiler) for compiler in ("gcc", "clang")]
    rows += [*covered(face, folder), instructions(face, folder)]
    return [Table("Checks on this machine", ("check", "tool", "result"), tuple(rows)), misra(face, folder)]


def _sources(face: Interface) -> list[str]:
    return [f"{face.prefix}.c", f"{face.prefix}_parameters.c", "test/compare.c"]


def sanitized(face: Interface, folder: Path, compiler: str) -> tuple[str, str, str]:
    """Reports of the address and undefined-behaviour sanitizers over vectors and random samples."""
    name = "address and undefined-behaviour sanitizers"
    program = f"build/sanitized-{compiler}"
    flags = ["-std=c99", "-O0", "-g", f"-fsanitize={SANITIZERS}", "-I."]
    built = ran([compiler, *flags, *_sources(face), "-o", program, "-lm"], folder)
    if built.code != 0:
        return name, version(compiler), f"not run: {built.first}"
    reports = 0
    for inputs in ("test/inputs.csv", "test/random.csv"):
        done = ran([program, inputs, "test/expected.csv"], folder)
        if done.code not in (0, 1):
            return name, version(compiler), f"ended with {done.code}: {done.first}"
        reports += done.text.count("runtime error") + done.text.count("Sanitizer:")
    return name, version(compiler), f"{reports} reports"


def covered(face: Interface, folder: Path) -> list[tuple[str, str, str]]:
    """Statements and branches that vectors and random samples reach."""
    built = ran(["gcc", "-std=c99", "-O0", "--coverage", "-I.", *_sources(face), "-o", "build/covered", "-lm"], folder)
    if built.code != 0:
        return [("coverage", version("gcov"), f"not run: {built.first}")]
    for inputs in ("test/inputs.csv", "test/random.csv"):
        ran(["build/covered", inputs, "test/expected.csv"], folder)
    stem = f"build/covered-{face.prefix}"
    text = ran(["gcov", "-b", "-c", "-o", f"{stem}.gcda", f"{face.prefix}.c"], folder).text
    part = text.partition(f"File '{face.prefix}.c'")[2]
    rows = []
    for name, pattern in (
        ("statements executed", r"Lines executed:([\d.]+)% of (\d+)"),
        ("branches taken", r"Taken at least once:([\d.]+)% of (\d+)"),
    ):
        found = re.search(pattern, part)
        rows.append((name, version("gcov"), f"{found[1]} % of {found[2]}" if found else "not found in the report"))
    rows.append(("conditions (MC/DC)", version("gcc"), _conditions(face, folder)))
    return rows


def _conditions(face: Interface, folder: Path) -> str:
    """Coverage of conditions, which gcc has from its version 14 on."""
    source = f"{face.prefix}.c"
    tried = ran(["gcc", "-fcondition-coverage", "-c", source, "-I.", "-o", "build/conditions.o"], folder)
    return (
        "available, see gcov --conditions" if tried.code == 0 else "this gcc has none (14 has); branches stand for it"
    )


def instructions(face: Interface, folder: Path) -> tuple[str, str, str]:
    """Instructions of one step on this machine, counted by callgrind."""
    name = "instructions of one step, x86-64, -O2"
    built = ran(["gcc", "-std=c99", "-O2", "-g", "-I.", *_sources(face), "-o", "build/counted", "-lm"], folder)
    if built.code != 0:
        return name, version("gcc"), f"not run: {built.first}"
    step = f"{face.prefix}_step"
    words = ["valgrind", "--tool=callgrind", f"--toggle-collect={step}", "--callgrind-out-file=/dev/null"]
    text = ran([*words, "build/counted", "test/inputs.csv", "test/expected.csv"], folder).text
    collected, steps = re.search(r"Collected : (\d+)", text), re.search(r"(\d+) steps", text)
    if not collected or not steps:
        return name, version("valgrind"), "not run"
    return name, version("valgrind"), f"{int(collected[1]) / int(steps[1]):.0f}"


def misra(face: Interface, folder: Path) -> Table:
    """Departures from MISRA C:2012 of monitor and parameters, counted by rule, with the reason of each."""
    header = ("rule", "count", "reason")
    title = f"Departures from MISRA C:2012 ({version('cppcheck')} with its addon)"
    addon = next((path for each in ADDONS if (path := Path(each) / "misra.py").is_file()), None)
    if addon is None or not there("cppcheck"):
        return Table(title, header, (("not run", "", "cppcheck and its addon misra.py are not installed"),))
    counted: Counter[str] = Counter()
    for name in (f"{face.prefix}.c", f"{face.prefix}_parameters.c"):
        dumped = ran(["cppcheck", "--dump", "--std=c99", "--quiet", "-I.", name], folder)
        judged = ran([sys.executable, str(addon), f"{name}.dump"], folder)
        (folder / f"{name}.dump").unlink(missing_ok=True)
        if dumped.code != 0 or "Checking" not in judged.text:
            return Table(title, header, (("not run", "", (dumped if dumped.code else judged).first),))
        for rule, count in re.findall(r"^\s*misra-c2012-(\d+\.\d+) .*: (\d+)$", judged.text, flags=re.MULTILINE):
            counted[rule] += int(count)
    rows = [
        (f"rule {rule}", str(count), REASONS.get(rule, "no reason is recorded"))
        for rule, count in sorted(counted.items(), key=lambda each: [int(part) for part in each[0].split(".")])
    ]
    note = "Of the rules that this addon checks; rules of the whole program and directives need a tool of their own."
    return Table(title, header, tuple(rows) or (("none", "0", "no departure was found"),), note)
