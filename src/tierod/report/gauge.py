"""The estimate on a scale with its interval and the levels it is judged against, as a drawing in the page."""

from __future__ import annotations

import math
from html import escape

from tierod.core.findings import Estimate
from tierod.core.shown import shown
from tierod.report.charts.figure import BLUE, level_colour
from tierod.report.display import INTERVAL, interval, number, words

_WIDTH, _MARGIN = 640.0, 14.0
_ROW = 26.0
_LETTER = 13.0
"""Width of a letter at the size that the narrowest screen shows; labels are placed so that they part there too."""


def gauge(estimate: Estimate) -> str:
    """An SVG drawing; empty where there is no value or nothing to compare it with."""
    factor, label = shown(estimate.unit)
    levels = sorted((level * factor, name) for name, level in estimate.reference.items() if math.isfinite(level))
    value, half = estimate.value * factor, INTERVAL * estimate.standard_deviation * factor
    if not levels or not math.isfinite(value):
        return ""
    half = half if math.isfinite(half) else 0.0
    high = 1.15 * max(value + half, levels[-1][0])
    low = min(0.0, 1.15 * (value - half), 1.15 * levels[0][0])

    def at(position: float) -> float:
        return _MARGIN + (_WIDTH - 2.0 * _MARGIN) * (position - low) / (high - low)

    marks = _placed(
        [(at(level), f"{words(name).lower()} {number(level, 3)}", level_colour(name)) for level, name in levels]
    )
    above = max((row for *_, row in marks if row > 0), default=0)
    below = max((-row for *_, row in marks if row < 0), default=0)
    line = 22.0 + _ROW * above
    parts = [_line(_MARGIN, line, _WIDTH - _MARGIN, line, "#94a3b8", 6.0)]
    parts += [_tick(x, colour, row, line) for x, _, colour, row in marks]
    parts += [_name(x, text, colour, row, line) for x, text, colour, row in marks]
    parts.append(_line(at(value - half), line, at(value + half), line, BLUE, 6.0))
    parts.append(f'<circle cx="{at(value):.1f}" cy="{line:.0f}" r="8" fill="{BLUE}" stroke="white" stroke-width="2"/>')
    size = f"0 0 {_WIDTH:.0f} {line + 22.0 + _ROW * below:.0f}"
    told = ", ".join(text for _, text, _, _ in marks)
    middle, lower, upper, _ = interval(estimate)
    title = escape(f"{middle} {label} (95 % interval {lower} to {upper}) on a scale with {told} {label}")
    return f'<svg class="gauge" viewBox="{size}" role="img" aria-label="{title}">{"".join(parts)}</svg>'


def _placed(marks: list[tuple[float, str, str]]) -> list[tuple[float, str, str, int]]:
    """Each mark with its row: 1, 2, ... above the line, -1, -2, ... beneath it, the nearest that is still free."""
    ends: dict[int, float] = {}
    placed = []
    for x, text, colour in marks:
        width = _LETTER * len(text)
        start = min(max(x - 0.5 * width, 0.0), _WIDTH - width)
        rows = (sign * row for row in range(1, len(marks) + 1) for sign in (1, -1))
        row = next(row for row in rows if ends.get(row, -1.0) < start)
        ends[row] = start + width
        placed.append((x, text, colour, row))
    return placed


def _line(x1: float, y1: float, x2: float, y2: float, colour: str, width: float) -> str:
    place = f'x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"'
    return f'<line {place} stroke="{colour}" stroke-width="{width:g}"/>'


def _reach(row: int, line: float) -> float:
    """Where the tick of a mark meets its name."""
    return line - 14.0 - _ROW * (row - 1) if row > 0 else line + 14.0 - _ROW * (row + 1)


def _tick(x: float, colour: str, row: int, line: float) -> str:
    return _line(x, line - 14.0, x, line + 14.0, colour, 2.5) + _line(x, line, x, _reach(row, line), colour, 1.0)


def _name(x: float, text: str, colour: str, row: int, line: float) -> str:
    y = _reach(row, line) + (-8.0 if row > 0 else 20.0)
    width = _LETTER * len(text)
    anchor = "start" if x < 0.5 * width else "end" if x > _WIDTH - 0.5 * width else "middle"
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{escape(text)}</text>'
