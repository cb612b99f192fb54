"""Kinds and sizes of faults of a made-up signal, against a prediction with errors that last."""

from dataclasses import replace

import numpy as np
import pytest

from tierod.core.graph import batch, scan
from tierod.monitors.condition.kinds import KINDS, KindOfFault

RATE, START, END = 100.0, 500, 900
NOISE, ERROR = 0.02, 0.03
BLOCK = KindOfFault.of_sensor("wheel_speed_rear_left")
TIME = np.arange(1200) / RATE


def truth(seed):
    chance = np.random.default_rng(seed)
    phase = chance.uniform(0.0, 6.0)
    return 6.0 + 3.0 * np.sin(1.3 * TIME + phase) + np.sin(3.1 * TIME + 2.0 * phase)


def faulty(kind, size, value, chance):
    since = TIME - TIME[START]
    changed = {
        "loss": 0.0 * value,
        "stuck": np.full_like(value, value[START]),
        "offset": value + size,
        "gain": value * size,
        "outlier": value * size,
        "drift": value + size * since,
        "noise": value + size * chance.normal(size=len(value)),
        "delay": np.interp(TIME - (size or 0.0), TIME, value),
    }[kind]
    return np.where((np.arange(len(value)) >= START) & (np.arange(len(value)) < END), changed, value)


def samples(kind, size, seed=0, late=5):
    """Declared so many samples after the fault began; the prediction errs for some 0.1 s at a time."""
    chance = np.random.default_rng(seed)
    value = truth(seed)
    reading = faulty(kind, size, value + NOISE * chance.normal(size=len(value)), chance)
    error = np.zeros(len(value))
    for k in range(1, len(value)):
        error[k] = 0.8 * error[k - 1] + ERROR * 0.6 * chance.normal()
    deviation = np.full(len(value), np.hypot(NOISE, ERROR))
    index = np.arange(len(value))
    declared = ((index >= START + late) & (index < END)).astype(float)
    supports = np.where((index >= START) & (index < END), 1.0, -1.0)
    return np.column_stack([reading, value + error, deviation, declared, np.zeros(len(value)), supports])


@pytest.mark.parametrize(
    ("kind", "size"),
    [
        *(("loss", 0.0), ("stuck", 0.0), ("offset", 2.0), ("offset", -0.6), ("gain", 1.5), ("gain", 0.7)),
        *(("drift", 0.3), ("drift", -0.5), ("noise", 0.5), ("delay", 0.2), ("delay", 0.1)),
    ],
)
def test_kind_and_size_are_right_after_two_seconds(kind, size):
    late = 50 if kind == "drift" else 5
    results = batch(BLOCK, [samples(kind, size, seed, late) for seed in range(20)])
    at = START + late + 200
    named = [KINDS[int(result["kind"][at]) - 1] for result in results]
    assert named.count(kind) >= 19
    sizes = np.array([result["magnitude"][at] for result, name in zip(results, named, strict=True) if name == kind])
    assert np.all(np.abs(sizes - size) <= 0.1 * abs(size) + 1e-12)


def test_nothing_is_named_while_nothing_is_declared_and_all_is_forgotten_after():
    result = scan(BLOCK, samples("offset", 2.0))
    outside = np.r_[0 : START + 5, END:1200]
    assert not result["kind"][outside].any()
    assert not result["magnitude"][outside].any()
    again = samples("offset", 2.0)
    again[1000:, 0] -= 1.0
    again[1005:, 3] = 1.0
    assert scan(BLOCK, again)["magnitude"][-1] == pytest.approx(-1.0, abs=0.1)


def grown(size, late, **changes):
    """A drift that is declared so many samples after it began."""
    given = samples("drift", size, late=late)
    return scan(replace(BLOCK, **changes), given), START + late


def test_what_a_late_declared_drift_grew_from_distinguishes_it_from_an_offset_at_once():
    result, at = grown(0.1, 350)
    assert KINDS[int(result["kind"][at + 2]) - 1] == "drift"
    assert result["magnitude"][at + 2] == pytest.approx(0.1, rel=0.1)
    blind, _ = grown(0.1, 350, away=1e9)
    assert KINDS[int(blind["kind"][at + 2]) - 1] != "drift"


@pytest.mark.parametrize(("kind", "size"), [("offset", 0.06), ("noise", 0.05), ("drift", 0.01)])
@pytest.mark.parametrize("small", [0.01, 1.0])
def test_no_magnitude_is_named_whose_interval_contains_that_of_a_fault_free_sensor(kind, size, small):
    for result in batch(BLOCK, [_scaled(samples(kind, size, seed), small) for seed in range(20)]):
        named = result["kind"] > 0.5
        number = result["kind"][named].astype(int) - 1
        neutral = np.array([1.0 if KINDS[each] in ("gain", "outlier") else 0.0 for each in number])
        valued = ~np.isin([KINDS[each] for each in number], ("loss", "stuck"))
        away = np.abs(result["magnitude"][named] - neutral)[valued]
        assert (away > BLOCK.sure * result["deviation"][named][valued]).all()


def _scaled(given, factor):
    """Reading and prediction of a signal that hardly differs from zero, with the same errors."""
    given[:, 0] -= (1.0 - factor) * given[:, 1]
    given[:, 1] *= factor
    return given
