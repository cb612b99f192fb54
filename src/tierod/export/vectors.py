"""Test vectors: a drive, what a monitor states about it in double precision, and how far an export may differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.graph import scan
from tierod.export.interface import Interface
from tierod.export.subject import Subject

STEPS = 10_000
"""Of the test vectors of an export: with their outputs some 2 MB of text."""
SPACING = 10
"""Steps between two rows of expected outputs."""

TOLERANCE: Annotated[dict[str, float], ""] = {"double": 1e-6, "single": 1e-2}
"""Share of an output's range in which other compilers and processors may differ: in double what sums of different
rounding become in a filter, in single its 24 bits."""
ROWS_BEYOND: Annotated[dict[str, float], ""] = {"double": 0.0, "single": 0.005}
"""Share of rows that may lie beyond it: in single a decision may fall a few steps earlier or later."""


@dataclass(frozen=True)
class Vectors:
    """Inputs, and outputs at some of their steps.

    Args:
        inputs: (steps, inputs); single-precision numbers, so that both precisions see the same
        outputs: (rows, outputs), of the steps 0, `SPACING`, ...
        source: where the inputs come from, in words
    """

    inputs: np.ndarray
    outputs: np.ndarray
    source: str

    @property
    def ranges(self) -> np.ndarray:
        """Largest less smallest value of every output; 1 where it never changes."""
        finite = np.where(np.isfinite(self.outputs), self.outputs, np.nan)
        known = ~np.isnan(finite).all(axis=0)
        span = np.zeros(finite.shape[1])
        span[known] = np.nanmax(finite[:, known], axis=0) - np.nanmin(finite[:, known], axis=0)
        return np.where(span > 0.0, span, 1.0)


def rounded(inputs: np.ndarray) -> np.ndarray:
    """Inputs as single precision holds them."""
    with np.errstate(over="ignore"):
        return np.asarray(inputs, dtype=np.float32).astype(float)


def vectors_of(subject: Subject, inputs: np.ndarray, source: str, steps: int = STEPS) -> Vectors:
    """Test vectors from the first steps of a drive.

    Args:
        subject: that is exported
        inputs: (n, inputs)
        source: where they come from, in words
        steps: at the most
    """
    taken = rounded(inputs[:steps])
    return Vectors(taken, scan(subject.block, taken).values[::SPACING], source)


def tolerances(face: Interface, vectors: Vectors) -> list[float]:
    """Difference of every output that passes."""
    share = TOLERANCE[face.options.precision]
    return [float(f"{share * each:.3g}") for each in vectors.ranges]


def input_table(subject: Subject, vectors: Vectors) -> str:
    """The inputs as CSV."""
    rows = (",".join(_written(value, 9) for value in row) for row in vectors.inputs.tolist())
    return "\n".join([",".join(subject.graph.sample), *rows]) + "\n"


def output_table(subject: Subject, vectors: Vectors) -> str:
    """The expected outputs as CSV, the number of the step first."""
    rows = (
        ",".join([str(k * SPACING), *(_written(value, 17) for value in row)])
        for k, row in enumerate(vectors.outputs.tolist())
    )
    return "\n".join([",".join(("step", *subject.graph.output)), *rows]) + "\n"


def _written(value: float, digits: int) -> str:
    return "nan" if value != value else f"{value:.{digits}g}"
