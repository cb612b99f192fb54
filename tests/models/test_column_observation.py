"""The column with the torques of hands and friction as states."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tierod.core.block import units
from tierod.core.errors import ParameterError
from tierod.models.column_observation import (
    linear_column,
    observed_column,
    with_disturbance_states,
    with_offset_state,
    with_outputs,
)
from tierod.models.linear import LinearSystem, sampled
from tierod.models.steering_column import (
    ColumnParameters,
    SteeringColumn,
    TwoInertiaColumn,
    without_gear,
)
from tierod.vehicles import load

DT = 1e-3


@pytest.fixture(scope="module")
def known():
    return load("column-bench").parameters_for(ColumnParameters)


@pytest.mark.parametrize("share", [0.8, 1.0, 1.25])
def test_zeros_and_ones_of_the_sampled_column_are_structure_for_every_column(known, share):
    column = without_gear(replace(known, torsion_bar_stiffness=share * known.torsion_bar_stiffness))
    observed = observed_column(linear_column(TwoInertiaColumn, column), DT)
    last = observed.discrete.A[-1]
    assert observed.discrete.states[-1] == "disturbance_torque"
    assert last.tolist() == [0.0] * (len(last) - 1) + [1.0]


def test_states_have_their_names_and_units(known):
    observed = observed_column(linear_column(SteeringColumn, known), DT, offset="driver_torque")
    states = dict(zip(observed.model.State._fields, units(observed.model.State), strict=True))
    assert states["hand_torque"] == states["disturbance_torque"] == states["driver_torque_offset"] == "N*m"
    assert states["hand_torque_rate"] == "N*m/s"
    assert states["motor_speed"] == states["gear_rate"] == "rad/s"
    assert states["motor_angle"] == "rad"
    assert units(observed.model.Output) == ["rad", "rad", "N*m"]


def test_it_moves_as_the_column_does(known):
    observed = observed_column(linear_column(SteeringColumn, known), DT, 2, 1)
    model, p = observed.model, observed.parameters
    x = model.State(0.3, -2.0, 0.1, 0.05, 1.0, 0.04, 1.5, 20.0, 0.2)
    u = model.Input(0.4)

    def slope(t, y):
        given = SteeringColumn.Input(0.4, 1.5 + 20.0 * t, 0.2)
        return SteeringColumn.derivative(SteeringColumn.State(*y), given, known)

    exact = solve_ivp(slope, (0.0, DT), x[:6], rtol=1e-11, atol=1e-13).y[:, -1]
    moved = model.transition(x, u, p)
    np.testing.assert_allclose(moved[:6], exact, rtol=1e-8)
    np.testing.assert_allclose(moved[6:], (1.52, 20.0, 0.2), rtol=1e-12)
    expected = SteeringColumn.output(SteeringColumn.State(*x[:6]), None, known)
    np.testing.assert_allclose(model.output(x, u, p), expected)


def test_without_the_motor_angle_or_with_a_wrong_offset(known):
    column = linear_column(TwoInertiaColumn, without_gear(known))
    outputs = ("steering_wheel_angle", "driver_torque")
    observed = observed_column(column, DT, outputs=outputs)
    assert observed.model.Output._fields == outputs
    for offset in ("motor_angle_mechanical", "steering_wheel_angle"):
        with pytest.raises(ParameterError, match="driver_torque"):
            observed_column(column, DT, offset=offset, outputs=outputs)
    assert math.isfinite(observed.discrete.A.sum())


def system():
    rng = np.random.default_rng(0)
    return LinearSystem(
        rng.normal(size=(2, 2)),
        rng.normal(size=(2, 3)),
        rng.normal(size=(2, 2)),
        rng.normal(size=(2, 3)),
        ("x0", "x1"),
        ("known", "first", "second"),
        ("y0", "y1"),
    )


def test_disturbances_move_from_inputs_to_states():
    plain = system()
    found = with_disturbance_states(plain, {"second": 2, "first": 1})
    assert found.states == ("x0", "x1", "second", "second_rate", "first")
    assert found.inputs == ("known",)
    x, u = np.array([1.0, -2.0, 0.7, 0.3, -0.5]), np.array([0.9])
    full = np.array([0.9, -0.5, 0.7])
    expected = [*(plain.A @ x[:2] + plain.B @ full), 0.3, 0.0, 0.0]
    np.testing.assert_allclose(found.A @ x + found.B @ u, expected)
    np.testing.assert_allclose(found.C @ x + found.D @ u, plain.C @ x[:2] + plain.D @ full)


def test_a_walk_of_second_order_is_a_ramp_without_noise():
    discrete = sampled(with_disturbance_states(system(), {"first": 2}), 0.1)
    x = np.array([0.0, 0.0, 1.0, 2.0])
    for _ in range(5):
        x = discrete.A @ x
    np.testing.assert_allclose(x[2:], [2.0, 2.0])


def test_an_offset_is_added_to_its_output_and_stays():
    plain = system()
    found = with_offset_state(plain, "y1", "offset")
    x = np.array([1.0, -2.0, 0.3])
    np.testing.assert_allclose(found.C @ x - plain.C @ x[:2], [0.0, 0.3])
    assert (found.A @ x)[2] == 0.0
    assert found.states[-1] == "offset"


def test_outputs_in_another_order():
    found = with_outputs(system(), ("y1",))
    np.testing.assert_allclose(found.C, system().C[1:])
    assert found.outputs == ("y1",)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: with_disturbance_states(system(), {"frist": 1}), "did you mean 'first'"),
        (lambda: with_disturbance_states(system(), {"first": 4}), "expected 1 to 3"),
        (lambda: with_offset_state(system(), "y2", "offset"), "no output 'y2'"),
        (lambda: with_outputs(system(), ("y2",)), "no output 'y2'"),
    ],
)
def test_refused(call, words):
    with pytest.raises(ParameterError, match=words):
        call()
