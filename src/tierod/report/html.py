"""What all pages share: templates, style, the charting library, packed series, and text made fit for them."""

from __future__ import annotations

import base64
import heapq
import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from tierod import __version__
from tierod.core.content import Chart, Heading, Item, Table
from tierod.core.decimation import Packed, coarser, pack
from tierod.core.findings import Trace
from tierod.core.signals import SIGNALS
from tierod.report.charts.figure import Figure, drawn_from
from tierod.report.charts.study import study_figure

TEMPLATES = Path(__file__).parent / "templates"

LIBRARY = "plotly-cartesian.min.js.gz"
"""The part of plotly.js that draws in a plane, a third of the whole."""


@cache
def template(name: str) -> Any:
    """The jinja template of a page, by the name of its file."""
    import jinja2

    loader = jinja2.FileSystemLoader(TEMPLATES)
    environment = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["breakable"] = breakable
    return environment.get_template(name)


@dataclass(frozen=True)
class Origin:
    """How a page came about.

    Args:
        created, version, command: when, by which version, and how
    """

    created: str = ""
    version: str = ""
    command: str = ""

    @classmethod
    def now(cls, command: str = "") -> Origin:
        """Of what is made at this moment by this version."""
        return cls(datetime.now(UTC).isoformat(timespec="seconds"), __version__, command)


@dataclass
class Section:
    """A part of a page: heading, paragraphs, and the tables and charts below it, each with its kind."""

    title: str
    text: tuple[str, ...]
    parts: list[tuple[str, Any]] = field(default_factory=list)


def rendered(
    name: str,
    origin: Origin,
    figures: Sequence[Figure] = (),
    packed: Mapping[str, Packed] | None = None,
    /,
    *,
    sections: Sequence[Section] = (),
    **content: Any,
) -> str:
    """A page as text, all in one file.

    Args:
        name: of its template
        origin: how it came about
        figures: its charts, in the order of the page
        packed: series that it holds packed, from which its script draws
        sections: parts with further charts
        content: what else the template takes
    """
    charts = [*figures, *(part for section in sections for kind, part in section.parts if kind == "chart")]
    text: str = template(name).render(
        {
            "style": (TEMPLATES / "report.css").read_text(encoding="utf-8"),
            "script": "".join((TEMPLATES / name).read_text(encoding="utf-8") for name in ("series.js", "report.js")),
            "origin": origin,
            "created": moment(origin.created),
            "sections": sections,
            "charts": [chart_script(figure, packed or {}) for figure in charts],
            "series": series_script(packed or {}),
            "library": library() if charts else "",
        }
        | content
    )
    return text


def sections(items: Sequence[Item]) -> list[Section]:
    """The items after their headings; claims stand elsewhere."""
    found = [Section("", ())]
    for item in items:
        if isinstance(item, Heading):
            found.append(Section(item.title, item.text))
        elif isinstance(item, Table):
            found[-1].parts.append(("table", item))
        elif isinstance(item, Chart):
            figure: Figure = study_figure(item)
            found[-1].parts.append(("chart", figure))
    return [section for section in found if section.title or section.parts]


def library() -> str:
    """The charting library, packed, which goes into the page: it opens without network."""
    return base64.b64encode((Path(__file__).parent / "library" / LIBRARY).read_bytes()).decode("ascii")


def chart_script(figure: Figure, packed: Collection[str] = ()) -> str:
    """A chart as the JSON that the page's script draws.

    Args:
        figure: the chart
        packed: names of the series that the page holds packed, whose points the chart need not hold
    """
    data = [
        _without_points(mark) if drawn_from(mark) and drawn_from(mark) <= set(packed) else mark for mark in figure.data
    ]
    return script_json({"name": figure.name, "timed": figure.timed, "data": data, "layout": figure.layout})


def _without_points(mark: Mapping[str, object]) -> dict[str, Any]:
    points = ("x", "z", "text") if mark["type"] == "heatmap" else ("x", "y")
    return {key: value for key, value in mark.items() if key not in points}


def script_json(content: object) -> str:
    """Content as JSON that may stand in a script element."""
    # A "<" in the text of a name must not end the script element that holds it.
    return json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def moment(text: str) -> str:
    """A time stamp as people write it; the text itself where it is none."""
    try:
        when = datetime.fromisoformat(text)
    except ValueError:
        return text
    return f"{when:%Y-%m-%d %H:%M} {when.tzname() or ''}".strip()


def breakable(value: object) -> Any:
    """The text with places at which a line may end: after the separators of paths and of names in recordings."""
    import markupsafe

    # Marked before escaping, by a character that no escape holds.
    marked = re.sub(r"([/_]|\.(?=[A-Za-z]))(?=\w)", "\\1\0", str(value))
    return markupsafe.Markup(str(markupsafe.escape(marked)).replace("\0", "<wbr>"))


BUDGET = 900_000
"""Characters of all series of a page; with the charting library and all else it stays below 2 MB."""

LEAST = 2000
"""Bins that every series keeps: as many as a chart of the whole recording draws."""

RECORDED, COMPUTED = 12, 16
"""Bits of a value: what was recorded is noise beyond a 4000th of its range, estimates settle on a small part of it."""


def packed_series(traces: Mapping[str, Trace], names: Iterable[str], budget: int = BUDGET) -> dict[str, Packed]:
    """The named traces packed; the largest are made coarser until all fit, and what cannot be packed is left out.

    Args:
        traces: of a diagnosis
        names: of those that its charts draw
        budget: characters that they may take in the page
    """
    packed = {name: each for name in names if (each := _pack(traces[name], 1)) is not None}
    steps = dict.fromkeys(packed, 1)
    largest = [(-_size(each), name) for name, each in packed.items() if each.count > LEAST]
    heapq.heapify(largest)
    total = sum(map(_size, packed.values()))
    while total > budget and largest:
        size, name = heapq.heappop(largest)
        steps[name] *= 2
        each = packed[name] = _pack(traces[name], steps[name]) or packed[name]
        total += size + _size(each)
        if each.count > LEAST:
            heapq.heappush(largest, (-_size(each), name))
    return packed


def series_script(packed: Mapping[str, Packed]) -> str:
    """The packed traces as the JSON that the page's script unpacks."""
    return script_json(
        {
            name: {
                "start": each.start,
                "width": each.width,
                "count": each.count,
                "lowest": each.lowest,
                "step": each.step,
                "data": base64.b64encode(each.data).decode("ascii"),
            }
            for name, each in packed.items()
        }
    )


def _pack(trace: Trace, step: int) -> Packed | None:
    return pack(coarser(trace, step), RECORDED if trace.name in SIGNALS else COMPUTED)


def _size(packed: Packed) -> int:
    """Characters that a packed trace takes in the page."""
    return 4 * len(packed.data) // 3
