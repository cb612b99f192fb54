"""Drive a virtual car through a scenario, and write the measured signals together with the truth."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from tierod_lab.ground.run import Outcome
    from tierod_lab.ground.scenarios import Scenario


def simulate(
    scenario: Annotated[
        str,
        typer.Argument(help="A shipped scenario (see 'tierod scenarios'), a scenario file, or a virtual fleet's file."),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="File to write: .mf4, .parquet or .csv; for a fleet, a folder.")
    ],
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of random numbers; else the scenario's.")] = None,
    seconds: Annotated[float | None, typer.Option(help="Duration in seconds, in place of the scenario's.")] = None,
    plant: Annotated[
        Path | None,
        typer.Option(help="Plant file (.toml) of a unit (.fmu) that replaces tierod's model of the vehicle."),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="print one JSON document")] = False,
    estimates: Annotated[
        bool, typer.Option("--estimates", help="For a fleet: draw estimates from measured errors; simulate no drives.")
    ] = False,
    workers: Annotated[int | None, typer.Option(min=1, help="For a fleet: processes; one per core.")] = None,
) -> int:
    """Run a scenario once; measured channels and the truth (channels named truth_...) go into one recording."""
    from tierod_lab.fleet.virtual import describes_fleet

    if describes_fleet(scenario):
        _refuse_plant(plant)
        return _fleet(scenario, output, seed, seconds, estimates, workers, json)
    from tierod.cli.app import HEALTHY, NOT_JUDGED
    from tierod.cli.terminal import messages, print_json, print_remark, progress
    from tierod.io.writers import require_writable, write
    from tierod_lab.ground.scenarios import load

    whole = load(scenario)
    chosen = whole.with_run(seconds, seed)
    require_writable(output)
    if plant is not None:
        chosen = _with_plant(chosen, plant)
    for remark in _before_run(whole, chosen):
        print_remark(remark)
    began = time.perf_counter()
    with progress(f"driving {chosen.name}") as advance:
        outcome = chosen.run(advance)
    took = time.perf_counter() - began
    write(outcome.recording, output)
    if json:
        print_json(_document(chosen, outcome, output))
    else:
        _show(chosen, outcome, output, took)
    if plant is not None and (astray := _astray(outcome)):
        messages().print(astray, soft_wrap=True, markup=False, highlight=False)
    if plant is not None and (standing := _standing(chosen, outcome)):
        messages().print(standing, soft_wrap=True, markup=False, highlight=False)
        return NOT_JUDGED
    if outcome.diverged_at is None:
        return HEALTHY
    print_remark(_diverged(chosen, outcome, output))
    return NOT_JUDGED


def _before_run(whole: Scenario, chosen: Scenario) -> Iterator[str]:
    from tierod_lab.ground.scenarios.plants import native_code

    yield from native_code([chosen])
    for fault in (each for each in whole.faults if each not in chosen.faults):
        yield f"left out, since it begins after the end of the run: {fault.label}"


def _refuse_plant(plant: Path | None) -> None:
    from tierod.core.errors import ParameterError

    if plant is not None:
        raise ParameterError("--plant replaces the car of one scenario, and a fleet has many cars; name a scenario")


def _with_plant(scenario: Scenario, plant: Path) -> Scenario:
    from tierod.cli.terminal import messages
    from tierod.core.errors import ParameterError
    from tierod.core.toml_document import Document
    from tierod_lab.ground.scenarios import with_plant

    if plant.suffix.lower() == ".fmu":
        raise ParameterError(f"{plant} is a unit; --plant takes the plant file (.toml) that maps its variables")
    driven, found = with_plant(scenario, Document.read(plant, "plant"))
    for each in found:
        messages().print(each, soft_wrap=True, markup=False, highlight=False)
    return driven


OFF_PATH = 10.0  # Distance from its path at which the driver has lost control of the car [m]


def _astray(outcome: Outcome) -> str:
    """Likeliest cause if the driver has lost control of a car computed by a unit; "" if not."""
    import numpy as np

    offset = outcome.recording.channels.get("truth_lateral_offset")
    if offset is None or not (np.abs(offset.values) > OFF_PATH).any():
        return ""
    first = offset.time[int(np.argmax(np.abs(offset.values) > OFF_PATH))]
    return (
        f"the car leaves its path by more than {OFF_PATH:g} m from {first:.4g} s on: check signs and units of the "
        "unit's steering input, yaw rate and speed (left is positive; sign = -1 reverses a signal)"
    )


STANDING = 0.5  # Speed up to which a car counts as standing [m/s]


def _standing(scenario: Scenario, outcome: Outcome) -> str:
    """Likeliest cause if the car of a unit stands although its course requires a speed; "" if it moves."""
    import numpy as np

    speeds = [
        each.values for name in ("truth_longitudinal_speed", "vehicle_speed")
        if (each := outcome.recording.channels.get(name)) is not None
    ]  # fmt: skip
    wanted = scenario.course.start.speed
    if not speeds or wanted <= STANDING or (np.nan_to_num(np.abs(speeds[0])) > STANDING).any():
        return ""
    return (
        f"the car stands still throughout, but its course begins at {wanted:.3g} m/s: in the plant file, connect the "
        "speed demand of the unit to demand.speed, or its initial speed to start_speed"
    )


def _diverged(scenario: Scenario, outcome: Outcome, path: Path) -> str:
    if outcome.reason:
        return f"{outcome.reason}; {path} holds the drive up to {outcome.diverged_at:g} s of {scenario.duration:g} s"
    return (
        f"the run diverged: its last good time is {outcome.diverged_at:g} s of {scenario.duration:g} s, up to which "
        f"{path} holds it; reduce the fault, or check the changed parameters"
    )


def _parted(outcome: Outcome) -> tuple[list[str], list[str]]:
    names = outcome.recording.names
    return [n for n in names if not n.startswith("truth_")], [n for n in names if n.startswith("truth_")]


def _document(scenario: Scenario, outcome: Outcome, path: Path) -> dict[str, Any]:
    measured, truth = _parted(outcome)
    return {
        "schema": "tierod.simulation/1",
        "recording": str(path),
        **scenario.provenance,
        "diverged_at": outcome.diverged_at,
        **({"reason": outcome.reason} if outcome.reason else {}),
        "faults": [dict(window) for window in outcome.windows],
        "measured_channels": measured,
        "truth_channels": truth,
    }


def _show(scenario: Scenario, outcome: Outcome, path: Path, took: float) -> None:
    import shlex

    from tierod.cli.terminal import output, rows
    from tierod_lab.ground.scenarios.plants import facts

    console = output()
    console.print(f"{scenario.name}: {scenario.description}", markup=False)
    console.print(rows(("", ""), facts(scenario)))
    if outcome.windows:
        console.print("\nFaults as they came")
        console.print(rows(("fault", "element", "behaviour", "from [s]", "to [s]"), map(_window, outcome.windows)))
    measured, truth = _parted(outcome)
    first, last = outcome.recording.span
    console.print(
        f"\nrecording: {path}: {len(measured)} measured channels, {len(truth)} of the truth, "
        f"{last - first:.4g} s driven in {took:.2g} s",
        soft_wrap=True,
        markup=False,
    )
    console.print(f"look into it with: {shlex.join(['tierod', 'inspect', str(path)])}", soft_wrap=True, markup=False)
    if scenario.vehicle:
        console.print(f"go on with: {shlex.join(_next(scenario, path))}", soft_wrap=True, markup=False)


def _next(scenario: Scenario, path: Path) -> list[str]:
    words = scenario.next_command.split() or ["diagnose"]
    options = next((place for place, word in enumerate(words) if word.startswith("--")), len(words))
    return ["tierod", *words[:options], str(path), "--vehicle", scenario.vehicle, *words[options:]]


def _window(window: Any) -> tuple[str, ...]:
    def cell(name: str) -> str:
        value = window.get(name)
        return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)

    return tuple(cell(name) for name in ("name", "element", "behaviour", "start", "end"))


def _fleet(
    path: str,
    folder: Path,
    seed: int | None,
    seconds: float | None,
    estimates: bool,
    workers: int | None,
    as_json: bool,
) -> int:
    """Write a virtual fleet, and return an exit code: all drives written (0), some failed (2)."""
    import shlex

    from tierod.cli.terminal import print_json, print_remark, progress, say
    from tierod.work.pool import cores
    from tierod_lab.fleet import virtual
    from tierod_lab.fleet import writing as virtual_writing

    file = virtual.load(path)
    file = file if seed is None else replace(file, seed=seed)
    file = file if seconds is None else replace(file, duration=seconds)
    cars, began = virtual.drawn(file), time.perf_counter()
    failures: list[str] = []
    if estimates:
        virtual_writing.write_estimates(cars, folder, virtual_writing.shipped_law())
    else:
        with progress(f"driving {file.cars} cars") as advance:
            failures = virtual_writing.write_drives(
                cars, folder, workers or cores(), lambda done, of: advance(done / of)
            )
    took = time.perf_counter() - began
    for failure in failures[:10]:
        print_remark(f"failed: {failure}")
    drives = [str(folder / "recordings"), "--vehicles", str(folder / "fleet.toml"), "-o", "results"]
    words = ["tierod", "fleet", *(["report", str(folder)] if estimates else drives)]
    if as_json:
        print_json({
            "schema": "tierod.virtual-fleet/1", "folder": str(folder), "cars": file.cars, "drives": int(cars.day.size),
            "failed": len(failures), "estimate_level": estimates, "seed": file.seed, "seconds": took,
        })  # fmt: skip
    else:
        how = "drawn at estimate level, from measured errors" if estimates else f"driven in {took:.3g} s"
        say(f"{file.name}: {file.cars} cars, {cars.day.size} drives {how}: {folder}")
        say(f"go on with: {shlex.join(words)}")
    return 2 if failures else 0
