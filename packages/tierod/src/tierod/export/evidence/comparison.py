"""Comparison of an export, compiled in several ways, with `scan`, and of single precision with double."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.content import Table
from tierod.core.graph import Memory, scan
from tierod.core.graph.trace import initial_memory
from tierod.export.bank import BankInterface
from tierod.export.evidence.checks import at_once, ran, there, version
from tierod.export.interface import Interface, free_clocks

COMPILERS = ("gcc", "clang")
LEVELS = (("-O0",), ("-O2",), ("-O3",), ("-O3", "-march=native"))
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-ffp-contract=off")


@dataclass(frozen=True)
class Difference:
    """Difference of a compiled export from `scan`."""

    build: str
    samples: str
    steps: int = 0
    # largest difference of an output as a share of its range; NaN where the build could not be run
    worst: float = float("nan")
    output: str = ""
    equal: float = float("nan")  # share of the numbers that are identical to the last bit
    decisions: float = float("nan")
    warnings: int = 0
    trouble: str = ""  # why the build could not be run; "" where it could


def differences(face: Interface, folder: Path, samples: Mapping[str, np.ndarray]) -> list[Difference]:
    """Compare every build over all samples.

    Args:
        folder: of the export; compiled files go to its subfolder `build`
        samples: (n, inputs) by name
    """
    wanted = {name: scan(face.subject.block, values).values for name, values in samples.items()}
    found = []
    ways = [(compiler, level) for compiler in COMPILERS for level in LEVELS]
    present = [way for way in ways if there(way[0])]
    made = dict(zip(present, at_once([partial(built, face, folder, *way) for way in present]), strict=True))
    for compiler in COMPILERS:
        for level in LEVELS:
            build = f"{compiler} {' '.join(level)}"
            if not there(compiler):
                found.append(Difference(build, "", trouble=version(compiler)))
                continue
            library, warnings, trouble = made[compiler, level]
            if library is None:
                found.append(Difference(build, "", trouble=trouble))
                continue
            for name, values in samples.items():
                outputs = run_over(library, values, wanted[name].shape[1])
                found.append(_difference(face, (build, name), outputs, wanted[name], warnings))
    return found


def built(face: Interface, folder: Path, compiler: str, level: tuple[str, ...]) -> tuple[ctypes.CDLL | None, int, str]:
    """Shared library of an export (None on failure), number of compiler warnings, and why the build failed.

    Args:
        folder: of the export; the library goes to its subfolder `build`
    """
    (folder / "build").mkdir(exist_ok=True)
    library = folder / "build" / f"{compiler}{'_'.join(level)}.so"
    sources = [f"{face.prefix}.c", f"{face.prefix}_parameters.c", "test/compare.c"]
    command = [compiler, *FLAGS, *level, "-fPIC", "-shared", "-DTIEROD_NO_MAIN", "-I.", *sources, "-o", str(library)]
    done = ran([*command, "-lm"], folder)
    if done.code != 0:
        return None, 0, done.first
    return ctypes.CDLL(str(library.resolve())), done.text.count("warning:"), ""


def run_over(library: ctypes.CDLL, values: np.ndarray, width: int, steps: int = 0) -> np.ndarray:
    """Outputs (n, outputs) of an export that is restarted first.

    Args:
        values: (n, inputs)
    """
    given = np.ascontiguousarray(values, dtype=float)
    outputs = np.zeros((len(given), width))
    library.tierod_run.argtypes = [ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_long, ctypes.c_long]
    library.tierod_run.restype = None
    library.tierod_run(len(given), given.ctypes.data, outputs.ctypes.data, 1, steps)
    return outputs


def _difference(
    face: Interface, names: tuple[str, str], found: np.ndarray, wanted: np.ndarray, warnings: int
) -> Difference:
    same = (found == wanted) | (np.isnan(found) & np.isnan(wanted))
    finite = np.where(np.isfinite(wanted), wanted, 0.0)
    span = finite.max(axis=0) - finite.min(axis=0)
    apart = np.where(same, 0.0, np.abs(found - wanted)) / np.where(span > 0.0, span, 1.0)
    worst = np.where(np.isnan(apart), np.inf, apart).max(axis=0)
    place = int(worst.argmax())
    statuses = list(face.statuses)
    decided = (found[:, statuses] != wanted[:, statuses]).any(axis=1).mean() if statuses else 0.0
    output = face.subject.graph.output[place]
    return Difference(*names, len(found), float(worst[place]), output, float(same.mean()), float(decided), warnings)


def table(found: list[Difference], precision: str) -> Table:
    rows = tuple(
        (each.build, each.trouble, "", "", "", "", "")
        if each.trouble
        else (
            each.build,
            f"{each.samples}, {each.steps} steps",
            f"{each.worst:.2g}",
            each.output if each.worst else "",
            f"{each.equal:.4%}",
            f"{each.decisions:.3%}",
            str(each.warnings),
        )
        for each in found
    )
    header = ("build", "samples", "largest difference", "of", "equal numbers", "steps with another status", "warnings")
    note = (
        "The difference is relative to the range of each output: an output of 0 or 1 differs by all of it where a "
        "decision falls one step earlier or later. Random samples jump, repeat and vanish without physical sense, so "
        "they can drive a filter to states in which it amplifies the last bit."
    )
    return Table(f"Back to back with scan, {precision} precision", header, rows, note)


class Aim(NamedTuple):
    """Permitted difference of an estimate in single precision from double."""

    output: str
    limit: float  # largest permitted difference, in the displayed unit
    unit: str
    scale: float = 1.0  # factor from the unit of the output to the displayed unit


# Required agreement, by the name of the monitor
AIMS = {
    "friction": Aim("estimate.friction_torque", 0.002, "N·m"),
    "motor-angle": Aim("estimate.motor_angle", 0.002, "rad"),
    "driver-torque": Aim("statement.magnitude", 0.01, "N·m"),
    "sideslip": Aim("estimate.sideslip_angle", 0.02, "°", math.degrees(1.0)),
}

LATEST: Annotated[float, "s"] = 0.05  # Largest permitted duration of a different status
HOURS = (0.0, 100.0)  # Running times of the clocks at the beginning of a drive [h]


@dataclass(frozen=True)
class Apart:
    """Difference between single and double precision on one drive."""

    samples: str
    hours: float  # running time of the clocks at its beginning [h]
    steps: int
    largest: float  # difference of the estimate in the unit of its aim; NaN where the monitor has no aim
    verdicts: int  # changes of the status in double precision
    longest: float  # longest stretch with different statuses [s]

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

    Returns a sentence where the export cannot be compiled.

    Args:
        samples: (n, inputs) by name
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
