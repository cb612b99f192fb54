"""Back-to-back comparison of an export, compiled in several ways, with `scan` on the same samples."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from tierod.core.content import Table
from tierod.core.graph import scan
from tierod.export.evidence.tools import at_once, ran, there, version
from tierod.export.interface import Interface

COMPILERS = ("gcc", "clang")
LEVELS = (("-O0",), ("-O2",), ("-O3",), ("-O3", "-march=native"))
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-ffp-contract=off")


@dataclass(frozen=True)
class Difference:
    """Difference of a compiled export from `scan`.

    Args:
        worst: largest difference of an output as a share of its range; NaN where the build could not be run
        equal: share of the numbers that are identical to the last bit
        trouble: why the build could not be run; "" where it could
    """

    build: str
    samples: str
    steps: int = 0
    worst: float = float("nan")
    output: str = ""
    equal: float = float("nan")
    decisions: float = float("nan")
    warnings: int = 0
    trouble: str = ""


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
        level: flags added to those common to all builds
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
        steps: steps that its free-running clocks have counted at the restart
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
