"""Attacks tierod: python -m tests.attack VERB.

all                                 everything for an hour, and the table of docs/explanation/reliability.md:
                                    `make attack`
fuzz [TARGET ...]                   mutated files of some targets
replay TARGET SEED NUMBER           one case again, with what it printed
show TARGET SEED NUMBER FOLDER      the file of a case, and the command that opens it
keep TARGET SEED NUMBER             the file of a failing case made small, as an entry of the corpus
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from .fuzz import SEED, Tally, attempt, class_of, run_all
from .minimise import entry, minimised
from .pool import Pool
from .reliability import attack, passed, table, write
from .targets import TARGETS, case


def main() -> int:
    """Run what the arguments ask for."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack")
    verbs = parser.add_subparsers(dest="verb", required=True)
    every = verbs.add_parser("all", help="run every attack and write the table of docs/explanation/reliability.md")
    every.add_argument("--share", type=float, default=1.0, help="of the changed signals and kills")
    fuzz = verbs.add_parser("fuzz", help="mutate files of all targets and open them")
    fuzz.add_argument("targets", nargs="*", default=list(TARGETS))
    for verb in (every, fuzz):
        verb.add_argument("--count", type=int, default=2000, help="cases of each target")
        verb.add_argument("--seed", type=int, default=SEED)
        verb.add_argument("--workers", type=int, default=2)
        verb.add_argument("--seconds", type=float, default=3600.0, help="after which no further case begins")
    replay = verbs.add_parser("replay", help="run one case again and print what became of it")
    show = verbs.add_parser("show", help="write the file of a case")
    keep = verbs.add_parser("keep", help="make the file of a failing case small and print it for the corpus")
    for verb in (replay, show, keep):
        verb.add_argument("target")
        verb.add_argument("seed", type=int)
        verb.add_argument("number", type=int)
    show.add_argument("folder", type=Path)
    given = parser.parse_args()
    return {"all": _all, "fuzz": _fuzz, "replay": _replay, "show": _show, "keep": _keep}[given.verb](given)


def _all(given: argparse.Namespace) -> int:
    sizes = (given.count, given.seed, given.seconds, given.workers)
    figures = attack(*sizes, lambda line: print(line, flush=True), given.share)
    write(figures)
    print(table(figures))
    for name, target in figures["targets"].items():
        for what, keys in target["classes"].items():
            print(f"{name}: {what}   [{', '.join(keys)}]")
    return int(not passed(figures))


def _fuzz(given: argparse.Namespace) -> int:
    until = time.monotonic() + given.seconds
    found = run_all(given.targets, given.count, given.seed, given.workers, until, _print_tally)
    return int(any(tally.failed for tally in found.values()))


def _print_tally(target: str, tally: Tally) -> None:
    codes = ", ".join(f"{code}: {count}" for code, count in sorted(tally.codes.items(), key=str))
    print(
        f"{target}: {tally.cases} cases, {len(tally.failed)} failed, {tally.unrepeated} unrepeated, exit {codes}, "
        f"slowest {tally.slowest:.2f} s, largest {tally.largest / 1e6:.0f} MB",
        flush=True,
    )
    classes: dict[str, list[str]] = {}
    for each, result in tally.failed:
        classes.setdefault(class_of(result), []).append(each.key)
    for name, keys in sorted(classes.items(), key=lambda pair: -len(pair[1])):
        print(f"    {len(keys):4d} x {name}   [{', '.join(keys[:3])}]", flush=True)


def _replay(given: argparse.Namespace) -> int:
    each = case(given.target, given.seed, given.number)
    with Pool() as pool:
        result = attempt(pool, each)
    print(f"tierod {' '.join(each.command)}   # {each.name}, {len(each.content)} bytes")
    print(result.stdout + result.stderr, end="")
    print(f"exit {result.code}, {result.seconds:.2f} s, {result.memory / 1e6:.0f} MB: {result.kind or 'held'}")
    print(result.detail)
    return int(bool(result.kind))


def _show(given: argparse.Namespace) -> int:
    each = case(given.target, given.seed, given.number)
    given.folder.mkdir(parents=True, exist_ok=True)
    print(" ".join(each.placed(given.folder)))
    return 0


def _keep(given: argparse.Namespace) -> int:
    print(entry(*minimised(case(given.target, given.seed, given.number))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
