"""Common parts of all pages: templates, style, charting library, packed series, and preparation of texts."""

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
from tierod.core.statuses import Status
from tierod.core.version import __version__
from tierod.report.charts.figure import Figure, drawn_from
from tierod.report.charts.study import study_figure
from tierod.report.glossary import Glossary
from tierod.report.packing import heads

TEMPLATES = Path(__file__).parent / "templates"

SCRIPTS = ("tips.js", "series.js", "csv.js", "report.js")
"""Scripts of a page with charts; a page without charts has only the first one."""

SHORTEST = 3
"""Number of sections from which on a page has a table of contents."""

UNFOLDED = 8
"""Number of charts of a page that are open at first; each further one is folded under its title."""

LIBRARY = "plotly-cartesian.min.js.gz"
"""Part of plotly.js for two-dimensional charts, a third of the whole library."""


@cache
def template(name: str | Path) -> Any:
    """Jinja template of a page, by its file name, or by its path in another package."""
    import jinja2

    path = Path(name)
    loader = jinja2.FileSystemLoader([TEMPLATES, path.parent])
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
    return environment.get_template(path.name)


@dataclass(frozen=True)
class Origin:
    """Origin of a page.

    Args:
        created, version, command: time of creation, version of tierod, and command line
    """

    created: str = ""
    version: str = ""
    command: str = ""

    @classmethod
    def now(cls, command: str = "") -> Origin:
        """Origin of a page created now by this version."""
        return cls(datetime.now(UTC).isoformat(timespec="seconds"), __version__, command)


@dataclass
class Section:
    """A section of a page.

    Args:
        title, text: heading and paragraphs
        parts: contents below them as (kind, content); kinds are chart, table, facts and verdict
        kind: CSS class of a section with a verdict; "" for any other section
    """

    title: str
    text: tuple[str, ...]
    parts: list[tuple[str, Any]] = field(default_factory=list)
    kind: str = ""


class Looks(NamedTuple):
    """Appearance of the first verdict of a page: symbol, CSS class and status word."""

    symbol: str
    kind: str
    status: str

    @classmethod
    def of(cls, status: Status) -> Looks:
        """Appearance of the status of a verdict."""
        return cls(status.symbol, status.colour, str(status))


def rendered(
    name: str | Path,
    origin: Origin,
    figures: Sequence[Figure] = (),
    packed: Mapping[str, Packed] | None = None,
    /,
    *,
    sections: Sequence[Section] = (),
    **content: Any,
) -> str:
    """HTML text of a self-contained page."""
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
    """Sections made of items, one per heading; claims are left out because they are shown elsewhere."""
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
    """Charting library, compressed and encoded for embedding, so that the page opens without a network connection."""
    return base64.b64encode((Path(__file__).parent / "library" / LIBRARY).read_bytes()).decode("ascii")


def chart_script(figure: Figure, packed: Collection[str] = ()) -> str:
    data = [
        _without_points(mark) if drawn_from(mark) and drawn_from(mark) <= set(packed) else mark for mark in figure.data
    ]
    return script_json({"name": figure.name, "timed": figure.timed, "data": data, "layout": figure.layout})


def _without_points(mark: Mapping[str, object]) -> dict[str, Any]:
    points = ("x", "z", "text") if mark["type"] == "heatmap" else ("x", "y")
    return {key: value for key, value in mark.items() if key not in points}


def script_json(content: object) -> str:
    # A "<" inside a name must not end the script element.
    return json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def moment(text: str) -> str:
    """A time stamp in readable form; any other text unchanged."""
    try:
        when = datetime.fromisoformat(text)
    except ValueError:
        return text
    return f"{when:%Y-%m-%d %H:%M} {when.tzname() or ''}".strip()


def breakable(value: object) -> Any:
    """Text with optional line breaks after the separators of paths and of signal names."""
    import markupsafe

    # The marks are set before escaping, as a character that escaping never produces.
    marked = re.sub(r"([/_]|\.(?=[A-Za-z]))(?=\w)", "\\1\0", str(value))
    return markupsafe.Markup(str(markupsafe.escape(marked)).replace("\0", "<wbr>"))


def anchored(body: str) -> tuple[list[tuple[str, Any]], Any]:
    """(identifier and title of every section, body with these identifiers); no titles if there are few sections."""
    import markupsafe

    titles: list[tuple[str, Any]] = []

    def marked(heading: re.Match[str]) -> str:
        titles.append((f"part-{len(titles) + 1}", markupsafe.Markup(re.sub(r"<[^>]*>", "", heading[1]))))
        return f'<h2 id="{titles[-1][0]}">{heading[1]}</h2>'

    found = markupsafe.Markup(re.sub(r"<h2>(.*?)</h2>", marked, str(body), flags=re.DOTALL))
    return (titles if len(titles) >= SHORTEST else []), found
