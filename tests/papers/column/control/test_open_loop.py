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
from tierod.papers.column.control.column_regulator import regulator
from tierod.papers.column.control.margins import margins
from tierod.papers.column.control.open_loop import open_loop

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
