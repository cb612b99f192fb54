"""The web application: endpoints of a workbench, the page, and errors as sentences."""

from __future__ import annotations

import hashlib
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlencode

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import HTMLResponse, JSONResponse, Response
from starlette.exceptions import HTTPException

from tierod.core.errors import TierodError
from tierod.core.statuses import SEVERITY
from tierod.core.version import __version__
from tierod.report.html import TEMPLATES
from tierod.web.endpoints import fleet_endpoints, recording_endpoints, work_endpoints
from tierod.web.errors import status_of
from tierod.web.guard import SAFE, BodyTooLong, Guard, Trust
from tierod.web.relay import Relay, live_endpoint
from tierod.web.workbench import Workbench


def application(bench: Workbench, trust: Trust, relay: Relay | None = None) -> Guard:
    """The complete server as an ASGI application."""

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        if relay is not None:
            await relay.begin()
        yield
        if relay is not None:
            await relay.end()

    app = FastAPI(
        title="tierod",
        version=__version__,
        description="Recordings, vehicles, fleets and live buses; the functions of `tierod.web.workbench.Workbench`.",
        openapi_url="/api/openapi.json",
        docs_url=None,
        redoc_url=None,
        lifespan=lifespan,
        redirect_slashes=False,
    )
    app.include_router(work_endpoints(bench))
    app.include_router(recording_endpoints(bench))
    app.include_router(fleet_endpoints(bench))
    app.include_router(live_endpoint(relay))
    page(app)
    _errors(app)
    return Guard(app, trust)


def _errors(app: FastAPI) -> None:
    @app.exception_handler(TierodError)
    async def ours(_: Request, error: TierodError) -> Response:
        return problem(status_of(error), " ".join(str(error).split()))

    @app.exception_handler(RequestValidationError)
    async def not_valid(_: Request, error: RequestValidationError) -> Response:
        first = error.errors()[0] if error.errors() else {"loc": (), "msg": "it cannot be read"}
        place = ".".join(str(part) for part in first["loc"][1:])[:100]
        return problem(422, f"the request is not valid: {place}: {str(first['msg'])[:200]}".replace(": :", ":"))

    @app.exception_handler(HTTPException)
    async def of_http(request: Request, error: HTTPException) -> Response:
        if (
            error.status_code == 404
            and request.method in SAFE
            and not request.url.path.startswith(("/api/", "/static/"))
        ):
            return HTMLResponse(files().html, 404)  # the page selects the view, and shows that there is none here
        words = {404: "there is nothing at this address; begin at /", 405: "this address does not take that method"}
        return problem(error.status_code, words.get(error.status_code, str(error.detail)[:300]))

    @app.exception_handler(BodyTooLong)
    async def too_long(_: Request, __: BodyTooLong) -> Response:
        return problem(413, "the request is too long; give a smaller file, or its path")

    @app.exception_handler(OSError)
    async def of_the_system(_: Request, error: OSError) -> Response:
        return problem(
            409, f"a file cannot be read or written ({(error.strerror or 'unknown reason').lower()}); try again"
        )

    @app.exception_handler(Exception)
    async def defect(_: Request, error: Exception) -> Response:
        return problem(500, f"a defect of tierod itself: {type(error).__name__}; please report it")


def problem(status: int, sentence: str) -> Response:
    """An error as a JSON response."""
    content: dict[str, Any] = {"error": sentence.encode("utf-8", "replace").decode()}
    return JSONResponse(content, status_code=status)


STATIC = Path(__file__).parent / "static"
COLOURS = TEMPLATES / "tokens.css"  # Colours of all pages, including reports

VIEWS = ("", "recording", "vehicle", "fleet", "live", "new", "scenario", "jobs", "interface")
"""Paths that return the page; the page itself selects the view."""

KINDS = {".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml"}

FOREVER = "public, max-age=31536000, immutable"


class Files(NamedTuple):
    """The files of the page."""

    content: dict[str, bytes]
    digest: str
    html: str  # the page itself, whose addresses contain the digest


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
