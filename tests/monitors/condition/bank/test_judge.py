"""The whole judge over made-up lanes: kinds, sizes and shares beside the names; and the bank of all hypotheses."""

import numpy as np
import pytest

from monitors.condition.made_up_lanes import HYPOTHESES, LEFT, MOTOR_2, TORQUE, column, healthy_drive, lane
from tierod.core.graph import Bank, scan
from tierod.monitors.condition.bank.decision import judge
from tierod.monitors.condition.bank.judge import ConditionJudge, condition_bank
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.bank.tuning import PlausibleRange
from tierod.monitors.condition.bank.weighing import Limits
from tierod.monitors.condition.kinds.catalogue import KINDS
from tierod.monitors.condition.kinds.kind import KindOfFault
from tierod.monitors.condition.signals import SENSORS, hypotheses
from tierod.vehicles import load


@pytest.fixture(scope="module")
def bank():
    count = len(HYPOTHESES) - 1
    decision = judge(HYPOTHESES, Limits((3.0,) * count, (1.0,) * count, gap=1.0, margin=1.0))
    kinds = tuple(KindOfFault.of_sensor(name, PlausibleRange()) for name in SENSORS)
    return Bank(tuple(map(lane, HYPOTHESES)), ConditionJudge(decision, kinds))


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
    return KINDS[int(result[f"kinds.{name}.kind"][index]) - 1]


def test_kind_and_size_are_named_beside_the_sensor_and_gone_with_it(bank, drive):
    drive[300:700, column(LEFT)] += 1.0
    result = scan(bank, drive)
    assert kind_at(result, LEFT, 510) == "offset"
    assert result[f"kinds.{LEFT}.size"][510] == pytest.approx(1.0, abs=0.05)
    assert not result[f"kinds.{LEFT}.kind"][:300].any()
    assert not result[f"kinds.{LEFT}.kind"][-100:].any()
    assert not any(result[f"kinds.{name}.kind"].any() for name in SENSORS if name != LEFT)


def test_an_offset_that_is_gone_shows_at_standstill_too(bank):
    drive = healthy_drive()
    drive[400:600, column("longitudinal_acceleration")] = -5.0
    drive[:, :2] += np.cumsum(drive[:, column("longitudinal_acceleration")])[:, None] / 100.0
    drive[300:700, column(LEFT)] += 2.0
    numbers = scan(bank, drive)["decision.hypothesis"].astype(int)
    assert (numbers[310:700] == 1).all()
    assert (numbers[750:] == 0).all()


def test_the_lost_share_of_torque_is_averaged(bank, drive):
    drive[300:700, column(TORQUE)] -= 0.4 * drive[300:700, column(f"{MOTOR_2}_target_torque")]
    result = scan(bank, drive)
    spread, plain = np.std(result["loss.share"][500:700]), np.std(result["decision.torque_loss"][500:700])
    assert spread < 0.5 * plain
    assert result["loss.share"][650] == pytest.approx(0.4, abs=0.04)
    assert 0.0 < result["loss.deviation"][650] < 0.05
    assert not result["loss.share"][:300].any()


def test_the_whole_bank_has_a_filter_for_every_hypothesis_and_one_of_sliding_tyres():
    limits = Limits((1.0,) * 51, (1.0,) * 51, 1.0, 1.0)
    bank = condition_bank(LeaveOutFilter.of_vehicle(load("smartload")), limits)
    assert len(bank.lanes) - 1 == len(hypotheses()) == 52
    assert bank.lanes[52].largest_force_error > bank.lanes[0].largest_force_error
    assert bank.lanes[1].use_wheel_speed_rear_left == 0.0
    assert bank.judge.kinds[2].offset == pytest.approx(1.0), "a quarter of the plausible range of the yaw rate"
