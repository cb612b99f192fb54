"""Write the generated pages of docs/, or check that they agree with the code.

python scripts/docs.py            # write the generated pages
python scripts/docs.py --check    # list the pages that differ from the code; exit code 1 if there are any
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import docs_catalogues
import docs_commands
import docs_monitors

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"


def pages() -> dict[str, Callable[[], str]]:
    return {**docs_commands.pages(), **docs_monitors.pages(), **docs_catalogues.pages()}


def stale() -> list[str]:
    return [
        page
        for page, text in pages().items()
        if not (DOCS / page).exists() or (DOCS / page).read_text(encoding="utf-8") != text()
    ]


def main() -> int:
    """Write or check all generated pages; returns the exit code."""
    changed = stale()
    if "--check" in sys.argv:
        print("\n".join(f"stale: docs/{page}; run make docs" for page in changed) or "all pages are up to date")
        return 1 if changed else 0
    for page in changed:
        (DOCS / page).parent.mkdir(parents=True, exist_ok=True)
        (DOCS / page).write_text(pages()[page](), encoding="utf-8")
        print(f"wrote docs/{page}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
