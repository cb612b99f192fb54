"""Drives of the virtual motor bench, as arrays at the rate of its modulation."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from tierod.core.graph import scan
from tierod.core.graph.trace import trace
from tierod_lab.ground.cars.benches import MotorBench

RATE = 1e4
SUBSTEPS = 10
NOISE = {
    "motor_current_alpha": 0.15,
    "motor_current_beta": 0.15,
    "motor_voltage_alpha": 0.03,
    "motor_voltage_beta": 0.03,
}
SENSOR_NOISE = 5e-4


def to_and_fro(time, seed):
    """A superposition at work: four sines of the motor's angle, up to some 100 rad/s."""
    random = np.random.default_rng(seed)
    angle = sum(
        random.uniform(0.4, 1.0) / (0.4 + f) * np.sin(2.0 * np.pi * f * time + random.uniform(0.0, 2.0 * np.pi))
        for f in (0.15, 0.4, 0.9, 1.7)
    )
    return 12.0 * angle * np.clip(2.0 * time, 0.0, 1.0)


def held(time, seed):
    """Turning for 5.6 s, held against the load until 15 s, then turning on; the same for every seed."""
    moving = np.where(time < 15.0, np.minimum(time, 5.6), 5.6 + time - 15.0)
    return 10.0 * np.sin(2.0 * np.pi * 0.4 * moving) * np.clip(2.0 * time, 0.0, 1.0)


@lru_cache(maxsize=8)
def drive(seed=0, seconds=20.0, course=to_and_fro):
    """Measured signals by canonical name, `sensor` the angle as measured, and the truth."""
    bench = MotorBench()
    time = np.arange(round(seconds * 1e3)) / 1e3
    names = trace(bench).sample
    inputs = np.zeros((len(time), len(names)))
    for column, name in enumerate(names):
        if name.endswith("gain") or name == "control":
            inputs[:, column] = 1.0
        if name == "target_motor_angle":
            inputs[:, column] = course(time, seed)
    found = scan(bench, inputs)

    def fine(name):
        return np.column_stack([found[f"motor.fine.{name}.{k}"] for k in range(SUBSTEPS)]).ravel()

    random = np.random.default_rng([seed, 77])
    signals = {name: fine(name) + noise * random.normal(size=len(time) * SUBSTEPS) for name, noise in NOISE.items()}
    signals["truth_angle"], signals["truth_speed"] = fine("motor_angle_mechanical"), fine("motor_speed")
    signals["sensor"] = signals["truth_angle"] + SENSOR_NOISE * random.normal(size=len(time) * SUBSTEPS)
    return signals


def observed(observer, signals, sensor=None):
    """The observer's outputs over a drive."""
    angle = signals["sensor"] if sensor is None else sensor
    return scan(observer, np.column_stack([*(signals[name] for name in NOISE), angle]))
