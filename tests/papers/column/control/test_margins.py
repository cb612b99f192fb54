"""Margins of loops, and the loop of the column cut at the motor."""

import math
from dataclasses import replace

import numpy as np
import pytest

from controlled_column import COLUMN, CONTROL, STEP
from tierod.core.errors import ParameterError
from tierod.methods.estimators.stationary import StationaryFilter
from tierod.models.column_observation import linear_column, observed_column
from tierod.models.linear import LinearSystem, sampled
from tierod.models.steering_column import SteeringColumn
from tierod.models.two_inertia_column import TwoInertiaColumn, without_gear
from tierod.papers.column.control.lqr import regulator
from tierod.papers.column.control.margins import margins, open_loop


def delayed_integrator(gain, samples):
    """gain/s, sampled, and some samples late."""
    n = samples + 1
    A = np.eye(n, k=1)
    A[0, 0] = 1.0
    A[0, 1:] = 0.0
    if samples:
        A[0, 1] = gain * STEP
    B = np.zeros((n, 1))
    B[-1, 0] = 1.0 if samples else gain * STEP
    return LinearSystem.of(A, np.eye(1, n), B)


def test_an_integrator_that_is_late_has_its_closed_form():
    found = margins(delayed_integrator(50.0, 4), STEP)
    crossover = 2.0 / STEP * math.asin(0.5 * 50.0 * STEP)
    assert found.crossover == pytest.approx(crossover / math.tau, rel=1e-3)
    lag = 0.5 * crossover * STEP + 4.0 * crossover * STEP
    assert found.phase == pytest.approx(math.pi / 2.0 - lag, rel=1e-3)
    assert found.delay == pytest.approx(found.phase / crossover, rel=2e-3)
    turning = math.pi / 2.0 / (4.5 * STEP)
    assert found.gain_up == pytest.approx(2.0 / STEP * math.sin(0.5 * turning * STEP) / 50.0, rel=1e-3)
    assert found.gain_down == 0.0


def test_an_unstable_plant_has_a_lowest_gain():
    plant = sampled(LinearSystem.of([[10.0]], [[1.0]], [[30.0]]), STEP)
    found = margins(plant, STEP)
    assert found.gain_down == pytest.approx(1.0 / 3.0, rel=1e-3)


def test_the_margins_are_where_the_loop_becomes_unstable():
    loop = delayed_integrator(50.0, 4)
    up = margins(loop, STEP).gain_up
    for factor, stable in ((0.999 * up, True), (1.001 * up, False)):
        closed = loop.A - factor * loop.B @ loop.C
        assert bool(np.abs(np.linalg.eigvals(closed)).max() < 1.0) is stable


def test_a_loop_that_is_unstable_is_refused_with_its_eigenvalue():
    with pytest.raises(ParameterError, match="unstable: eigenvalue .* of size 1"):
        margins(delayed_integrator(500.0, 4), STEP)


def test_a_peak_that_is_narrower_than_any_grid_is_seen():
    turning, damping, height = math.tau * 112.3, 1e-6, 1.5
    width = 2.0 * damping * turning
    ringing = LinearSystem.of([[0.0, 1.0], [-(turning**2), -width]], [[0.0, height * width]], [[0.0], [1.0]])
    found = margins(sampled(ringing, STEP), STEP)
    assert found.crossover == pytest.approx(112.3, rel=1e-4)
    # Sampled and held it is half a sample late, and smaller by the sine of that lag over the lag.
    lag = 0.5 * turning * STEP
    beside = math.acos(lag / (height * math.sin(lag)))
    assert found.phase == pytest.approx(math.pi - beside - lag, abs=1e-3)


def test_an_eigenvalue_without_damping_is_passed_by():
    turning, rate = math.tau * 20.0, 2.0
    swinging = LinearSystem.of([[0.0, 1.0], [-(turning**2), 0.0]], [[0.0, rate]], [[0.0], [1.0]])
    found = margins(sampled(swinging, STEP), STEP)
    # |L| is one where w rate = |w^2 - turning^2|, above and below the eigenvalue.
    assert found.crossover == pytest.approx((0.5 * rate + math.hypot(0.5 * rate, turning)) / math.tau, rel=1e-3)
    assert found.phase == pytest.approx(0.5 * math.pi - 0.5 * turning * STEP, abs=0.01)


OBSERVED = observed_column(linear_column(TwoInertiaColumn, without_gear(COLUMN)), STEP, 1, 1)
NOISE = {"hand_torque": 1e-4, "disturbance_torque": 1e-5, "steering_wheel_rate": 1e-8, "motor_speed": 1e-6}
OBSERVER = StationaryFilter.design(
    OBSERVED.model,
    OBSERVED.parameters,
    tuple(NOISE.get(name) for name in OBSERVED.discrete.states),
    (1e-6, 1e-5, 4e-4),
    (0.0,) * 6,
    (0.0,),
)


def plant(column=COLUMN):
    whole = sampled(linear_column(SteeringColumn, column), STEP)
    return LinearSystem(whole.A, whole.B[:, :1], whole.C, whole.D[:, :1], whole.states, whole.inputs[:1], whole.outputs)


def test_closing_the_loop_gives_the_eigenvalues_of_regulator_and_observer():
    """The separation theorem, with the observer's own model as the plant; what is left over decays at once."""
    own = sampled(linear_column(TwoInertiaColumn, without_gear(COLUMN)), STEP)
    own = LinearSystem(own.A, own.B[:, :1], own.C, own.D[:, :1], own.states, own.inputs[:1], own.outputs)
    loop = open_loop(own, OBSERVER, CONTROL)
    closed = np.linalg.eigvals(loop.A - loop.B @ loop.C)
    gain = np.array(OBSERVER.gain)
    system = OBSERVED.discrete
    error = np.linalg.eigvals((np.eye(6) - gain @ system.C) @ system.A)
    regulated = regulator(without_gear(COLUMN), COLUMN.torsion_bar_stiffness, STEP).eigenvalues
    for value in [*error, *regulated]:
        if abs(value) > 1e-3:
            assert np.abs(closed - value).min() < 1e-6


def test_the_default_has_the_usual_margins():
    found = margins(open_loop(plant(), OBSERVER, CONTROL), STEP)
    assert found.gain_up > 1.9
    assert np.degrees(found.phase) > 30.0
    assert found.delay > 1.5 * STEP
    assert found.distance > 0.4


def test_a_gain_that_is_too_high_is_refused_with_its_eigenvalue():
    high = replace(CONTROL, gains=replace(CONTROL.gains, motor_angle=30.0 * CONTROL.gains.motor_angle))
    with pytest.raises(ParameterError, match="closed loop is unstable: eigenvalue"):
        margins(open_loop(plant(), OBSERVER, high), STEP)


def test_a_plant_with_other_outputs_is_refused():
    whole = plant()
    fewer = LinearSystem(whole.A, whole.B, whole.C[:2], whole.D[:2], whole.states, whole.inputs, whole.outputs[:2])
    with pytest.raises(ParameterError, match="expected 3 outputs"):
        open_loop(fewer, OBSERVER, CONTROL)
