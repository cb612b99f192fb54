"""Export of functional mock-up units: of a monitor for a vehicle, or of a part of a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tierod.core.errors import OutputError, ParameterError

if TYPE_CHECKING:
    from tierod.export.fmu_description import Model
    from tierod.export.subject import Subject

OF_SCENARIO = ("plant", "driver", "assist")
"""Parts of a scenario that are exported: the whole car with its driver, the driver alone, the assist unit alone."""


def export_fmu(what: str, vehicle: str | None, scenario: str | None, variant: str | None, output: Path) -> None:
    """Write a functional mock-up unit, and print a summary.

    Args:
        what: name of a monitor, or one of `OF_SCENARIO`
        vehicle: vehicle of a monitor
        scenario: scenario of a part
        variant: variant of a monitor
        output: path of the file

    Raises:
        ParameterError: vehicle or scenario is missing, or the scenario has no such part
        OutputError: the file's name does not end in .fmu
    """
    from tierod.cli.terminal import output as console
    from tierod.core.files import require_folder
    from tierod.export.fmu_archive import write_unit

    if output.suffix.lower() != ".fmu":
        raise OutputError(f"{output} does not end in .fmu; write {output}.fmu")
    require_folder(output)
    model = _of_scenario(what, scenario) if what in OF_SCENARIO else _monitor(what, vehicle, variant)
    path = write_unit(model, output)
    subject = model.face.subject
    console().print(
        f"{subject.title}, FMI 2.0 co-simulation, step {subject.sample_time:g} s: "
        f"{len(model.of('input'))} inputs, {len(model.of('output', 'status'))} outputs, "
        f"{len(model.of('tunable'))} tunable and {len(model.of('fixed'))} fixed parameters\n{path}",
        soft_wrap=True, markup=False, highlight=False,
    )  # fmt: skip


def _monitor(name: str, vehicle: str | None, variant: str | None) -> Model:
    from tierod.core.graph.bank import BankGraph
    from tierod.export.subject import subject_of
    from tierod.vehicles import load

    if vehicle is None:
        raise ParameterError(f"the unit of the monitor '{name}' needs its vehicle; name it with --vehicle")
    subject = subject_of(name, load(vehicle), variant)
    if isinstance(subject.graph, BankGraph):
        raise ParameterError(
            f"the monitor '{name}', variant '{subject.variant}', is a bank of {subject.graph.count} filters, which "
            "cannot be exported as a unit; export it as C"
        )
    return _model(subject, {}, False)


def _of_scenario(what: str, name: str | None) -> Model:
    from tierod.core.plugins import part

    if name is None:
        raise ParameterError(f"the unit '{what}' needs a scenario; name it with --scenario")
    subject, starts = part("unit", f"the unit '{what}'")(what, name)
    return _model(subject, starts, what == "plant")


def _model(subject: Subject, starts: dict[str, float], present: bool) -> Model:
    from tierod.export.fmu_description import Model
    from tierod.export.interface import Interface, Options

    # The same functions and fused products as in the kernels make the outputs of the binary equal to the last bit.
    return Model(Interface(subject, Options("double", libm=False, fused=True)), starts, present)
