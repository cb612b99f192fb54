"""The discrete column against the matrix exponential and a fine integration, its sensitivities against differences."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from tierod.core.block import rebuild, skeleton
from tierod.core.graph import jacobian, scan
from tierod.methods.identification.maximum_likelihood import Simulation
from tierod.methods.identification.sampled_column import BenchInput, BenchParameters, RoundedColumn, SampledColumn
from tierod.models.linear import linearise
from tierod.models.steering_column import ColumnInput, ColumnWithFriction, SteeringColumn
from tierod.vehicles import load

BENCH = load("column-bench").parameters_for(BenchParameters)
AT = rebuild(skeleton(SampledColumn.State), [0.3, -4.0, 0.1, 0.2, 3.0, 0.15, 0.4])


def simulated(parameters, torque):
    return scan(Simulation(SampledColumn, parameters, (0.0,) * 7), torque[:, None]).values[:, :3]


def test_without_friction_a_step_is_the_matrix_exponential():
    parameters = replace(BENCH, motor_friction=1e-12, motor_friction_stiffness=1e-9)
    zero = ColumnInput(0.0, 0.0, 0.0)
    system = linearise(SteeringColumn, parameters, (0.0,) * 6, zero)
    after = SampledColumn.transition(AT, BenchInput(0.2), parameters)[:6]
    whole = np.zeros((7, 7))
    whole[:6, :6], whole[:6, 6] = system.A * 1e-3, system.B[:, 0] * 1e-3
    np.testing.assert_allclose(after, (expm(whole) @ [*AT[:6], 0.2])[:6], rtol=1e-7, atol=1e-10)


def test_with_friction_it_follows_a_fine_integration_of_the_continuous_model():
    count = 400
    torque = 0.4 * np.sin(2.0 * np.pi * 4.0 * np.arange(count) * 1e-3)

    def slope(now, state):
        given = torque[min(int(now * 1e3 + 1e-9), count - 1)]
        return list(
            ColumnWithFriction.derivative(ColumnWithFriction.State(*state), ColumnInput(given, 0.0, 0.0), BENCH)
        )

    fine = solve_ivp(slope, (0.0, (count - 1) * 1e-3), [0.0] * 7, t_eval=np.arange(count) * 1e-3, max_step=2e-4)
    ours = simulated(BENCH, torque)
    assert np.max(np.abs(ours[:, 1] - fine.y[4])) < 1e-3 * np.ptp(fine.y[4])
    assert np.max(np.abs(ours[:, 0] - fine.y[3])) < 1e-3 * np.ptp(fine.y[3])


def test_a_locked_wheel_stays():
    ours = simulated(replace(BENCH, wheel_freedom=0.0), 0.3 * np.sin(0.01 * np.arange(500)))
    assert np.all(ours[:, 0] == 0.0)
    assert np.ptp(ours[:, 1]) > 0.5


def test_what_the_bench_adds():
    torque = 0.3 * np.sin(0.02 * np.arange(300))
    given = simulated(replace(BENCH, motor_torque_gain=1.1, motor_torque_offset=0.02), torque)
    np.testing.assert_allclose(given, simulated(BENCH, 1.1 * torque + 0.02), atol=1e-12)
    shifted = simulated(replace(BENCH, driver_torque_offset=0.5), torque) - simulated(BENCH, torque)
    np.testing.assert_allclose(shifted, np.tile([0.0, 0.0, 0.5], (300, 1)), atol=1e-12)


def test_the_rounded_column_has_nearly_the_same_jacobian_away_from_the_kink():
    exact, rounded = (
        np.array(jacobian(lambda x, kind=kind: kind.transition(x, BenchInput(0.1), BENCH), AT))
        for kind in (SampledColumn, RoundedColumn)
    )
    np.testing.assert_allclose(rounded, exact, rtol=0.02, atol=0.02 * np.max(np.abs(exact), axis=1).min())


def test_the_rounded_column_has_no_jump_where_the_motor_reverses():
    def slope(kind, speed):
        at = SampledColumn.State(0.0, speed, 0.0, 0.0, 0.0, 0.0, AT.normalised_friction)
        torque = BENCH.motor_friction * AT.normalised_friction + BENCH.motor_damping * speed
        return np.array(jacobian(lambda x: kind.transition(x, BenchInput(torque), BENCH), at))[6, 1]

    jumps = [abs(slope(kind, 1e-3) - slope(kind, -1e-3)) for kind in (SampledColumn, RoundedColumn)]
    assert jumps[0] > 0.01  # 2 x 0.4 x 1 ms over Dahl's angle of 0.05 rad
    assert jumps[1] < 0.1 * jumps[0]


@pytest.mark.parametrize(
    "name",
    [
        "motor_friction_stiffness",
        *(pytest.param(each, marks=pytest.mark.slow) for each in ("motor_damping", "motor_friction", "motor_inertia")),
    ],
)
def test_sensitivities_agree_with_differences(name):
    torque = (0.35 * np.sin(2.0 * np.pi * 2.0 * np.arange(600) * 1e-3))[:, None]
    turning = (0.5, 9.0, 0.5, 0.0, 0.0, 0.0, 0.2)

    def block(factor=1.0, step=0.0):
        changed = replace(BENCH, **{name: getattr(BENCH, name) * factor})
        return Simulation(SampledColumn, changed, (*turning[:4], step, *turning[5:]), (name,), (4,))

    def difference(**changes):
        ahead, behind = (
            scan(block(**{what: start + side * size}), torque).values[:, :3]
            for what, (start, size) in changes.items()
            for side in (1.0, -1.0)
        )
        return ahead - behind

    found = scan(block(), torque).values[:, 3:].reshape(-1, 3, 2)
    expected = difference(factor=(1.0, 1e-5)) / (2e-5 * getattr(BENCH, name)), difference(step=(0.0, 1e-6)) / 2e-6
    for place, differences in enumerate(expected):
        for output in range(3):
            size = np.max(np.abs(differences[:, output]))
            np.testing.assert_allclose(found[:, output, place], differences[:, output], atol=2e-3 * size)
