"""The whole attack: damaged files, corpus, crowds, kills, changed signals; its figures go into the documentation."""

from __future__ import annotations

import importlib
import json
import platform
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from . import corpus
from .fuzz import Tally, class_of, run_all
from .pool import Pool
from .targets import READERS, TARGETS

ROOT = Path(__file__).resolve().parents[2]
FIGURES = ROOT / "attack.json"
PAGE = ROOT / "docs" / "explanation" / "reliability.md"
MARKS = ("<!-- figures: begin; made by make attack -->\n", "<!-- figures: end -->\n")

OTHERS = (("signals", "semantic", 2500, True), ("crowd of two", "crowds", 2, False),
          ("crowd of twenty", "crowds", 20, False), ("kills", "kills", 500, True))  # fmt: skip
"""Attacks of other modules here: title, module, `count` (2500 changes of signals are more than all), and whether a
share will do.

Each has `run(count, seed, folder)`, which gives figures, or figures for each thing that was attacked.
"""

BAD = {"failed", "defects", "wrong", "wrong_words", "broken", "lost", "hindered", "strays"}
"""Figures of theirs that have to be zero, or empty."""


def attack(
    count: int, seed: int, seconds: float, workers: int, report: Callable[[str], None], share: float = 1.0
) -> dict[str, Any]:
    """Run everything, and give the figures.

    Args:
        count: mutated files of each target
        seed: of all chance
        seconds: after which no further file is mutated [s]
        workers: processes
        report: takes a line of progress
        share: of the changed signals and kills that are made [-]
    """
    until = time.monotonic() + seconds
    sys.path.insert(0, str(ROOT / "tests"))  # some modules name their neighbours as the tests do
    figures: dict[str, Any] = {
        "date": datetime.now(UTC).date().isoformat(),
        "machine": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "seed": seed,
        "corpus": _corpus(report),
        "others": {},
        "targets": {},
    }
    for title, name, number, divisible in OTHERS:
        report(f"{title} ...")
        with tempfile.TemporaryDirectory(prefix="tierod-attack-") as folder:
            module = importlib.import_module(f"{__package__}.{name}")
            figures["others"][title] = module.run(
                max(round(share * number), 1) if divisible else number, seed, Path(folder)
            )
        keep(figures)
    one_at_a_time = threading.Lock()

    def progress(name: str, tally: Tally) -> None:
        with one_at_a_time:
            report(f"{name}: {tally.cases} cases")
            figures["targets"][name] = _figures(tally)
            keep(figures)

    run_all(list(TARGETS), count, seed, workers, until, progress)
    return figures


def _corpus(report: Callable[[str], None]) -> dict[str, Any]:
    failed = []
    kept = corpus.load()
    with Pool() as pool:
        for each in kept:
            fault = each.fault(each.run(pool))
            if fault:
                failed.append(each.name)
                report(f"corpus {each.name}: {fault[:300]}")
    return {"cases": len(kept), "failed": failed}


def _figures(tally: Tally) -> dict[str, Any]:
    classes: dict[str, list[str]] = {}
    for each, result in tally.failed:
        classes.setdefault(class_of(result), []).append(each.key)
    return {
        "cases": tally.cases,
        "codes": {str(code): number for code, number in sorted(tally.codes.items(), key=str)},
        "failed": dict(Counter(result.kind for _, result in tally.failed)),
        "unrepeated": tally.unrepeated,
        "slowest": round(tally.slowest, 2),
        "largest": tally.largest,
        "classes": {name: keys[:5] for name, keys in classes.items()},
    }


def passed(figures: dict[str, Any]) -> bool:
    """Whether nothing failed.

    Args:
        figures: as `attack` gives them
    """
    rows = [row for other in figures["others"].values() for row in _rows(other).values()]
    return (
        not figures["corpus"]["failed"]
        and not any(target["failed"] for target in figures["targets"].values())
        and not any(row.get(name) for row in rows for name in BAD)
    )


def _rows(other: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The figures of another attack by what was attacked; "all" where it does not distinguish them."""
    nested = all(isinstance(value, dict) for value in other.values())
    return other if nested else {"all": other}


def table(figures: dict[str, Any]) -> str:
    """The figures as Markdown.

    Args:
        figures: as `attack` gives them
    """
    lines = [
        f"Seed {figures['seed']}, {figures['date']}, {figures['machine']}.",
        "",
        "| what is opened | cases | read or judged | refused | traceback or exit 4 | crash | beyond 10 s | "
        "beyond 1.5 GB | control characters | other | slowest [s] | largest [MB] |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    lines += [_row(name, figures["targets"][name]) for name in TARGETS]
    readers, files = (_sum(figures, names) for names in (READERS, [name for name in TARGETS if name not in READERS]))
    kept = figures["corpus"]
    lines += [
        "",
        f"Together {readers[0]} damaged recordings in {len(READERS)} formats, of which {readers[1]} failed, and "
        f"{files[0]} damaged user files of {len(TARGETS) - len(READERS)} kinds, of which {files[1]} failed. "
        f"Corpus: {kept['cases']} cases that failed once, {len(kept['failed'])} of which fail now.",
    ]
    for title, other in figures["others"].items():
        rows = _rows(other)
        names = list(dict.fromkeys(name for row in rows.values() for name in row))
        lines += ["", f"| {title} | {' | '.join(name.replace('_', ' ') for name in names)} |"]
        lines += ["|---|" + "---:|" * len(names)]
        lines += [
            f"| {what} | {' | '.join(_shown(row.get(name, '')) for name in names)} |" for what, row in rows.items()
        ]
    return "\n".join(lines) + "\n"


def _row(name: str, target: dict[str, Any]) -> str:
    codes, failed = Counter(target["codes"]), Counter(target["failed"])
    known = (
        failed["traceback"] + failed["defect"],
        failed["crash"],
        failed["hang"],
        failed["memory"],
        failed["escape"],
    )
    other = sum(failed.values()) - sum(known)
    judged = codes["0"] + codes["1"] + codes["2"]
    cells = (target["cases"], judged, codes["3"], *known, other, f"{target['slowest']:.1f}")
    return f"| {name} | {' | '.join(map(str, cells))} | {target['largest'] / 1e6:.0f} |"


def _sum(figures: dict[str, Any], names: Any) -> tuple[int, int]:
    chosen = [figures["targets"][name] for name in names]
    return sum(each["cases"] for each in chosen), sum(sum(each["failed"].values()) for each in chosen)


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, dict):
        return ", ".join(f"{key}: {each}" for key, each in value.items()) if len(value) < 6 else str(len(value))
    return str(value)


def keep(figures: dict[str, Any]) -> None:
    """Write the figures that there are, after each part: what ends a run of hours does not take them along.

    Args:
        figures: as `attack` gives them, or the first of them
    """
    FIGURES.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def write(figures: dict[str, Any]) -> None:
    """Keep the figures, and put their table between the marks of the page.

    Args:
        figures: as `attack` gives them
    """
    keep(figures)
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(MARKS[0])
    PAGE.write_text(before + MARKS[0] + table(figures) + MARKS[1] + rest.partition(MARKS[1])[2], encoding="utf-8")
