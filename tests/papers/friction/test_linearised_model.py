"""Equation (19) against central differences of eq (18) written out here."""

import math

import numpy as np
import pytest

from models.friction_paper import CAR
from tierod.core.graph.analysis import jacobian
from tierod_lab.ground.laws import variable_ratio
from tierod_lab.papers.friction.joint_model import FrictionEstimation
from tierod_lab.papers.friction.linearised import LinearisedFrictionEstimation as Model
from tierod_lab.papers.friction.linearised import VariableRatioParameters, smooth_sign_slope, variable_ratio_slope

GROWTH, WIDTH = 0.06, 0.02
KNOWN = {name: getattr(CAR, name) for name in CAR.__dataclass_fields__}
PARAMETERS = VariableRatioParameters(**KNOWN, smoothing_rate=WIDTH, steering_ratio_growth=GROWTH)
THERE = np.array([1.1, 0.013, 0.2, 90.0, 6.0])


def rate_after(x, driver=2.0, motor=0.1):
    """Eq (18), its sign smoothed: exact zero-order hold, corrected as in the errata."""
    angle, rate, _, aligning, friction = x
    decay = math.exp(-0.01 * 0.8 / 0.10)
    gain = (1.0 - decay) / 0.8
    ratio = (1.0 + GROWTH * angle * angle) / 15.5
    net = driver + 20.0 * motor - ratio * aligning - friction * math.tanh(rate / WIDTH)
    return decay * rate + gain * net


def inputs(direction):
    return Model.Input(2.0, 0.1, 1.5, direction, THERE[0], THERE[1], THERE[3], THERE[4])


def test_the_jacobian_is_that_of_the_nonlinear_balance():
    direction = math.tanh(THERE[1] / WIDTH)
    found = jacobian(lambda x: Model.transition(x, inputs(direction), PARAMETERS), Model.State(*THERE))[1]
    steps = np.array([1e-6, 1e-7, 1e-6, 1e-4, 1e-5])
    for place, step in enumerate(steps):
        ahead, behind = (rate_after(THERE + sign * step * np.eye(5)[place]) for sign in (1.0, -1.0))
        assert found[place] == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-5, abs=1e-9), place
    at = Model.transition(Model.State(*THERE), inputs(direction), PARAMETERS)
    assert at.steering_wheel_rate == pytest.approx(rate_after(THERE))


def test_without_growth_and_terms_it_is_the_printed_filter():
    plain = VariableRatioParameters(**KNOWN, with_sign_slope=0.0)
    x = Model.State(0.4, 0.6, 0.1, 120.0, 5.0)
    found = Model.transition(x, Model.Input(3.0, 0.2, 2.0, 1.0, 1.0, 0.3, 80.0, 4.0), plain)
    printed = FrictionEstimation.transition(x, FrictionEstimation.Input(3.0, 0.2, 2.0, 1.0), CAR)
    assert found == pytest.approx(printed)


def test_the_delta_integrates_to_two_as_the_jump_of_a_sign():
    rates = np.linspace(-1.0, 1.0, 200001)
    area = np.trapezoid([smooth_sign_slope(float(rate), WIDTH) for rate in rates[::20]], rates[::20])
    assert area == pytest.approx(2.0, rel=1e-6)


@pytest.mark.parametrize("angle", [-2.0, 0.0, 0.7])
def test_the_slope_of_the_ratio_is_its_derivative(angle):
    ahead, behind = (variable_ratio(angle + step, 1.0 / 15.5, GROWTH) for step in (1e-5, -1e-5))
    assert variable_ratio_slope(angle, 1.0 / 15.5, GROWTH) == pytest.approx((ahead - behind) / 2e-5, abs=1e-9)
