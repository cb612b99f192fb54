"""Benches for identification: the virtual bench, its experiments, and deviations that the model does not contain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.graph import scan
from tierod.core.recording import Channel, Recording
from tierod.methods.identification.bench_recording import BenchRecording, bench_recording
from tierod.methods.identification.sampled_column import BenchParameters
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import Acting, ColumnBench
from tierod_lab.ground.courses.bench import BenchMultisine, BenchRamps, BenchSweep, BenchTorque
from tierod_lab.ground.steering import Ripple
from tierod_lab.ground.steering.friction import Dahl, DahlPower, DryFriction, Law, LuGre, MaxwellSlip, Stribeck
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

LAWS: dict[str, Law] = {
    "Dahl, exponent 0.5": DahlPower(BUILD_UP, 0.5),
    "Dahl, exponent 2": DahlPower(BUILD_UP, 2.0),
    "Stribeck, 20 % at rest": Stribeck(BUILD_UP, 0.2, 1.0),
    "LuGre, 20 % at rest": LuGre(BUILD_UP, 0.2, 1.0),
    "Maxwell slip, 4 elements": MaxwellSlip((0.02, 0.04, 0.06, 0.08)),
}
"""Friction laws outside the model of the identification, with the same level and about the same build-up."""


def truth() -> BenchParameters:
    """True parameters of the bench, from the vehicle file of the same set; the plant shares no code with the model."""
    return load("column-bench").parameters_for(BenchParameters)


def bench(law: Law | None = None, cogging: float = 0.0, ripple: float = 0.0) -> ColumnBench:
    """A bench with another friction law, or with torque ripple of the motor.

    Args:
        law: friction law; Dahl's where None
        cogging: amplitude of the cogging torque, 24 periods per turn [N m]
        ripple: amplitude of the torque ripple over the torque [-]
    """
    friction = DryFriction(level=0.1, law=law or Dahl(BUILD_UP))
    motor = Ripple(cogging, ripple, 24.0) if cogging or ripple else None
    return replace(ColumnBench(), friction=friction, ripple=motor)


def recorded(
    plant: ColumnBench, seed: int, torque_noise: float = 0.0, torque_gain: float = 1.0, seconds: float | None = None
) -> dict[str, Recording]:
    """Simulate all experiments and record them.

    Args:
        torque_noise: standard deviation of an unrecorded motor torque per sample [N m]
        torque_gain: true torque of the motor over the recorded one [-]
        seconds: duration of every experiment; its own where None [s]
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
    """Prepare recordings for the identification."""
    return [bench_recording(name, each, start) for name, each in recordings.items()]
