"""Cars with sliding tyres: no sensor fault is declared, and faults that began before the slide are still named."""

import numpy as np
import pytest

from monitors.condition.at_the_limit import BEFORE, driven
from monitors.condition.motion_alone import OF_CARS, SETS, declared, judged
from tierod.core.graph import scan
from tierod.core.statuses import Status
from tierod.monitors.condition.courses import FAULT
from tierod.monitors.condition.definition import rolling_monitor
from tierod.monitors.condition.limits import aligned
from tierod.monitors.condition.rolling_filter import FASTEST, Hands
from tierod.monitors.diagnose import diagnose
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import OFFSET, Injected
from tierod_lab.papers.own_car.cars import drawn

SEED = 41


@pytest.fixture(scope="module")
def car():
    """A quadricycle of rear drive, which spins."""
    return drawn(1, SEED)


@pytest.mark.parametrize("only", ["all", "without accelerations", "without front wheels"])
@pytest.mark.parametrize("name", ["dwell 0.6", "slalom 0.35", "ramp 0.2", "ice in a bend"])
def test_a_spin_accuses_no_sensor_and_is_seen(car, name, only):
    part, slip = driven(car, name, SEED)
    assert slip > 60.0
    result = judged(rolling_monitor(car.brochure), part, SETS[only])
    assert not declared(result)
    low = result["low_grip"][round(100.0 * BEFORE) :]
    assert low.mean() > 0.2
    assert result["low_grip"][200 : round(100.0 * BEFORE)].mean() < 0.1


def test_the_finding_says_that_tyres_slid_and_accuses_no_acceleration(car):
    part, _ = driven(car, "dwell 0.6", SEED)
    found = diagnose(part, car.brochure, "condition")
    assert found.findings[0].status is not Status.FAULT
    assert not [each.name for each in found.elements if each.status in (Status.FAULT, Status.SUSPECT)]
    assert any("the tyres slid" in each for each in found.findings[0].warnings)


def test_a_wrong_yaw_rate_on_the_straight_before_is_named(car):
    part, _ = driven(car, "step 1.0", SEED)
    first = part[OF_CARS[0]].time[0]
    wrong = injected(part, [Injected("yaw_rate", OFFSET, 0.1, first + 4.0, first + 7.0).fault])
    result = scan(rolling_monitor(car.brochure), aligned(wrong))
    status = result["statements.yaw_rate.status"]
    assert (status[400:430] == FAULT).any()


def test_hands_follow_the_wheel_and_no_jump_of_a_reading():
    turning = Hands(np.inf, 0.0, 0.0, 0.0)
    for place in range(40):
        turning = turning.after(0.05 * place, 0.01)
    assert turning.rate == pytest.approx(5.0, rel=0.01)
    assert turning.after(np.nan, 0.01).rate == turning.rate
    jumped = turning.after(turning.angle + 2.0 * FASTEST * 0.01, 0.01)
    assert jumped.rate == 0.0
    assert jumped.jumped == pytest.approx(0.5)
    assert jumped.after(turning.angle, 0.01).jumped == pytest.approx(0.0, abs=0.01)


def test_readings_that_come_seldom_give_the_same_rate():
    turning = Hands(np.inf, 0.0, 0.0, 0.0)
    for place in range(80):
        turning = turning.after(np.nan if place % 2 else 0.05 * place, 0.01)
    assert turning.rate == pytest.approx(5.0, rel=0.01)
