import numpy as np
import pytest

from controlled_column import CONTROL, STEP
from tierod.core.graph import scan
from tierod.papers.column.control.intervention import DriverIntervention, Noise
from tierod.papers.column.control.reference import Sweep
from tierod.papers.column.control.steering_controller import SteeringController

CONTROLLER = SteeringController(CONTROL, DriverIntervention.design(Noise(0.05, 8.0), STEP))
COUNT = 3000


@pytest.fixture(scope="module")
def grip():
    """A wheel that stands still while a sweep is asked for; hands push from 2 s on."""
    time = np.arange(COUNT) * STEP
    reference = Sweep(start=1.0, stop=1.0).at(np.maximum(time - 1.2, 0.0))
    hands = np.where(time >= 2.0, 1.5, 0.0)
    rows = np.column_stack([np.zeros((COUNT, 5)), hands, *reference, (time >= 1.2).astype(float)])
    return time, scan(CONTROLLER, rows)


def test_control_acts_until_the_driver_is_found(grip):
    time, result = grip
    hold = result["control.hold"]
    assert hold[(time > 1.6) & (time < 2.0)].min() == 1.0
    found = time[result["driver.found"] > 0.5]
    assert len(found) == 1
    assert found[0] == pytest.approx(2.0 + 7.5 / 0.75 * STEP, abs=2.0 * STEP)
    gone = time[(time > 2.0) & (hold <= 0.0)][0]
    assert gone - found[0] == pytest.approx(CONTROL.limits.releasing, abs=2.0 * STEP)
    assert not result["control.motor_torque"][time > gone + 0.01].any()


def test_letting_go_is_smooth(grip):
    _, result = grip
    assert np.abs(np.diff(result["control.motor_torque"])).max() <= CONTROL.limits.rate * STEP * (1.0 + 1e-9)
