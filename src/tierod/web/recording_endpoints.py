"""Endpoints of analysed recordings: signals, time spans, exports, findings, reports."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query
from fastapi.responses import FileResponse, HTMLResponse, Response
from starlette.background import BackgroundTask

from tierod.web import windows
from tierod.web.guard import REPORT_POLICY
from tierod.web.shapes import Curve, SeriesShape
from tierod.web.work_endpoints import PROBLEMS
from tierod.web.workbench import Workbench

Key = Annotated[str, Query(max_length=80)]
Names = Annotated[list[str], Query(max_length=64)]
Time = Annotated[float | None, Query(allow_inf_nan=False)]
Points = Annotated[int, Query(ge=10, le=windows.MOST_POINTS)]

FORMATS = {
    "csv": "text/csv; charset=utf-8",
    "parquet": "application/vnd.apache.parquet",
    "mf4": "application/octet-stream",
}


def recording_endpoints(bench: Workbench) -> APIRouter:
    """Endpoints of analysed recordings.

    Args:
        bench: the workbench to serve
    """
    router = APIRouter(prefix="/api", tags=["recordings"], responses=PROBLEMS)

    @router.get("/series/{key}")
    def series(key: str) -> SeriesShape:
        """The signals of a recording."""
        return bench.series(key)

    @router.get(
        "/series/{key}/window", response_class=Response, responses={200: {"content": {"application/octet-stream": {}}}}
    )
    def window(
        key: str, name: Names, result: Key = "", start: Time = None, stop: Time = None, points: Points = 1000
    ) -> Response:
        """Time spans of signals, as numbers in one binary packet (see `tierod.web.windows.packet`)."""
        found = windows.windows(bench.readers(key, result), name, start, stop, points)
        return Response(windows.packet(found), media_type="application/octet-stream")

    @router.get("/series/{key}/curves")
    def curves(
        key: str, name: Names, result: Key = "", start: Time = None, stop: Time = None, points: Points = 1000
    ) -> list[Curve]:
        """Time spans of signals, as lists for programs."""
        return windows.curves(windows.windows(bench.readers(key, result), name, start, stop, points))

    _exports(router, bench)
    _results(router, bench)
    return router


def _exports(router: APIRouter, bench: Workbench) -> None:
    @router.get("/series/{key}/export", response_class=FileResponse)
    def export(
        key: str,
        name: Names,
        result: Key = "",
        start: Time = None,
        stop: Time = None,
        kind: Annotated[str, Query(pattern="^(csv|parquet|mf4)$")] = "csv",
    ) -> Response:
        """Every sample of some signals over a time span, as a file."""
        handle, place = tempfile.mkstemp(prefix="tierod-export-", suffix=f".{kind}")
        os.close(handle)
        path = Path(place)
        try:
            windows.export(bench.readers(key, result), name, start, stop, path)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
        done = BackgroundTask(path.unlink, missing_ok=True)
        return FileResponse(path, media_type=FORMATS[kind], filename=f"tierod-export.{kind}", background=done)


def _results(router: APIRouter, bench: Workbench) -> None:
    @router.get("/results/{key}")
    def result(key: str) -> dict[str, Any]:
        """Findings of the monitors in a recording."""
        return bench.result(key)

    @router.get("/results/{key}/report/{monitor}", response_class=HTMLResponse)
    def report(key: str, monitor: str) -> Response:
        """The report of a monitor; it runs in a sandbox without access to this page."""
        return HTMLResponse(bench.report(key, monitor), headers={"content-security-policy": REPORT_POLICY})
