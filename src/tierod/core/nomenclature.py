"""The page `docs/nomenclature.md`, made from the catalogue of signals.

python -m tierod.core.nomenclature > docs/nomenclature.md
"""

from __future__ import annotations

import sys
from itertools import groupby
from math import isinf, pi

from tierod.core.signals import SIGNALS, Signal

_HEAD = """# Nomenclature

Generated from `tierod.core.signals` by `python -m tierod.core.nomenclature > docs/nomenclature.md`; do not edit.

SI units and radians inside; degrees, km/h and rpm only in files, reports and on the command line. ISO 8855: x forward,
y left, z up. A left turn has positive steering-wheel angle, yaw rate and lateral acceleration. Motor-side and
column-side torque, axle and wheel, mechanical and electrical angle are told apart by name.

*Plausible* is the range that a healthy road vehicle can reach: values outside earn a remark, never a correction.
*Aliases* are matched without regard to case and punctuation where a recording comes without a channel map.
"""


def nomenclature() -> str:
    """The page as Markdown: one table per group of signals."""
    parts = [_HEAD]
    for group, members in groupby(SIGNALS.values(), key=lambda signal: signal.group):
        parts.append(f"\n## {group}\n")
        parts.append("| signal | unit | meaning | positive | plausible | aliases |\n|---|---|---|---|---|---|")
        parts.extend(_row(signal) for signal in members)
    return "\n".join(parts) + "\n"


def _row(signal: Signal) -> str:
    aliases = ", ".join(f"`{alias}`" for alias in signal.aliases)
    cells = (f"`{signal.name}`", signal.unit or "-", signal.meaning, signal.positive, _plausible(signal), aliases)
    return "| " + " | ".join(cells) + " |"


def _plausible(signal: Signal) -> str:
    low, high = signal.plausible
    if isinf(low) and isinf(high):
        return ""
    text = f"{low:g} to {high:g}"
    if signal.unit.startswith("rad"):
        text += f" ({low * 180.0 / pi:.0f} to {high * 180.0 / pi:.0f} {signal.unit.replace('rad', 'deg')})"
    return text


if __name__ == "__main__":
    sys.stdout.write(nomenclature())
