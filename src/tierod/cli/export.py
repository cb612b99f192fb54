"""Export a monitor as C for a control unit, or monitor, plant, driver and assist unit as functional mock-up units."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tierod.core.errors import ParameterError, nearest

if TYPE_CHECKING:
    import numpy as np

    from tierod.export.interface import Interface
    from tierod.export.subject import Subject
    from tierod.vehicles import Vehicle

KINDS = ("c", "fmu")
PRECISIONS = ("single", "double")

DRIVES = {
    "friction": "mixed-drive-friction-step",
    "driver-torque": "hands-off",
    "sideslip": "slalom-winter-tyres",
    "condition": "demonstrator-lap",
    "motor-angle": "motor-bench-sweep",
}
"""Shipped scenario whose drive a monitor is compared by where no other is named."""

FAULT_MEMORY = "fault-memory"
"""What is exported beside monitors as C: the memory of their trouble codes."""

DRIVEN_STEPS, RANDOM_STEPS = 100_000, 100_000
"""At the most, of the comparison of the evidence."""


def export(
    kind: Annotated[str, typer.Argument(help="c: C99 for a control unit; fmu: a functional mock-up unit.")],
    monitor: Annotated[
        str,
        typer.Argument(
            help="Name of the monitor, see 'tierod monitors'; as fmu also plant, driver or assist, as c fault-memory."
        ),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder that takes the C, or file of the unit.")],
    vehicle: Annotated[
        str | None, typer.Option(help="Vehicle file, or the name of a shipped vehicle; of a monitor.")
    ] = None,
    scenario: Annotated[
        str | None, typer.Option(help="Scenario whose plant, driver or assist unit is exported as fmu.")
    ] = None,
    fmi: Annotated[int, typer.Option(help="Version of the standard of a unit: 2 or 3.")] = 3,
    variant: Annotated[str | None, typer.Option(help="Variant of the monitor; its default where not given.")] = None,
    precision: Annotated[str, typer.Option(help="single or double.")] = "single",
    validity: Annotated[
        bool, typer.Option("--validity", help="A mask says which inputs are valid, in place of NaN.")
    ] = False,
    libm: Annotated[
        bool,
        typer.Option("--libm/--no-libm", help="Sine, logarithm and the like of the C library, or tierod's own."),
    ] = True,
    drive: Annotated[
        str | None,
        typer.Option(help="Recording or scenario that the test vectors come from; a shipped one where not given."),
    ] = None,
    evidence: Annotated[
        bool, typer.Option("--evidence", help="Compare, check and measure, and write evidence.html beside it.")
    ] = False,
) -> None:
    """Write a monitor as C with test vectors and what compares them, or a functional mock-up unit."""
    if kind not in KINDS:
        raise ParameterError(f"there is no export '{kind}'{nearest(kind, KINDS)}")
    if kind == "c" and monitor == FAULT_MEMORY:
        _write_fault_memory(output)
        return
    if kind == "fmu":
        _unit(monitor, vehicle, scenario, variant, fmi, output)
        return
    from tierod.cli.terminal import output as console
    from tierod.core.files import require_folder
    from tierod.export.interface import Interface, Options
    from tierod.export.subject import subject_of
    from tierod.vehicles import load

    if vehicle is None:
        raise ParameterError("C is printed for one vehicle; name it with --vehicle")
    if precision not in PRECISIONS:
        raise ParameterError(f"--precision is '{precision}'{nearest(precision, PRECISIONS)}")
    require_folder(output)
    car = load(vehicle)
    subject = subject_of(monitor, car, variant)
    chosen: Options = Options("single" if precision == "single" else "double", validity, libm)
    face = Interface(subject, chosen)
    written = _write_c(face, car, drive, output)
    console().print(
        f"{subject.title} for {car.name}, {precision} precision, parameters {subject.digest:08x}: "
        f"{len(written)} files in {output}\nbuild and compare with: make -C {output}",
        soft_wrap=True, markup=False, highlight=False,
    )  # fmt: skip
    if evidence:
        _write_evidence(face, car, drive, output)


def _unit(name: str, vehicle: str | None, scenario: str | None, variant: str | None, fmi: int, output: Path) -> None:
    """Write a functional mock-up unit."""
    from tierod.cli.export_fmu import export_fmu

    if fmi not in (2, 3):
        raise ParameterError(f"--fmi is {fmi}; the versions are 2 and 3")
    export_fmu(name, vehicle, scenario, variant, 2 if fmi == 2 else 3, output)


def _write_fault_memory(output: Path) -> None:
    """Write the fault memory of the shipped trouble codes."""
    from tierod.cli.terminal import output as console
    from tierod.core.files import require_folder
    from tierod.diagnosis.trouble_codes import load_trouble_codes
    from tierod.export.c_export import write_folder
    from tierod.export.fault_memory.texts import fault_memory_files

    require_folder(output)
    codes = load_trouble_codes()
    texts = fault_memory_files(codes)
    write_folder(texts, output)
    console().print(
        f"fault memory of {len(codes.codes)} trouble codes: {', '.join(texts)} in {output}",
        soft_wrap=True, markup=False, highlight=False,
    )  # fmt: skip


def _write_c(face: Interface, car: Vehicle, drive: str | None, output: Path) -> list[str]:
    """Write the files of an export, and give their names."""
    from tierod.export.c_export import files, refuse_foreign, write_folder
    from tierod.export.vectors import STEPS, vectors_of

    refuse_foreign(output, face)
    inputs, source = inputs_of(face.subject, car, drive, STEPS)
    texts = files(face, vectors_of(face.subject, inputs, source))
    write_folder(texts, output)
    return list(texts)


def _write_evidence(face: Interface, car: Vehicle, drive: str | None, output: Path) -> None:
    """Compare, check and measure an export, and write the page about it."""
    from tierod.cli.terminal import messages, show, write_page
    from tierod.export.evidence.page import evidence
    from tierod.export.stimuli import SEED, random_inputs
    from tierod.export.vectors import STEPS, rounded, vectors_of
    from tierod.report.analysis.analysis import facts_of

    inputs, source = inputs_of(face.subject, car, drive, DRIVEN_STEPS)
    samples = {source: rounded(inputs), f"random (seed {SEED})": rounded(random_inputs(face.subject, RANDOM_STEPS))}
    messages().print("comparing, checking and measuring: some minutes", markup=False)
    found = evidence(face, output, vectors_of(face.subject, inputs[:STEPS], source), samples)
    show(found)
    write_page(found, facts_of(car), output / "evidence.html", car.not_good_for, kind="evidence")


def inputs_of(subject: Subject, car: Vehicle, drive: str | None, steps: int) -> tuple[np.ndarray, str]:
    """Inputs of a monitor, at least so many steps where there are, and where they come from in words.

    Args:
        subject: that takes them
        car: whose channel map reads a recording
        drive: path of a recording or name of a scenario; a shipped scenario where None, else random
        steps: that are wanted
    """
    from tierod.export.drives import inputs_from
    from tierod.export.stimuli import SEED, random_inputs
    from tierod.proving_ground.scenarios import load

    name = drive or DRIVES.get(subject.monitor)
    if name is None:
        return random_inputs(subject, steps), f"drawn at random (seed {SEED})"
    if drive is not None and Path(drive).suffix not in ("", ".toml"):
        return inputs_from(subject, car, drive), f"the recording {Path(drive).name}"
    scenario = load(name)
    scenario = scenario.with_run(min(scenario.duration, steps / subject.rate), None)
    recording = scenario.run(lambda share: None).recording
    return inputs_from(subject, car, recording), f"the simulated drive {scenario.name} (seed {scenario.seed})"
