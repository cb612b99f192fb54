"""Compile an export here, and run it beside `scan`."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from tierod.core.graph import scan
from tierod.export.c_export import files, interface_of, write_folder
from tierod.export.interface import Options
from tierod.export.vectors import random_inputs, rounded, vectors_of

WARNINGS = "-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror"

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc is installed")


def exported(subject, folder, inputs=None, **options):
    """The interface of an export that was written into a folder."""
    face = interface_of(subject, Options(**options))
    inputs = random_inputs(subject, 300) if inputs is None else inputs
    write_folder(files(face, vectors_of(subject, inputs, "a test")), folder)
    return face


def run(face, folder, inputs, *, steps=0, flags=("-O2", "-march=native", "-ffp-contract=off"), compiler="gcc"):
    """Outputs of the compiled export, whose clocks have counted so many steps."""
    library = folder / f"run-{compiler}{abs(hash(flags))}.so"
    command = [compiler, *WARNINGS.split(), *flags, "-fPIC", "-shared", "-DTIEROD_NO_MAIN", f"-I{folder}"]
    sources = [str(folder / name) for name in (f"{face.prefix}.c", f"{face.prefix}_parameters.c", "test/compare.c")]
    done = subprocess.run([*command, *sources, "-o", str(library), "-lm"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    loaded = ctypes.CDLL(str(library)).tierod_run
    loaded.argtypes = [ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_long, ctypes.c_long]
    given = np.ascontiguousarray(inputs)
    outputs = np.zeros((len(given), len(face.subject.graph.output)))
    loaded(len(given), given.ctypes.data, outputs.ctypes.data, 1, steps)
    return outputs


def reference(subject, inputs):
    """Outputs of `scan`."""
    return scan(subject.block, inputs).values


def worst_share(found, wanted):
    """Largest difference of each output in shares of its range; NaN has to stand where NaN stands."""
    assert np.array_equal(np.isnan(found), np.isnan(wanted))
    span = np.nanmax(wanted, axis=0) - np.nanmin(wanted, axis=0)
    same = (found == wanted) | np.isnan(wanted)
    return np.where(same, 0.0, np.abs(found - wanted)).max(axis=0) / np.where(span > 0.0, span, 1.0)


__all__ = ["exported", "needs_gcc", "reference", "rounded", "run", "worst_share"]
