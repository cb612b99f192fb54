"""A signal whose readings scatter far more than those of usual sensors is named with its noise, whoever reads it."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from tierod.core.findings import Finding, Status
from tierod.core.recording import Recording
from tierod.monitors.diagnose import diagnose
from tierod.monitors.inspection import inspect
from tierod_lab.ground import drive, lock_to_lock
from tierod_lab.ground.scenarios import load

NOISE = 0.6


def noisy(recording: Recording, name: str = "driver_torque", deviation: float = NOISE) -> Recording:
    channel = recording[name]
    scatter = np.random.default_rng(3).normal(scale=deviation, size=len(channel.values))
    return recording.with_channels([dataclasses.replace(channel, values=channel.values + scatter)])


def judged(recording: Recording, monitor: str, variant: str | None = None) -> Finding:
    return diagnose(recording, "midsize-eps", monitor, variant, spread=False).findings[0]


@pytest.fixture(scope="module")
def bends() -> Recording:
    return drive(minutes=3.0, friction=4.0, seed=8)


RECORDINGS = {
    "hysteresis": lambda bends: lock_to_lock(4.0, hoist=True, seed=5),
    "driver-torque": lambda bends: dataclasses.replace(load("hands-off"), faults=()).with_run(20.0, 5).run().recording,
    "friction": lambda bends: bends,
}


@pytest.mark.parametrize("monitor", RECORDINGS)
def test_every_monitor_names_the_noise_of_the_driver_torque_with_its_size(monitor, bends):
    recording = RECORDINGS[monitor](bends)
    variant = "hoist" if monitor == "hysteresis" else None
    quiet, loud = judged(recording, monitor, variant), judged(noisy(recording), monitor, variant)
    assert not any("scatter by" in each for each in (quiet.cause, *quiet.warnings))
    (said,) = [each for each in loud.warnings if "the readings of driver_torque scatter by" in each]
    size = float(re.search(r"scatter by ([\d.]+) N·m", said)[1])
    assert size == pytest.approx(NOISE, rel=0.15)


def test_noise_is_the_first_cause_where_nothing_is_identifiable(bends):
    found = judged(noisy(bends, "steering_wheel_rate", 1.0), "friction")
    assert found.status is Status.NOT_IDENTIFIABLE
    assert found.cause.startswith("the readings of steering_wheel_rate scatter by")
    assert "check the sensor" in found.cause


def test_an_inspection_names_noise(bends):
    assert not any("scatter by" in each for each in inspect(bends).warnings)
    assert any("motor_torque scatter by" in each for each in inspect(noisy(bends, "motor_torque", 0.2)).warnings)


@pytest.mark.parametrize(("step", "rate"), [(0.5, 100.0), (0.0, 10.0)])
def test_coarse_or_held_readings_are_no_noise(bends, step, rate):
    torque = bends["driver_torque"]
    values = np.round(torque.values / step) * step if step else torque.values
    held = np.floor(np.arange(len(values)) * rate / 100.0) * 100.0 / rate
    slow = dataclasses.replace(torque, values=values[held.astype(int)])
    assert not any("scatter by" in each for each in inspect(bends.with_channels([slow])).warnings)


def test_the_noise_does_not_depend_on_the_cuts(bends):
    from tierod.io.readings import Noise

    values = noisy(bends)["driver_torque"].values
    whole, cut = Noise(), Noise()
    whole.add(values)
    for part in np.array_split(values, 41):
        cut.add(part)
    assert cut.deviation(100.0) == whole.deviation(100.0)
