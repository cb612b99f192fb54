"""Inputs of a drive, or random and altered ones, and test vectors: outputs in double precision, and tolerances."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.core.graph.analysis import operation_count
from tierod.core.recording import Recording
from tierod.core.signals import SIGNALS
from tierod.export.interface import Interface
from tierod.export.subject import Subject
from tierod.io.derive import complete
from tierod.io.readers import read
from tierod.monitors.runner import find
from tierod.vehicles import Vehicle
from tierod.vehicles.vehicle import read_by


def inputs_from(subject: Subject, vehicle: Vehicle, source: Recording | str | Path) -> np.ndarray:
    """Input samples (n, inputs) of a monitor from a recording; NaN where a signal is missing."""
    monitor, variant = find(subject.monitor, subject.variant)
    databases, used = read_by(vehicle)
    whole = source if isinstance(source, Recording) else read(source, dbc=databases, channel_map=used)
    names = subject.graph.sample
    filled = complete(whole, [*monitor.needing(variant).required, *monitor.optional, *names])
    known = [name for name in names if name in filled]
    if not known:
        raise InputError(
            f"the recording has none of the inputs of the monitor '{subject.monitor}' ({', '.join(names)}); give "
            "another one, or a channel map in the vehicle file"
        )
    aligned = filled.align(known, subject.rate, maximum_age=monitor.maximum_age)
    values = np.full((len(aligned.time), len(names)), np.nan)
    for name in known:
        values[:, names.index(name)] = aligned.values[:, aligned.names.index(name)]
    if not len(values):
        raise InputError("the recording holds no samples; give a longer one")
    return values


SEED = 20261123
SHARE: Annotated[float, ""] = 0.3  # Share of the plausible range in which a signal usually stays
UNBOUNDED: Annotated[float, ""] = 10.0  # Bound of a signal without a plausible range, in its unit
STEPS_BETWEEN_GAPS = 400
# Longest gap [samples]; longer than signals are held, so that the recovery from a missing signal is reached too
LONGEST_GAP = 120


# Operations that samples of one kind may take; without compiler optimisation a step of a bank takes 1 ms, and the
# evidence runs the samples a dozen times
WORK: Annotated[float, ""] = 0.7e9
FEWEST = 1_000

# Operations that all samples with sanitizers may take; there a step of a bank takes 20 ms
SANITIZED_WORK: Annotated[float, ""] = 0.7e9
MOST_SANITIZED = 500_000  # Largest number of samples that run with sanitizers


def affordable(subject: Subject, most: int, work: float = WORK) -> int:
    """Number of samples of one kind that the evidence can afford; smaller where a step is expensive."""
    counted = asdict(operation_count(subject.block))
    operations = sum(count for name, count in counted.items() if name != "states")
    return max(FEWEST, min(most, int(work / max(operations, 1))))


def random_inputs(subject: Subject, count: int, seed: int = SEED) -> np.ndarray:
    """Random samples (count, inputs): slow signals with noise, steps, spikes, frozen stretches and gaps of NaN."""
    generator = np.random.default_rng(seed)
    columns = [_course(generator, _range(name), count) for name in subject.graph.sample]
    return np.column_stack(columns) if columns else np.zeros((count, 0))


def _range(name: str) -> tuple[float, float]:
    low, high = SIGNALS[name].plausible if name in SIGNALS else (-math.inf, math.inf)
    return -UNBOUNDED if math.isinf(low) else low, UNBOUNDED if math.isinf(high) else high


def _course(generator: np.random.Generator, limits: tuple[float, float], count: int) -> np.ndarray:
    low, high = limits
    middle, half = 0.0 if low < 0.0 < high else 0.5 * (low + high), 0.5 * (high - low)
    time = np.arange(count)
    values = np.full(count, middle)
    for period in generator.uniform(30.0, 3000.0, 4):
        size = SHARE * half * generator.uniform(0.05, 0.5)
        values += size * np.sin(2.0 * math.pi * (time / period + generator.uniform()))
    values += half * 0.003 * generator.standard_normal(count)
    for start, stop in _stretches(generator, count, 8):
        kind = generator.integers(4)
        if kind == 0:
            values[start:stop] = values[start]
        elif kind == 1:
            values[start:stop] += half * generator.uniform(-1.0, 1.0)
        elif kind == 2:
            values[start] = generator.uniform(low, high)
        else:
            values[start:stop] = 0.0
    values = np.clip(values, low, high)
    for start, stop in _stretches(generator, count, 4):
        values[start:stop] = np.nan
    return np.asarray(values)


def _stretches(generator: np.random.Generator, count: int, often: int) -> list[tuple[int, int]]:
    """Random beginnings and ends of stretches; with `often` = 8 on average one per `STEPS_BETWEEN_GAPS` samples."""
    number = 1 + count * often // (8 * STEPS_BETWEEN_GAPS)
    starts = generator.integers(0, count, number)
    lengths = generator.integers(1, LONGEST_GAP, number)
    return [(int(start), int(min(start + length, count))) for start, length in zip(starts, lengths, strict=True)]


def disturbed_inputs(inputs: np.ndarray, count: int, seed: int = SEED) -> np.ndarray:
    """Samples (count, inputs) of a repeated drive in which signals fail, for the coverage of fault reactions.

    Args:
        inputs: (n, inputs), the drive
    """
    generator = np.random.default_rng(seed)
    values = np.resize(inputs, (count, inputs.shape[1])).copy()
    spread = np.nanstd(np.where(np.isfinite(inputs), inputs, np.nan), axis=0)
    spread = np.where(np.isfinite(spread) & (spread > 0.0), spread, 1.0)
    for start in range(len(inputs) // 2, count, DISTURBED_EVERY):
        stop = min(start + int(generator.integers(DISTURBED_EVERY // 8, DISTURBED_EVERY)), count)
        failing = generator.random(inputs.shape[1]) < generator.choice([0.15, 0.3, 1.0], p=[0.6, 0.3, 0.1])
        for k in np.flatnonzero(failing):
            values[start:stop, k] = _failed(generator, values[start:stop, k], float(spread[k]))
    return values


def altered_inputs(inputs: np.ndarray, count: int) -> Iterator[np.ndarray]:
    """Samples (at most count, inputs) of a drive in which one signal is scaled or inverted throughout.

    Such a drive belongs to a car that no vehicle file describes, and reaches the plausibility checks of a monitor.

    Args:
        inputs: (n, inputs), the drive
    """
    for column in range(inputs.shape[1]):
        for factor in FACTORS:
            values = inputs[:count].copy()
            values[:, column] *= factor
            yield values


FACTORS = (-1.0, 0.2, 4.0)  # Factors of the changed signal of an altered drive
DISTURBED_EVERY = 1500  # Interval between two failures [samples]


def _failed(generator: np.random.Generator, given: np.ndarray, spread: float) -> np.ndarray:
    size = generator.choice([0.3, 3.0, 100.0]) * spread
    kinds = (
        lambda: np.full(len(given), np.nan),
        lambda: np.where(generator.random(len(given)) < 0.5, np.nan, given),
        lambda: given + size,
        lambda: given * generator.choice([0.0, 0.5, 2.0, -1.0]),
        lambda: np.full(len(given), given[0]),
        lambda: given + np.linspace(0.0, size, len(given)),
        lambda: given + size * generator.standard_normal(len(given)),
        lambda: np.where(generator.random(len(given)) < 0.02, given + 10.0 * size, given),
        lambda: np.full(len(given), generator.choice([np.inf, -np.inf])),
    )
    return np.asarray(kinds[int(generator.integers(len(kinds)))]())


STEPS = 10_000  # Steps of the test vectors of an export; with their outputs about 2 MB of text
SPACING = 10  # Steps between two rows of expected outputs

# Permitted difference as a share of an output's range: for double precision the effect of rounding in filters, for
# single precision that of its 24-bit mantissa
TOLERANCE: Annotated[dict[str, float], ""] = {"double": 1e-6, "single": 1e-2}
# Share of rows that may exceed the tolerance; in single precision a decision may fall a few steps earlier or later
ROWS_BEYOND: Annotated[dict[str, float], ""] = {"double": 0.0, "single": 0.005}


@dataclass(frozen=True)
class Vectors:
    """Inputs, and outputs at regular intervals."""

    inputs: np.ndarray  # (steps, inputs); single-precision numbers, so that they are equal in both precisions
    outputs: np.ndarray  # (rows, outputs) of the steps 0, `SPACING`, ...
    source: str  # description of the origin of the inputs

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
    """
    taken = rounded(inputs[:steps])
    return Vectors(taken, scan(subject.block, taken).values[::SPACING], source)


def tolerances(face: Interface, vectors: Vectors) -> list[float]:
    """Permitted difference of every output."""
    share = TOLERANCE[face.options.precision]
    return [float(f"{share * each:.3g}") for each in vectors.ranges]


def input_table(subject: Subject, vectors: Vectors) -> str:
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
