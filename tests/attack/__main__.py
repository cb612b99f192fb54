"""Attacks tierod: PYTHONPATH=tests python -m attack VERB.

all                                 everything for an hour, with its figures in attack.json: `make attack`
fuzz [TARGET ...]                   mutated files of some targets
replay TARGET SEED NUMBER           one case again, with what it printed
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

from . import corpus
from .fuzz import SEED, TARGETS, Tally, attempt, case, class_of, run_all
from .pool import Pool

ROOT = Path(__file__).resolve().parents[2]

OTHERS = (("semantic", 2500, True), ("crowds", 2, False), ("crowds", 20, False), ("kills", 500, True))
"""Attacks of other modules here: module, its `count`, and whether a share of it will do."""

BAD = {"failed", "defects", "wrong", "wrong_words", "broken", "lost", "hindered", "strays"}
"""Figures of theirs that have to be zero, or empty."""


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m attack")
    verbs = parser.add_subparsers(dest="verb", required=True)
    whole = verbs.add_parser("all", help="run every attack")
    whole.add_argument("--share", type=float, default=1.0, help="of the changed signals and kills")
    fuzz = verbs.add_parser("fuzz", help="mutate files of all targets and open them")
    fuzz.add_argument("targets", nargs="*", default=list(TARGETS))
    for verb in (whole, fuzz):
        verb.add_argument("--count", type=int, default=2000, help="cases of each target")
        verb.add_argument("--seed", type=int, default=SEED)
        verb.add_argument("--workers", type=int, default=2)
        verb.add_argument("--seconds", type=float, default=3600.0, help="after which no further case begins")
    replay = verbs.add_parser("replay", help="run one case again and print what became of it")
    replay.add_argument("target")
    replay.add_argument("seed", type=int)
    replay.add_argument("number", type=int)
    given = parser.parse_args()
    return {"all": _all, "fuzz": _fuzz, "replay": _replay}[given.verb](given)


def _all(given: argparse.Namespace) -> int:
    until = time.monotonic() + given.seconds
    figures: dict[str, Any] = {"seed": given.seed, "corpus": _corpus()}
    for name, count, divisible in OTHERS:
        count = max(round(given.share * count), 1) if divisible else count
        with tempfile.TemporaryDirectory(prefix="tierod-attack-") as folder:
            module = importlib.import_module(f"{__package__}.{name}")
            figures[f"{name} {count}"] = module.run(count, given.seed, Path(folder))
        _keep(figures)
    tallies = run_all(list(TARGETS), given.count, given.seed, given.workers, until, _print_tally)
    figures["files"] = {name: _figures(tally) for name, tally in tallies.items()}
    _keep(figures)
    return int(_any_bad(figures))


def _corpus() -> dict[str, Any]:
    kept = corpus.load()
    with Pool() as pool:
        failed = {each.name: fault for each in kept if (fault := each.fault(each.run(pool)))}
    return {"cases": len(kept), "failed": failed}


def _figures(tally: Tally) -> dict[str, Any]:
    return {
        "cases": tally.cases,
        "codes": dict(Counter(map(str, tally.codes.elements()))),
        "failed": {each.key: class_of(result) for each, result in tally.failed},
        "slowest": round(tally.slowest, 2),
        "largest": tally.largest,
    }


def _keep(figures: dict[str, Any]) -> None:
    """Write the figures that there are after each part: what ends a run of hours does not take them along."""
    (ROOT / "attack.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def _any_bad(figures: dict[str, Any]) -> bool:
    return any(
        bool(value) if name in BAD else isinstance(value, dict) and _any_bad(value) for name, value in figures.items()
    )


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


if __name__ == "__main__":
    sys.exit(main())
