"""Put what `tierod study friction` prints into docs/friction.md, between its two marks: `... study friction | ...`."""

from __future__ import annotations

import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent / "docs" / "friction.md"
BEGIN, END = "<!-- tierod study friction: begin -->", "<!-- tierod study friction: end -->"


def main() -> int:
    """Replace what stands between the marks by standard input; nothing happens without a list of claims."""
    printed = sys.stdin.read().strip()
    if "**Claims**" not in printed:
        print("standard input holds no list of claims; give what 'tierod study friction' prints", file=sys.stderr)
        return 1
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    _, after = rest.split(END)
    PAGE.write_text(f"{before}{BEGIN}\n\n{printed}\n\n{END}{after}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
