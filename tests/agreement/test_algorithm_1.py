from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from agreement.algorithm_1 import Oracle
from models.friction_paper import CAR
from tierod.core.graph import scan
from tierod_lab.papers.friction.presets import consistent, printed, printed_open

pytestmark = pytest.mark.usefixtures("shipped_kernels")

LITERAL = (0.01, 0.01, 0.1, 1.0, 0.001)


def signals(count: int = 800, missing: bool = False) -> np.ndarray:
    random = np.random.default_rng(5)
    t = np.arange(count) * 0.01
    angle = 0.6 * np.sin(1.1 * t) + 0.1 * np.sin(5.0 * t)
    rate = np.gradient(angle, t)
    aligning = 60.0 * angle
    torque = 0.1 * np.gradient(rate, t) + 0.8 * rate + 5.0 * np.sign(rate) + aligning / 15.5
    columns = np.column_stack([angle, rate, 0.4 * torque, 0.6 * torque / 20.0, 0.25 * angle, 3.0 * angle])
    columns += random.standard_normal(columns.shape) * [0.01, 0.01, 0.05, 0.005, 3e-3, 0.1]
    if missing:
        columns[random.random(columns.shape) < 0.05] = np.nan
        columns[400:460] = np.nan
    return columns


CASES = {
    "printed": (printed(CAR), Oracle(CAR, LITERAL)),
    "printed, operating point estimated": (
        printed(CAR, operating_point="estimate"),
        Oracle(CAR, LITERAL, measured_operating_point=False),
    ),
    "printed, virtual rows of G one": (
        printed(CAR, virtual_noise="per sample"),
        Oracle(CAR, LITERAL, rows_of_dt=False),
    ),
    "printed_open": (printed_open(CAR), Oracle(CAR, (0.01, 0.01, 0.1, 1e4, 0.001))),
    "consistent": (
        consistent(CAR),
        Oracle(CAR, (1.0, 1.0, 0.1, 1e4, 0.1), consistent=True, sticking=True, initial_friction_variance=25.0),
    ),
}


@pytest.mark.parametrize("missing", [False, True])
@pytest.mark.parametrize("case", CASES)
def test_the_kernel_computes_algorithm_1(case, missing):
    monitor, oracle = CASES[case]
    samples = signals(missing=missing)
    monitor = dataclasses.replace(monitor, longest_gap=math.inf)
    run, expected = scan(monitor, samples), oracle.run(samples)
    assert 0.1 < expected["enabled"].mean() < 0.9
    for name, values in expected.items():
        np.testing.assert_allclose(run[name], values, rtol=5e-7, atol=5e-8, equal_nan=False, err_msg=name)


def test_printed_variance_shrinks_in_disabled_time_and_the_consistent_one_does_not():
    samples = signals(2000)
    samples[:, 2] = 0.0
    both = {}
    for update in ("printed", "schmidt"):
        monitor = consistent(CAR)
        monitor = dataclasses.replace(monitor, filter=dataclasses.replace(monitor.filter, covariance_update=update))
        both[update] = scan(monitor, samples)["friction_deviation"]
    assert both["schmidt"][-1] > 4.9
    assert both["printed"][-1] < 1.0
