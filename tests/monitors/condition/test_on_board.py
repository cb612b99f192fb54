"""The block that runs on board says what its parts say one by one."""

import numpy as np
import pytest

from monitors.condition.made_up_lanes import HYPOTHESES, LEFT, column, healthy_drive, lane
from tierod.core.graph import Bank, Stream, scan, trace
from tierod.diagnosis.counting import Counting
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.monitors.condition.bank.decision import judge
from tierod.monitors.condition.bank.judge import ConditionJudge
from tierod.monitors.condition.bank.tuning import PlausibleRange
from tierod.monitors.condition.bank.weighing import Limits
from tierod.monitors.condition.kinds.kind import KindOfFault
from tierod.monitors.condition.on_board import CODES, OnBoardJudge, on_board
from tierod.monitors.condition.session import filtered_by_bank
from tierod.monitors.condition.signals import ELEMENTS, SENSORS
from tierod.vehicles import load


@pytest.fixture(scope="module")
def whole():
    return on_board(load("smartload")).judge


@pytest.fixture(scope="module")
def bank():
    count = len(HYPOTHESES) - 1
    decision = judge(HYPOTHESES, Limits((3.0,) * count, (1.0,) * count, gap=1.0, margin=1.0))
    kinds = tuple(KindOfFault.of_sensor(name, PlausibleRange()) for name in SENSORS)
    return Bank(tuple(map(lane, HYPOTHESES)), ConditionJudge(decision, kinds))


@pytest.fixture(scope="module")
def drive():
    values = healthy_drive()
    values[300:700, column(LEFT)] += 2.0
    values[100, column("yaw_rate")] += 50.0
    values[:, column("tie_rod_force")] = np.nan
    return values


@pytest.fixture(scope="module")
def said(bank, whole, drive):
    block = Bank(bank.lanes, OnBoardJudge(bank.judge, whole.rules, whole.reconfiguration, whole.counters))
    return scan(block, drive)


def part(result, name):
    """The outputs below one name."""
    return np.column_stack([result[path] for path in result.names if path.startswith(f"{name}.")])


def test_the_bank_and_the_rules_in_it_say_what_they_say_alone(bank, whole, drive, said):
    np.testing.assert_array_equal(part(said, "judgement"), scan(bank, drive).values)
    np.testing.assert_allclose(part(said, "rules"), scan(whole.rules[0], drive).values, rtol=1e-12)


def test_a_reading_that_is_not_believed_is_supplied_to_nobody(bank, whole, drive, said):
    alone = scan(bank, drive)
    believed = drive.copy()
    gated = np.column_stack([alone[f"decision.gated.{name}"] for name in SENSORS]) > 0.5
    assert gated[100].any()
    believed[:, : len(SENSORS)][gated] = np.nan
    faulty = np.column_stack([alone[f"decision.faulty.{name}"] for name in SENSORS])
    supplied = scan(whole.reconfiguration, np.hstack([believed, faulty, filtered_by_bank(alone)]))
    np.testing.assert_allclose(part(said, "supplied"), supplied.values, rtol=1e-12)
    assert np.abs(said["supplied.yaw_rate.value"][100]) < 1.0


def test_codes_fail_and_pass_as_in_a_fault_memory(bank, drive, said):
    left = said[f"codes.{LEFT}"]
    assert left[299] == -1.0
    assert (left[310:690] == 1.0).all()
    assert left[-1] == -1.0
    assert not said["codes.tie_rod_force"].any(), "what is not read is neither sound nor at fault"
    assert (part(said, "codes")[:290] <= 0.0).all()
    faulty = said[f"judgement.decision.faulty.{LEFT}"]
    sound = said[f"judgement.decision.testable.{LEFT}"] * (1.0 - said[f"judgement.decision.candidates.{LEFT}"])
    results = np.select([faulty > 0.5, sound > 0.5], [1.0, -1.0], 0.0)
    changes = Counting(load_trouble_codes()).add(np.arange(len(drive)) / 100.0, {LEFT.replace("_", "-"): results})
    expected = [(round(100.0 * each.time), float(each.verdict)) for each in changes]
    at = np.flatnonzero(np.diff(left, prepend=0.0))
    assert [(int(place), float(left[place])) for place in at] == expected


def test_all_of_a_vehicle_is_one_graph_that_runs_live():
    block = on_board(load("smartload"), rules=("rules", "rules-printed"))
    graph = trace(block)
    assert len(block.judge.rules) == 2
    assert [name for name in graph.output if name.startswith("codes.")] == [
        f"codes.{name.replace('-', '_')}" for name in CODES
    ]
    assert len(CODES) == len(ELEMENTS) + 1
    stream = Stream(block, engine="virtual machine")
    for _ in range(3):
        said = stream.push((np.nan,) * len(graph.sample))
    assert not any(said.codes)
    assert all(np.isfinite(each.value) for each in said.supplied)
