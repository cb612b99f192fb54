"""Show the inputs and outputs of a functional mock-up unit, and write a plant file for it."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tierod.experiments.plant_proposal import PlantProposal


def inspect_unit(path: Path, target: Path | None, overwrite: bool, as_json: bool) -> None:
    """Show the variables of a unit with the proposal for each, and write the plant file if requested.

    Args:
        path: path of the unit
        target: plant file to write; None for none
        overwrite: whether an existing file is replaced
        as_json: whether to print one JSON document

    Raises:
        InputError: the unit cannot be used
        OutputError: the plant file cannot be written
    """
    from tierod.cli.terminal import print_json, refuse_to_overwrite
    from tierod.core.errors import OutputError, ParameterError
    from tierod.core.files import require_folder, write_text
    from tierod.experiments.plant_proposal import propose_plant
    from tierod.proving_ground.foreign import read_unit

    if target is not None and as_json:
        raise ParameterError("--write-map and --json exclude each other; give one of them")
    found = propose_plant(read_unit(path))
    if as_json:
        print_json(_document(found))
        return
    if target is not None:
        if target.suffix != ".toml":
            raise OutputError(f"{target} is not the name of a plant file, which ends in .toml; write car.plant.toml")
        refuse_to_overwrite(target, [path], "plant file", "--write-map")
        require_folder(target)
        if target.exists() and not overwrite:
            raise OutputError(f"{target} exists already; name another file, or replace it with --overwrite")
        write_text(target, found.text(os.path.relpath(path, target.absolute().parent)))
    _show(found, target)


def _document(found: PlantProposal) -> dict[str, Any]:
    unit = found.unit
    return {
        "schema": "tierod.unit/1",
        "unit": str(unit.path),
        "name": unit.name,
        "fmi": unit.version,
        "sha256": unit.digest,
        "step": None if unit.step != unit.step else unit.step,
        "proposed": {name: rows for name, rows in found.content.items() if name != "fmu"},
        "free_inputs": [each.name for each in found.free],
        "tunable": [name for name, each in unit.of("parameter").items() if each.variability == "tunable"],
    }


def _show(found: PlantProposal, target: Path | None) -> None:
    from tierod.cli.terminal import messages, output, rows

    console, unit = output(), found.unit
    tunable = sum(each.variability == "tunable" for each in unit.of("parameter").values())
    step = "no step stated" if unit.step != unit.step else f"step {unit.step:g} s"
    console.print(
        f"{unit.path}: {unit.name}, FMI {unit.version}.0 co-simulation, {step}, {tunable} tunable parameters",
        soft_wrap=True, markup=False, highlight=False,
    )  # fmt: skip
    cells = [(each.variable, "takes", each.signal, each.unit, _check(each.is_assumed)) for each in found.inputs]
    cells += [(each.name, "takes", "", each.unit, "nothing found") for each in found.free]
    cells += [(each.variable, "gives", each.signal, each.unit, _check(each.is_assumed)) for each in found.outputs]
    console.print(rows(("variable", "", "signal", "unit", "check"), cells))
    if target is None:
        messages().print("as a plant: tierod simulate SCENARIO --plant", shlex.quote(str(unit.path)), "-o DRIVE.mf4")
        return
    console.print(f"plant file: {target}: edit it where it is wrong, signs above all", markup=False, soft_wrap=True)
    words = ["tierod", "simulate", "mixed-drive-healthy", "--plant", str(target), "-o", "drive.mf4"]
    console.print(f"go on with: {shlex.join(words)}", markup=False, soft_wrap=True)


def _check(is_assumed: bool) -> str:
    return "unit assumed" if is_assumed else ""
