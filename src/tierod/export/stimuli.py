"""Inputs to compare by: drawn at random within the plausible range of every signal, with values that are missing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Annotated

import numpy as np

from tierod.core.graph.operation_count import operation_count
from tierod.core.signals import SIGNALS
from tierod.export.subject import Subject

SEED = 20261123
SHARE: Annotated[float, ""] = 0.3
"""Of the plausible range that a signal usually stays in."""
UNBOUNDED: Annotated[float, ""] = 10.0
"""Half range of a signal for which the catalogue names none, in its unit."""
STEPS_BETWEEN_GAPS = 400
LONGEST_GAP = 120
"""Samples: longer than signals are held for, so that whatever waits for a signal to return is reached too."""


WORK: Annotated[float, ""] = 0.7e9
"""Operations that samples of one kind may take: compiled without optimisation, a bank takes a millisecond for a step,
and the evidence runs it a dozen times over."""
FEWEST = 1_000

SANITIZED_WORK: Annotated[float, ""] = 0.7e9
"""Operations of all samples together that run with sanitizers: a step of a bank takes 20 ms with them."""
MOST_SANITIZED = 500_000
"""Samples that run with sanitizers at the most."""


def affordable(subject: Subject, most: int, work: float = WORK) -> int:
    """Samples of one kind that the evidence takes: fewer where a step is long.

    Args:
        subject: that runs
        most: samples
        work: operations that they may take
    """
    counted = asdict(operation_count(subject.block))
    operations = sum(count for name, count in counted.items() if name != "states")
    return max(FEWEST, min(most, int(work / max(operations, 1))))


def random_inputs(subject: Subject, count: int, seed: int = SEED) -> np.ndarray:
    """Samples (count, inputs): slow courses with noise, steps, spikes, values that repeat, and gaps of NaN.

    Args:
        subject: whose inputs they are
        count: of samples
        seed: of all chance
    """
    generator = np.random.default_rng(seed)
    columns = [_course(generator, _range(name), count) for name in subject.graph.sample]
    return np.column_stack(columns) if columns else np.zeros((count, 0))


def _range(name: str) -> tuple[float, float]:
    low, high = SIGNALS[name].plausible if name in SIGNALS else (-math.inf, math.inf)
    return max(low, -UNBOUNDED), min(high, UNBOUNDED) if math.isinf(high) else high


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
    """Beginnings and ends of stretches, as many as `often` for every few gaps."""
    number = 1 + count * often // (8 * STEPS_BETWEEN_GAPS)
    starts = generator.integers(0, count, number)
    lengths = generator.integers(1, LONGEST_GAP, number)
    return [(int(start), int(min(start + length, count))) for start, length in zip(starts, lengths, strict=True)]


def disturbed_inputs(inputs: np.ndarray, count: int, seed: int = SEED) -> np.ndarray:
    """Samples (count, inputs) of a drive, over and over, in which signals fail: for the coverage of what faults reach.

    Args:
        inputs: (n, inputs) of a drive
        count: of samples
        seed: of all chance
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
    """Samples (at most count, inputs) of a drive in which one signal has another size or sign throughout.

    So the drive is one of a car that no vehicle file describes: what a monitor finds implausible is reached.

    Args:
        inputs: (n, inputs) of a drive
        count: of samples of each
    """
    for column in range(inputs.shape[1]):
        for factor in FACTORS:
            values = inputs[:count].copy()
            values[:, column] *= factor
            yield values


FACTORS = (-1.0, 0.2, 4.0)
"""Of the signals of an altered drive."""

DISTURBED_EVERY = 1500
"""Samples from one failure to the next."""


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
