"""Draw single changes of the source, and list those that no test detects.

python -m scripts.mutants --number 60 --seed 1 src/tierod/physics src/tierod/models
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

from scripts.mutants.changes import Change, changes_of
from scripts.mutants.chosen_tests import ChosenTests
from scripts.mutants.trying import Copy, Outcome

ROOT = Path(__file__).resolve().parents[2]
PAGES = Path("tests/examples/test_site.py")
"""Test of the generated pages, which contain every number of the monitors and therefore concern every file."""


def drawn(paths: Sequence[Path], number: int, seed: int) -> Iterator[Change]:
    """Randomly drawn changes, with equal probability for each kind, because constants far outnumber signs.

    Args:
        paths: files and folders
        number: largest number of changes
        seed: of the random generator
    """
    files = sorted({file for path in paths for file in ([path] if path.is_file() else path.rglob("*.py"))})
    kinds: dict[str, list[Change]] = {}
    for file in files:
        for change in changes_of(file.relative_to(ROOT / "src"), file.read_bytes()):
            kinds.setdefault(change.kind, []).append(change)
    chance = random.Random(seed)
    while kinds and number > 0:
        kind = chance.choice(sorted(kinds))
        change = kinds[kind].pop(chance.randrange(len(kinds[kind])))
        if not kinds[kind]:
            del kinds[kind]
        if change.valid((ROOT / "src" / change.path).read_bytes()):
            number -= 1
            yield change


def outcomes(changes: Sequence[Change], processes: int, limit: float) -> Iterator[Outcome]:
    """Results of the tests for every change, in order.

    Args:
        changes: to be tried
        processes: number of concurrent tests
        limit: time limit for the tests of one change [s]
    """
    tests = ChosenTests(ROOT)
    chosen = {path: [*tests.of(path), PAGES] for path in {change.path for change in changes}}
    copies: SimpleQueue[Copy] = SimpleQueue()
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder, ThreadPoolExecutor(processes) as pool:
        for number in range(processes):
            copies.put(Copy(ROOT, Path(folder) / str(number)).make())

        def tried(change: Change) -> Outcome:
            copy = copies.get()
            try:
                return copy.tried(change, chosen[change.path], limit)
            finally:
                copies.put(copy)

        yield from pool.map(tried, changes)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print every change with the test that detected it, and the detected share; returns 1 if one was not detected."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*", type=Path, default=[ROOT / "src" / "tierod"])
    parser.add_argument("--number", type=int, default=60, help="of changes")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=600.0, help="no further tests of one change begin after")
    parser.add_argument("--output", type=Path, help="JSON file with all that was found out")
    given = parser.parse_args(arguments)
    if missing := [str(path) for path in given.paths if not path.exists()]:
        parser.error(f"{missing[0]} does not exist; give files or folders below src")
    changes = list(drawn([path.resolve() for path in given.paths], given.number, given.seed))
    survivors, rows = 0, []
    for number, outcome in enumerate(outcomes(changes, given.processes, given.seconds), 1):
        change, survived = outcome.change, outcome.found_by is None
        survivors += survived
        said = f"SURVIVED {outcome.tests[0]} of {outcome.tests[1]} test files" if survived else outcome.found_by
        print(f"{number} {change.path}:{change.line} {change.kind} ({outcome.seconds:.0f} s): {said}")
        if survived:
            print(outcome.diff)
        sys.stdout.flush()
        rows.append(
            {
                "path": str(change.path),
                "line": change.line,
                "kind": change.kind,
                "diff": outcome.diff,
                "found_by": outcome.found_by,
                "tests": outcome.tests,
                "seconds": round(outcome.seconds, 1),
            }
        )
    print(f"{len(changes) - survivors} of {len(changes)} changes found (seed {given.seed})")
    if given.output:
        given.output.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
