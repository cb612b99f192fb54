"""The four states against eq (3) typed in by hand, SciPy's exponential and its stiff solver."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from monitors.condition.demonstrator import CAR
from tierod.core.errors import ParameterError
from tierod.core.graph.analysis import jacobian
from tierod.models.linear import discretise
from tierod_lab.papers.condition.rules.rack import StiffRack, TwoBodyRack, discretise_stiff

MASS, TEETH, LOSS = 3.0, 1e8, 1e3
RUBBING = TwoBodyRack.Parameters(**asdict(CAR.rack), rack_mass=MASS, tooth_stiffness=TEETH, tooth_damping=LOSS)
SMOOTH = replace(RUBBING, nominal_friction=0.0)
REST = TwoBodyRack.State(0.0, 0.0, 0.0, 0.0)
SLIDING = TwoBodyRack.State(0.0, 0.0, 0.0, 1e3)


def printed():
    """Equation (3) with the reciprocal of the printed ratio, from Table A1."""
    g, inertia, k, d = 1.0 / 146.12, 0.045, 31227.0, 22867.0
    return np.array(
        [
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-(TEETH + k) / MASS, TEETH * g / MASS, -(LOSS + d) / MASS, LOSS * g / MASS],
            [TEETH * g / inertia, -TEETH * g * g / inertia, LOSS * g / inertia, -LOSS * g * g / inertia],
        ]
    )


def test_the_jacobian_is_the_matrix_of_the_paper():
    rest = StiffRack.Input(0.0, 0.0)
    found = np.array(jacobian(lambda x: TwoBodyRack.derivative(x, rest, SMOOTH), REST))
    assert found == pytest.approx(printed(), rel=1e-6)
    assert TwoBodyRack.output(TwoBodyRack.State(1.0, 2.0, 3.0, 4.0), rest, SMOOTH) == (1.0, 2.0)


def test_torque_and_force_enter_their_own_rows():
    rates = TwoBodyRack.derivative(REST, StiffRack.Input(0.9, 6.0), SMOOTH)
    assert rates == pytest.approx((0.0, 0.0, -6.0 / MASS, 0.9 / 0.045))
    rates = TwoBodyRack.derivative(SLIDING, StiffRack.Input(0.0, 0.0), RUBBING)
    free = TwoBodyRack.derivative(SLIDING, StiffRack.Input(0.0, 0.0), SMOOTH)
    assert free.steering_wheel_rate - rates.steering_wheel_rate == pytest.approx(1.11 / 0.045)


@pytest.mark.parametrize("at", [None, SLIDING])
def test_a_linear_steering_is_sampled_as_by_the_exponential(at):
    whole = np.zeros((5, 5))
    whole[:4, :4] = printed()
    whole[:4, 4] = 0.0, 0.0, -250.0 / MASS, 3.0 / 0.045
    x = np.array([0.002, 0.4, 0.01, 2.0])
    exact = (expm(0.01 * whole) @ [*x, 1.0])[:4]
    model = discretise_stiff(TwoBodyRack, 20, at)
    parameters = model.Parameters(SMOOTH, 0.01)
    found = model.transition(TwoBodyRack.State(*x), StiffRack.Input(3.0, 250.0), parameters)
    assert np.array(found) == pytest.approx(exact, rel=1e-6)


def test_with_friction_small_steps_meet_a_stiff_solver():
    inputs = StiffRack.Input(2.5, 120.0)

    def slope(_, x):
        return TwoBodyRack.derivative(TwoBodyRack.State(*x), inputs, RUBBING)

    exact = solve_ivp(slope, (0.0, 0.1), (0.0, 0.0, 0.0, 0.0), method="Radau", rtol=1e-9, atol=1e-12).y[:, -1]
    errors = []
    for step in (2e-3, 1e-3):
        model = discretise_stiff(TwoBodyRack, 20)
        x = REST
        for _ in range(round(0.1 / step)):
            x = model.transition(x, inputs, model.Parameters(RUBBING, step))
        errors.append(abs(x.steering_wheel_angle - exact[1]))
    assert errors[1] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.8)  # second order


def test_explicit_steps_blow_up_where_the_exponential_does_not():
    inputs = StiffRack.Input(1.5, 0.0)
    for steps, stable in ((18, False), (25, True)):
        model = discretise(TwoBodyRack, "rk4", steps)
        x = REST
        for _ in range(5):
            x = model.transition(x, inputs, model.Parameters(SMOOTH, 0.01))
        assert (abs(x.rack_speed) < 0.1) == stable


def test_no_squaring_is_refused():
    with pytest.raises(ParameterError, match="squarings is 0"):
        discretise_stiff(TwoBodyRack, 0)
