"""Default monitors as run by `diagnose`, on a simulated drive: one vehicle, and several side by side.

The peer is the same graph on CasADi's virtual machine, which runs it without a compiler.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from tierod.core.block import Block
from tierod.core.graph.kernel import Engine, LaneKernel, kernel, lane_array
from tierod.core.graph.printer import LANES
from tierod.core.graph.trace import initial_memory
from tierod.io.derive import complete
from tierod.monitors.harness.session import BlockSession, opened
from tierod.monitors.registry import MONITORS
from tierod.vehicles import load
from tierod_lab.ground import drive

MONITORS_TIMED = ("friction", "driver-torque", "sideslip")
VEHICLE = "midsize-eps"
MINUTES, LANE_STEPS, PEER_STEPS = 10.0, 1_000, 5_000
REPEATS = 7


def run() -> list[dict]:
    """Two rows per monitor: name, value, unit, peer, its value, ratio (peer over ours)."""
    recording = drive(minutes=MINUTES, seed=1)
    vehicle, rows = load(VEHICLE), []
    for name in MONITORS_TIMED:
        monitor = MONITORS.required(name)
        session = opened(monitor, monitor.variants[str(monitor.default)], vehicle)
        assert isinstance(session, BlockSession)
        whole = complete(recording, [*monitor.required, *monitor.optional])
        samples = whole.align(session.signals, monitor.rate, maximum_age=monitor.maximum_age).values
        values = np.ascontiguousarray(samples)
        peer = _single(session.block, values[-PEER_STEPS:], "virtual machine")
        for key, value in (("single", _single(session.block, values)), ("lanes", _lanes(session.block, values))):
            rows.append(
                {
                    "name": f"monitor-{name}-{key}",
                    "value": value,
                    "unit": "ns/step",
                    "peer": "CasADi's virtual machine, the same graph",
                    "peer_value": peer,
                    "ratio": peer / value,
                }
            )
    return rows


def _least(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Processor time of the fastest of several runs [ns]."""
    seconds = []
    for _ in range(repeats):
        begin = time.process_time()
        work()
        seconds.append(time.process_time() - begin)
    return 1e9 * min(seconds)


def _single(block: Block, samples: np.ndarray, engine: Engine = "auto") -> float:
    runner = kernel(block, engine)
    outputs = np.empty((len(samples), len(runner.graph.output)))
    return _least(lambda: runner.scan(initial_memory(block), samples, outputs, 0)) / len(samples)


def _lanes(block: Block, samples: np.ndarray) -> float:
    """Time per step and lane, with a different stretch of the drive in every lane [ns]."""
    runner = LaneKernel([block] * LANES)
    starts = np.linspace(0, len(samples) - LANE_STEPS, LANES).astype(int)
    given, outputs = lane_array(LANE_STEPS, samples.shape[1]), lane_array(LANE_STEPS, len(runner.graph.output))
    given[:] = np.stack([samples[start : start + LANE_STEPS] for start in starts], axis=2)
    first = initial_memory(block)[:, None]
    states = lane_array(len(first))

    def work() -> None:
        states[:] = first
        runner.scan(states, given, outputs, 0)

    return _least(work) / (LANE_STEPS * LANES)
