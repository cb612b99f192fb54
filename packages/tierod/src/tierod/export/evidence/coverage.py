"""Statement and branch coverage of an export's C code, and a classification of the branches that are not reached."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from tierod.core.content import Table
from tierod.core.graph.operations import STATE, TUNING, Program, is_constant
from tierod.export.evidence.checks import Checked, ran, version
from tierod.export.segments import is_presence

# Explanation of branches that are not reached, by their kind
REASONS = {
    "parameters": "decided by the parameters alone, which of three whole numbers a count is compared with",
    "clock": "the end of a counter of steps, after 2^32 steps: 497 days at 100 Hz",
    "presence": "presence of a value that the monitor computes from held inputs: no sample makes it missing, not "
    "even where whole signals are missing; the block is used elsewhere too, where it can be missing",
    "age": "age of a value that the monitor computes itself: with these samples it is always present",
    "limit": "a limit at zero or at a fixed number, which the value does not reach with these samples",
    "number": "check that the number of a lane is whole and exists, which holds for every number that the judge gives",
    "circle": "lanes that take over each other's states in a circle, which this judge never requests; "
    "tests/export/test_printed_numbers.py runs a bank whose judge does",
    "store": "a correct checksum over damaged contents",
    "other": "no reason is recorded: drives, altered ones too, random samples and failed signals do not reach them; "
    "listed below",
}

LONGEST = 110  # Characters of a listed line of C code

_LINE = re.compile(r"\s*[-#\d=*]+:\s*(\d+):(.*)")
_MISSED = re.compile(r"branch\s+\d+ (?:taken 0\b|never executed)")
_NUMBER = re.compile(r"\b(?:bool k|int32_t [ij])\d+ =")
_NAMED = re.compile(r"\bv(\d+) =")


class Stepped(NamedTuple):
    """Meaning of the numbered values in the C code of a step, or of a lane of a bank."""

    program: Program  # of the printed step, with its chains of selections replaced by picks and members
    state: tuple[str, ...]
    functions: tuple[str, ...] = ("_step", "_judge")


def covered(export: Checked, folder: Path, *stepped: Stepped) -> list[Table]:
    """Coverage of all runs together, and the remaining branches, counted by kind.

    Args:
        stepped: meaning of the numbered values in the C code; none if the export is no monitor
    """
    title, header = "Coverage by vectors, random samples and failed signals", ("what", "tool", "result")
    compiled = ["gcc", "-std=c99", "-O0", "-I.", "--coverage"]
    built = ran([*compiled, "-c", export.code, "-o", "build/covered.o"], folder)
    programs = {
        "build/covered": export.sources,
        **({"build/varied": (*export.parts, export.varied)} if export.varied else {}),
    }
    for name, sources in programs.items():
        others = [each for each in sources if each != export.code]
        linked = ran([*compiled[:-1], *others, "build/covered.o", "--coverage", "-o", name, "-lm"], folder)
        built = built if built.code != 0 else linked
    if built.code != 0:
        return [Table(title, header, (("coverage", version("gcov"), f"not run: {built.first}"),))]
    # gcov accumulates counts over runs, so those of an earlier run are removed first.
    (folder / "build/covered.gcda").unlink(missing_ok=True)
    for given in export.runs:
        ran(["build/covered", *given], folder)
    if export.varied:
        ran(["build/varied"], folder)
    text = ran(["gcov", "-b", "-c", "-o", "build/covered.gcda", export.code], folder).text
    listing = folder / f"{export.code}.gcov"
    missed = list(_missed(listing.read_text(encoding="utf-8"), stepped)) if listing.exists() else []
    listing.unlink(missing_ok=True)
    part = text.partition(f"File '{export.code}'")[2]
    rows = [(name, version("gcov"), _found(part, pattern)) for name, pattern in _PATTERNS]
    rows.append(("conditions (MC/DC)", version("gcc"), _conditions(export, folder)))
    counted = Counter(kind for kind, _, _ in missed)
    left = tuple((REASONS[kind], str(count)) for kind, count in sorted(counted.items()))
    named = tuple(dict.fromkeys((line, text[:LONGEST]) for kind, line, text in missed if kind == "other"))
    return [
        Table(title, header, tuple(rows)),
        Table("Branches that are not reached", ("what they decide", "branches"), left or (("none is left", "0"),)),
        *(
            [Table("Decisions that fall one way alone, without a recorded reason", ("line", "C"), named)]
            if named
            else []
        ),
    ]


_PATTERNS = (
    ("statements executed", r"Lines executed:([\d.]+)% of (\d+)"),
    ("branches taken", r"Taken at least once:([\d.]+)% of (\d+)"),
)


def _found(part: str, pattern: str) -> str:
    found = re.search(pattern, part)
    return f"{found[1]} % of {found[2]}" if found else "not found in the report"


def _missed(listing: str, stepped: Sequence[Stepped]) -> Iterator[tuple[str, str, str]]:
    line, text, function, asked = "", "", "", ""
    for each in listing.splitlines():
        if source := _LINE.match(each):
            line, text = source.groups()
            # The condition of an if statement is the value declared on the line before it.
            asked = asked if text.lstrip().startswith("if (") else text
        elif each.startswith("function "):
            function = each.split()[1]
        elif _MISSED.match(each):
            known = next((own for own in stepped if any(word in function for word in own.functions)), None)
            yield _kind(asked, function, known), line, text.strip()


def _kind(line: str, function: str, stepped: Stepped | None) -> str:
    if "UINT32_MAX" in line:
        return "clock"
    if "TIEROD_MEMORY_CODES) ? (int16_t)" in line:
        return "store"
    if "_prepare" in function:
        return "parameters"
    if function.endswith("_member") or _NUMBER.search(line):
        return "number"
    if function.endswith("_adopt"):
        return "circle"
    named = _NAMED.search(line)
    # Loop iterations and their copies use value numbers beyond those of the program.
    if stepped is None or not named or int(named[1]) >= len(stepped.program.operations):
        return "other"
    if _rests_on_presence(stepped.program, int(named[1])):
        return "presence"
    if _rests_on_age(stepped, int(named[1])):
        return "age"
    return "limit" if _is_limit(stepped.program, int(named[1])) else "other"


def _is_limit(program: Program, index: int) -> bool:
    operations = program.operations
    name, arguments = operations[index].name, operations[index].arguments
    if name == "if":
        asked = operations[arguments[0]]
        compared = operations[asked.arguments[0]] if asked.name == "not" else asked
        return asked.name == "not" and compared.name == "lt" and is_constant(operations[compared.arguments[1]], 0.0)
    if name != "select" or operations[arguments[0]].name != "lt":
        return False
    laid_down = [each in program.invariant or operations[each].name == "constant" for each in arguments[1:]]
    return set(operations[arguments[0]].arguments) == set(arguments[1:]) and any(laid_down)


def _rests_on_age(stepped: Stepped, index: int) -> bool:
    operations = stepped.program.operations
    waiting = list(operations[index].arguments[:1]) if operations[index].name in ("select", "if") else []
    ages = 0
    while waiting:
        operation = operations[waiting.pop()]
        if operation.name == "input" and operation.constant[0] != TUNING:
            if operation.constant[0] != STATE or not stepped.state[operation.constant[1]].endswith(".age"):
                return False
            ages += 1
        held = operation.name in ("select", "if") and is_presence(stepped.program, operation.arguments[0])
        waiting += operation.arguments[1:] if held else operation.arguments
    return ages > 0


def _rests_on_presence(program: Program, index: int) -> bool:
    operation = program.operations[index]
    asked = operation.arguments[:1] if operation.name in ("select", "if") else operation.arguments
    return operation.name in ("select", "if", "and", "or") and any(is_presence(program, each) for each in asked)


def _conditions(export: Checked, folder: Path) -> str:
    """Availability of condition coverage, which gcc supports from version 14 on."""
    tried = ran(["gcc", "-fcondition-coverage", "-c", export.code, "-I.", "-o", "build/conditions.o"], folder)
    return (
        "available, see gcov --conditions" if tried.code == 0 else "this gcc has none (14 has); branches stand for it"
    )
