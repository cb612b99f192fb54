"""Checks of exported C code: sanitizers, MISRA rules and instruction count on this machine, with the tools they run."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Annotated, NamedTuple, TypeVar

from tierod.core.content import Table
from tierod.export.interface import Interface

LONGEST: Annotated[float, "s"] = 600.0  # Time limit for one run of a tool
AT_ONCE = 2  # Number of tools that run concurrently


T = TypeVar("T")


class Outcome(NamedTuple):
    """Result of running a tool."""

    code: int | None  # exit status; None where the tool could not be started or was stopped by the time limit
    text: str

    @property
    def first(self) -> str:
        """First line of the output, shortened."""
        return next(iter(self.text.strip().splitlines()), "nothing was written")[:160]


@cache
def there(name: str) -> bool:
    """Whether a tool is installed."""
    return shutil.which(name) is not None


@cache
def version(name: str) -> str:
    if not there(name):
        return f"{name} is not installed"
    found = re.search(r"\d+\.\d+(\.\d+)?", ran([name, "--version"], Path(), 20.0).text)
    return f"{name} {found[0]}" if found else name


def ran(command: Sequence[str], folder: Path, limit: float = LONGEST) -> Outcome:
    """Run a tool to its end.

    Args:
        limit: time limit [s]
    """
    try:
        done = subprocess.run(
            list(command), cwd=folder, capture_output=True, text=True, errors="replace", check=False, timeout=limit
        )
    except subprocess.TimeoutExpired:
        return Outcome(None, f"did not end within {limit:g} s")
    except OSError as error:
        return Outcome(None, f"could not be run ({error.strerror})")
    return Outcome(done.returncode, done.stdout + done.stderr)


def at_once(calls: Sequence[Callable[[], T]]) -> list[T]:
    """Results of several calls, a few of which run concurrently, in the given order.

    Args:
        calls: independent of each other; they mostly wait for tools
    """
    with ThreadPoolExecutor(AT_ONCE) as pool:
        return [each.result() for each in [pool.submit(call) for call in calls]]


FURTHER = "build/further.csv"  # Samples of drive, random and failed signals for the coverage measurement
SANITIZED = "build/sanitized.csv"  # Shorter version of these samples for the sanitizers, cut where a step is expensive

SANITIZERS = "address,undefined,float-cast-overflow"

# Justification of each departure from MISRA C:2012, by rule number
REASONS = {
    "8.9": "advisory; the parameters have a file of their own, so that they can be replaced",
    "10.5": "advisory; a status that was computed as a number becomes its enumeration",
    "10.8": "a status that was computed as a number becomes its enumeration",
    "14.4": "the checker does not know the type bool of stdbool.h",
    "15.5": "advisory; a function of the fault memory returns as soon as its answer is known",
    "20.9": "macros of math.h that a C library may lack",
    "21.15": "the bytes of a number become a whole number by memcpy, in place of a union",
}

# Justifications for the kernels' own mathematical functions, which replace those of the C library
OF_OWN_FUNCTIONS = {
    "2.2": "x - x, which is NaN of an infinite angle and zero else",
    "10.3": "a whole number is taken as a truth, or for one of another width",
    "10.4": "an unsigned number beside a constant without U",
    "10.6": "a difference of whole numbers that becomes a wider one",
    "10.8": "the sign of a difference of unsigned numbers",
    "12.1": "advisory; polynomials without the brackets that C does not need",
    "12.3": "advisory; several constants declared in one line",
    "15.6": "a branch of one statement",
    "17.7": "what memcpy returns is its own argument",
}

# Folders in which distributions install the MISRA addon of cppcheck
ADDONS = ("/usr/lib/x86_64-linux-gnu/cppcheck/addons", "/usr/share/cppcheck/addons", "/usr/lib/cppcheck/addons")


class Checked(NamedTuple):
    """An export as input of the tools."""

    code: str
    parts: tuple[str, ...]
    # arguments of the comparison program, one pair of input and expected file per run
    runs: tuple[tuple[str, str], ...]
    sanitized: tuple[tuple[str, str], ...]  # arguments of the runs with sanitizers, likewise
    counted: str  # name of the function whose instructions are counted; "" for none
    reasons: Mapping[str, str]  # justification of each departure from MISRA C:2012, by rule number
    varied: str = ""  # program that runs the export with changed parameters, for the coverage; "" for none

    @property
    def sources(self) -> tuple[str, ...]:
        """Source files of the comparison program."""
        return (*self.parts, "test/compare.c")


def of_monitor(face: Interface) -> Checked:
    """Checked export of a monitor, run over the vectors, `test/random.csv` and the further samples."""
    runs = tuple((each, "test/expected.csv") for each in ("test/inputs.csv", "test/random.csv", FURTHER))
    own = {rule: f"in the kernels' own functions: {reason}" for rule, reason in OF_OWN_FUNCTIONS.items()}
    reasons = REASONS if face.options.libm else {**own, **REASONS}
    code = f"{face.prefix}.c"
    short = ((SANITIZED, "test/expected.csv"),)
    return Checked(code, (code, f"{face.prefix}_parameters.c"), runs, short, f"{face.prefix}_step", reasons)


def checks(export: Checked, folder: Path) -> list[Callable[[], tuple[str, str, str]]]:
    """Deferred checks on this machine, each returning a table row; they are independent of each other."""
    rows = [partial(sanitized, export, folder, compiler) for compiler in ("clang", "gcc")]
    return [*rows, *([partial(instructions, export, folder)] if export.counted else [])]


def checked(rows: Sequence[tuple[str, str, str]]) -> Table:
    return Table("Checks on this machine", ("check", "tool", "result"), tuple(rows))


def sanitized(export: Checked, folder: Path, compiler: str) -> tuple[str, str, str]:
    """Number of reports by the address and undefined-behaviour sanitizers over the sanitizer samples."""
    name = "address and undefined-behaviour sanitizers"
    program = f"build/sanitized-{compiler}"
    flags = ["-std=c99", "-O0", "-g", f"-fsanitize={SANITIZERS}", "-I."]
    built = ran([compiler, *flags, *export.sources, "-o", program, "-lm"], folder)
    if built.code != 0:
        return name, version(compiler), f"not run: {built.first}"
    reports = steps = 0
    for given in export.sanitized:
        # The comparison exits with 1 where outputs differ; anything else is a crash.
        done = ran([program, *given], folder)
        if done.code not in (0, 1):
            return name, version(compiler), f"ended with {done.code}: {done.first}"
        reports += done.text.count("runtime error") + done.text.count("Sanitizer:")
        steps += sum(map(int, re.findall(r"(\d+) steps", done.text)))
    return name, version(compiler), f"{reports} reports" + (f" in {steps} steps" if steps else "")


def instructions(export: Checked, folder: Path) -> tuple[str, str, str]:
    """Instructions per step on this machine, counted by callgrind."""
    name = "instructions of one step, x86-64, -O2"
    built = ran(["gcc", "-std=c99", "-O2", "-g", "-I.", *export.sources, "-o", "build/counted", "-lm"], folder)
    if built.code != 0:
        return name, version("gcc"), f"not run: {built.first}"
    words = ["valgrind", "--tool=callgrind", f"--toggle-collect={export.counted}", "--callgrind-out-file=/dev/null"]
    text = ran([*words, "build/counted", *export.runs[0]], folder).text
    collected, steps = re.search(r"Collected : (\d+)", text), re.search(r"(\d+) steps", text)
    if not collected or not steps:
        return name, version("valgrind"), "not run"
    return name, version("valgrind"), f"{int(collected[1]) / int(steps[1]):.0f}"


def misra(export: Checked, folder: Path) -> Table:
    """Departures from MISRA C:2012 of all source files, counted by rule, with their justification."""
    header = ("rule", "count", "reason")
    title = f"Departures from MISRA C:2012 ({version('cppcheck')} with its addon)"
    addon = next((path for each in ADDONS if (path := Path(each) / "misra.py").is_file()), None)
    if addon is None or not there("cppcheck"):
        return Table(title, header, (("not run", "", "cppcheck and its addon misra.py are not installed"),))
    counted: Counter[str] = Counter()
    for name in export.parts:
        dumped = ran(["cppcheck", "--dump", "--std=c99", "--quiet", "-I.", name], folder)
        # Without -P, since the addon imports a module that lies beside it; the working folder is not searched.
        judged = ran([sys.executable, str(addon), f"{name}.dump"], folder)
        for left in ("dump", "ctu-info"):
            (folder / f"{name}.{left}").unlink(missing_ok=True)
        if dumped.code != 0 or "Checking" not in judged.text:
            return Table(title, header, (("not run", "", (dumped if dumped.code else judged).first),))
        for rule, count in re.findall(r"^\s*misra-c2012-(\d+\.\d+) .*: (\d+)$", judged.text, flags=re.MULTILINE):
            counted[rule] += int(count)
    rows = [
        (f"rule {rule}", str(count), export.reasons.get(rule, "no reason is recorded"))
        for rule, count in sorted(counted.items(), key=lambda each: [int(part) for part in each[0].split(".")])
    ]
    note = "Of the rules that this addon checks; rules of the whole program and directives need a tool of their own."
    return Table(title, header, tuple(rows) or (("none", "0", "no departure was found"),), note)
