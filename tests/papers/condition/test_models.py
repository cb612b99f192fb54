"""Racks and their sampling beside SciPy's exponential and stiff solver, and the adaptive speed on drives by hand."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from monitors.condition.demonstrator import CAR
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.core.graph.trace import jacobian
from tierod_lab.papers.condition.rules.filters import AdaptiveSpeed
from tierod_lab.papers.condition.rules.models import StiffRack, TwoBodyRack, discretise_stiff
from tierod_lab.papers.condition.rules.parameters import part

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

MASS, TEETH, LOSS = 3.0, 1e8, 1e3
RACK = part(StiffRack.Parameters, CAR)
RUBBING = TwoBodyRack.Parameters(**asdict(RACK), rack_mass=MASS, tooth_stiffness=TEETH, tooth_damping=LOSS)
SMOOTH = replace(RUBBING, nominal_friction=0.0)
REST, SLIDING = TwoBodyRack.State(0.0, 0.0, 0.0, 0.0), TwoBodyRack.State(0.0, 0.0, 0.0, 1e3)
G, INERTIA, STIFFNESS, DAMPING = 1.0 / 146.12, 0.045, 31227.0, 22867.0
PRINTED = np.array(
    [
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [-(TEETH + STIFFNESS) / MASS, TEETH * G / MASS, -(LOSS + DAMPING) / MASS, LOSS * G / MASS],
        [TEETH * G / INERTIA, -TEETH * G * G / INERTIA, LOSS * G / INERTIA, -LOSS * G * G / INERTIA],
    ]
)
"""Equation (3) with the reciprocal of the printed ratio, from Table A1."""


def test_the_jacobian_is_the_matrix_of_the_paper_and_swings_at_666_hz():
    rest = StiffRack.Input(0.0, 0.0)
    found = np.array(jacobian(lambda x: TwoBodyRack.derivative(x, rest, SMOOTH), REST))
    assert found == pytest.approx(PRINTED, rel=1e-6)
    slow, fast = np.sort(np.linalg.eigvals(found).real)[2:], np.linalg.eigvals(found).imag.max()
    assert slow == pytest.approx([-22.4, -1.45], abs=0.05)
    assert fast / (2.0 * np.pi) == pytest.approx(666.4, abs=0.2)


@pytest.mark.parametrize("at", [None, SLIDING])
def test_a_linear_steering_is_sampled_as_by_the_exponential(at):
    whole = np.zeros((5, 5))
    whole[:4, :4] = PRINTED
    whole[:4, 4] = 0.0, 0.0, -250.0 / MASS, 3.0 / INERTIA
    x = np.array([0.002, 0.4, 0.01, 2.0])
    model = discretise_stiff(TwoBodyRack, 20, at)
    found = model.transition(TwoBodyRack.State(*x), StiffRack.Input(3.0, 250.0), model.Parameters(SMOOTH, 0.01))
    assert np.array(found) == pytest.approx((expm(0.01 * whole) @ [*x, 1.0])[:4], rel=1e-6)


def test_with_friction_small_steps_meet_a_stiff_solver():
    inputs = StiffRack.Input(2.5, 120.0)

    def slope(_, x):
        return TwoBodyRack.derivative(TwoBodyRack.State(*x), inputs, RUBBING)

    exact = solve_ivp(slope, (0.0, 0.1), (0.0,) * 4, method="Radau", rtol=1e-9, atol=1e-12).y[:, -1]
    errors = []
    for step in (2e-3, 1e-3):
        model, x = discretise_stiff(TwoBodyRack, 20), REST
        for _ in range(round(0.1 / step)):
            x = model.transition(x, inputs, model.Parameters(RUBBING, step))
        errors.append(abs(x.steering_wheel_angle - exact[1]))
    assert errors[1] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.8)  # second order


def test_one_body_is_what_two_bodies_of_the_paper_are_below_their_swing():
    A = np.zeros((6, 6))
    A[:4, :4], A[2, 4], A[3, 5] = PRINTED, -1.0 / MASS, 1.0 / INERTIA
    step, model = expm(0.01 * A), discretise_stiff(StiffRack)
    x, y = StiffRack.State(0.0, 0.0), np.zeros(6)
    for k in range(200):
        y[4:] = 100.0 * np.sin(0.05 * k), 2.0 * np.cos(0.03 * k)
        inputs = StiffRack.Input(y[5], y[4])
        y = step @ y
        x = model.transition(x, inputs, model.Parameters(replace(RACK, nominal_friction=0.0), 0.01))
        assert x.steering_wheel_angle == pytest.approx(y[1], abs=2e-3)


def test_no_squaring_and_a_model_without_a_derivative_are_refused():
    with pytest.raises(ParameterError, match="squarings is 0"):
        discretise_stiff(TwoBodyRack, 0)
    with pytest.raises(ParameterError, match="derivative"):
        discretise_stiff(object)


SPEED = AdaptiveSpeed.design(1.084, 0.01)
TIME = np.arange(3000) * 0.01


def drive(offset=0.05):
    random = np.random.default_rng(5)
    speed = 8.0 + 2.0 * np.sin(0.4 * TIME)
    yaw = 0.4 * np.sin(0.6 * TIME)
    columns = [0.8 * np.cos(0.4 * TIME) + offset, yaw, 0.0 * yaw, speed - 0.542 * yaw, speed + 0.542 * yaw]
    return speed, np.stack(columns, axis=1) + random.normal(size=(3000, 5)) * [0.1, 0.003, 0.0, 0.02, 0.02]


def error(speed, columns, start=300):
    return float(np.sqrt(np.mean((scan(SPEED, columns)["forward_speed"] - speed)[start:] ** 2)))


def test_the_speed_follows_both_wheels_to_millimetres_per_second_and_starts_at_theirs():
    speed, columns = drive()
    assert error(speed, columns) < 0.01
    assert scan(SPEED, columns[:20])["forward_speed"][-1] == pytest.approx(speed[19], abs=0.1)


@pytest.mark.parametrize(("column", "kind"), [(3, "lost"), (4, "offset")])
def test_a_wheel_that_fails_for_twenty_seconds_hardly_moves_it(column, kind):
    speed, columns = drive()
    columns[1000:, column] = 0.0 if kind == "lost" else columns[1000:, column] + 2.0
    assert error(speed, columns, 1000) < 0.03
