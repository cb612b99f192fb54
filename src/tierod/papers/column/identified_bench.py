"""Benches that are identified: the virtual one, its experiments, and what the model of the identification lacks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.methods.identification.bench_recording import BenchRecording, bench_recording
from tierod.methods.identification.sampled_column import BenchParameters
from tierod.papers.column.swept_bench import NOISE
from tierod.proving_ground.cars.column_bench import Acting, ColumnBench
from tierod.proving_ground.courses.bench import BenchMultisine, BenchRamps, BenchSweep, BenchTorque
from tierod.proving_ground.steering.friction import DryFriction
from tierod.proving_ground.steering.friction_laws import Dahl, DahlPower, Law, LuGre, MaxwellSlip, Stribeck
from tierod.proving_ground.steering.shaft import Ripple
from tierod.vehicles import load

SAMPLE_TIME = 1e-3

EXPERIMENTS: dict[str, BenchTorque] = {
    "sweep, wheel free": BenchSweep(amplitude=0.3, lowest=0.3, highest=20.0, settle=0.2, time=6.2, wheel="free"),
    "sweep, wheel locked": BenchSweep(amplitude=0.3, lowest=0.5, highest=30.0, settle=0.2, time=6.2, wheel="locked"),
    "ramps, wheel locked": BenchRamps(amplitude=0.35, period=3.0, settle=0.2, time=6.2, wheel="locked"),
    "many sines, wheel free": BenchMultisine(amplitude=0.25, settle=0.2, time=6.2, wheel="free"),
}
"""About 25 s in all."""

BUILD_UP = 0.05
"""Angle of Dahl's law of the bench [rad]: 0.1 N m of friction, 2 N m/rad of stiffness."""

LAWS: dict[str, Law] = {
    "Dahl, exponent 0.5": DahlPower(BUILD_UP, 0.5),
    "Dahl, exponent 2": DahlPower(BUILD_UP, 2.0),
    "Stribeck, 20 % at rest": Stribeck(BUILD_UP, 0.2, 1.0),
    "LuGre, 20 % at rest": LuGre(BUILD_UP, 0.2, 1.0),
    "Maxwell slip, 4 elements": MaxwellSlip((0.02, 0.04, 0.06, 0.08)),
}
"""Laws that the model of the identification does not know, of the same level and about the same build-up."""


def truth() -> BenchParameters:
    """Parameters of the bench, by the vehicle file of the same set; the plant has a code of its own."""
    return load("column-bench").parameters_for(BenchParameters)


def bench(law: Law | None = None, cogging: float = 0.0, ripple: float = 0.0) -> ColumnBench:
    """A bench with another law of friction, or with a motor that cogs.

    Args:
        law: of the friction; Dahl's where None
        cogging: amplitude, 24 times a turn [N m]
        ripple: amplitude over the torque []
    """
    friction = DryFriction(level=0.1, law=law or Dahl(BUILD_UP))
    motor = Ripple(cogging, ripple, 24.0) if cogging or ripple else None
    return replace(ColumnBench(), friction=friction, ripple=motor)


def recorded(
    plant: ColumnBench, seed: int, torque_noise: float = 0.0, torque_gain: float = 1.0, seconds: float | None = None
) -> dict[str, Recording]:
    """Recordings of all experiments.

    Args:
        plant: the bench
        seed: of all noise
        torque_noise: of the motor's torque, unrecorded [N m] per sample
        torque_gain: true torque of the motor over the recorded one []
        seconds: of every experiment; its own time where None
    """
    random = np.random.default_rng([seed, 2])
    found = {}
    for name, whole in EXPERIMENTS.items():
        test = whole if seconds is None else replace(whole, time=seconds)
        time = np.arange(round(test.duration / SAMPLE_TIME)) * SAMPLE_TIME
        columns = test.columns(time, time, 0.0, 0.0)
        torque = columns["motor_torque"]
        columns["motor_torque"] = torque_gain * torque
        columns["motor_disturbance"] = torque_noise * random.standard_normal(len(time))
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
    """Recordings made ready for identification."""
    return [bench_recording(name, each, start) for name, each in recordings.items()]
