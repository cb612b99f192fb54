"""The estimate on a scale with its interval and the levels it is judged against, as a drawing in the page."""

from __future__ import annotations

import math
from html import escape

from tierod.findings import Estimate
from tierod.report.charts.figure import BLUE, level_colour
from tierod.report.display import INTERVAL, interval, number, shown, words

_WIDTH, _HEIGHT, _LEFT, _RIGHT, _LINE = 640, 96, 14, 626, 50


def gauge(estimate: Estimate) -> str:
    """An SVG drawing; empty where there is no value or nothing to compare it with."""
    factor, label = shown(estimate.unit)
    levels = [(name, value * factor) for name, value in estimate.reference.items() if math.isfinite(value)]
    value, half = estimate.value * factor, INTERVAL * estimate.standard_deviation * factor
    if not levels or not math.isfinite(value):
        return ""
    half = half if math.isfinite(half) else 0.0
    high = 1.15 * max([value + half, *(level for _, level in levels)])
    low = min(0.0, 1.15 * (value - half))

    def at(position: float) -> float:
        return _LEFT + (_RIGHT - _LEFT) * (position - low) / (high - low)

    parts = [_bar(_LEFT, _RIGHT, 6, "#94a3b8")]
    parts += [_mark(at(level), words(name).lower(), number(level, 3), row) for row, (name, level) in _rows(levels, at)]
    parts.append(_bar(at(value - half), at(value + half), 6, BLUE))
    parts.append(f'<circle cx="{at(value):.1f}" cy="{_LINE}" r="8" fill="{BLUE}" stroke="white" stroke-width="2"/>')
    middle, lower, upper, _ = interval(estimate)
    told = ", ".join(f"{words(name).lower()} {number(level, 3)}" for name, level in levels)
    title = escape(f"{middle} {label} (95 % interval {lower} to {upper}) on a scale with {told} {label}")
    return f'<svg class="gauge" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{title}">{"".join(parts)}</svg>'


def _bar(start: float, stop: float, width: float, colour: str) -> str:
    place = f'x1="{start:.1f}" y1="{_LINE}" x2="{stop:.1f}" y2="{_LINE}"'
    return f'<line {place} stroke="{colour}" stroke-width="{width}"/>'


def _rows(levels, at):
    """Levels from left to right, each above or beneath the line in turn, so that names of near ones do not collide."""
    ordered = sorted(levels, key=lambda each: each[1])
    return [(index % 2, each) for index, each in enumerate(ordered)]


def _mark(x: float, name: str, value: str, row: int) -> str:
    colour = level_colour(name)
    y = _LINE - 22 if row == 0 else _LINE + 36
    anchor = "start" if x < 90 else "end" if x > _WIDTH - 90 else "middle"
    return (
        f'<line x1="{x:.1f}" y1="{_LINE - 15}" x2="{x:.1f}" y2="{_LINE + 15}" stroke="{colour}" stroke-width="2.5"/>'
        f'<text x="{x:.1f}" y="{y}" text-anchor="{anchor}" fill="{colour}">{escape(name)} {value}</text>'
    )
