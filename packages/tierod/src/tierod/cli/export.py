"""Export a monitor as C for a control unit, or monitor, plant, driver or assist unit as a functional mock-up unit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from tierod.core.errors import ParameterError, nearest

KINDS = ("c", "fmu")

Name = Annotated[
    str,
    typer.Argument(
        help="Name of the monitor, see 'tierod monitors'; as fmu also plant, driver or assist, as c fault-memory."
    ),
]
OutputPath = Annotated[Path, typer.Option("--output", "-o", help="Folder for the C, or .fmu file to write.")]
VehicleName = Annotated[str | None, typer.Option(help="For a monitor: vehicle file, or the name of a shipped vehicle.")]
VariantName = Annotated[str | None, typer.Option(help="Variant of the monitor; its default where not given.")]
ScenarioName = Annotated[
    str | None, typer.Option(help="Scenario whose plant, driver or assist unit is exported as fmu.")
]
PrecisionName = Annotated[str | None, typer.Option(help="For the C of a monitor: single (default) or double.")]
Validity = Annotated[bool, typer.Option("--validity", help="Mark valid inputs by a bit mask, in place of NaN.")]
Libm = Annotated[
    bool,
    typer.Option(
        "--libm/--no-libm", help="Take sine, logarithm and similar functions from the C library, or print tierod's own."
    ),
]
DriveName = Annotated[
    str | None,
    typer.Option(help="Recording or scenario that the test vectors come from; a shipped one where not given."),
]
WithEvidence = Annotated[
    bool, typer.Option("--evidence", help="Compare, check and measure, and write evidence.html beside it.")
]


def export(
    kind: Annotated[str, typer.Argument(help="c: C99 for a control unit; fmu: a functional mock-up unit.")],
    monitor: Name,
    output: OutputPath,
    vehicle: VehicleName = None,
    variant: VariantName = None,
    scenario: ScenarioName = None,
    precision: PrecisionName = None,
    validity: Validity = False,
    libm: Libm = True,
    drive: DriveName = None,
    evidence: WithEvidence = False,
) -> None:
    """Write a monitor as C with test vectors and a program that compares them, or a functional mock-up unit."""
    from tierod.cli.export_c import FAULT_MEMORY, CChoice, export_c, export_fault_memory
    from tierod.cli.export_fmu import OF_SCENARIO, export_fmu

    if kind not in KINDS:
        raise ParameterError(f"there is no export '{kind}'{nearest(kind, KINDS)}")
    of_c = {"--precision": precision, "--validity": validity, "--no-libm": not libm, "--drive": drive}
    of_monitor = {"--vehicle": vehicle, "--variant": variant}
    of_unit = {"--scenario": scenario}
    if kind == "c" and monitor == FAULT_MEMORY:
        _refuse({**of_monitor, **of_unit, **of_c}, "the fault memory, whose C is the same for every vehicle")
        export_fault_memory(output, evidence)
    elif kind == "c":
        _refuse(of_unit, "the C of a monitor")
        export_c(monitor, vehicle, variant, CChoice(precision or "single", validity, libm, drive, evidence), output)
    else:
        foreign = of_monitor if monitor in OF_SCENARIO else {"--scenario": scenario}
        _refuse({**of_c, "--evidence": evidence, **foreign}, f"the unit of '{monitor}'")
        export_fmu(monitor, vehicle, scenario, variant, output)


def _refuse(given: Mapping[str, object], what: str) -> None:
    named = [name for name, value in given.items() if value not in (None, False)]
    if named:
        it = "it" if len(named) == 1 else "them"
        raise ParameterError(f"{' and '.join(named)} would have no effect on {what}; leave {it} out")
