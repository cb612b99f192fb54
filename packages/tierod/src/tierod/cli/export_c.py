"""Export of C for control units: a monitor of a vehicle, or the fault memory, each with a program that compares it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

from tierod.core.errors import ParameterError, nearest

if TYPE_CHECKING:
    import numpy as np

    from tierod.export.interface import Interface
    from tierod.export.subject import Subject
    from tierod.vehicles import Vehicle

PRECISIONS = ("single", "double")

DRIVES = {
    "friction": "mixed-drive-friction-step",
    "driver-torque": "hands-off",
    "sideslip": "slalom-winter-tyres",
    "condition": "demonstrator-lap",
    "motor-angle": "motor-bench-sweep",
}
"""Shipped scenario whose drive gives the test vectors of a monitor if no other is named."""

FAULT_MEMORY = "fault-memory"  # Name of the fault memory, which is exported as C like a monitor

DRIVEN_STEPS, RANDOM_STEPS = 100_000, 100_000
"""Largest numbers of steps from a drive and from random inputs in the comparison of the evidence."""


@dataclass(frozen=True)
class CChoice:
    """Options of the C export of a monitor, as on the command line."""

    precision: str = "single"
    validity: bool = False  # whether a mask states which inputs are valid, in place of NaN
    libm: bool = True  # whether functions such as the sine come from the C library
    drive: str | None = None  # recording or scenario of the test vectors; a shipped scenario where None
    evidence: bool = False  # whether the export is compared, checked and measured


def export_c(name: str, vehicle: str | None, variant: str | None, choice: CChoice, output: Path) -> None:
    """Write the C of a monitor, and print a summary.

    Args:
        name: name of the monitor
        vehicle: file or name of the vehicle
        variant: variant of the monitor; its default where None
        choice: all other options
        output: folder for the files

    Raises:
        ParameterError: there is no such monitor, vehicle, variant or precision, or the monitor cannot be exported
    """
    from tierod.cli.terminal import output as console
    from tierod.core.files import require_folder
    from tierod.export.c_export import interface_of
    from tierod.export.interface import Options
    from tierod.export.subject import subject_of
    from tierod.monitors.registry import MONITORS
    from tierod.vehicles import load

    if name not in MONITORS:
        raise ParameterError(f"there is no monitor '{name}'{nearest(name, [*MONITORS, FAULT_MEMORY])}")
    if vehicle is None:
        raise ParameterError("C is printed for one vehicle; name it with --vehicle")
    if choice.precision not in PRECISIONS:
        raise ParameterError(f"--precision is '{choice.precision}'{nearest(choice.precision, PRECISIONS)}")
    require_folder(output)
    car = load(vehicle)
    subject = subject_of(name, car, variant)
    options = Options("single" if choice.precision == "single" else "double", choice.validity, choice.libm)
    face = interface_of(subject, options)
    written = _write(face, car, choice.drive, output)
    console().print(
        f"{subject.title} for {car.name}, {choice.precision} precision, parameters {subject.digest:08x}: "
        f"{len(written)} files in {output}\nbuild and compare with: make -C {quote(str(output))}",
        soft_wrap=True, markup=False, highlight=False,
    )  # fmt: skip
    if choice.evidence:
        _write_evidence(face, car, choice.drive, output)


def export_fault_memory(output: Path, evidence: bool) -> None:
    """Write the fault memory of the shipped trouble codes as C, and print a summary."""
    from tierod.cli.terminal import messages, show_analysis, write_page
    from tierod.cli.terminal import output as console
    from tierod.core.files import require_folder
    from tierod.diagnosis.trouble_codes import load_trouble_codes
    from tierod.export.c_export import refuse_foreign, write_folder
    from tierod.export.evidence.page import memory_evidence
    from tierod.export.fault_memory import NAMES, fault_memory_files

    require_folder(output)
    refuse_foreign(output, NAMES[0])
    codes = load_trouble_codes()
    texts = fault_memory_files(codes)
    write_folder(texts, output)
    console().print(
        f"fault memory of {len(codes.codes)} trouble codes: {len(texts)} files in {output}\n"
        f"build and compare with: make -C {quote(str(output))}",
        soft_wrap=True, markup=False, highlight=False,
    )  # fmt: skip
    if evidence:
        messages().print("comparing, checking and measuring", markup=False)
        found = memory_evidence(output)
        show_analysis(found)
        write_page(found, (), output / "evidence.html", kind="evidence")


def _write(face: Interface, car: Vehicle, drive: str | None, output: Path) -> list[str]:
    from tierod.export.c_export import files, refuse_foreign, write_folder
    from tierod.export.vectors import STEPS, affordable, vectors_of

    refuse_foreign(output, f"{face.prefix}.h")
    steps = affordable(face.subject, STEPS)
    inputs, source = inputs_of(face.subject, car, drive, steps)
    texts = files(face, vectors_of(face.subject, inputs, source, steps))
    write_folder(texts, output)
    return list(texts)


def _write_evidence(face: Interface, car: Vehicle, drive: str | None, output: Path) -> None:
    from tierod.cli.terminal import messages, show_analysis, write_page
    from tierod.export.evidence.page import evidence
    from tierod.export.vectors import SEED, STEPS, affordable, random_inputs, rounded, vectors_of

    subject, most = face.subject, affordable(face.subject, DRIVEN_STEPS)
    inputs, source = inputs_of(subject, car, drive, most)
    random = random_inputs(subject, affordable(subject, RANDOM_STEPS))
    samples = {source: rounded(inputs[:most]), f"random (seed {SEED})": rounded(random)}
    messages().print("comparing, checking and measuring: some minutes", markup=False)
    found = evidence(face, output, vectors_of(subject, inputs[:STEPS], source), samples)
    show_analysis(found)
    write_page(found, car.facts, output / "evidence.html", car.not_good_for, kind="evidence")


def inputs_of(subject: Subject, car: Vehicle, drive: str | None, steps: int) -> tuple[np.ndarray, str]:
    """Inputs of a monitor, if possible for at least the given number of steps, and their origin in words."""
    from tierod.core import plugins as lab
    from tierod.export.vectors import SEED, inputs_from, random_inputs

    name = drive or (DRIVES.get(subject.monitor) if lab.installed() else None)
    if name is None:
        return random_inputs(subject, steps), f"drawn at random (seed {SEED})"
    if drive is not None and Path(drive).suffix not in ("", ".toml"):
        return inputs_from(subject, car, drive), f"the recording {Path(drive).name}"
    scenario = lab.part("scenario", f"the scenario '{name}'")(name)
    scenario = scenario.with_run(min(scenario.duration, steps / subject.rate), None)
    recording = scenario.run(lambda share: None).recording
    return inputs_from(subject, car, recording), f"the simulated drive {scenario.name} (seed {scenario.seed})"
