"""Endpoints of the server: files, uploads, jobs, scenarios, analysed recordings, fleets and vehicles."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import FileResponse, HTMLResponse, Response
from starlette.background import BackgroundTask
from starlette.requests import ClientDisconnect

from tierod.core.errors import InputError
from tierod.core.files import replacing
from tierod.core.plugins import part
from tierod.web import fleets
from tierod.web import series as signals
from tierod.web.errors import Absent
from tierod.web.guard import REPORT_POLICY
from tierod.web.jobs import Job
from tierod.web.shapes import (
    Analysed,
    Asked,
    ChosenScenario,
    FleetTable,
    JobShape,
    Opened,
    Problem,
    SeriesShape,
    SiteShape,
    State,
)
from tierod.web.site import Listing
from tierod.web.workbench import Workbench

Text = Annotated[str, Query(max_length=4096)]
Short = Annotated[str, Query(max_length=200)]

PROBLEMS: dict[int | str, dict[str, Any]] = {400: {"model": Problem}, 403: {"model": Problem}, 404: {"model": Problem}}

Key = Annotated[str, Query(max_length=80)]
Names = Annotated[list[str], Query(max_length=64)]
Time = Annotated[float | None, Query(allow_inf_nan=False)]
Points = Annotated[int, Query(ge=10, le=signals.MOST_POINTS)]

FORMATS = {
    "csv": "text/csv; charset=utf-8",
    "parquet": "application/vnd.apache.parquet",
    "mf4": "application/octet-stream",
}

HELD_BACK = ("rows", "bands", "cars")  # Parts of a fleet that separate endpoints return piece by piece


def work_endpoints(bench: Workbench) -> APIRouter:
    """Endpoints of files, uploads, jobs and scenarios."""
    router = APIRouter(prefix="/api", tags=["work"], responses=PROBLEMS)

    @router.get("/site")
    def site() -> SiteShape:
        """Description of the served site."""
        return bench.about

    @router.get("/files")
    def files(
        folder: Text = "",
        search: Short = "",
        sort: Annotated[str, Query(pattern="^(name|modified|bytes)$")] = "name",
        offset: Annotated[int, Query(ge=0, le=10**9)] = 0,
        count: Annotated[int, Query(ge=1, le=1000)] = 200,
    ) -> Listing:
        """Listing of a folder; no file is opened."""
        return bench.files(folder, search, sort, offset, count)

    @router.get("/opened")
    def opened(file: Text) -> Opened:
        """State of a recording, with its signals and findings if they are stored."""
        return bench.opened(file)

    @router.post("/analyses", status_code=202)
    def analyses(asked: Analysed) -> JobShape:
        """Analyse a recording."""
        return JobShape.of(bench.analyse(asked))

    @router.post("/proposals", status_code=202)
    def proposals(asked: Asked) -> JobShape:
        """Propose a channel map for a recording."""
        return JobShape.of(bench.propose(asked.file, asked.dbc))

    @router.post("/inspections", status_code=202)
    def inspections(asked: Asked) -> JobShape:
        """Examine the content of a recording, and the requirements of each monitor that it does not meet."""
        return JobShape.of(bench.inspect(asked))

    _uploads(router, bench)
    _jobs(router, bench)
    _scenarios(router, bench)
    return router


def _uploads(router: APIRouter, bench: Workbench) -> None:
    @router.post("/uploads", status_code=201)
    async def uploads(request: Request, name: Short) -> State:
        """Upload a recording; the body is the file."""
        path = bench.room(name)
        size = 0
        try:
            with replacing(path) as temporary, temporary.open("wb") as file:
                async for part in request.stream():
                    size += len(part)
                    file.write(part)
                if not size:
                    raise InputError("the upload is empty; choose a file")
        except ClientDisconnect:
            raise InputError("the upload broke off; send it again") from None
        return bench.state(f"uploads/{name}")


def _jobs(router: APIRouter, bench: Workbench) -> None:
    @router.get("/jobs")
    def jobs() -> list[JobShape]:
        """All jobs, the newest first."""
        return [JobShape.of(each) for each in bench.jobs.all()]

    @router.get("/jobs/{number}")
    def job(number: str) -> JobShape:
        """One job."""
        return JobShape.of(bench.jobs.job(number))

    @router.delete("/jobs/{number}")
    def cancel(number: str) -> JobShape:
        """Cancel a job."""
        return JobShape.of(bench.jobs.cancel(number))


def _scenarios(router: APIRouter, bench: Workbench) -> None:
    @router.get("/scenarios")
    def scenarios() -> dict[str, Any]:
        """Shipped cars, courses, faults and scenarios to choose from."""
        return dict(part("page", "a simulated drive").catalogue())

    @router.post("/scenarios", status_code=202)
    def simulate(chosen: ChosenScenario) -> JobShape:
        """Simulate a drive, and judge it."""
        return JobShape.of(bench.simulate(chosen))


def recording_endpoints(bench: Workbench) -> APIRouter:
    """Endpoints of analysed recordings."""
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
        """Time spans of signals, as numbers in one binary packet (see `tierod.web.series.packet`)."""
        found = signals.windows(bench.readers(key, result), name, start, stop, points)
        return Response(signals.packet(found), media_type="application/octet-stream")

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
            signals.export(bench.readers(key, result), name, start, stop, path)
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


def fleet_endpoints(bench: Workbench) -> APIRouter:
    router = APIRouter(prefix="/api", tags=["fleets"], responses=PROBLEMS)

    def loaded(name: str) -> dict[str, Any]:
        found = bench.fleet(name)
        if isinstance(found, Job):
            raise Absent("the fleet is being evaluated; ask again when its job is done")
        return found

    @router.get("/fleets/{name}")
    def fleet(name: str) -> dict[str, Any]:
        """Report on a fleet, or the job that computes it."""
        found = bench.fleet(name)
        if isinstance(found, Job):
            return {"job": JobShape.of(found).model_dump()}
        return {key: value for key, value in found.items() if key not in HELD_BACK}

    @router.get("/fleets/{name}/cars")
    def cars(
        name: str,
        search: Short = "",
        state: Short = "",
        cohort: Short = "",
        sort: Short = "rank",
        offset: Annotated[int, Query(ge=0, le=10**9)] = 0,
        count: Annotated[int, Query(ge=1, le=500)] = 100,
    ) -> FleetTable:
        """A part of the table of cars, by default the worst first."""
        rows = fleets.filtered(loaded(name)["rows"], search, state, cohort, sort)
        return FleetTable(total=len(rows), rows=[dict(row) for row in rows[offset : offset + count]])

    @router.get("/fleets/{name}/car")
    def car(name: str, vehicle: Short) -> dict[str, Any]:
        """One car: its reasons in the list, its drives, and its smoothed levels."""
        found = loaded(name)
        drives = bench.drives(name, vehicle)
        row: dict[str, Any] = next((each for each in found["rows"] if each["vehicle"] == vehicle), {})
        listed = next((each for each in found["cars"] if each["vehicle"] == vehicle), None)
        bands = {place: own[vehicle] for place, own in found["bands"].items() if vehicle in own}
        return {"row": row, "listed": listed, "drives": drives, "bands": bands, "quantities": found["quantities"]}

    @router.get("/vehicle")
    def vehicle(name: Text = "") -> dict[str, Any]:
        """Parameters of a vehicle, with standard deviation and source."""
        return bench.parameters(name)

    return router
