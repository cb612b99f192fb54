"""The whole judge over made-up lanes: kinds, sizes and shares beside the names; and the bank of all hypotheses."""

from functools import partial

import numpy as np
import pytest

from monitors.condition.made_up_judge import made_up_bank
from monitors.condition.made_up_lanes import LEFT, MOTOR_2, TORQUE, column, healthy_drive
from tierod.core import graph
from tierod.core.graph import Bank
from tierod.monitors.condition.courses import FAULT
from tierod.monitors.condition.definition import condition_monitor
from tierod.monitors.condition.kinds import KINDS
from tierod.monitors.condition.signals import ELEMENTS, OF_AUTOMATED, hypotheses
from tierod.vehicles import load

scan = partial(graph.scan, engine="virtual machine")
"""To compile a bank takes far longer than the few thousand samples here."""


@pytest.fixture(scope="module")
def bank():
    return made_up_bank()


@pytest.fixture
def drive():
    """Speed up and slow down, so that factors and offsets differ."""
    values = healthy_drive()
    time = np.arange(len(values)) / 100.0
    rate = 2.0 * np.cos(2.0 * time)
    values[:, column("longitudinal_acceleration")] = rate
    values[:, :2] += np.cumsum(rate)[:, None] / 100.0
    return values


def kind_at(result, name, index):
    return KINDS[int(result[f"statements.{name}.kind"][index]) - 1]


def test_kind_and_size_are_named_beside_the_sensor_and_gone_with_it(bank, drive):
    drive[300:700, column(LEFT)] += 1.0
    result = scan(bank, drive)
    assert kind_at(result, LEFT, 510) == "offset"
    assert result[f"statements.{LEFT}.magnitude"][510] == pytest.approx(1.0, abs=0.05)
    assert not result[f"statements.{LEFT}.kind"][:300].any()
    assert not result[f"statements.{LEFT}.kind"][-100:].any()
    assert not any(result[f"statements.{name}.kind"].any() for name in OF_AUTOMATED if name != LEFT)


def test_an_offset_that_is_gone_shows_at_standstill_too(bank):
    drive = healthy_drive()
    drive[400:600, column("longitudinal_acceleration")] = -5.0
    drive[:, :2] += np.cumsum(drive[:, column("longitudinal_acceleration")])[:, None] / 100.0
    drive[300:700, column(LEFT)] += 2.0
    result = scan(bank, drive)
    faulty = {name: result[f"statements.{name}.status"] == FAULT for name in ELEMENTS}
    assert faulty[LEFT][310:700].all()
    assert not any(each[310:700].any() for name, each in faulty.items() if name != LEFT)
    assert not any(each[750:].any() for each in faulty.values())


def test_the_lost_share_of_torque_is_averaged(bank, drive):
    drive[300:700, column(TORQUE)] -= 0.4 * drive[300:700, column(f"{MOTOR_2}_target_torque")]
    result = scan(bank, drive)
    alone = Bank(bank.lanes, bank.judge.decision)
    share = result[f"statements.{MOTOR_2}.magnitude"]
    assert np.std(share[500:700]) < 0.5 * np.std(scan(alone, drive)["torque_loss"][500:700])
    assert share[650] == pytest.approx(0.4, abs=0.04)
    assert 0.0 < result[f"statements.{MOTOR_2}.deviation"][650] < 0.05
    assert not share[:300].any()


def test_the_whole_bank_has_a_filter_for_every_hypothesis_and_one_of_sliding_tyres():
    bank = condition_monitor(load("smartload"))
    assert len(bank.lanes) - 1 == len(hypotheses()) == 52
    assert bank.lanes[52].largest_force_error > bank.lanes[0].largest_force_error
    assert bank.lanes[1].trusted.wheel_speed_rear_left == 0.0
    assert bank.judge.kinds[2].offset == pytest.approx(1.0), "a quarter of the plausible range of the yaw rate"
