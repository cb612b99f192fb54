"""The running verdict on friction alone, fed with estimates."""

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.facts import assemble
from tierod.core.findings import Status
from tierod.core.graph import scan
from tierod.core.statement import STATUSES, code_of
from tierod.monitors.friction.facts import FrictionRun, verdict_of_run
from tierod.monitors.friction.thresholds import ABSOLUTE_DESIGN, RISING_DESIGN, AlarmTuning
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


def test_an_episode_that_is_over_is_suspect():
    _, last, finding = judged(FrictionVerdict(LIMITS), estimates((130.0, 4.0), (20.0, 5.5), (30.0, 4.0)))
    assert finding.status is Status.SUSPECT
    assert last.figures.alarm_seconds == pytest.approx(20.0, abs=3.0)


def test_the_level_is_frozen_while_friction_is_suspicious():
    _, last, finding = judged(FrictionVerdict(LIMITS), estimates((90.0, 4.0), (60.0, 4.7)))
    assert last.baseline.level == pytest.approx(4.0, abs=1e-9)
    assert last.baseline.seconds == pytest.approx(40.0, abs=0.1)
    assert finding.status is Status.HEALTHY


def test_without_limits_the_ratio_alone_speaks():
    verdict = FrictionVerdict(None)
    assert judged(verdict, estimates((130.0, 40.0)))[0][-1] is Status.HEALTHY
    running, last, finding = judged(verdict, estimates((130.0, 40.0), (20.0, 80.0)))
    assert running[-1] is Status.FAULT
    assert last.statement.status == code_of(Status.NOT_IDENTIFIABLE)
    assert "raw counts" in finding.cause


def test_friction_far_below_the_learnt_level_is_said():
    finding = judged(FrictionVerdict(LIMITS, learnt_level=4.0), estimates((80.0, 2.8)))[2]
    assert finding.status is Status.HEALTHY
    assert "only 0.70 times its baseline of 4.00 N·m: the gains of driver_torque or motor_torque" in finding.cause
    assert "check the gains of driver_torque and motor_torque, judge a lock-to-lock test" in finding.action
    assert judged(FrictionVerdict(LIMITS, learnt_level=4.0), estimates((80.0, 3.5)))[2].action == "none"


def column(name):
    return VerdictSample._fields.index(name)


def changed(samples, **columns):
    for name, value in columns.items():
        samples[:, column(name)] = value
    return samples


def test_the_margin_of_a_limit_is_that_of_the_verdict():
    """An estimate just below where a limit acts is no alarm, one just above is."""
    verdict = FrictionVerdict(LIMITS)
    for limit, status in ((4.8, Status.RISING), (7.5, Status.FAULT)):
        acts_from = verdict.acts_from(limit, 0.05)
        assert 1.08 * limit < acts_from < 1.1 * limit
        below = judged(verdict, estimates((60.0, 0.999 * acts_from)))[2]
        above = judged(verdict, estimates((400.0, 1.002 * acts_from)))[2]
        assert below.status is not status
        assert above.status is status
        assert above.estimate.reference[status.value] == pytest.approx(acts_from)


def test_what_is_drawn_agrees_with_the_verdict():
    for friction in (3.0, 5.0, 5.22, 6.0, 7.6, 8.0, 8.4, 12.0):
        finding = judged(FrictionVerdict(LIMITS), estimates((140.0, friction)))[2]
        reference = finding.estimate.reference
        assert list(reference)[:3] == ["nominal", "rising", "fault"]
        expected = Status.FAULT if friction > reference["fault"] else Status.RISING
        assert finding.status is (expected if friction > reference["rising"] else Status.HEALTHY)


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


def test_friction_above_the_rising_limit_but_within_the_margin_is_said_so():
    finding = judged(FrictionVerdict(LIMITS), estimates((140.0, 5.1)))[2]
    assert finding.status is Status.HEALTHY
    words = (
        "above the limit of rising friction of 4.8 N·m, but within the margin of torque gain and estimate (up to 5.2"
    )
    assert words in said(finding)
    assert words in finding.cause
    assert "before this level is stored" in finding.action
    known = judged(FrictionVerdict(LIMITS, learnt_level=5.0), estimates((140.0, 5.1)))[2]
    assert "given baseline" in known.cause
    assert "before this level is stored" not in known.action


def test_a_verdict_by_the_ratio_says_so_and_draws_it():
    finding = judged(FrictionVerdict(LIMITS), estimates((160.0, 4.0), (30.0, 7.32)))[2]
    assert finding.status is Status.FAULT
    assert finding.headline == "Friction: fault, 7.3 ± 0.6 N·m since 160 s"
    assert "1.83 times the 4.00 N·m learnt in this recording, fault from 1.6 times" in finding.details
    assert "7.5" not in said(finding)
    assert "fault from 1.6 times (6.40 N·m)" in finding.cause
    assert finding.estimate.reference["fault"] == pytest.approx(6.4)
    assert finding.estimate.reference["rising"] == pytest.approx(4.8)


def test_limits_by_the_ratio_are_said_to_be_multiples_of_the_level_and_of_which_one():
    """1.2 times the level of a car with little friction is below the nominal friction of its class."""
    finding = judged(FrictionVerdict(LIMITS), estimates((140.0, 3.0)))[2]
    assert finding.status is Status.HEALTHY
    learnt = "1.00 times the 3.00 N·m learnt in this recording"
    assert f"{learnt}, rising from 1.2 times (3.60 N·m), fault from 1.6 times (4.80 N·m)" in said(finding)
    assert "nominal 4 N·m" in finding.details
    given = judged(FrictionVerdict(LIMITS, learnt_level=3.0), estimates((140.0, 3.0)))[2]
    assert "1.00 times its baseline of 3.00 N·m, rising from" in said(given)


def test_without_a_level_the_limits_are_those_of_the_vehicle_file():
    finding = judged(FrictionVerdict(LIMITS), estimates((60.0, 4.0)))[2]
    assert finding.headline == "Friction: healthy, 4.00 ± 0.32 N·m"
    assert "nominal 4 N·m, rising from 5.2" in said(finding)
    assert "times" not in said(finding)


def test_an_absolute_fault_of_a_car_that_only_rose_by_the_ratio_names_the_absolute_limit():
    finding = judged(FrictionVerdict(FrictionLimits(4.0, 5.9, 6.0)), estimates((160.0, 5.0), (30.0, 6.8)))[2]
    assert finding.status is Status.FAULT
    assert "above the fault limit of 6 N·m plus its margin (6.52 N·m)" in said(finding)
    assert "1.36 times the 5.00 N·m learnt in this recording" in said(finding)
    assert "limit of the vehicle file" in finding.cause
    assert finding.since == pytest.approx(160.0, abs=0.1)


@pytest.mark.parametrize(("friction", "words"), [(5.3, "watch it"), (6.2, "close to a fault")])
def test_rising_friction_close_to_a_fault_is_not_just_watched(friction, words):
    finding = judged(FrictionVerdict(LIMITS), estimates((160.0, 4.0), (60.0, friction)))[2]
    assert finding.status is Status.RISING
    assert words in finding.action


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


@pytest.mark.parametrize(
    "columns",
    [
        {"damping": -0.4},
        {"aligning_gain": 0.3},
        {"aligning_gain": 3.2},
        {"misfit": 4.0, "residual": 1.2},
        {"misfit": 1.4, "residual": 1.4},
    ],
)
def test_what_fault_free_drives_reach_does_not_withhold_it(columns):
    assert judged(FrictionVerdict(LIMITS), changed(estimates((80.0, 8.5)), **columns))[2].status is Status.FAULT


@pytest.mark.parametrize(("friction", "rest"), [(4.0, Status.NOT_IDENTIFIABLE), (12.5, Status.FAULT)])
def test_friction_that_is_higher_at_rest_may_lower_the_damping_by_a_share_of_itself(friction, rest):
    """The line through a Stribeck curve, 10 % higher at rest and gone at 0.3 rad/s, over the rates of driving."""
    rates = np.linspace(0.0, 1.0, 1001)
    slope = np.polyfit(rates, 12.5 * (1.0 + 0.1 * np.exp(-((rates / 0.3) ** 2))) + 0.75 * rates, 1)[0]
    assert slope == pytest.approx(0.75 - 0.106 * 12.5, abs=0.01)
    samples = changed(estimates((80.0, friction)), damping=slope)
    assert judged(FrictionVerdict(LIMITS), samples)[2].status is rest


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


def test_a_strange_self_aligning_torque_is_doubted():
    finding = judged(FrictionVerdict(LIMITS), changed(estimates((80.0, 4.0)), aligning_gain=3.0))[2]
    assert finding.status is Status.HEALTHY
    assert any("3.00 times the value from the vehicle file" in warning for warning in finding.warnings)


def test_the_ratio_of_rising_friction_is_that_of_its_design():
    tuning = AlarmTuning()
    assert 1.0 + RISING_DESIGN.threshold * tuning.wander == pytest.approx(tuning.rising_ratio, abs=0.002)
    limits = FrictionLimits(4.0, 4.8, 7.5)
    acts_from = FrictionVerdict(limits).acts_from(limits.rising_friction, 0.0)
    assert (acts_from / 4.0 - 1.0) / tuning.gain_deviation == pytest.approx(ABSOLUTE_DESIGN.threshold, abs=0.01)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: AlarmTuning(confidence=3.0, gain_deviation=0.4), "below 1"),
        (lambda: FrictionLimits(4.0, 3.0, 7.5), "must rise"),
        (lambda: FrictionLimits(0.0, 1.0, 2.0), "must rise"),
        (lambda: FrictionLimits(4.0, 5.0, 5.0), "must rise"),
        (lambda: FrictionVerdict(LIMITS, learnt_level=-1.0), "positive torque"),
    ],
)
def test_limits_and_levels_that_make_no_sense_are_refused(wrong, words):
    with pytest.raises(ParameterError, match=words):
        wrong()
