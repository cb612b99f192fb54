"""The study of own cars, in small."""

from __future__ import annotations

import json

import numpy as np
import pytest

from shared_data import shared_data
from tierod.cli import main
from tierod.core.claims import Claim
from tierod.core.findings import Status
from tierod.io.readers import read
from tierod.vehicles import load
from tierod_lab.papers.own_car import real
from tierod_lab.papers.own_car.judging import BROCHURE, TRUE, Case, Judged, Studied, studied, without_truth
from tierod_lab.papers.own_car.virtual import pooled, shown
from tierod_lab.studies.registry import STUDIES


@pytest.fixture(scope="module")
def small():
    return studied(Case(number=0, seed=2, learning=0.0, minutes=1.4, drives=1))


def test_a_car_by_its_brochure_is_held_by_its_bands_and_accused_of_nothing(small):
    found = {(each.monitor, each.file): each for each in small.judged}
    assert {file for _, file in found} == {BROCHURE, TRUE}
    for monitor in ("sideslip", "driver-torque"):
        each = found[monitor, BROCHURE]
        assert each.samples > 100
        assert each.held > 0.9 * each.samples
        assert each.squares > 0.0
    assert not any(each.status in (Status.FAULT, Status.RISING) for each in small.judged)
    assert all(np.isnan(each.cost) for each in small.judged)


def test_claims_are_of_the_groups_of_the_study(small):
    claims = [each for each in shown([small]) if isinstance(each, Claim)]
    assert {each.group for each in claims} | {"identified", "cost", "real"} == set(STUDIES["own-car"].groups)
    assert len({each.id for each in claims}) == len(claims)


def made(car, file, held, status=Status.HEALTHY):
    return Judged(car, "sideslip", file, status, "", 100, held, 4.0, 2.5)


def test_pooling_counts_samples_drives_and_false_verdicts():
    every = [made("a", BROCHURE, 100), made("b", BROCHURE, 60, Status.FAULT), made("a", TRUE, 95)]
    each = pooled(every, "sideslip", BROCHURE)
    assert (each.coverage, each.worst, each.false, each.drives) == (0.8, 0.6, 1, 2)
    assert each.error == pytest.approx(0.2)
    whole = Studied(tuple(every), ("mass",) * 4, (True, True, True, False), "", 0.0)
    claims = {each.id: each for each in shown([whole]) if isinstance(each, Claim)}
    assert claims["unknown.sideslip-band"].met is False
    assert claims["verdicts.sideslip"].measured == 1
    assert claims["cost.sideslip"].measured == 2.5
    assert claims["identified.parameters-band"].measured == 0.75
    assert "1 of 4 lie outside" in claims["identified.parameters-band"].cause


def test_monitors_see_no_truth():
    path = shared_data("revsted_slip_angle", "obd.csv")
    recording = read(path, channel_map=load("revsted-car").channel_map)
    assert "sideslip_angle" not in without_truth(recording)
    assert "sideslip_angle" not in real.without_reference(recording)


def test_typical_values_hold_the_optical_reference_of_a_real_car():
    path = shared_data("revsted_slip_angle", "obd.csv")
    recording = read(path, channel_map=load("revsted-car").channel_map)
    known = next(each for each in real.KNOWN if each.vehicle == "revsted-car")
    brochure = dict(real.files_for(known))["class midsize"]
    held, error = real.beside_reference(recording, brochure, known.reference)
    assert held > 0.9
    assert np.degrees(error) < 1.0


@pytest.mark.slow
def test_the_quick_study_runs_from_the_console(tmp_path):
    assert main(["study", "own-car", "--quick", "-o", str(tmp_path)]) in (0, 1)
    claims = json.loads((tmp_path / "claims.json").read_text())
    assert {row["id"].partition(".")[0] for row in claims} == set(STUDIES["own-car"].groups)
    false = [row["measured"] for row in claims if row["id"].startswith("verdicts.") or row["id"] == "real.false"]
    assert sum(each or 0.0 for each in false) == 0.0
