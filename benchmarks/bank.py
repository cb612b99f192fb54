"""Fifty filters on one signal with a judge: as a bank, and as a Python loop over the same compiled filters."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.filters import EnabledFilter
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
    value = min(_timed(lambda: scan(bank, samples)) for _ in range(REPEATS)) / STEPS
    streams = [Stream(each) for each in filters]
    peer = min(_timed(lambda: _looped(streams, samples[:LOOPED_STEPS])) for _ in range(REPEATS)) / LOOPED_STEPS
    return [
        {
            "name": f"bank-of-{LANES}",
            "value": 1e-3 * value,
            "unit": "us/sample",
            "peer": "Python loop over compiled filters",
            "peer_value": 1e-3 * peer,
            "ratio": peer / value,
        }
    ]


def _filter(monitor: Any, noise: float) -> EnabledFilter:
    scaled = tuple(noise * variance for variance in monitor.filter.measurement_noise)
    return EnabledFilter(replace(monitor.filter, measurement_noise=scaled), monitor.gate)


def _looped(streams: list[Stream], samples: np.ndarray) -> list[float]:
    least = []
    for row in samples:
        for stream in streams:
            stream.inputs[:] = row
            stream.advance()
        least.append(min(stream.outputs[4] for stream in streams))
    return least


def _timed(function: Any) -> float:
    """Duration of one call [ns]."""
    start = time.perf_counter_ns()
    function()
    return float(time.perf_counter_ns() - start)
