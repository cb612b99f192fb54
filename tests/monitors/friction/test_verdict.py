"""The running verdict on friction alone, fed with estimates."""

import numpy as np
import pytest

from tierod.core.facts import assemble
from tierod.core.findings import Status
from tierod.core.graph import scan
from tierod.core.statement import STATUSES
from tierod.monitors.friction.facts import FrictionRun, verdict_of_run
from tierod.monitors.friction.verdict import FrictionLimits, FrictionVerdict, VerdictSample

LIMITS = FrictionLimits(4.0, 4.8, 7.5)


def estimates(*stretches):
    """Estimates of a (seconds, friction) course with the gate always open."""
    course = np.concatenate([np.full(round(100 * seconds), friction) for seconds, friction in stretches])
    neutral = np.array([0.0, 0.05, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.9, 0.0, 0.8, 1.0])
    samples = np.tile(neutral, (len(course), 1))
    samples[:, 0] = course
    samples[:, 9] = np.where(np.arange(len(course)) // 100 % 2, 1.0, -1.0)
    return samples


def judged(verdict, samples):
    result = scan(verdict, samples)
    last = result.at(-1)
    running = np.array([STATUSES[round(code)] for code in result["running"]], dtype=object)
    return running, last, assemble("Friction", verdict_of_run(FrictionRun("test", verdict, last)))


def said(finding):
    return "; ".join(finding.details)


@pytest.mark.parametrize(
    ("course", "status"),
    [
        (((49.0, 12.5),), Status.NOT_READY),
        (((80.0, 4.0),), Status.HEALTHY),
        (((80.0, 5.5),), Status.RISING),
        (((80.0, 9.0),), Status.FAULT),
        (((130.0, 4.0), (1.5, 5.5), (10.0, 4.0)), Status.HEALTHY),
    ],
    ids=["before the ready time", "nominal", "rising", "fault", "a short excursion"],
)
def test_a_course_of_friction_has_the_status_of_its_limits(course, status):
    running, _, finding = judged(FrictionVerdict(LIMITS), estimates(*course))
    assert finding.status is running[-1] is status


def column(name):
    return VerdictSample._fields.index(name)


def changed(samples, **columns):
    for name, value in columns.items():
        samples[:, column(name)] = value
    return samples


def test_friction_above_the_fault_limit_but_within_the_margin_is_said_so():
    finding = judged(FrictionVerdict(LIMITS), estimates((140.0, 8.0)))[2]
    assert finding.status is Status.RISING
    assert "limit of rising friction of 4.8 N·m plus its margin (5.2" in said(finding)
    assert "also above the fault limit of 7.5 N·m, but within its margin (up to 8.15 N·m)" in said(finding)
    assert (
        "above the fault limit of 7.5 N·m, but within the margin of torque gain and estimate (up to 8.15 N·m)"
        in finding.cause
    )
    assert "calibrate driver_torque and motor_torque" in finding.action
    assert "lock-to-lock" in finding.action
    assert "watch it" not in finding.action


def test_a_verdict_by_the_ratio_says_so_and_draws_it():
    finding = judged(FrictionVerdict(LIMITS), estimates((160.0, 4.0), (30.0, 7.32)))[2]
    assert finding.status is Status.FAULT
    assert finding.headline == "Friction: fault, 7.3 ± 0.6 N·m since 160 s"
    assert "1.83 times the 4.00 N·m learnt in this recording, fault from 1.6 times" in finding.details
    assert "7.5" not in said(finding)
    assert "fault from 1.6 times (6.40 N·m)" in finding.cause
    assert finding.estimate.reference["fault"] == pytest.approx(6.4)
    assert finding.estimate.reference["rising"] == pytest.approx(4.8)


@pytest.mark.parametrize(
    ("verdict", "course", "words"),
    [
        (
            FrictionVerdict(LIMITS),
            ((160.0, 4.0), (1.0, 5.4)),
            "1.35 times the 4.00 N·m learnt in this recording, rising from 1.2 times",
        ),
        (FrictionVerdict(LIMITS), ((60.0, 4.0), (1.0, 5.5)), "5.50 N·m, rising from 5.2"),
    ],
)
def test_a_recording_that_ends_above_a_limit_is_not_healthy(verdict, course, words):
    finding = judged(verdict, estimates(*course))[2]
    assert finding.status is Status.SUSPECT
    assert finding.status.exit_code == 1
    assert f"at the end friction was {words}" in finding.cause
    assert "the recording ended, or signals were lost, before this was confirmed" in finding.cause
    assert "fell back" not in finding.cause


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"damping": -1.2}, "damping is -1.2"),
        ({"aligning_gain": 0.15}, "0.15 times the value from the vehicle file"),
        ({"aligning_gain": 8.0}, "8.00 times the value from the vehicle file"),
        ({"misfit": 4.0, "residual": 1.4}, "does not fit: its residual is 1.4 N·m"),
    ],
)
def test_what_cannot_be_withholds_the_verdict(columns, words):
    running, _, finding = judged(FrictionVerdict(LIMITS), changed(estimates((80.0, 8.5)), **columns))
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert set(running) == {Status.NOT_READY, Status.NOT_IDENTIFIABLE}
    assert finding.estimate is None
    assert words in finding.cause
    assert "sign" in finding.action or "unit" in finding.action


def test_a_balance_that_fitted_may_misfit_for_a_while_after_a_step_but_not_for_ever():
    samples = estimates((70.0, 4.0), (60.0, 12.5))
    samples[7000:, [column("misfit"), column("residual")]] = 9.0, 3.4
    assert judged(FrictionVerdict(LIMITS), samples)[2].status is Status.FAULT
    longer = np.concatenate([samples, samples[-4500:]])
    running, _, finding = judged(FrictionVerdict(LIMITS), longer)
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert running[-1000] is Status.FAULT
    recovered = np.concatenate([longer, estimates((1.0, 12.5))])
    assert judged(FrictionVerdict(LIMITS), recovered)[0][-1] is Status.FAULT
