"""Compiler of pages: items and charts over time become one self-contained page with style, script and series."""

from __future__ import annotations

import base64
import hashlib
import heapq
import json
import re
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from tierod.core.content import Chart, Facts, Fold, Heading, Item, Table, Verdict
from tierod.core.decimation import Packed, coarser, pack
from tierod.core.findings import Trace
from tierod.core.graph import compiler
from tierod.core.signals import SIGNALS
from tierod.core.version import __version__
from tierod.report.charts.figure import Figure, drawn_from, gauge
from tierod.report.charts.panels import panel_figure
from tierod.report.display import interval
from tierod.report.glossary import Glossary

TEMPLATES = Path(__file__).parent / "templates"

# Scripts of a page with charts; a page without charts has only the first one
SCRIPTS = ("tips.js", "series.js", "csv.js", "report.js")

SHORTEST = 3  # Number of sections from which on a page has a table of contents
UNFOLDED = 8  # Number of charts of a page that are open at first; each further one is folded under its title
LIBRARY = "plotly-cartesian.min.js.gz"  # Part of plotly.js for two-dimensional charts, a third of the whole library

# Characters available for all series of a page, which keeps the page with its charting library below 2 MB
BUDGET = 900_000

LEAST = 2000  # Smallest number of bins of a series, as many as a chart of the whole recording draws

# Bits per value: recorded signals are noise below 1/4000 of their range, estimates settle within a small part
RECORDED, COMPUTED = 12, 16


@dataclass(frozen=True)
class Origin:
    """Time of creation, version of tierod and command line of a page."""

    created: str = ""
    version: str = ""
    command: str = ""

    @classmethod
    def now(cls, command: str = "") -> Origin:
        return cls(datetime.now(UTC).isoformat(timespec="seconds"), __version__, command)


@dataclass
class _Section:
    title: str = ""
    text: tuple[str, ...] = ()
    look: str = ""
    verdict: Verdict | None = None
    parts: list[tuple[str, Any]] = field(default_factory=list)


def page(
    items: Iterable[Item | Figure],
    origin: Origin,
    title: str,
    about: str,
    traces: Mapping[str, Trace] | None = None,
    came: Sequence[Item] = (),
) -> str:
    found = _sections(items)
    drawn = [figure for figure, _ in _charts(found)]
    marks = (mark for figure in drawn for mark in figure.data)
    packed = packed_series(traces or {}, sorted(set().union(*map(drawn_from, marks))))
    text: str = _template().render(
        style=_read("tokens.css", "report.css"),
        script=_read(*(SCRIPTS if drawn else SCRIPTS[:1])),
        glossary=Glossary(),
        folded={figure.name for figure, inside in _charts(found)[UNFOLDED:] if not inside},
        origin=origin,
        created=moment(origin.created),
        window=title,
        about=about,
        sections=found,
        came=_sections(came),
        charts=[_chart_script(figure, packed) for figure in drawn],
        series=script_json(heads(packed)),
        library=base64.b64encode((Path(__file__).parent / "library" / LIBRARY).read_bytes()).decode() if drawn else "",
    )
    return text


@dataclass(frozen=True)
class Analysis:
    """Result of an analysis, for terminal, page and JSON document."""

    title: str
    summary: tuple[str, ...]  # paragraphs with the main results
    items: Sequence[Item]  # headings, tables and charts in order; the terminal shows the tables
    document: Mapping[str, Any]  # the results as data in SI units, for JSON
    remarks: tuple[str, ...] = ()

    @property
    def head(self) -> Verdict:
        return Verdict(self.title, text=self.summary, reasons=tuple(("To know", each) for each in self.remarks))


def render_analysis(
    analysis: Analysis,
    facts: Sequence[tuple[str, str]],
    origin: Origin,
    not_good_for: Sequence[str] = (),
    kind: str = "analysis",
) -> str:
    """HTML page of an analysis, with its boundary conditions; `kind` is the kind of page, in one word."""
    unfit = [("not good for", "; ".join(not_good_for))] if not_good_for else []
    items = [analysis.head, Facts([*facts, *unfit]), *analysis.items]
    return page(items, origin, analysis.title, kind)


def _sections(items: Iterable[Item | Figure]) -> list[_Section]:
    """Sections made of items; claims are left out because a study shows them elsewhere."""
    found = [_Section()]
    for item in items:
        if isinstance(item, Verdict):
            colour = f"verdict {item.status.colour}" if item.status is not None else ""
            found.append(_Section(look=colour, verdict=item))
        elif isinstance(item, Heading):
            found.append(_Section(item.title, item.text, item.look))
        elif (part := _part(item)) is not None:
            found[-1].parts.append(part)
    return [each for each in found if each.title or each.verdict or each.parts]


def _part(item: Item | Figure) -> tuple[str, Any] | None:
    match item:
        case Figure():
            return "chart", item
        case Chart():
            return "chart", panel_figure(item)
        case Table() | Facts():
            return type(item).__name__.lower(), item
        case Fold():
            return "fold", replace(item, items=[part for each in item.items if (part := _part(each)) is not None])
    return None


def _charts(sections: Sequence[_Section]) -> list[tuple[Figure, bool]]:
    def of(parts: Sequence[tuple[str, Any]], inside: bool) -> Iterator[tuple[Figure, bool]]:
        for kind, part in parts:
            if kind == "chart":
                yield part, inside
            elif kind == "fold":
                yield from of(part.items, True)

    return [each for section in sections for each in of(section.parts, False)]


def _compiled_templates() -> Any:
    """Cache of templates compiled by earlier processes, among the kernels: compiling one takes as long as a drive."""
    import jinja2

    class Compiled(jinja2.BytecodeCache):
        def load_bytecode(self, bucket: Any) -> None:
            if (found := compiler.kept(_entry(bucket))) is not None:
                bucket.bytecode_from_string(found)

        def dump_bytecode(self, bucket: Any) -> None:
            compiler.keep(_entry(bucket), bucket.bytecode_to_string())

    def _entry(bucket: Any) -> str:
        # The compiler of templates may apply a filter to a constant: the sources of the filters belong to the name.
        sources = b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.rglob("*.py")))
        parts = (jinja2.__version__, sys.version, bucket.key, bucket.checksum, hashlib.sha256(sources).hexdigest())
        return f"page-{hashlib.sha256(' '.join(parts).encode()).hexdigest()[:24]}"

    return Compiled()


@cache
def _template() -> Any:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        bytecode_cache=_compiled_templates(),
    )
    environment.filters |= {
        "breakable": breakable,
        "anchored": anchored,
        "sentence": sentence,
        "gauge": gauge,
        "interval": interval,
        "explained": jinja2.pass_context(lambda page, text: page["glossary"].link(text)),
        "status": jinja2.pass_context(lambda page, text: page["glossary"].status(text)),
        "reading": jinja2.pass_context(lambda page, figure: page["glossary"].chart(figure)),
    }
    return environment.get_template("page.html.j2")


def _read(*names: str) -> str:
    return "".join((TEMPLATES / name).read_text(encoding="utf-8") for name in names)


def _chart_script(figure: Figure, packed: Collection[str]) -> str:
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


def packed_series(traces: Mapping[str, Trace], names: Iterable[str], budget: int = BUDGET) -> dict[str, Packed]:
    """Pack the named traces; the largest are coarsened until all fit, and traces that cannot be packed are left out."""
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


def heads(packed: Mapping[str, Packed]) -> dict[str, dict[str, object]]:
    """Packed traces as JSON content for the script of the page."""
    names = ("start", "width", "count", "lowest", "step")
    return {
        key: {name: getattr(each, name) for name in names} | {"data": base64.b64encode(each.data).decode("ascii")}
        for key, each in packed.items()
    }


def _pack(trace: Trace, step: int) -> Packed | None:
    return pack(coarser(trace, step), RECORDED if trace.name in SIGNALS else COMPUTED)


def _size(packed: Packed) -> int:
    return 4 * len(packed.data) // 3


def moment(text: str) -> str:
    """A time stamp in readable form; any other text unchanged."""
    try:
        when = datetime.fromisoformat(text)
    except ValueError:
        return text
    return f"{when:%Y-%m-%d %H:%M} {when.tzname() or ''}".strip()


def sentence(text: str) -> str:
    """Text with initial capital and full stop, and with non-breaking spaces between numbers and units."""
    text = re.sub(r"(?<=[\d±]) (?=N·m|km/h|m/s|Hz|[%°±]|(?<=± )\d)", "\N{NO-BREAK SPACE}", text.strip())
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith(('.', '!', '?')) else '.'}" if text else ""


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
