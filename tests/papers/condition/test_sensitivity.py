"""Numbers a fifth smaller or larger: every float of the bank is covered, and one that decides is shown to decide."""

from __future__ import annotations

import dataclasses
from dataclasses import replace

import pytest

from tierod.core.block import tuning
from tierod.core.claims import Claim
from tierod.core.content import Table
from tierod.monitors.condition import weighing as testability
from tierod.monitors.condition.decision import Decision
from tierod.monitors.condition.definition import condition_monitor
from tierod.monitors.condition.judge import ConditionJudge
from tierod.monitors.condition.kinds import KindOfFault
from tierod.monitors.condition.low_grip import LowGrip
from tierod.monitors.condition.reaction import FaultReaction
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter, ModelError
from tierod.monitors.condition.weighing import Limits, Returning, Weighing
from tierod.vehicles import load
from tierod_lab.papers.condition import sensitivity
from tierod_lab.papers.condition.by_bank import Known
from tierod_lab.papers.condition.drives import Drive
from tierod_lab.papers.condition.faults import KINDS, OFFSET, Injected
from tierod_lab.papers.condition.recorded import recorded
from tierod_lab.papers.condition.sensitivity import Judged, drives, effect, judged_by
from tierod_lab.papers.condition.tuned_numbers import COUNTS, is_given, numbers_of, varied
from tierod_lab.papers.condition.vehicles import SHORT
from tierod_lab.studies.effort import Effort

BLOCKS = (
    *(ConditionJudge, Decision, FaultReaction, KindOfFault, LeaveOutFilter, Limits),
    *(LowGrip, ModelError, Returning, testability.Testability, Weighing),
)


@pytest.fixture(scope="module")
def bank():
    return condition_monitor(load("smartload"))


@pytest.fixture(scope="module")
def numbers(bank):
    return {each.name: each for each in numbers_of(bank)}


def test_every_float_is_in_one_number_or_is_given(bank, numbers):
    places = [place for each in numbers.values() for place in each.places]
    assert len(places) == len({*places})
    left = [path for place, (path, _) in enumerate(tuning(bank)) if place not in {*places}]
    assert all(is_given(".".join(part for part in path.split(".") if not part.isdigit())) for path in left)
    assert not {path.split(".")[2] for path in left if path.startswith("lanes.")} - {"vehicle", "trusted"}


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.__name__)
def test_no_field_of_the_blocks_is_forgotten(block, numbers):
    names = {each.name.partition(",")[0].rpartition(".")[2] for each in numbers.values()}
    annotated = {each.name for each in dataclasses.fields(block) if "Annotated[float" in str(each.type)}
    assert annotated
    assert annotated - {"sample_time"} <= names


def test_every_number_that_the_graph_uses_has_the_sentence_of_its_field(numbers):
    assert [each.name for each in numbers.values() if not each.reason] == []
    assert not numbers["judge.reaction.reconfiguration.vehicle.fading.road"].used
    assert numbers["lanes.vehicle.fading.road"].used


def test_one_number_changes_and_nothing_else(bank, numbers):
    gap = numbers["judge.decision.weighing.limits.gap"]
    before, after = list(tuning(bank)), list(tuning(varied(bank, gap, 0.8)))
    changed = [(path, value, other) for (path, value), (_, other) in zip(before, after, strict=True) if value != other]
    assert changed == [("judge.decision.weighing.limits.gap", 2.0, 1.6)]


def test_counts_go_to_the_next_whole_number(numbers):
    samples = numbers["judge.decision.samples"]
    assert (samples.scaled(0.8), samples.scaled(1.2)) == ((2.0,), (4.0,))
    assert {each for each in COUNTS if not any(name.endswith(f".{each}") for name in numbers)} == set()


def test_every_kind_and_every_element_fails_once_and_some_drives_are_fault_free():
    found = drives(7)
    assert {fault.kind for each in found for fault in each.injected} == {*KINDS}
    assert {fault.element for each in found for fault in each.injected} == {
        *sensitivity.SENSORS,
        *sensitivity.ACTUATORS,
    }
    assert any(not each.injected for each in found)
    assert all(fault.end < each.seconds for each in found for fault in each.injected)


@pytest.fixture(scope="module")
def prepared():
    offset = Injected("steering_wheel_angle", OFFSET, 1.5, start=8.0, end=10.0)
    made = [Drive(SHORT, 11.0, 3, 77, faults) for faults in ((), (offset,))]
    return [sensitivity._prepared(each, recorded(each)) for each in made]


def test_a_threshold_moved_far_changes_verdicts_and_one_moved_nowhere_none(bank, numbers, prepared):
    usual = judged_by(bank, prepared)
    same = effect(usual, judged_by(varied(bank, numbers["judge.decision.gate"], 1.0), prepared))
    assert (same.changed, same.alarms, same.accuracy, same.delay, same.shows) == ((), 0, 0.0, 0.0, False)
    deaf = varied(
        varied(bank, numbers["judge.decision.weighing.limits.fast"], 1e3),
        numbers["judge.decision.weighing.limits.slow"],
        1e3,
    )
    lost = effect(usual, judged_by(deaf, prepared))
    assert len(lost.changed) == 1
    assert "steering_wheel_angle" in lost.changed[0]
    assert lost.accuracy < 0.0
    assert lost.shows


def test_what_decides_comes_first_and_is_the_cause(numbers, prepared, bank, monkeypatch):
    usual = judged_by(bank, prepared)
    quiet, faulty = usual.scores
    alarm = quiet._replace(false_alarms=2)
    later = faulty._replace(faults=(faulty.faults[0]._replace(delay_excited=9.0),))

    def judged(known, vehicle, quick, asked):
        name = asked[0].name if asked else ""
        if name.endswith("decision.gate") and asked[1] > 1.0:
            return Judged((alarm, faulty), (0, 1))
        return Judged((quiet, later), (0, 2)) if name.endswith("loss_time") else usual

    monkeypatch.setattr(sensitivity, "judged", judged)
    key = sensitivity.VARIANTS[sensitivity.BEST].module, sensitivity.first_vehicle()
    monkeypatch.setattr(sensitivity, "calibrations", lambda *_: {key: Known(load("smartload"))})
    found = list(sensitivity.items(Effort(thorough=True, processes=1)))
    (table,) = (each for each in found if isinstance(each, Table))
    used = [each for each in numbers.values() if each.used and not each.off]
    assert {row[0] for row in table.rows} == {each.name for each in used}
    assert table.rows[0][:4] == ("judge.decision.gate", "6", "0 / 1", "0 / 2")
    assert table.rows[1][0] == "judge.loss_time"
    assert table.rows[1][2:6] == (
        "0",
        "0",
        "0",
        f"{9.0 - faulty.faults[0].delay_excited:g} / {9.0 - faulty.faults[0].delay_excited:g}",
    )
    assert {row[2:6] for row in table.rows[2:]} == {("–",) * 4}
    claims = {each.id: each for each in found if isinstance(each, Claim)}
    share, alarms = claims["sensitivity.unchanged"], claims["sensitivity.alarms"]
    assert share.measured == pytest.approx(1.0 - 1.0 / len(used))
    assert share.met
    assert share.note.endswith(f"which do not reach {len(used) - 2} of the numbers.")
    assert alarms.measured == 1
    assert "judge.decision.gate (+0 / +2); 1 of 1 drives with more are without a fault" in alarms.cause


def test_a_usual_study_does_not_take_the_time():
    assert list(sensitivity.items(Effort())) == []


def test_verdicts_are_names_kinds_and_alarms(bank, prepared):
    _, faulty = judged_by(bank, prepared).scores
    before = Judged((faulty,), (0,))
    for other in (
        faulty._replace(named="yaw_rate"),
        faulty._replace(faults=(faulty.faults[0]._replace(kind_right=False),)),
        faulty._replace(wrong_share=0.1),
        faulty._replace(false_alarms=1),
    ):
        assert effect(before, Judged((other,), (0,))).changed == (faulty.drive.name,)
    assert not effect(before, Judged((faulty._replace(drive=replace(faulty.drive, seed=1)),), (0,))).changed
