"""Motors identified from drives of the bench: intervals, and the observer with what was found."""

import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod_lab.papers.motor_angle import identified
from tierod_lab.studies.effort import Effort


def test_the_study_shows_bias_intervals_and_the_observer():
    items = list(identified.items(Effort(quick=True, processes=1)))
    claims = {item.id: item for item in items if isinstance(item, Claim)}
    assert claims["identified.bias"].met
    assert claims["identified.observer"].met
    table, angles = (item for item in items if isinstance(item, Table))
    assert len(table.rows) == 7
    assert [row[0] for row in angles.rows] == ["identified", "true", "of the vehicle file"]


def test_errors_count_the_intervals_that_hold():
    found = identified.Errors(np.array([0.1, -0.3, 0.0]), np.array([0.1, 0.1, 0.01]))
    assert found.covered == 2


def test_no_two_motors_are_alike():
    first, second = identified.drawn(1), identified.drawn(2)
    assert first.machine.resistance != second.machine.resistance
    assert first == identified.drawn(1)
    assert first.machine.inductance_d == first.machine.inductance_q


@pytest.mark.slow
def test_the_intervals_hold_45_of_50_true_values():
    motors = [identified.drawn(number) for number in range(700, 750)]
    found = [identified.identified(motor) for motor in motors]
    for name, each in identified.errors(motors, found).items():
        assert each.covered >= 45, name
        assert abs(each.errors.mean()) < 0.005, name
