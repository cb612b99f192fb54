"""Find the detectable and isolable faults from a car's equations, and which further sensor would help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def isolability(
    vehicle: Annotated[
        str, typer.Option(help="A vehicle's name (see 'tierod vehicles') or the path of its TOML file.")
    ] = "smartload",
    without: Annotated[
        list[str] | None, typer.Option(help="A sensor that the car does not have; may be given more than once.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="HTML page to write; in the current folder if not given.")
    ] = None,
    report: Annotated[bool, typer.Option(help="Write the HTML page.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document to stdout, all else to stderr.")] = False,
) -> int:
    """Find detectable and isolable faults of sensors and actuators: done (0), bad input (3)."""
    from tierod.cli.app import HEALTHY
    from tierod.cli.terminal import present, refuse_to_overwrite, report_path
    from tierod.report.isolability import analyse
    from tierod.vehicles import load

    car = load(vehicle)
    target = report_path(output, report, f"{car.name}-isolability.html")
    refuse_to_overwrite(target, [car.path])
    found = analyse(car, without or ())
    content = {"vehicle": car.name, "remarks": list(found.remarks), **found.document}
    present(found, {"schema": "tierod.isolability/2", **content}, as_json, target, car.facts, car.not_good_for)
    return HEALTHY
