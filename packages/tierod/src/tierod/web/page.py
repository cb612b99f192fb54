"""The files of the page, without user data; browsers cache them under the digest of their content."""

from __future__ import annotations

import hashlib
import json
from functools import cache
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlencode

from fastapi import FastAPI, Request
from fastapi.responses import HTMLResponse, Response
from starlette.exceptions import HTTPException

from tierod.core.statuses import SEVERITY
from tierod.report.html import TEMPLATES

STATIC = Path(__file__).parent / "static"
COLOURS = TEMPLATES / "tokens.css"
"""Colours of all pages, including reports."""

VIEWS = ("", "recording", "vehicle", "fleet", "live", "new", "scenario", "jobs", "interface")
"""Paths that return the page; the page itself selects the view."""

KINDS = {".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml"}

FOREVER = "public, max-age=31536000, immutable"


class Files(NamedTuple):
    """The files of the page.

    Args:
        content: content of every file, by its name
        digest: digest of all files
        html: the page itself, whose addresses contain the digest
    """

    content: dict[str, bytes]
    digest: str
    html: str


@cache
def files() -> Files:
    """The files as they are at the first call."""
    paths = {path.relative_to(STATIC).as_posix(): path for path in STATIC.rglob("*") if path.suffix in KINDS}
    paths[COLOURS.name] = COLOURS
    content = {name: path.read_bytes() for name, path in sorted(paths.items())}
    content["statuses.js"] = _statuses().encode()
    index = (STATIC / "index.html").read_text(encoding="utf-8")
    whole = hashlib.sha256(index.encode())
    for name, each in content.items():
        whole.update(f"\0{name}\0{len(each)}\0".encode() + each)
    digest = whole.hexdigest()[:16]
    return Files(content, digest, index.replace("/static/", f"/static/{digest}/"))


def _statuses() -> str:
    """Module with colour and symbol of every status of a verdict and of a car, so that the page has no own table."""
    from tierod.fleet.ranking import WORDS
    from tierod.fleet.report_words import LOOKS

    table = {WORDS[urgency]: (colour, symbol) for urgency, (symbol, colour) in LOOKS.items()}
    table |= {status.value: (status.colour, status.symbol) for status in SEVERITY}
    return f"export const STATUSES = {json.dumps(table, ensure_ascii=False)};\n"


def page(app: FastAPI) -> None:
    """Add the routes of the page."""
    found = files()

    @app.get("/static/{name:path}", include_in_schema=False)
    async def static(name: str, request: Request) -> Response:
        lasting = name.startswith(f"{found.digest}/")
        name = name.removeprefix(f"{found.digest}/")
        if name not in found.content:
            raise HTTPException(404, f"there is no '{name[:100]}'")
        tag = f'"{found.digest}"'
        headers = {"cache-control": FOREVER if lasting else "no-cache", "etag": tag}
        if request.headers.get("if-none-match") == tag:
            return Response(status_code=304, headers=headers)
        return Response(found.content[name], media_type=KINDS[Path(name).suffix], headers=headers)

    async def view(request: Request) -> Response:
        return HTMLResponse(found.html.replace("</head>", f"{_early(request)}</head>"))

    for name in VIEWS:
        app.add_api_route(f"/{name}", view, methods=["GET", "HEAD"], include_in_schema=False)


def _early(request: Request) -> str:
    """Preload links for the first requests of the view, which the browser then sends while it reads the modules.

    They follow from the address alone, so that the page reveals nothing about the served data.
    """
    wanted = ["/api/site"]
    file = request.query_params.get("file", "")
    if request.url.path == "/recording" and 0 < len(file) <= 4096 and "report" not in request.query_params:
        # Encoded like URLSearchParams, since the browser compares addresses character by character.
        asked = urlencode({"file": file}, safe="*").replace("~", "%7E")
        wanted.append(f"/api/opened?{asked}")
    return "".join(f'<link rel="preload" as="fetch" crossorigin href="{each}">\n' for each in wanted)
