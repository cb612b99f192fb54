"""What all pages share: templates, style, the charting library, and text made fit for them."""

from __future__ import annotations

import json
import re
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

from tierod.report.charts.figure import Figure

TEMPLATES = Path(__file__).parent / "templates"


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


def looks() -> dict[str, str]:
    """Style and script of every page, as its template takes them."""
    return {
        "style": (TEMPLATES / "report.css").read_text(encoding="utf-8"),
        "script": (TEMPLATES / "report.js").read_text(encoding="utf-8"),
    }


def library() -> str:
    """The source of the charting library, which goes into the page: it opens without network."""
    from plotly.offline import get_plotlyjs

    return get_plotlyjs()


def chart_script(figure: Figure) -> str:
    """A chart as the JSON that the page's script draws."""
    content = {"name": figure.name, "timed": figure.timed, "data": figure.data, "layout": figure.layout}
    # A "<" in the text of a name must not end the script element that holds it.
    return json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def moment(text: str) -> str:
    """A time stamp as people write it; the text itself where it is none."""
    try:
        when = datetime.fromisoformat(text)
    except ValueError:
        return text
    return f"{when:%Y-%m-%d %H:%M} {when.tzname() or ''}".strip()


def breakable(value: Any) -> Any:
    """The text with places at which a line may end: after the separators of paths and of names in recordings."""
    import markupsafe

    # Marked before escaping, by a character that no escape holds.
    marked = re.sub(r"([/_]|\.(?=[A-Za-z]))(?=\w)", "\\1\0", str(value))
    return markupsafe.Markup(str(markupsafe.escape(marked)).replace("\0", "<wbr>"))
