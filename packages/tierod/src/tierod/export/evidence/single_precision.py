"""Single precision compared with `scan` in double: error of the main estimate, and delay of the verdicts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.content import Table
from tierod.core.graph import Memory, scan
from tierod.core.graph.trace import initial_memory
from tierod.export.bank_interface import BankInterface
from tierod.export.clocks import free_clocks
from tierod.export.evidence.comparison import built, run_over
from tierod.export.interface import Interface


class Aim(NamedTuple):
    """Permitted difference of an estimate in single precision from double.

    Args:
        limit: largest permitted difference, in the displayed unit
        scale: factor from the unit of the output to the displayed unit
    """

    output: str
    limit: float
    unit: str
    scale: float = 1.0


AIMS = {
    "friction": Aim("estimate.friction_torque", 0.002, "N·m"),
    "motor-angle": Aim("estimate.motor_angle", 0.002, "rad"),
    "driver-torque": Aim("statement.magnitude", 0.01, "N·m"),
    "sideslip": Aim("estimate.sideslip_angle", 0.02, "°", math.degrees(1.0)),
}
"""Required agreement, by the name of the monitor."""

LATEST: Annotated[float, "s"] = 0.05
"""Largest permitted duration of a different status."""
HOURS = (0.0, 100.0)
"""Running times of the clocks at the beginning of a drive [h]."""


@dataclass(frozen=True)
class Apart:
    """Difference between single and double precision on one drive.

    Args:
        hours: running time of the clocks at its beginning [h]
        largest: difference of the estimate in the unit of its aim; NaN where the monitor has no aim
        verdicts: changes of the status in double precision
        longest: longest stretch with different statuses [s]
    """

    samples: str
    hours: float
    steps: int
    largest: float
    verdicts: int
    longest: float

    def within(self, aim: Aim | None) -> bool:
        """Whether the agreement is as close as required."""
        # `not <=` instead of `>`, so that NaN does not pass.
        return self.longest <= LATEST and not (aim is not None and not self.largest <= aim.limit)


def aim_of(face: Interface) -> Aim | None:
    """Required agreement; None for a monitor without a requirement, or a variant without that output."""
    aim = AIMS.get(face.subject.monitor)
    return aim if aim is not None and aim.output in face.subject.graph.output else None


def apart(face: Interface, folder: Path, samples: Mapping[str, np.ndarray]) -> list[Apart] | str:
    """Compare single precision, compiled by gcc with -O2, over drives with clocks at zero and after long running.

    Args:
        face: interface of an export in single precision
        samples: (n, inputs) by name

    Returns a sentence where the export cannot be compiled.
    """
    library, _, trouble = built(face, folder, "gcc", ("-O2",))
    if library is None:
        return trouble
    found = []
    for name, values in samples.items():
        for hours in HOURS:
            steps = round(3600.0 * hours * face.subject.rate)
            outputs = run_over(library, values, len(face.graph.output), steps)
            found.append(_measured(face, name, hours, outputs, values, steps))
    return found


def _measured(face: Interface, name: str, hours: float, found: np.ndarray, values: np.ndarray, steps: int) -> Apart:
    wanted = scan(face.subject.block, values, _after(face, steps)).values
    statuses = list(face.statuses)
    aim = aim_of(face)
    largest = math.nan
    if aim is not None:
        place = face.graph.output.index(aim.output)
        largest = aim.scale * _largest(found[:, place], wanted[:, place])
    unlike = (found[:, statuses] != wanted[:, statuses]).any(axis=1)
    changes = (np.diff(wanted[:, statuses], axis=0) != 0.0).any(axis=1)
    return Apart(name, hours, len(values), largest, int(changes.sum()), _longest(unlike) / face.subject.rate)


def _after(face: Interface, steps: int) -> Memory:
    memory = initial_memory(face.subject.block)
    # The clocks of a bank are those of its judge, whose states lie behind those of the lanes.
    first = face.bank.lanes_memory if isinstance(face, BankInterface) else 0
    for position in free_clocks(face.program, face.clocks):
        memory[first + position] = steps / face.subject.rate
    return Memory(memory, 0)


def _largest(found: np.ndarray, wanted: np.ndarray) -> float:
    """Largest difference; infinite where only one of both is missing."""
    missing = np.isnan(wanted)
    if (np.isnan(found) != missing).any():
        return math.inf
    return float(np.abs(found - wanted)[~missing].max(initial=0.0))


def _longest(unlike: np.ndarray) -> int:
    """Length of the longest stretch [steps]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], unlike.astype(int), [0]])))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def beside_double(face: Interface, found: list[Apart] | str) -> Table:
    aim = aim_of(face)
    title = "Single precision beside scan in double (gcc -O2)"
    if isinstance(found, str):
        return Table(title, ("samples", "result"), (("all", f"not run: {found}"),))
    header = ("samples", "clocks began at", "largest difference", "changes of the status", "longest while it differs")
    shown = "" if aim is None else f" {aim.unit}"
    rows = tuple(
        (
            f"{each.samples}, {each.steps} steps",
            f"{each.hours:g} h",
            "-" if math.isnan(each.largest) else f"{each.largest:.2g}{shown}",
            str(each.verdicts),
            f"{1e3 * each.longest:.3g} ms",
        )
        for each in found
    )
    note = f"Statuses may differ for {1e3 * LATEST:g} ms."
    if aim is not None:
        note = f"Of {aim.output}, which may differ by {aim.limit:g}{shown}. {note}"
    return Table(title, header, rows, note)
