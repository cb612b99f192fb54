"""The block of the monitor: what follows from its statements, and one graph that runs live."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.condition.made_up_judge import made_up_bank
from monitors.condition.made_up_lanes import LEFT, column, healthy_drive
from tierod.core.graph import Stream, scan, trace
from tierod.diagnosis.fault_memory import Counting
from tierod.diagnosis.trouble_codes import load_trouble_codes
from tierod.monitors.condition.courses import FAULT, HEALTHY
from tierod.monitors.condition.definition import condition_monitor
from tierod.monitors.condition.limits import NAME
from tierod.monitors.condition.reaction import CODES, FILTER, substitution_graph
from tierod.monitors.condition.signals import ELEMENTS, OF_AUTOMATED, PLACES, SENSORS
from tierod.vehicles import load

CAR = load("smartload")


@pytest.fixture(scope="module")
def drive():
    values = healthy_drive()
    values[300:700, column(LEFT)] += 2.0
    values[100, column("yaw_rate")] += 50.0
    values[:, column("tie_rod_force")] = np.nan
    return values


@pytest.fixture(scope="module")
def stated(drive):
    return scan(made_up_bank(), drive)


def part(result, name):
    """The outputs below one name."""
    return np.column_stack([result[path] for path in result.names if path.startswith(f"{name}.")])


def test_a_statement_says_since_when_there_was_evidence_for_its_status(stated):
    status, since = stated[f"statements.{LEFT}.status"], stated[f"statements.{LEFT}.since"]
    first = int(np.flatnonzero(status == FAULT)[0])
    assert first > 300
    assert since[first : first + 300] == pytest.approx(3.0), "the onset, before the declaration"
    assert (stated[f"statements.{OF_AUTOMATED[1]}.since"][:90] < 0.0).all(), "it holds from the start"
    assert stated[f"statements.{LEFT}.evidence"][first] >= 1.0


def test_a_reading_that_is_gated_is_supplied_to_nothing(drive, stated):
    gated = part(stated, "gated") > 0.5
    assert gated[100].any()
    trusted = drive.copy()
    trusted[:, PLACES] = np.where(gated, np.nan, trusted[:, PLACES])
    faulty = np.column_stack([stated[f"statements.{name}.status"] == FAULT for name in SENSORS])
    reconfiguration = made_up_bank().judge.reaction.reconfiguration
    supplied = scan(reconfiguration, np.hstack([trusted, faulty, part(stated, "value")]))
    own = part(stated, "supplied")[:, : supplied.values.shape[1]]
    np.testing.assert_allclose(own, supplied.values, rtol=1e-12)
    assert np.abs(stated["supplied.yaw_rate.value"][100]) < 1.0


def test_codes_fail_and_pass_as_in_a_fault_memory(drive, stated):
    left = stated[f"codes.{LEFT}"]
    assert left[299] == -1.0
    assert (left[310:690] == 1.0).all()
    assert left[-1] == -1.0
    assert not stated["codes.tie_rod_force"].any(), "what is not read is neither healthy nor at fault"
    assert (part(stated, "codes")[:290] <= 0.0).all()
    status = stated[f"statements.{LEFT}.status"]
    results = np.select([status == FAULT, status == HEALTHY], [1.0, -1.0], 0.0)
    changes = Counting(load_trouble_codes()).add(np.arange(len(drive)) / 100.0, {LEFT.replace("_", "-"): results})
    expected = [(round(100.0 * each.time), float(each.verdict)) for each in changes]
    at = np.flatnonzero(np.diff(left, prepend=0.0))
    assert [(int(place), float(left[place])) for place in at] == expected


def test_the_monitor_of_a_vehicle_is_one_graph_that_runs_live():
    block = condition_monitor(CAR)
    graph = trace(block)
    assert [name for name in graph.output if name.startswith("codes.")] == [
        f"codes.{name.replace('-', '_')}" for name in CODES
    ]
    assert len(CODES) == len(ELEMENTS) + 1
    stream = Stream(block, engine="virtual machine")
    for _ in range(3):
        output = stream.push((np.nan,) * len(graph.sample))
    assert not any(output.codes)
    assert all(np.isfinite(each.value) for each in output.supplied)


def test_kinds_of_an_uncalibrated_vehicle_reckon_with_the_measured_error_and_nothing_else_changes():
    own = {**CAR.thresholds[NAME], "calibrated": 1.0}
    after = condition_monitor(CAR)
    bank = condition_monitor(replace(CAR, thresholds={**CAR.thresholds, NAME: own}))
    ways = substitution_graph(calibrated=False).substitutes
    for name, kind, before in zip(OF_AUTOMATED, after.judge.kinds, bank.judge.kinds, strict=True):
        (error,) = (way.deviation for way in ways[name] if way.name == FILTER)
        assert before.unknown == 0.0
        assert kind == replace(before, unknown=error)
    assert after.lanes == bank.lanes
    assert after.judge.decision == bank.judge.decision
