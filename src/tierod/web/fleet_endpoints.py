"""Endpoints of fleets and vehicles."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query

from tierod.web import fleets
from tierod.web.errors import Absent
from tierod.web.jobs import Job
from tierod.web.shapes import FleetTable, JobShape
from tierod.web.work_endpoints import PROBLEMS, Short, Text
from tierod.web.workbench import Workbench

HELD_BACK = ("rows", "bands", "cars")
"""Parts of a fleet that separate endpoints return piece by piece."""


def fleet_endpoints(bench: Workbench) -> APIRouter:
    """Endpoints of fleets and vehicles.

    Args:
        bench: the workbench to serve
    """
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
