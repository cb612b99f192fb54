import math

import numpy as np
import pytest

from methods.analysis.column_sets import TORQUES, column
from tierod.core.errors import ParameterError
from tierod.models.column_observation import with_outputs
from tierod.models.linear import LinearSystem, sampled
from tierod_lab.papers.column.cramer_rao import cramer_rao
from tierod_lab.papers.column.output_subsets import extended

NOISE = {"steering_wheel_angle": 8.7e-4, "motor_angle_mechanical": 3.5e-3, "driver_torque": 0.02}


def test_a_constant_is_averaged():
    found = cramer_rao(LinearSystem.of([[0.0]], [[1.0]]), {"y0": 0.3}, 2.5, 0.1)
    assert found.end[0] == pytest.approx(0.3 / math.sqrt(25))


def test_a_line_is_fitted():
    line = LinearSystem.of([[0.0, 1.0], [0.0, 0.0]], [[1.0, 0.0]])
    found = cramer_rao(line, {"y0": 0.3}, 40 * 0.1, 0.1)
    slope = 0.3 * math.sqrt(12.0 / (40 * (40**2 - 1))) / 0.1
    edge = 0.3 * math.sqrt(2.0 * (2 * 40 - 1) / (40 * (40 + 1)))
    np.testing.assert_allclose(found.start, [edge, slope], rtol=1e-9)
    np.testing.assert_allclose(found.end, [edge, slope], rtol=1e-9)


def test_it_is_the_spread_of_least_squares():
    system = sampled(extended(column(), TORQUES), 1e-3)
    found = cramer_rao(system, NOISE, 0.2, 1e-3, discrete=True)
    weights = np.array([NOISE[name] for name in system.outputs])
    rows, block = [], system.C
    for _ in range(200):
        rows.append(block / weights[:, None])
        block = block @ system.A
    information = sum(row.T @ row for row in rows)
    unit = np.sqrt(np.diag(information))
    spread = np.sqrt(np.diag(np.linalg.inv(information / np.outer(unit, unit)))) / unit
    np.testing.assert_allclose(found.start, spread, rtol=1e-6)
    assert found["hand_torque"] == pytest.approx(spread[6], rel=1e-6)


def test_continuous_systems_are_sampled():
    continuous = cramer_rao(column(), NOISE, 0.1, 1e-3)
    discrete = cramer_rao(sampled(column(), 1e-3), NOISE, 0.1, 1e-3, discrete=True)
    np.testing.assert_allclose(continuous.end, discrete.end)


def test_what_the_outputs_hide_has_no_bound():
    found = cramer_rao(with_outputs(column(), ["driver_torque"]), NOISE, 0.5, 1e-3)
    assert np.isfinite(found.end[:3]).all()
    assert np.isinf(found.end[3:]).all()
    assert found.condition == math.inf


@pytest.mark.parametrize(
    ("noise", "duration", "message"),
    [
        ({**NOISE, "driver_torque": 0.0}, 1.0, "driver_torque"),
        (NOISE, 1e-4, "hold no sample"),
        ({}, 1.0, "steering_wheel_angle"),
    ],
)
def test_wrong_settings_are_refused(noise, duration, message):
    with pytest.raises(ParameterError, match=message):
        cramer_rao(column(), noise, duration, 1e-3)
