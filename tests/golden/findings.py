"""What a user reads in the findings of a recording, as text that a person can compare; prints what changed.

`PYTHONPATH=tests python -m golden.findings` prints the difference to the kept findings; with `--write` it is kept.
"""

from __future__ import annotations

import argparse
import contextlib
import difflib
import io
import json
import math
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest

from golden.recordings import KEPT, Kept
from tierod.cli import main as tierod

FOLDER = Path(__file__).parent / "findings"

READ = ("status", "exit_code", "findings", "elements", "remarks")
"""What is kept of the document of one diagnosis."""

NUMBER = re.compile(r"(?<![\w.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")

TOLERANCE = 2e-3
"""Relative difference of two numbers that is none: processors and libraries round differently [-]."""


def text_of(kept: Kept, folder: Path) -> str:
    """The findings of a recording, one fact a line.

    Args:
        kept: recording
        folder: empty folder for what is written
    """
    vehicle = kept.vehicle
    if " " in vehicle:
        kind, *values = vehicle.split()
        vehicle = str(folder / "car.toml")
        _run(["new", vehicle, "--class", kind, *values])
    path = kept.make(folder)
    code, said, error = _run(["diagnose", str(path), "--vehicle", vehicle, "--no-report", "--json", *kept.arguments])
    lines = [f"exit {code}", *_lines("", _read(json.loads(said)) if said else {"error": error})]
    return "\n".join(lines).replace(f"{folder}/", "") + "\n"


def _run(arguments: list[str]) -> tuple[int, str, str]:
    """Exit code, output and error of a command."""
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as error:
        code = tierod(arguments)
    return code, out.getvalue(), error.getvalue()


def _read(document: dict[str, Any]) -> dict[str, Any]:
    """What is kept of a document with one diagnosis, or with those of several monitors."""
    if "recordings" not in document:
        return {key: document[key] for key in READ}
    only = document["recordings"][0]
    return {
        "status": document["status"],
        **{name: {key: each[key] for key in READ} for name, each in only["diagnoses"].items()},
        "not_run": {each["monitor"]: each["reason"] for each in only["not_run"]},
    }


def _lines(name: str, value: Any) -> list[str]:
    if isinstance(value, dict):
        return [line for key, each in value.items() for line in _lines(f"{name}.{key}" if name else key, each)]
    if isinstance(value, list):
        return [line for at, each in enumerate(value) for line in _lines(f"{name}[{at}]", each)]
    if value in (None, "", [], {}):
        return []
    return [f"{name}: {value:.6g}" if isinstance(value, float) else f"{name}: {value}"]


def differences(kept: str, found: str) -> list[str]:
    """Lines that differ by more than rounding, as a unified difference; empty where none does.

    Args:
        kept, found: texts as of `text_of`
    """
    before, after = kept.splitlines(), found.splitlines()
    if len(before) == len(after) and all(map(_alike, before, after)):
        return []
    matched = [old if _alike(old, new) else new for old, new in zip(before, after, strict=False)] + after[len(before) :]
    return list(difflib.unified_diff(before, matched, "kept", "found", n=0, lineterm=""))


def _alike(before: str, after: str) -> bool:
    if before == after:
        return True
    old, new = NUMBER.findall(before), NUMBER.findall(after)
    if NUMBER.sub("#", before) != NUMBER.sub("#", after):
        return False
    return all(map(_close, old, new))


def _close(before: str, after: str) -> bool:
    """Whether two printed numbers differ by rounding only: by their last digit, or by the tolerance."""
    old, new = (float(each.replace("−", "-")) for each in (before, after))
    digits = len(before.partition("e")[0].partition(".")[2])
    last = 0.0 if "e" in before else 10.0**-digits if "." in before else 0.0
    return math.isclose(old, new, rel_tol=TOLERANCE, abs_tol=1.01 * last + 1e-9)


def main() -> int:
    """Print what changed; with --write, keep it."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("names", nargs="*", help="recordings; all where none is given")
    parser.add_argument("--write", action="store_true", help="keep what was found")
    given = parser.parse_args()
    changed = 0
    for name in given.names or KEPT:
        with tempfile.TemporaryDirectory() as folder:
            try:
                found = text_of(KEPT[name], Path(folder))
            except pytest.skip.Exception as absent:
                print(f"== {name}: {absent}")
                continue
        path = FOLDER / f"{name}.txt"
        lines = differences(path.read_text(encoding="utf-8") if path.exists() else "", found)
        changed += bool(lines)
        print(f"== {name}: {'changed' if lines else 'the same'}", *lines, sep="\n", flush=True)
        if given.write and lines:
            FOLDER.mkdir(exist_ok=True)
            path.write_text(found, encoding="utf-8")
    return int(changed > 0)


if __name__ == "__main__":
    sys.exit(main())
