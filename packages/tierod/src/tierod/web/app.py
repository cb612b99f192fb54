"""The web application: endpoints of a workbench, the page, and errors as sentences."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import HTMLResponse, JSONResponse, Response
from starlette.exceptions import HTTPException

from tierod.core.errors import TierodError
from tierod.core.version import __version__
from tierod.web.endpoints import fleet_endpoints, recording_endpoints, work_endpoints
from tierod.web.errors import status_of
from tierod.web.guard import SAFE, BodyTooLong, Guard, Trust
from tierod.web.page import files, page
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
    """Register handlers that turn every error into a sentence in JSON."""

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
