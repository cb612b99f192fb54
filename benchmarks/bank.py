"""Fifty filters on one signal with a judge: as a bank, and as a Python loop over the same compiled filters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.filters import EnabledFilter
from benchmarks.timing import fastest, row
from tierod.core.block import Tree
from tierod.core.graph import KEEP, Bank, JudgeSample, Stream, Verdict, scan
from tierod.core.graph.maths import maximum, where
from tierod.models.friction_estimation import FrictionParameters
from tierod.vehicles import load
from tierod_lab.papers.friction.presets import printed

LANES = 50
STEPS = 20_000
LOOPED_STEPS = 500
REPEATS = 5


@dataclass(frozen=True)
class LeastFriction:
    """Judge that selects the smallest friction estimated by any filter."""

    lanes: int

    def feedback(self) -> Tree:
        """No feedback to the filters."""
        return ()

    def init(self) -> Tree:
        """No state."""
        return ()

    def step(self, state: Tree, sample: JudgeSample) -> tuple[Tree, Verdict]:
        """Smallest friction estimate, and the number of its filter."""
        values = [lane.friction_torque for lane in sample.lanes]
        least, chosen = values[0], 0.0
        for number, value in enumerate(values[1:], 1):
            chosen = where(value < least, float(number), chosen)
            least = -maximum(-least, -value)
        return state, Verdict((least, chosen), (KEEP,) * self.lanes)


def run() -> list[dict]:
    """Rows of the benchmark table: name, value, unit, peer, its value, ratio (peer over ours)."""
    monitor = printed(load("midsize-eps").parameters_for(FrictionParameters))
    noises = np.geomspace(0.1, 10.0, LANES)
    filters = [_filter(monitor, float(noise)) for noise in noises]
    samples = np.random.default_rng(0).normal(size=(STEPS, 6)) * 0.3
    bank = Bank(tuple(filters), LeastFriction(LANES))
    scan(bank, samples[:10])
    value = 1e6 * fastest(lambda: scan(bank, samples), REPEATS) / STEPS
    streams = [Stream(each) for each in filters]
    peer = 1e6 * fastest(lambda: _looped(streams, samples[:LOOPED_STEPS]), REPEATS) / LOOPED_STEPS
    return [row(f"bank-of-{LANES}", value, "us/sample", "Python loop over compiled filters", peer)]


def _filter(monitor: Any, noise: float) -> EnabledFilter:
    scaled = tuple(noise * variance for variance in monitor.filter.measurement_noise)
    return EnabledFilter(replace(monitor.filter, measurement_noise=scaled), monitor.gate)


def _looped(streams: list[Stream], samples: np.ndarray) -> list[float]:
    least = []
    for sample in samples:
        for stream in streams:
            stream.inputs[:] = sample
            stream.advance()
        least.append(min(stream.outputs[4] for stream in streams))
    return least
