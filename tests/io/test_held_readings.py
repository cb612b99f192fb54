"""Readings that a file repeats in many rows are found with their rate, and coarse or resting signals are left alone."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.io.quality import channel_quality
from tierod.monitors.harness.quality_over_chunks import QualityOverChunks

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
