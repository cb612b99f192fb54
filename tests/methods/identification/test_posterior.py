"""The search for the most probable parameters, against closed forms."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from tierod.core.block import Scalar
from tierod.methods.identification.posterior import Prior, Search, considering


@dataclass(frozen=True)
class Reading:
    """A constant that is read with noise."""

    level: Annotated[float, ""]
    noise: Annotated[float, ""]

    class Sample(NamedTuple):
        value: Annotated[Scalar, ""]

    class Output(NamedTuple):
        whitened: Annotated[Scalar, ""]
        spread: Annotated[Scalar, ""]

    def init(self) -> Scalar:
        return 0.0

    def step(self, state: Scalar, sample: Sample) -> tuple[Scalar, Output]:
        from tierod.core.graph.maths import log

        return state, self.Output((sample.value - self.level) / self.noise, log(self.noise))


def built(values, recording):
    return Reading(values["level"], values.get("noise", 0.5))


def readings(level, seed, count=400):
    return level + 0.5 * np.random.default_rng(seed).standard_normal((count, 1))


def test_the_mean_of_normal_readings_is_the_closed_form():
    values = readings(3.0, 1)
    prior = Prior("level", 2.0, 0.1, positive=False)
    found = Search((prior,), [values], built, 1, trusted=400.0).run()
    # Half of the 400 readings count where 400 are trusted.
    precision = 200.0 / 0.25 + 1.0 / 0.01
    wanted = (200.0 / 0.25 * values.mean() + 2.0 / 0.01) / precision
    assert found.converged
    assert found.values["level"] == pytest.approx(wanted, rel=1e-6)
    assert found.deviations["level"] == pytest.approx(precision**-0.5, rel=1e-3)


def test_several_recordings_count_together_and_keep_their_own_share():
    parts = [readings(3.0, 1), readings(3.0, 2, 200)]
    prior = Prior("level", 2.0, 0.5, positive=False)
    together = Search((prior,), parts, built, 1).run()
    one = Search((prior,), [np.concatenate(parts)], built, 1).run()
    assert together.values["level"] == pytest.approx(one.values["level"], rel=1e-6)
    assert together.at.shares[0][0, 0] == pytest.approx(2.0 * together.at.shares[1][0, 0], rel=1e-6)


def test_noise_is_found_beside_the_level_and_longer_driving_narrows_no_further_than_is_trusted():
    priors = (Prior("level", 2.5, 1.0), Prior("noise", 1.0, 1.0))
    deviations = []
    for count in (5_000, 20_000):
        found = Search(priors, [readings(3.0, 3, count)], built, 1, trusted=1_000.0).run()
        assert found.values["noise"] == pytest.approx(0.5, rel=0.03)
        deviations.append(found.deviations["level"])
    assert deviations[1] > 0.9 * deviations[0]


def shifted(values, recording):
    return Reading(values["level"] + values.get("offset", 0.0), 0.5)


def test_the_deviation_of_a_held_parameter_goes_into_that_of_the_others_and_no_reading_lessens_it():
    search = Search((Prior("level", 2.0, 1.0, positive=False),), [readings(3.0, 1)], shifted, 1, trusted=400.0)
    found = search.run()
    offset = Prior("offset", 0.0, 0.3, positive=False)
    wider = considering(search, found, (offset,), {})
    # Data hold 800 of the 801 units of precision: an offset of 0.3 moves the level by nearly as much.
    assert wider.values == found.values
    assert wider.deviations["level"] ** 2 == pytest.approx(1.0 / 801.0 + (0.3 * 800.0 / 801.0) ** 2, rel=1e-3)
    assert considering(search, found, (), {}).deviations == found.deviations


def test_an_error_of_the_model_is_relative_where_the_logarithm_is_looked_for():
    for positive, error in ((False, 0.4), (True, 0.1)):
        search = Search((Prior("level", 2.0, 1.0, positive),), [readings(3.0, 1)], built, 1)
        found = search.run()
        wider = considering(search, found, (), {"level": error, "other": 1.0})
        added = wider.deviations["level"] ** 2 - found.deviations["level"] ** 2
        assert added**0.5 == pytest.approx(error * (found.values["level"] if positive else 1.0), rel=1e-6)


def test_a_prior_keeps_values_within_what_is_possible():
    prior = Prior("mass", 1000.0, 300.0, low=900.0, high=1100.0)
    assert prior.at(3.0) == 1100.0
    assert prior.at(-3.0) == 900.0
    assert prior.at(0.0) == 1000.0
