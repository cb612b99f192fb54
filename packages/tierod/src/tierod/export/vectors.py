"""Test vectors: inputs of a drive, outputs of a monitor in double precision, and tolerances for an export."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.graph import scan
from tierod.export.interface import Interface
from tierod.export.subject import Subject

STEPS = 10_000
"""Steps of the test vectors of an export; with their outputs about 2 MB of text."""
SPACING = 10
"""Steps between two rows of expected outputs."""

TOLERANCE: Annotated[dict[str, float], ""] = {"double": 1e-6, "single": 1e-2}
"""Permitted difference as a share of an output's range: for double precision the effect of rounding in filters, for
single precision that of its 24-bit mantissa."""
ROWS_BEYOND: Annotated[dict[str, float], ""] = {"double": 0.0, "single": 0.005}
"""Share of rows that may exceed the tolerance; in single precision a decision may fall a few steps earlier or later."""


@dataclass(frozen=True)
class Vectors:
    """Inputs, and outputs at regular intervals.

    Args:
        inputs: (steps, inputs); single-precision numbers, so that they are equal in both precisions
        outputs: (rows, outputs) of the steps 0, `SPACING`, ...
        source: description of the origin of the inputs
    """

    inputs: np.ndarray
    outputs: np.ndarray
    source: str

    @property
    def ranges(self) -> np.ndarray:
        """Range of every output (maximum minus minimum); 1 where it is constant."""
        finite = np.where(np.isfinite(self.outputs), self.outputs, np.nan)
        known = ~np.isnan(finite).all(axis=0)
        span = np.zeros(finite.shape[1])
        span[known] = np.nanmax(finite[:, known], axis=0) - np.nanmin(finite[:, known], axis=0)
        return np.where(span > 0.0, span, 1.0)


def rounded(inputs: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):
        return np.asarray(inputs, dtype=np.float32).astype(float)


def vectors_of(subject: Subject, inputs: np.ndarray, source: str, steps: int = STEPS) -> Vectors:
    """Test vectors from the first steps of a drive.

    Args:
        inputs: (n, inputs)
        source: description of the origin of the inputs
    """
    taken = rounded(inputs[:steps])
    return Vectors(taken, scan(subject.block, taken).values[::SPACING], source)


def tolerances(face: Interface, vectors: Vectors) -> list[float]:
    """Permitted difference of every output."""
    share = TOLERANCE[face.options.precision]
    return [float(f"{share * each:.3g}") for each in vectors.ranges]


def input_table(subject: Subject, vectors: Vectors) -> str:
    """Inputs as CSV text."""
    rows = (",".join(_written(value, 9) for value in row) for row in vectors.inputs.tolist())
    return "\n".join([",".join(subject.graph.sample), *rows]) + "\n"


def output_table(subject: Subject, vectors: Vectors) -> str:
    """Expected outputs as CSV text, with the step number in the first column."""
    rows = (
        ",".join([str(k * SPACING), *(_written(value, 17) for value in row)])
        for k, row in enumerate(vectors.outputs.tolist())
    )
    return "\n".join([",".join(("step", *subject.graph.output)), *rows]) + "\n"


def _written(value: float, digits: int) -> str:
    return "nan" if value != value else f"{value:.{digits}g}"
