"""Cohorts: the odd one is named, its companions are not, and confounded ones are said to be."""

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.methods.trends.cohort_effects import cohorts

CARS = 1000


def fleet(shift, seed=1, between=0.3):
    chance = np.random.default_rng(seed)
    batch = ["odd" if car < 20 else f"batch {car % 40}" for car in range(CARS)]
    supplier = ["A" if car < 20 or car % 3 else "B" for car in range(CARS)]
    value = 4.0 + between * chance.standard_normal(CARS)
    value[:20] += shift
    return value, {"batch": batch, "supplier": supplier, "climate": ["cold", "hot"] * (CARS // 2)}


def test_the_odd_batch_is_named_and_no_other():
    value, labels = fleet(1.0)
    found = cohorts(value, np.full(CARS, 0.05), labels, 0.5)
    assert (found.all[0].kind, found.all[0].name, found.all[0].cars) == ("batch", "odd", 20)
    assert found.all[0].effect == pytest.approx(1.0, abs=0.2)
    assert found.all[0].log_odds > 20.0
    assert found.all[1].log_odds < 0.0
    assert (found.mean, found.between) == (pytest.approx(4.0, abs=0.03), pytest.approx(0.3, rel=0.1))
    assert found.usual[0] == pytest.approx(found.mean + found.all[0].effect)


def test_equal_cohorts_are_seldom_named():
    named = sum(
        each.log_odds > 0.0
        for seed in range(30)
        for each in cohorts(fleet(0.0, seed)[0], np.full(CARS, 0.05), fleet(0.0)[1], 0.5).all
    )
    assert named <= 4  # of 30 times 45


def test_faulty_cars_do_not_make_a_cohort():
    value, labels = fleet(0.0)
    value[[25, 65]] += 8.0  # two of the 25 cars of one batch
    assert all(each.log_odds < 0.0 for each in cohorts(value, np.full(CARS, 0.05), labels, 0.5).all)


def test_cohorts_of_the_same_cars_cannot_be_separated():
    value, labels = fleet(1.0)
    labels["plant"] = ["new" if car < 21 else "old" for car in range(CARS)]
    best = cohorts(value, np.full(CARS, 0.05), labels, 0.5).all[0]
    other = {("batch", "odd"), ("plant", "new")} - {(best.kind, best.name)}
    assert other <= set(best.alike)


def test_the_odds_are_those_of_bayes():
    # cars differ by less than their estimates err, so that the contrast and its variance are known by hand
    value = np.repeat([4.0, 4.2], 40)
    found = cohorts(value, np.full(80, 0.3), {"kind": ["a"] * 40 + ["b"] * 40}, 0.5, prior_share=0.5).all[0]
    variance = 2.0 * 0.3**2 / 40.0
    expected = 0.5 * np.log(variance / (variance + 0.25)) + 0.02 * (1.0 / variance - 1.0 / (variance + 0.25))
    assert found.log_odds == pytest.approx(expected, rel=1e-6)


def test_too_few_cars_are_refused():
    with pytest.raises(InputError, match="fleets of 3 or more"):
        cohorts(np.zeros(2), np.zeros(2), {}, 0.5)
