"""The virtual bench for identification, and its experiments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.methods.identification.bench_recording import BenchParameters, BenchRecording, bench_recording
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import Acting, ColumnBench
from tierod_lab.ground.courses.bench import BenchMultisine, BenchRamps, BenchSweep, BenchTorque
from tierod_lab.ground.steering.friction import Dahl, DryFriction
from tierod_lab.papers.column.swept_bench import NOISE

SAMPLE_TIME = 1e-3  # Sampling interval [s]

EXPERIMENTS: dict[str, BenchTorque] = {
    "sweep, wheel free": BenchSweep(amplitude=0.3, lowest=0.3, highest=20.0, settle=0.2, time=6.2, wheel="free"),
    "sweep, wheel locked": BenchSweep(amplitude=0.3, lowest=0.5, highest=30.0, settle=0.2, time=6.2, wheel="locked"),
    "ramps, wheel locked": BenchRamps(amplitude=0.35, period=3.0, settle=0.2, time=6.2, wheel="locked"),
    "many sines, wheel free": BenchMultisine(amplitude=0.25, settle=0.2, time=6.2, wheel="free"),
}
"""Experiments by name, about 25 s in all."""

BUILD_UP = 0.05
"""Angle over which the bench's friction builds up [rad]: 0.1 N m of friction over 2 N m/rad of stiffness."""


def truth() -> BenchParameters:
    """True parameters of the bench, from the vehicle file of the same set; the plant shares no code with the model."""
    return load("column-bench").parameters_for(BenchParameters)


def bench() -> ColumnBench:
    """The virtual bench with Dahl's friction."""
    return replace(ColumnBench(), friction=DryFriction(level=0.1, law=Dahl(BUILD_UP)))


def recorded(plant: ColumnBench, seed: int, seconds: float | None = None) -> dict[str, Recording]:
    """Simulate all experiments and record them; each lasts as long as it does by itself where no duration is given."""
    random = np.random.default_rng([seed, 2])
    found = {}
    for name, whole in EXPERIMENTS.items():
        test = whole if seconds is None else replace(whole, time=seconds)
        time = np.arange(round(test.duration / SAMPLE_TIME)) * SAMPLE_TIME
        columns = test.columns(time, time, 0.0, 0.0)
        torque = columns["motor_torque"]
        # An unrecorded torque of zero: its draw keeps the noise of the sensors that of every such bench.
        random.standard_normal(len(time))
        result = scan(plant, _samples(columns, len(time)))
        channels = {
            signal: Channel(signal, time, result[signal] + noise * random.standard_normal(len(time)), "")
            for signal, noise in NOISE.items()
        }
        channels["motor_torque"] = Channel("motor_torque", time, torque, "N*m")
        found[name] = Recording(channels)
    return found


def _samples(columns: dict[str, np.ndarray], count: int) -> np.ndarray:
    names = [name for name, _ in leaves(skeleton(Acting))]
    usual = [np.full(count, float(name.endswith(".gain"))) for name in names]
    return np.column_stack([columns.get(name, column) for name, column in zip(names, usual, strict=True)])


def experiments(recordings: dict[str, Recording], start: BenchParameters) -> list[BenchRecording]:
    """Prepare recordings for the identification."""
    return [bench_recording(name, each, start) for name, each in recordings.items()]
