"""Endpoints of files, uploads, jobs and scenarios."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from starlette.requests import ClientDisconnect

from tierod.core.errors import InputError
from tierod.core.files import replacing
from tierod.web.listing import Listing
from tierod.web.shapes import Analysed, Asked, ChosenScenario, JobShape, Opened, Problem, SiteShape, State
from tierod.web.workbench import Workbench

Text = Annotated[str, Query(max_length=4096)]
Short = Annotated[str, Query(max_length=200)]

PROBLEMS: dict[int | str, dict[str, Any]] = {400: {"model": Problem}, 403: {"model": Problem}, 404: {"model": Problem}}


def work_endpoints(bench: Workbench) -> APIRouter:
    """Endpoints of files, uploads, jobs and scenarios.

    Args:
        bench: the workbench to serve
    """
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

    @router.get("/recording")
    def recording(file: Text) -> State:
        """State of a recording."""
        return bench.state(file)

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
        from tierod.web.scenarios import catalogue

        return catalogue()

    @router.post("/scenarios", status_code=202)
    def simulate(chosen: ChosenScenario) -> JobShape:
        """Simulate a drive, and judge it."""
        return JobShape.of(bench.simulate(chosen))
