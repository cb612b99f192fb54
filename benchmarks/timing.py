"""Times of kernels and functions, and rows of the benchmark table."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from tierod.core.block import Block
from tierod.core.graph.kernel import Engine, LaneKernel, kernel, lane_array
from tierod.core.graph.trace import LANES, initial_memory


def row(name: str, value: float, unit: str, peer: str, peer_value: float, **remarks: float) -> dict:
    """Row of the table; the ratio to the peer is above 1 where ours is better.

    Args:
        unit: a rate where it contains "/s" or "real time", otherwise a duration
    """
    faster = value / peer_value if unit.endswith(("/s", "real time")) else peer_value / value
    return {
        "name": name, "value": value, "unit": unit, "peer": peer, "peer_value": peer_value, "ratio": faster, **remarks
    }  # fmt: skip


def fastest(work: Callable[[], Any], repeats: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """Duration of the fastest of several calls [s]; processor time is independent of other programs."""
    times = []
    for _ in range(repeats):
        begin = clock()
        work()
        times.append(clock() - begin)
    return min(times)


def single(
    block: Block,
    samples: np.ndarray,
    repeats: int,
    engine: Engine = "auto",
    clock: Callable[[], float] = time.perf_counter,
) -> tuple[float, np.ndarray]:
    """Time per step of one recording [ns], and the outputs."""
    runner = kernel(block, engine)
    outputs = np.empty((len(samples), len(runner.graph.output)))
    seconds = fastest(lambda: runner.scan(initial_memory(block), samples, outputs, 0), repeats, clock)
    return 1e9 * seconds / len(samples), outputs


def in_lanes(block: Block, samples: np.ndarray, repeats: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """Time per step and lane [ns].

    Args:
        samples: of every lane, (n, signals, LANES)
    """
    runner = LaneKernel([block] * LANES)
    given, outputs = lane_array(*samples.shape[:2]), lane_array(len(samples), len(runner.graph.output))
    given[:] = samples
    first = initial_memory(block)[:, None]
    states = lane_array(len(first))

    def work() -> None:
        states[:] = first
        runner.scan(states, given, outputs, 0)

    return 1e9 * fastest(work, repeats, clock) / (len(samples) * LANES)
