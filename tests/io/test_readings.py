"""Readings that scatter far more than usual, and readings that a file repeats in many rows, are named with figures."""

from __future__ import annotations

import dataclasses
import itertools
import re

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.core.findings import Finding, Status
from tierod.core.recording import Channel, Recording
from tierod.io.quality import channel_quality
from tierod.monitors.diagnose import diagnose
from tierod.monitors.inspection import inspect
from tierod.monitors.pieces import QualityOverChunks
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
    from tierod.io.readings import Readings

    values = noisy(bends)["driver_torque"].values
    whole, cut = Readings(), Readings()
    whole.add(values)
    for part in np.array_split(values, 41):
        cut.add(part)
    assert cut.deviation(100.0) == whole.deviation(100.0)


RATE = 50.0
TIME = np.arange(round(200 * RATE)) / RATE
SPEED = np.maximum(8.0 + 9.0 * np.sin(0.13 * TIME) + np.sin(0.71 * TIME), 0.0)
"""Speed of a car that stands at times [m/s]."""


def speed(values: np.ndarray) -> Channel:
    return Channel("vehicle_speed", TIME, values, "m/s")


def held(rows: int, step: float = 0.01) -> np.ndarray:
    return np.round(SPEED[np.arange(len(TIME)) // rows * rows] / step) * step


def checked(values: np.ndarray, pieces: int) -> QualityOverChunks:
    whole, quality = Recording({"vehicle_speed": speed(values)}), QualityOverChunks(["vehicle_speed"])
    edges = np.linspace(0.0, TIME[-1] + 1.0, pieces + 1)
    for start, stop in itertools.pairwise(edges.tolist()):
        quality.add(whole.slice(start, stop))
    return quality


@pytest.mark.parametrize("pieces", [1, 7, 150])
@pytest.mark.parametrize(("rows", "rate"), [(50, "1"), (5, "10")])
def test_held_readings_are_named_with_their_rate_and_refused_if_too_slow(rows: int, rate: str, pieces: int) -> None:
    quality = checked(held(rows), pieces)
    sentence = f"readings come at {rate} Hz only: each is repeated in {rows} rows"
    assert quality.held_warnings() == (f"vehicle_speed: {sentence}",)
    assert sentence in channel_quality(speed(held(rows))).remarks
    quality.refuse_unusable(["vehicle_speed"], 1.0)
    with pytest.raises(InputError, match=f"{sentence}; at least 20 Hz are needed"):
        quality.refuse_unusable(["vehicle_speed"], 20.0)


def test_a_rate_that_suffices_is_not_refused_and_jitter_of_a_row_hides_nothing() -> None:
    checked(held(5), 3).refuse_unusable(["vehicle_speed"], 10.0)
    edges = 20 * np.arange(len(TIME) // 20) + np.random.default_rng(1).integers(0, 2, len(TIME) // 20)
    at = edges[np.maximum(np.searchsorted(edges, np.arange(len(TIME)), "right") - 1, 0)]
    assert checked(SPEED[at], 1).held_warnings() != ()


@pytest.mark.parametrize("step", [0.01, 0.1, 0.28, 1.0])
@pytest.mark.parametrize("values", [SPEED, 0.1 * TIME, 10.0 + 0.2 * np.random.default_rng(2).normal(size=len(TIME))])
def test_coarse_resting_and_even_signals_are_not_called_held(values: np.ndarray, step: float) -> None:
    assert checked(np.round(values / step) * step, 1).held_warnings() == ()
