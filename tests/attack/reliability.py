"""The whole attack: damaged files, corpus, crowds, kills, changed signals; its figures go into the documentation."""

from __future__ import annotations

import importlib
import importlib.util
import json
import platform
import tempfile
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
PAGE = ROOT / "docs" / "reliability.md"
MARKS = ("<!-- figures: begin; made by make attack -->\n", "<!-- figures: end -->\n")

OTHERS = {"semantic": 0, "crowds": 0, "kills": 500}
"""Attacks of other modules here, where they are present, with their `count`; 0 leaves it to the module.

Each has `run(count, seed, folder)`, which gives figures by what they mean; one named "failed" counts.
"""


def attack(count: int, seed: int, seconds: float, workers: int, told: Callable[[str], None]) -> dict[str, Any]:
    """Run everything, and give the figures.

    Args:
        count: mutated files of each target
        seed: of all chance
        seconds: after which no further file is mutated [s]
        workers: processes
        told: takes a line of progress
    """
    until = time.monotonic() + seconds
    figures: dict[str, Any] = {
        "date": datetime.now(UTC).date().isoformat(),
        "machine": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "seed": seed,
        "corpus": _corpus(told),
    }
    for name, number in OTHERS.items():
        if importlib.util.find_spec(f"{__package__}.{name}") is not None:
            told(f"{name} ...")
            with tempfile.TemporaryDirectory(prefix="tierod-attack-") as folder:
                module = importlib.import_module(f"{__package__}.{name}")
                figures[name] = module.run(number, seed, Path(folder))
    found = run_all(
        list(TARGETS), count, seed, workers, until, lambda name, tally: told(f"{name}: {tally.cases} cases")
    )
    figures["targets"] = {name: _figures(tally) for name, tally in found.items()}
    return figures


def _corpus(told: Callable[[str], None]) -> dict[str, Any]:
    failed = []
    kept = corpus.load()
    with Pool() as pool:
        for each in kept:
            fault = each.fault(each.run(pool))
            if fault:
                failed.append(each.name)
                told(f"corpus {each.name}: {fault[:300]}")
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
    others = (figures[name] for name in OTHERS if name in figures)
    return (
        not figures["corpus"]["failed"]
        and not any(target["failed"] for target in figures["targets"].values())
        and not any(other.get("failed") for other in others)
    )


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
    for name in OTHERS:
        if name in figures:
            lines += ["", f"| {name} | figure |", "|---|---:|"]
            lines += [f"| {what} | {_shown(value)} |" for what, value in figures[name].items()]
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
    if isinstance(value, list | tuple | set):
        return ", ".join(map(str, value)) or "none"
    return str(value)


def write(figures: dict[str, Any]) -> None:
    """Keep the figures, and put their table between the marks of the page.

    Args:
        figures: as `attack` gives them
    """
    FIGURES.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(MARKS[0])
    PAGE.write_text(before + MARKS[0] + table(figures) + MARKS[1] + rest.partition(MARKS[1])[2], encoding="utf-8")
