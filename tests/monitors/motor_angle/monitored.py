"""The monitor of the motor's angle over drives of the bench."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from exact_vehicle import diagnose
from tierod.core.graph import scan, trace
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.monitors.motor_angle.definition import MotorAngleMonitor
from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.bench import RATE, drive

MONITOR = MotorAngleMonitor.of_vehicle(load("motor-bench"), 1.0 / RATE)
FAULT_FREE = lru_cache(maxsize=8)(lambda seed=3, seconds=9.0: drive(seed, seconds))
COLUMN = {name: column for column, name in enumerate(MotorAngleSample._fields)}


def columns(block, count, **values):
    """Samples of a block, (count, n): some of its signals by the last part of their name, all others missing."""
    named = [values.get(name.rpartition(".")[-1], np.nan) for name in trace(block).sample]
    return np.column_stack([np.broadcast_to(each, count) for each in named]).astype(float)


def alarms_of(samples, monitor=MONITOR):
    """First sample of every alarm, by name."""
    found = scan(monitor, samples)
    names = [name for name in found.names if name.startswith("alarms.") and (found[name] > 0.5).any()]
    return {name.removeprefix("alarms."): int(np.argmax(found[name] > 0.5)) for name in names}


def changed(**columns):
    """A fault-free drive with other columns."""
    samples = FAULT_FREE().samples.copy()
    for name, values in columns.items():
        samples[:, COLUMN[name]] = values
    return samples


def redrawn(samples, signal, change):
    """Samples in which a vector of the stator, as a complex number, is another."""
    samples, columns = samples.copy(), [COLUMN[f"{signal}_{axis}"] for axis in ("alpha", "beta")]
    vector = change(samples[:, columns[0]] + 1j * samples[:, columns[1]])
    samples[:, columns] = np.column_stack([vector.real, vector.imag])
    return samples


def finding(source, vehicle="motor-bench", **more):
    """Of a recording, or of samples."""
    source = source if isinstance(source, Recording) else recording(source)
    return diagnose(source, vehicle, "motor-angle", **more).findings[0]


def recording(samples, **metadata):
    """As a recording: every channel with the samples that it has."""
    time = np.arange(len(samples)) / RATE
    channels = {}
    for name, column in COLUMN.items():
        there = np.isfinite(samples[:, column])
        if there.any():
            channels[name] = Channel(name, time[there], samples[there, column], SIGNALS[name].unit)
    return Recording(channels, metadata)


def vehicle_with(name="motor-bench", **parameters):
    """A vehicle with other values."""
    vehicle = load(name)
    own = {key: replace(vehicle.parameters[key], value=value) for key, value in parameters.items()}
    return replace(vehicle, parameters={**vehicle.parameters, **own})
