import dataclasses

import numpy as np
import pytest

from papers.friction.made_drives import QUICK, claims_of, made_drives, right
from tierod.core.content import Chart, Table
from tierod.core.statuses import Status
from tierod_lab.papers.friction import (
    all_terms,
    baseline,
    conditions,
    convergence,
    fleet,
    laws,
    refined_claims,
    refined_figures,
    steps,
    verdicts,
)
from tierod_lab.papers.friction.cases import Case
from tierod_lab.papers.friction.digest import Course, Digest
from tierod_lab.papers.friction.estimators import ALL_TERMS, DEFAULT, PRINTED
from tierod_lab.papers.friction.runs import Drives
from tierod_lab.papers.friction.study import PARTS


def test_every_part_shows_and_claims_something():
    drives = made_drives()
    for part in PARTS:
        items = list(part(drives, QUICK))
        assert any(isinstance(item, Chart | Table) or hasattr(item, "met") for item in items)
        for item in items:
            if isinstance(item, Table):
                assert all(len(row) == len(item.header) for row in item.rows)


def test_names_of_claims_are_unique():
    drives = made_drives()
    names = [name for part in PARTS for name in claims_of(part, drives)]
    assert len(set(names)) == len(names) > 40


def test_a_right_estimator_meets_its_claims():
    claims = claims_of(fleet.items, made_drives())
    assert {name: claim.met for name, claim in claims.items() if not claim.met} == {}
    assert claims["estimator.bias-12.5"].measured == pytest.approx(0.0, abs=0.15)


def test_what_the_gains_of_the_driven_cars_explain_leaves_nothing():
    first = 700_000
    cases = tuple(Case(9000 + car, 4.0, 5.0, car=50 + car) for car in range(8))
    drives = {}
    for case in cases:
        gain = case.counted_from(first).setup().sensors["driver_torque"].gain
        course = Course(np.full(4, case.level * gain), np.full(4, 60.0))
        drives[case] = Digest(60.0, np.zeros(4), {DEFAULT: course})
    assert np.abs(fleet._without_gains(cases, Drives(drives, first=first))).max() < 1e-6
    assert np.abs(fleet._without_gains(cases, Drives(drives))).max() > 0.01


def off(estimator, by):
    def estimate(level, name, chance):
        return right(level, name, chance) + (by if name == estimator else 0.0)

    return estimate


def test_a_biased_estimator_fails_its_claims_and_no_other():
    claims = claims_of(fleet.items, made_drives(off(DEFAULT, 0.5)))
    assert not any(claims[f"estimator.bias-{level}"].met for level in ("4", "8", "12.5"))
    assert all(claims[f"estimator.deviation-{level}"].met for level in ("4", "8", "12.5"))
    assert claims["estimator.bias-8"].measured == pytest.approx(0.5, abs=0.15)


def test_an_estimator_that_sees_nothing_separates_nothing():
    def blind(level, name, chance):
        return 4.0

    claims = claims_of(refined_claims.items, made_drives(blind))
    for name in ("separation", "before-driver-notices", "refined-overlap", "tyres-separation"):
        assert claims[f"paper.{name}"].met is False
    assert claims_of(fleet.items, made_drives(blind))["estimator.auc-slight"].met is False


def test_a_filter_that_never_settles_meets_nothing_and_stops_nothing():
    drives = made_drives()
    never = {
        case: dataclasses.replace(
            digest,
            courses={
                name: dataclasses.replace(course, enabled_seconds=0.0 * course.enabled_seconds)
                for name, course in digest.courses.items()
            },
        )
        for case, digest in drives.digests.items()
    }
    for part in PARTS:
        for claim in claims_of(part, Drives(never)).values():
            if claim.figure is None and claim.measured is not None:
                assert claim.met in (False, None)
    claims = claims_of(fleet.items, Drives(never))
    assert claims["estimator.bias-4"].met is claims["estimator.auc-slight"].met is False


def test_a_missed_fault_and_a_false_alarm_are_counted():
    claims = claims_of(verdicts.items, made_drives(verdict=lambda level: Status.HEALTHY))
    assert (claims["verdict.faults-found"].measured, claims["verdict.faults-found"].met) == (6.0, False)
    claims = claims_of(verdicts.items, made_drives(verdict=lambda level: Status.FAULT))
    assert claims["verdict.healthy-minutes"].measured == 12.0
    assert claims["verdict.healthy-minutes"].met is False


def test_wrong_verdicts_under_an_unknown_law_are_counted():
    assert claims_of(laws.items, made_drives())["laws.verdicts"].met is True
    claims = claims_of(laws.items, made_drives(verdict=lambda level: Status.HEALTHY))
    assert claims["laws.verdicts"].measured == 3.0


def test_drives_that_failed_are_faults_not_found():
    drives = made_drives()
    lost = {case: digest for case, digest in drives.digests.items() if case.friction != 12.5}
    assert claims_of(verdicts.items, Drives(lost))["verdict.faults-found"].measured == 2.0


def test_the_scatter_of_the_printed_filter_is_held_against_the_printed_one():
    def wide(level, name, chance):
        return level + (1.8 if name == PRINTED else 0.0) * (1.0 if chance.random() < 0.5 else -1.0)

    narrow = claims_of(refined_claims.items, made_drives())
    assert narrow["paper.deviation-healthy"].met is False
    assert narrow["paper.deviation-largest"].met is True
    spread = claims_of(refined_claims.items, made_drives(wide))
    assert spread["paper.deviation-healthy"].measured == pytest.approx(1.7, abs=0.3)


def test_convergence_is_read_off_the_course():
    drives = made_drives()
    claims = claims_of(convergence.items, drives)
    # 80 % of the way to the truth with a time constant of 10 s.
    assert claims["paper.convergence-enabled"].measured == pytest.approx(16.1, abs=1.0)
    assert claims["paper.convergence-total"].measured == pytest.approx(16.1 / 0.36, abs=3.0)


def test_convergence_to_an_own_mean_that_is_not_the_truth_does_not_count():
    def low(level, name, chance):
        return 0.6 * level

    claims = claims_of(convergence.items, made_drives(low))
    assert claims["paper.convergence-enabled"].met is claims["paper.convergence-total"].met is False
    assert claims["paper.convergence-enabled"].figure is None
    assert "25: never" in claims["paper.convergence-enabled"].cause


def test_terms_that_move_the_estimate_are_not_ignored():
    plain = claims_of(all_terms.items, made_drives())
    assert all(plain[f"paper.{name}"].met for name in ("delta-term", "ratio-slope-term", "constant-ratio"))
    moved = claims_of(all_terms.items, made_drives(off(ALL_TERMS, 0.5)))
    assert moved["paper.delta-term"].measured == pytest.approx(0.5, abs=0.2)
    assert moved["paper.delta-term"].met is False
    assert moved["paper.constant-ratio"].met


def test_a_baseline_that_overlaps_is_found_overlapping():
    apart = claims_of(baseline.items, made_drives())
    assert apart["paper.baseline-overlap"].met is False
    assert apart["paper.baseline-overlap"].measured == pytest.approx(0.0, abs=0.01)
    same = {
        case: dataclasses.replace(
            digest,
            windows={
                name: dataclasses.replace(w, variance=w.variance / case.level**2) for name, w in digest.windows.items()
            },
        )
        for case, digest in made_drives().digests.items()
    }
    together = claims_of(baseline.items, Drives(same))
    assert together["paper.baseline-overlap"].met is True
    assert claims_of(conditions.items, Drives(same))["paper.search-baseline-corrected"].met is True


def test_figures_of_the_paper_are_redrawn():
    drives = made_drives()
    names = [
        item.name
        for part in (baseline.items, refined_figures.items)
        for item in part(drives, QUICK)
        if isinstance(item, Chart)
    ]
    assert names == ["figure-3", "figure-5", "figure-6", "figure-7", "figure-8", "figure-9"]


def test_delays_after_a_step_are_reported():
    tables = [item for item in steps.items(made_drives(), QUICK) if isinstance(item, Table)]
    assert tables[0].rows[0] == ("4 to 12.5 N·m, nominal", "3.0", "3.0", "never", "never", "0")


def test_a_drive_that_is_missing_is_left_out():
    drives = made_drives()
    assert drives.of([Case(987654)]) == []
