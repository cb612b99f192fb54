"""The judge over made-up lanes: which element is declared, when, with which kind, size, substitute and code."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from monitors.condition.made_up_lanes import (
    HYPOTHESES,
    LEFT,
    MOTOR_1,
    MOTOR_2,
    RATE,
    RIGHT,
    TORQUE,
    column,
    decision_of,
    healthy_drive,
    judged_bank,
    lane,
)
from tierod.core import graph
from tierod.core.graph import Bank, Stream, trace
from tierod.monitors.condition.courses import FAULT
from tierod.monitors.condition.definition import condition_monitor
from tierod.monitors.condition.kinds import KINDS
from tierod.monitors.condition.limits import GAP
from tierod.monitors.condition.reaction import CODES
from tierod.monitors.condition.signals import (
    OF_AUTOMATED,
)
from tierod.vehicles import load

scan = partial(graph.scan, engine="virtual machine")
"""To compile a bank takes far longer than the few thousand samples here."""


@pytest.fixture(scope="module")
def bank():
    return Bank(tuple(map(lane, HYPOTHESES)), decision_of())


@pytest.fixture
def drive():
    return healthy_drive()


def declared(result):
    """(time, name) of every change of the declared hypothesis."""
    numbers = result["hypothesis"].astype(int)
    return [(k / RATE, HYPOTHESES[numbers[k]].name) for k in np.flatnonzero(np.diff(numbers, prepend=-1))]


def names_of(bank, drive):
    return [name for _, name in declared(scan(bank, drive))]


def accelerated(drive, at, rate):
    drive[at, column("longitudinal_acceleration")] = rate
    drive[:, :2] += np.cumsum(drive[:, column("longitudinal_acceleration")])[:, None] / RATE
    return drive


@pytest.mark.parametrize(("name", "size"), [(LEFT, 1.0), (RIGHT, -1.0)])
def test_an_offset_is_declared_within_a_tenth_of_a_second_and_taken_back_after_it(bank, drive, name, size):
    drive[300:700, column(name)] += size
    (_, first), (at, second), (back, third) = declared(scan(bank, drive))
    assert (first, second, third) == ("healthy", name, "healthy")
    assert 3.0 < at < 3.1
    assert 7.2 < back < 7.5


def test_a_lost_sensor_is_replaced_from_the_first_sample_on(bank, drive):
    drive[300:, 0] = 0.0
    result = scan(bank, drive)
    assert np.abs(result[f"value.{LEFT}"][300:] - 10.0).max() < 0.1
    assert (result["speed"][300:] > 9.9).all(), "lanes that believe the sensor are corrected from others"


def test_a_single_outlier_is_gated_and_not_declared(bank, drive):
    drive[300, 0] += 5.0
    result = scan(bank, drive)
    assert declared(result) == [(0.0, "healthy")]
    np.testing.assert_array_equal(np.flatnonzero(result[f"gated.{LEFT}"]), [300])


def test_one_after_another_becomes_a_pair_and_each_recovers_by_itself(bank, drive):
    drive[300:600, 0] = 0.0
    drive[400:800, 1] += 2.0
    assert names_of(bank, drive) == ["healthy", LEFT, "both wheels", RIGHT, "healthy"]


@pytest.mark.parametrize(("lasts", "named"), [(6, False), (100, True)])
def test_a_bump_just_after_a_fault_is_no_second_one(drive, lasts, named):
    bank = Bank(tuple(map(lane, HYPOTHESES)), decision_of(fast=50.0))
    drive[300:, column(LEFT)] = 0.0
    _, (at, _) = declared(scan(bank, drive[:500]))
    bump = round(at * RATE) + 2
    drive[bump : bump + lasts, column(RIGHT)] += 1.0
    assert names_of(bank, drive[: bump + 100]) == ["healthy", LEFT, *(["both wheels"] if named else [])]


def test_a_lost_sensor_does_not_recover_while_it_should_read_zero(bank, drive):
    accelerated(drive, slice(400, 600), -5.0)[300:, 0] = 0.0
    result = scan(bank, drive)
    assert declared(result)[-1][1] == LEFT
    assert (result[f"testable.{LEFT}"][350], result[f"testable.{LEFT}"][-50:].max()) == (1.0, 0.0)


def standing(drive):
    accelerated(drive, slice(100, 300), -5.0)[400:, column(LEFT)] += 1.0


def braking(drive):
    accelerated(drive, slice(300, 400), -9.0)[310:390, column(LEFT)] = 0.0


def missing(drive):
    drive[300:500, 0] = np.nan
    drive[600:650] = np.nan


def gain_of_torque(drive):
    drive[300:700, column(TORQUE)] *= 1.5


@pytest.mark.parametrize("change", [standing, braking, missing, gain_of_torque, lambda drive: None])
def test_nothing_is_declared_at_standstill_of_a_locked_wheel_of_gaps_nor_of_a_wrong_gain(bank, drive, change):
    change(drive)
    weighing = bank.judge.weighing
    shipped = replace(bank.judge, weighing=replace(weighing, limits=replace(weighing.limits, gap=GAP)))
    result = scan(replace(bank, judge=shipped), drive)
    assert declared(result) == [(0.0, "healthy")]
    assert np.isfinite(result[f"value.{LEFT}"]).all()


@pytest.mark.parametrize(("acceleration", "named"), [(8.0, False), (-8.0, False), (5.0, True), (np.nan, True)])
def test_no_fault_is_declared_where_the_tyres_slide(bank, drive, acceleration, named):
    drive[300:700, column("lateral_acceleration")] = acceleration
    drive[350:650, column(LEFT)] += 1.0
    result = scan(bank, drive)
    assert (LEFT in [name for _, name in declared(result)]) is named
    assert result[f"testable.{LEFT}"][400:600].max() == float(named)


@pytest.mark.parametrize(("name", "share"), [(MOTOR_1, 1.0), (MOTOR_2, 0.5)])
def test_a_motor_is_distinguished_from_the_other_by_the_swing_of_their_split(bank, drive, name, share):
    drive[300:700, column(TORQUE)] -= share * drive[300:700, column(f"{name}_target_torque")]
    result = scan(bank, drive)
    assert [name for _, name in declared(result)] == ["healthy", name, "healthy"]
    assert result["torque_loss"][690] == pytest.approx(share, abs=0.05)


# From here on the whole judge.


def kind_at(result, name, index):
    return KINDS[int(result[f"statements.{name}.kind"][index]) - 1]


@pytest.fixture(scope="module")
def whole():
    """A wheel off by 2 m/s from 3 to 7 s, an outlier of the yaw rate at 1 s, and no tie-rod force."""
    drive = accelerated(healthy_drive(), slice(None), 2.0 * np.cos(2.0 * np.arange(1000) / RATE))
    drive[300:700, column(LEFT)] += 2.0
    drive[100, column("yaw_rate")] += 50.0
    drive[:, column("tie_rod_force")] = np.nan
    return scan(judged_bank(), drive)


def test_a_statement_has_onset_kind_size_and_evidence_and_only_the_faulty_one(whole):
    status, since = whole[f"statements.{LEFT}.status"], whole[f"statements.{LEFT}.since"]
    first = int(np.flatnonzero(status == FAULT)[0])
    assert first > 300
    assert since[first : first + 300] == pytest.approx(3.0), "the onset, before the declaration"
    assert whole[f"statements.{LEFT}.evidence"][first] >= 1.0
    assert kind_at(whole, LEFT, 510) == "offset"
    assert whole[f"statements.{LEFT}.magnitude"][510] == pytest.approx(2.0, abs=0.05)
    assert not whole[f"statements.{LEFT}.kind"][:300].any()
    assert not whole[f"statements.{LEFT}.kind"][-100:].any()
    assert not any(whole[f"statements.{name}.kind"].any() for name in OF_AUTOMATED if name != LEFT)


def test_the_monitor_of_a_vehicle_is_one_graph_that_runs_live():
    block = condition_monitor(load("smartload"))
    graph = trace(block)
    assert [name for name in graph.output if name.startswith("codes.")] == [
        f"codes.{name.replace('-', '_')}" for name in CODES
    ]
    stream = Stream(block, engine="virtual machine")
    output = [stream.push((np.nan,) * len(graph.sample)) for _ in range(3)][-1]
    assert not any(output.codes)
    assert all(np.isfinite(each.value) for each in output.supplied)
