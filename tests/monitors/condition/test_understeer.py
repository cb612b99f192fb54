"""A car that understeers turns less than by geometry at speed: its steering ratio is not wrong for that."""

import numpy as np
import pytest

from monitors.condition.small_car import STEP, SmallCar, recordings, vehicle_of
from tierod.core.findings import Status
from tierod.monitors.diagnose import diagnose

CAR = SmallCar(1100.0, 1600.0, 0.95, 1.5, 1.45, 34e3, 0.95, ratio=1.0 / 15.0, zero=0.01)


@pytest.fixture(scope="module")
def fast():
    """Gentle bends at 21 to 24 m/s, in which the car turns about 0.6 times as much as by geometry."""
    time = np.arange(0.0, 50.0, STEP)
    angle = 0.018 * (np.sin(0.9 * time) + 0.5 * np.sin(1.63 * time + 1.0))
    return recordings([(CAR, (22.5 + 1.5 * np.sin(0.15 * time), angle))], 5)[0].slice(10.0)


def test_understeer_is_not_called_a_wrong_steering_ratio(fast):
    finding = diagnose(fast, vehicle_of(CAR, "small"), "condition").findings[0]
    assert "steering ratio" not in finding.cause
    assert finding.status is Status.HEALTHY


@pytest.mark.parametrize("factor", [1.6, 0.3])
def test_a_wrong_steering_ratio_is_named_beside_understeer(fast, factor):
    wrong = vehicle_of(CAR._replace(ratio=factor * CAR.ratio), "small")
    assert "the steering ratio of the vehicle file" in diagnose(fast, wrong, "condition").findings[0].cause
