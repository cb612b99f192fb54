"""The parts of the study, on a diagnosis that declares the truth a little late: every figure is then known."""

from __future__ import annotations

import sys
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

from tierod.core.claims import Claim, Outcome
from tierod.core.content import Table
from tierod.core.recording import Recording
from tierod_lab.papers.condition import (
    actuators,
    beyond,
    closed_loop,
    healthy,
    reported,
    runs,
    sensors,
    theory,
    uncalibrated,
)
from tierod_lab.papers.condition.drives import OFFSET, Drive, Injected
from tierod_lab.papers.condition.recorded import fault_free, recorded
from tierod_lab.papers.condition.scoring import ELEMENTS, score
from tierod_lab.papers.condition.truth import Declared, truth_of
from tierod_lab.papers.condition.vehicles import vehicle
from tierod_lab.studies.effort import Effort

LATE = 0.1


def _declare(known: float, recording: Recording, name: str) -> Declared:
    time = recording["yaw_rate"].time
    faulty, kind, size, value = {}, {}, {}, {}
    for fault in recording.metadata["faults"]:
        element = fault["element"]
        faulty[element] = (time >= fault["start"] + known - 1e-9) & (time < fault["end"] - 1e-9)
        kind[element], size[element] = np.full(len(time), fault["kind"]), np.full(len(time), fault["size"])
        if element in recording:
            value[element] = fault_free(element, recording, vehicle(1).sensors)
    return Declared(time, faulty, kind=kind, size=size, value=value)


@pytest.fixture
def late_truth(monkeypatch):
    module = ModuleType("late_truth")
    module.calibrate, module.declare = lambda number, quick: LATE, _declare
    monkeypatch.setitem(sys.modules, "late_truth", module)
    monkeypatch.setattr(reported, "first_vehicle", lambda: 1)  # known here, whatever the monitor is
    variants = {"bank": runs.Variant("the truth, late", "late_truth")}
    for part in (runs, sensors, actuators, beyond, healthy, theory, sensors.tables):
        monkeypatch.setattr(part, "VARIANTS", variants)


def _claims(part) -> dict[str, Claim]:
    found = list(part.items(Effort(quick=True, processes=1)))
    assert all(table.rows for table in found if isinstance(table, Table))
    return {each.id: each for each in found if isinstance(each, Claim)}


def test_the_tests_of_the_sensors_are_as_good_as_the_diagnosis(late_truth):
    claims = _claims(sensors)
    assert claims["sensors.accuracy"].measured == pytest.approx(1.0 - LATE / 60.0)
    assert claims["sensors.offsets"].measured == pytest.approx(LATE)
    assert claims["sensors.kinds"].measured == 1.0
    assert claims["sensors.value-yaw-rate"].measured == 0.0
    assert not [claim for claim in claims.values() if claim.goal and not claim.met]


@pytest.mark.slow
def test_the_tests_of_the_actuators_are_as_good_as_the_diagnosis(late_truth):
    claims = _claims(actuators)
    assert claims["actuators.lost-accuracy"].measured == pytest.approx(1.0 - LATE / 200.0)
    assert claims["actuators.half-named"].measured == claims["actuators.both-named"].measured == 1.0
    assert not [claim for claim in claims.values() if claim.goal and not claim.met]


def test_pairs_kinds_and_small_faults_are_all_found_by_the_late_truth(late_truth):
    claims = _claims(beyond)
    assert claims["beyond.pairs-isolated"].measured == 1.0
    assert not [claim for claim in claims.values() if claim.goal and not claim.met]


def _useless(known: float, recording: Recording, name: str) -> Declared:
    time = recording["yaw_rate"].time
    failed = {fault["element"] for fault in recording.metadata["faults"]}
    faulty = {name: np.mod(time, 5.0) > 1.0 for name in ELEMENTS if name not in failed}
    return Declared(time, faulty, kind={name: np.full(len(time), "stuck") for name in faulty})


@pytest.mark.slow
def test_every_claim_that_a_useless_diagnosis_fails_has_a_cause(late_truth, monkeypatch):
    def scored(drive, recording):
        return score(drive, truth_of(drive, recording), _useless(LATE, recording, ""))

    sys.modules["late_truth"].declare = _useless
    monkeypatch.setattr(uncalibrated, "_scored", scored)
    monkeypatch.setattr(uncalibrated, "healthy_drives", lambda hours, vehicles: [Drive("short-round", 10.0, 1, 5)])
    claims = [
        each
        for part in (sensors, actuators, beyond, healthy, uncalibrated)
        for each in part.items(Effort(quick=True, processes=1))
        if isinstance(each, Claim) and each.goal is not None
    ]
    assert [each.id for each in claims if each.met] == []
    assert [each.id for each in claims if not each.cause] == []
    causes = {each.id: each.cause for each in claims}
    assert causes["sensors.missed"].startswith("Missed: wheel speed rear left loss")
    assert "something fault-free named" in causes["beyond.pairs-wrong"]
    assert causes["healthy.alarms"].startswith("In healthy, ")


def test_a_figure_of_the_paper_that_rules_do_not_reach_has_the_weakest_faults_as_its_cause(late_truth):
    runs.VARIANTS["rules"] = runs.Variant("rules, corrected", "late_truth")
    drive = Drive("short-round", 12.0, 1, 5, (Injected("yaw_rate", OFFSET, 0.3, 8.0, 11.0),))
    recording = recorded(drive)
    scored = score(drive, truth_of(drive, recording), _useless(LATE, recording, ""))
    failed = {each.id: each for each in sensors._baseline({"rules": [scored]}) if each.met is False}
    assert {*failed} == {"rules.rules-accuracy", "rules.rules-worst"}
    for each in failed.values():
        assert each.outcome is Outcome.IRREPRODUCIBLE
        assert "accuracy least for yaw rate offset 0.750" in each.cause


def test_faults_of_uncalibrated_vehicles_are_counted_by_kind(late_truth, monkeypatch):
    def scored(drive, recording):
        return score(drive, truth_of(drive, recording), _declare(LATE, recording, ""))

    monkeypatch.setattr(uncalibrated, "_scored", scored)
    monkeypatch.setattr(uncalibrated, "healthy_drives", lambda hours, vehicles: [Drive("short-round", 10.0, 1, 5)])
    found = list(uncalibrated.items(Effort(quick=True, processes=1)))
    (table,) = (each for each in found if isinstance(each, Table))
    assert {row[0] for row in table.rows} <= {"offset", "gain", "noise", "delay"}
    assert all(row[1] == row[2] and row[3] == "0" and row[6] == "1.000" for row in table.rows)
    measured = {each.id: each.measured for each in found if isinstance(each, Claim)}
    assert measured["uncalibrated.kinds"] == 1.0
    assert measured["uncalibrated.wrong"] == measured["uncalibrated.alarms"] == 0.0


def test_healthy_driving_without_alarms_leaves_a_bound(late_truth, monkeypatch):
    monkeypatch.setattr(healthy, "changed_drives", lambda hours, vehicles: [Drive("short-round", 10.0, 1, 5)])
    claims = _claims(healthy)
    assert claims["healthy.alarms"].measured == 0
    assert "29.9 per hour" in claims["healthy.alarms"].note or "30 per hour" in claims["healthy.alarms"].note


def test_a_variant_is_calibrated_once_for_a_vehicle(late_truth, monkeypatch):
    asked = []
    sys.modules["late_truth"].calibrate = lambda number, quick: asked.append(number) or LATE
    monkeypatch.setattr(runs, "_known", {})
    for _ in range(2):
        runs.scores([Drive("short-round", 4.0, number) for number in (1, 2)], Effort(True, 1))
    assert asked == [1, 2]
    made = recorded(Drive("short-round", 4.0, 1))
    known = runs.calibrations(["bank"], [1], Effort(True, 1))
    assert not runs.diagnosed("bank", Drive("short-round", 4.0, 1), made, known).faulty


def test_every_variant_is_calibrated_on_every_vehicle(late_truth, monkeypatch):
    monkeypatch.setitem(sys.modules, "other_truth", sys.modules["late_truth"])
    runs.VARIANTS["other"] = runs.Variant("the truth as well", "other_truth")
    monkeypatch.setattr(runs, "_known", {})
    found = runs.calibrations(runs.VARIANTS, (number for number in (1, 2)), Effort(True, 1))
    assert set(found) == {(module, number) for module in ("late_truth", "other_truth") for number in (1, 2)}


@pytest.mark.slow
def test_the_late_truth_disagrees_with_structure_on_the_motors_alone(late_truth):
    *_, disagreements = (each for each in theory.items(Effort(quick=True, processes=1)) if isinstance(each, Table))
    motors = [row for row in disagreements.rows if row[1] != "isolable"]
    assert motors
    assert all("structure regards no time" in row[-1] for row in motors)
    assert all(
        row[-1].startswith("its equations have it, but not its size") for row in disagreements.rows if row not in motors
    )


def test_faults_inside_the_loop_change_the_drive_and_are_scored_like_all_others(late_truth, monkeypatch):
    chosen = [each for each in closed_loop.drives(Effort(quick=True)) if each.injected[0].element == "yaw_rate"][:2]
    assert all(not each.injected[0].in_recording_alone for each in closed_loop.drives(Effort()))
    monkeypatch.setattr(closed_loop, "drives", lambda effort: [replace(each, seconds=30.0) for each in chosen])
    (table,) = (each for each in closed_loop.items(Effort(quick=True, processes=1)) if isinstance(each, Table))
    assert [row[:4] for row in table.rows] == [("yaw_rate", "loss", "1", "1"), ("yaw_rate", "offset", "1", "1")]
    assert {row[4] for row in table.rows} == {f"{LATE:.2f}"}
    assert {row[-2] for row in table.rows} == {"0"}
