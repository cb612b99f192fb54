"""How far the parameters move an estimate, where the moved vehicles hardly differ."""

from __future__ import annotations

import pytest

from tierod.core.findings import Estimate
from tierod.monitors.harness.spread.effects import effects
from tierod.monitors.harness.spread.parameter_spread import Outcome
from tierod.vehicles import load

CAR = load("rav4")
ESTIMATE = Estimate("sideslip angle", 0.002, 0.006, "rad")


def outcome(move: float, deviation: float = 0.0) -> Outcome:
    """No direction was carried on; the parameter moves the result by so many of its own standard deviations."""
    return Outcome({}, (), {"steering_ratio": move}, deviation, None, "rad")


def test_moves_in_deviations_of_the_estimate_are_not_taken_for_its_unit():
    assert effects(outcome(0.01), ESTIMATE, CAR) == (0.0, ())
    found = effects(outcome(0.5), ESTIMATE, CAR)
    assert found.each[0].effect == pytest.approx(0.5 * 0.006)
    assert found.variance == pytest.approx((0.5 * 0.006) ** 2)


def test_moves_are_scaled_by_what_was_seen_over_the_recording():
    assert effects(outcome(0.5, 0.004), ESTIMATE, CAR).each[0].effect == pytest.approx(0.004)
    assert effects(outcome(0.5), None, CAR).each[0].effect == 0.5
