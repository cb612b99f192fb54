"""Common parts of all pages: templates, style, the charting library, packed series, and text made fit for them."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from tierod.core.content import Chart, Heading, Item, Table
from tierod.core.decimation import Packed
from tierod.core.version import __version__
from tierod.report.charts.figure import Figure, drawn_from
from tierod.report.charts.study import study_figure
from tierod.report.glossary import Glossary
from tierod.report.packing import heads

TEMPLATES = Path(__file__).parent / "templates"

SCRIPTS = ("tips.js", "series.js", "csv.js", "report.js")
"""Of a page with charts; the first one of any page."""

SHORTEST = 3
"""Parts of a page from which it has a list of contents."""

UNFOLDED = 8
"""Charts of a page that are shown at once; each further one unfolds under its title."""

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
    environment.filters |= {
        "breakable": breakable,
        "anchored": anchored,
        "explained": jinja2.pass_context(lambda page, text: page["glossary"].link(text)),
        "status": jinja2.pass_context(lambda page, text: page["glossary"].status(text)),
        "reading": jinja2.pass_context(lambda page, figure: page["glossary"].chart(figure)),
    }
    return environment.get_template(name)


@dataclass(frozen=True)
class Origin:
    """Origin of a page.

    Args:
        created, version, command: when, by which version, and how
    """

    created: str = ""
    version: str = ""
    command: str = ""

    @classmethod
    def now(cls, command: str = "") -> Origin:
        """Origin of a page made now by this version."""
        return cls(datetime.now(UTC).isoformat(timespec="seconds"), __version__, command)


@dataclass
class Section:
    """A part of a page.

    Args:
        title, text: heading and paragraphs
        parts: what stands below them, each with its kind: chart, table, facts or verdict
        kind: class of the page of a verdict; empty for any other part
    """

    title: str
    text: tuple[str, ...]
    parts: list[tuple[str, Any]] = field(default_factory=list)
    kind: str = ""


class Looks(NamedTuple):
    """Looks of the first verdict of a page: its sign, the class of its colour, and its word."""

    symbol: str
    kind: str
    status: str


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
    scripts = SCRIPTS if charts else SCRIPTS[:1]
    text: str = template(name).render(
        {
            "style": _read("tokens.css", "report.css"),
            "script": _read(*scripts),
            "glossary": Glossary(),
            "folded": {figure.name for figure in charts[UNFOLDED:]},
            "origin": origin,
            "created": moment(origin.created),
            "looks": None,
            "remarks": (),
            "not_good_for": (),
            "sections": sections,
            "charts": [chart_script(figure, packed or {}) for figure in charts],
            "series": script_json(heads(packed or {})),
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


def _read(*names: str) -> str:
    return "".join((TEMPLATES / name).read_text(encoding="utf-8") for name in names)


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


def anchored(body: str) -> tuple[list[tuple[str, Any]], Any]:
    """(identifier and title of every part, the body with those identifiers); no list where it would be short."""
    import markupsafe

    titles: list[tuple[str, Any]] = []

    def marked(heading: re.Match[str]) -> str:
        titles.append((f"part-{len(titles) + 1}", markupsafe.Markup(re.sub(r"<[^>]*>", "", heading[1]))))
        return f'<h2 id="{titles[-1][0]}">{heading[1]}</h2>'

    found = markupsafe.Markup(re.sub(r"<h2>(.*?)</h2>", marked, str(body), flags=re.DOTALL))
    return (titles if len(titles) >= SHORTEST else []), found
