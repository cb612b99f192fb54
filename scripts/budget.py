"""The budget of size: lines of source per folder and words of docs, in budget.toml, which only falls.

python scripts/budget.py            # lower every number to what is there; none is raised
python scripts/budget.py --check    # list what is above its budget, or far below it; exit code 1 if there is any

To raise a number, edit budget.toml by hand, and give the reason in a comment beside it and in the same commit.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUDGET = ROOT / "budget.toml"

SOURCE = {".py", ".js", ".css", ".j2", ".html", ".c", ".h", ".sh"}
SLACK = 0.03  # Share by which a folder may lie below its budget before the budget has to follow
SMALL = 60  # Lines, or words by hundreds, below which a difference does not matter


def lines(folder: str) -> int:
    """Lines of source below a folder."""
    files = (path for path in (ROOT / folder).rglob("*") if path.suffix in SOURCE and "vendor" not in path.parts)
    return sum(path.read_bytes().count(b"\n") for path in files if "__pycache__" not in path.parts)


def measured() -> dict[str, int]:
    """What is there, by the names of budget.toml: every package of both distributions, what is beside them, docs."""
    roots = ("packages/tierod/src/tierod", "packages/tierod-lab/src/tierod_lab")
    found = [f"{root}/{each.name}" for root in roots for each in sorted((ROOT / root).iterdir()) if _is_package(each)]
    pages = [page for page in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")) if page.name != "CHANGELOG.md"]
    words = sum(len(page.read_text(encoding="utf-8").split()) for page in pages)
    return {folder: lines(folder) for folder in (*found, "tests", "scripts", "benchmarks")} | {"words of docs": words}


def _is_package(folder: Path) -> bool:
    return (folder / "__init__.py").is_file()


def budget() -> dict[str, int]:
    return {name: int(number) for name, number in tomllib.loads(BUDGET.read_text(encoding="utf-8")).items()}


def complaints() -> list[str]:
    """A sentence for each number above its budget, far below it, or without one."""
    allowed, found = budget(), []
    for name, size in measured().items():
        if name not in allowed:
            found.append(f"{name} has {size} and no budget: name in budget.toml what it makes superfluous")
        elif size > allowed[name]:
            found.append(f"{name} has {size}, budget {allowed[name]}: delete, or raise it with a reason")
        elif size < allowed[name] * (1.0 - SLACK) - SMALL:
            found.append(f"{name} has {size}, budget {allowed[name]}: run python scripts/budget.py, which lowers it")
    return [*found, *(f"{name} has a budget and is not there: take it out" for name in allowed.keys() - measured())]


def lowered() -> str:
    size, text = measured(), BUDGET.read_text(encoding="utf-8")
    kept = []
    for line in text.splitlines():
        found = re.match(r'"(.+)" = (\d+)(.*)$', line)
        if not found:
            kept.append(line)
        elif found[1] in size:
            kept.append(f'"{found[1]}" = {min(int(found[2]), size[found[1]])}{found[3]}')
    return "\n".join(kept) + "\n"


def main() -> int:
    """Lower or check the budget; returns the exit code."""
    if "--check" not in sys.argv:
        BUDGET.write_text(lowered(), encoding="utf-8")
    found = complaints()
    print("\n".join(found) or "everything is within its budget")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
