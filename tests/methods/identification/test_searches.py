from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from tierod.core.block import Scalar
from tierod.methods.identification.experiment import Experiment, Free, long_run_covariance
from tierod.methods.identification.map_search import Prior, Search, considering
from tierod.methods.identification.maximum_likelihood import MaximumLikelihood


class Level(NamedTuple):
    """One state."""

    level: Annotated[float, ""]


@dataclass(frozen=True)
class Lag:
    """Parameters of a lag of first order."""

    decay: float = 0.9
    gain: float = 1.0


class FirstOrder:
    """x+ = decay x + gain u, y = x."""

    State = Input = Output = Level
    Parameters = Lag

    @staticmethod
    def transition(x, u, p):
        return Level(p.decay * x.level + p.gain * u.level)

    @staticmethod
    def output(x, u, p):
        return Level(x.level)


NOISE, DRIVE = 0.3, 0.2
FREE = (Free("decay"), Free("gain", positive=False))


def recorded(seed, drive, count=1500, noise=NOISE):
    random = np.random.default_rng(seed)
    inputs, state, outputs = np.sign(random.standard_normal(count)).repeat(5)[:count], 0.0, []
    for given in inputs:
        outputs.append(state)
        state = 0.9 * state + given + drive * random.standard_normal()
    measured = np.array(outputs) + noise * random.standard_normal(count)
    return Experiment(str(seed), inputs[:, None], measured[:, None], (0.0,), (0.01,))


def by_hand(experiment, decay, gain, drive, noise):
    mean, variance, total = 0.0, 0.01, 0.0
    for (given,), (measured,) in zip(experiment.inputs, experiment.measured, strict=True):
        spread = variance + noise**2
        total += 0.5 * (measured - mean) ** 2 / spread + 0.5 * np.log(spread)
        weight = variance / spread
        mean, variance = mean + weight * (measured - mean), variance * (1.0 - weight)
        mean, variance = decay * mean + gain * given, decay**2 * variance + gain**2 * drive**2
    return total


def search(**changes):
    return MaximumLikelihood(FirstOrder, Lag(0.8, 0.7), FREE, (0.1,), (0.5,), **changes)


def test_the_likelihood_is_that_of_a_filter_written_by_hand():
    experiment = recorded(1, DRIVE)
    place = np.array([np.log(0.85), 1.1, np.log(0.15), np.log(0.4)])
    assert search().cost(place, [experiment]) == pytest.approx(by_hand(experiment, 0.85, 1.1, 0.15, 0.4), rel=1e-10)


def test_gradient_and_scores_agree_with_differences_of_the_cost():
    experiment, place = recorded(2, DRIVE), np.array([np.log(0.88), 1.05, np.log(0.2), np.log(0.3)])
    found = search().search([experiment]).at(place)
    for k in range(4):
        step = 1e-5 * np.eye(4)[k]
        slope = search().cost(place + step, [experiment]) - search().cost(place - step, [experiment])
        assert found.gradient[k] == pytest.approx(slope / 2e-5, rel=2e-3, abs=0.1)
    np.testing.assert_allclose(found.scores[0].sum(axis=0), found.gradient, rtol=1e-9)


def test_it_finds_parameters_and_both_noises():
    found = search().fit([recorded(3, DRIVE), recorded(4, DRIVE)])
    assert found.converged
    assert found["decay"] == pytest.approx(0.9, abs=4.0 * found.deviation("decay"))
    assert found["gain"] == pytest.approx(1.0, abs=4.0 * found.deviation("gain"))
    assert found.input_deviation[0] == pytest.approx(DRIVE, rel=0.15)
    assert found.output_deviation[0] == pytest.approx(NOISE, rel=0.1)
    assert np.std(found.residuals[0]) == pytest.approx(1.0, rel=0.05)


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


def autoregressive(factor, count, seed):
    random, values = np.random.default_rng(seed), np.zeros(count)
    for k in range(1, count):
        values[k] = factor * values[k - 1] + random.standard_normal()
    return values[:, None]


@pytest.mark.parametrize("factor", [0.0, 0.5, 0.9])
def test_it_is_the_variance_of_the_sum_of_an_autoregression(factor):
    scores = [autoregressive(factor, 20_000, seed) for seed in range(3)]
    expected = 60_000 / (1.0 - factor) ** 2
    assert long_run_covariance(scores)[0, 0] == pytest.approx(expected, rel=0.2)
