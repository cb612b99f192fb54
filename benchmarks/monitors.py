"""Default monitors as run by `diagnose`, on a simulated drive: one vehicle, and several side by side.

The peer is the same graph on CasADi's virtual machine, which runs it without a compiler.
"""

from __future__ import annotations

import time

import numpy as np

from benchmarks.timing import in_lanes, row, single
from tierod.core.graph.trace import LANES
from tierod.io.derive import complete
from tierod.monitors.registry import MONITORS
from tierod.monitors.session import BlockSession, opened
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
        peer = single(session.block, values[-PEER_STEPS:], REPEATS, "virtual machine", time.process_time)[0]
        starts = np.linspace(0, len(values) - LANE_STEPS, LANES).astype(int)
        stretches = np.stack([values[start : start + LANE_STEPS] for start in starts], axis=2)
        times = {
            "single": single(session.block, values, REPEATS, clock=time.process_time)[0],
            "lanes": in_lanes(session.block, stretches, REPEATS, time.process_time),
        }
        rows += [
            row(f"monitor-{name}-{key}", value, "ns/step", "CasADi's virtual machine, the same graph", peer)
            for key, value in times.items()
        ]
    return rows
