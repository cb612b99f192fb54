"""Drawing of an estimate on a scale with its reference levels."""

from __future__ import annotations

import math
from html import escape

from tierod.core.findings import Estimate
from tierod.core.shown import shown
from tierod.report.charts.figure import BLUE, GREY, PAPER, level_colour
from tierod.report.display import INTERVAL, interval, number, words

_WIDTH, _MARGIN, _ROW = 640.0, 14.0, 26.0
_LETTER = 13.0  # Width of a letter on the narrowest screen, for which labels are placed without overlap


def gauge(estimate: Estimate) -> str:
    """SVG drawing; "" without a value or without levels."""
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
    parts = [_line(_MARGIN, line, _WIDTH - _MARGIN, line, GREY, 6.0)]
    parts += [_mark(*mark, line) for mark in marks]
    parts.append(_line(at(value - half), line, at(value + half), line, BLUE, 6.0))
    parts.append(
        f'<circle cx="{at(value):.1f}" cy="{line:.0f}" r="8" fill="{BLUE}" stroke="{PAPER}" stroke-width="2"/>'
    )
    size = f"0 0 {_WIDTH:.0f} {line + 22.0 + _ROW * below:.0f}"
    scale = ", ".join(text for _, text, _, _ in marks)
    middle, lower, upper, _ = interval(estimate)
    title = escape(f"{middle} {label} (95 % interval {lower} to {upper}) on a scale with {scale} {label}")
    return f'<svg class="gauge" viewBox="{size}" role="img" aria-label="{title}">{"".join(parts)}</svg>'


def _placed(marks: list[tuple[float, str, str]]) -> list[tuple[float, str, str, int]]:
    """Marks with their rows: 1, 2, ... above the line, -1, -2, ... below it, each in the nearest free row."""
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


def _mark(x: float, text: str, colour: str, row: int, line: float) -> str:
    reach = line - 14.0 - _ROW * (row - 1) if row > 0 else line + 14.0 - _ROW * (row + 1)
    y, half = reach + (-8.0 if row > 0 else 20.0), 0.5 * _LETTER * len(text)
    anchor = "start" if x < half else "end" if x > _WIDTH - half else "middle"
    return (
        _line(x, line - 14.0, x, line + 14.0, colour, 2.5)
        + _line(x, line, x, reach, colour, 1.0)
        + f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{escape(text)}</text>'
    )
