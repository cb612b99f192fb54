"""Put what a study prints into its page, between its two marks.

tierod study column | python scripts/study_docs.py column
"""

from __future__ import annotations

import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent.parent / "docs"
CLAIMS = "**Claims**"
WHOLE = {"friction": True, "column": False, "sideslip": False, "condition": True, "motor-angle": True}
"""Whether a page shows all that its study prints, or its claims alone."""


def main(name: str) -> int:
    """Replace what stands between the marks by standard input; nothing happens without a list of claims."""
    if name not in WHOLE:
        print(f"there is no page of a study '{name}'; known: {', '.join(WHOLE)}", file=sys.stderr)
        return 1
    printed = sys.stdin.read().strip()
    if CLAIMS not in printed:
        print(f"standard input holds no list of claims; give what 'tierod study {name}' prints", file=sys.stderr)
        return 1
    told = printed if WHOLE[name] else printed[printed.index(CLAIMS) :]
    page = DOCS / f"{name}.md"
    begin, end = (f"<!-- tierod study {name}: {edge} -->" for edge in ("begin", "end"))
    before, rest = page.read_text(encoding="utf-8").split(begin)
    _, after = rest.split(end)
    page.write_text(f"{before}{begin}\n\n{told}\n\n{end}{after}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else ""))
