import math
from functools import cache

import numpy as np
import pytest

from tierod.errors import InputError, ParameterError
from tierod.findings import Status
from tierod.graph import scan
from tierod.monitors.friction.conditioning import SteeringSample
from tierod.monitors.friction.judgement import judge
from tierod.monitors.friction.monitor import FrictionMonitor
from tierod.monitors.friction.run import FrictionRun
from tierod.monitors.friction.verdict import UNKNOWN_LIMITS, FrictionLimits, FrictionVerdict
from tierod.monitors.friction.verdict_state import VerdictSample
from tierod.studies.friction_cases import Case
from tierod.vehicles import load

VEHICLE = load("midsize-eps")
MONITOR = FrictionMonitor.of_vehicle(VEHICLE)
LIMITS = FrictionLimits(4.0, 4.8, 7.5)
ANGLE, RATE, DRIVER, MOTOR, YAW, LATERAL, SPEED = range(7)
CHANGE = 390.0


@cache
def signals(case):
    return case.recording().align(SteeringSample._fields, 100.0).values


def enabled_delay(result, code):
    """Enabled time [s] from the change to the first verdict of at least this code."""
    enabled = np.cumsum(result["estimate.enabled"]) / 100.0
    change = round(100.0 * CHANGE)
    assert (result["verdict.code"][:change] < 3.0).all()
    reached = np.flatnonzero(result["verdict.code"][change:] >= code)
    return enabled[change + reached[0]] - enabled[change] if len(reached) else math.inf


@pytest.mark.parametrize("seed", [1001, 1002])
def test_a_step_to_12_5_is_a_fault_within_12_s_enabled(seed):
    result = scan(MONITOR, signals(Case(seed, 4.0, 12.5)))
    assert enabled_delay(result, 4.0) <= 12.0
    finding = MONITOR.finding(result)
    assert finding.status is Status.FAULT
    assert finding.since == pytest.approx(CHANGE, abs=30.0)
    assert finding.estimate.value == pytest.approx(12.5, abs=0.3)
    assert finding.evidence["ratio_to_own_level"] == pytest.approx(12.5 / 4.0, abs=0.1)


@pytest.mark.parametrize("seed", [1001, 1002])
def test_a_step_to_5_5_is_rising_within_25_s_enabled(seed):
    result = scan(MONITOR, signals(Case(seed, 4.0, 5.5)))
    assert enabled_delay(result, 3.0) <= 25.0
    finding = MONITOR.finding(result, start_time=1000.0)
    assert finding.status is Status.RISING
    assert finding.since == pytest.approx(1000.0 + CHANGE, abs=60.0)
    assert "own level" in finding.cause


@pytest.mark.parametrize(("seed", "scatter"), [(30_001, "usual"), (30_002, "usual"), (30_003, "hard")])
def test_healthy_cars_of_all_sorts_stay_healthy(seed, scatter):
    result = scan(MONITOR, signals(Case(seed, scatter=scatter)))
    assert set(np.unique(result["verdict.code"])) == {0.0, 2.0}
    finding = MONITOR.finding(result)
    assert finding.status is Status.HEALTHY
    assert finding.status.exit_code == 0
    assert any("10 % of torque" in warning for warning in finding.warnings)


def test_a_car_that_was_bad_from_the_start_is_a_fault_and_teaches_no_level():
    finding = MONITOR.finding(scan(MONITOR, signals(Case(1001, 12.5))))
    assert finding.status is Status.FAULT
    assert finding.since is None
    assert "own level" not in finding.estimate.reference
    assert any("not learnt" in warning for warning in finding.warnings)


def test_a_level_from_earlier_drives_tells_a_small_rise_at_once():
    stored = FrictionMonitor.of_vehicle(VEHICLE, learnt_level=4.0, learnt_deviation=0.05)
    finding = stored.finding(scan(stored, signals(Case(1001, 5.2))))
    assert finding.status is Status.RISING
    assert finding.evidence["ratio_to_own_level"] == pytest.approx(1.3, abs=0.03)


def finding_of(change, case=Case(1001), **options):  # noqa: B008
    samples = signals(case).copy()
    change(samples)
    return MONITOR.finding(scan(MONITOR, samples), **options)


def turned(*columns):
    def change(samples):
        samples[:, list(columns)] *= -1.0

    return change


@pytest.mark.parametrize(
    ("change", "status", "words"),
    [
        (turned(DRIVER), Status.NOT_IDENTIFIABLE, "opposite signs"),
        (turned(DRIVER, MOTOR), Status.NOT_IDENTIFIABLE, "negative"),
        (turned(LATERAL, YAW), Status.NOT_IDENTIFIABLE, "self-aligning torque is negative"),
        (lambda s: s[:, DRIVER].fill(0.1), Status.NOT_ENABLED, "driver's torque was too small 100%"),
        (lambda s: s[:, SPEED].fill(1.0), Status.NOT_ENABLED, "stood or crept 100%"),
        (lambda s: s[:, [RATE]].fill(0.0) or s[:, RATE].fill(0.0), Status.NOT_ENABLED, "hardly turned 100%"),
        (lambda s: s[:, YAW].fill(np.nan), Status.NOT_AVAILABLE, "never were all signals present"),
        (lambda s: s[6000:].fill(np.nan), Status.NOT_READY, "s enabled of 50 s needed"),
    ],
)
def test_without_a_sound_basis_the_value_is_withheld(change, status, words):
    finding = finding_of(change)
    assert finding.status is status
    assert finding.status.exit_code == 2
    assert words in finding.cause
    assert finding.action
    assert finding.estimate is None


def test_raw_counts_are_withheld():
    finding = finding_of(lambda samples: None, calibrated=False)
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert finding.estimate is None
    assert "raw counts" in finding.cause
    assert not any(name.endswith("_Nm") for name in finding.evidence)


def test_lane_keeping_is_told_from_a_wrong_sign():
    def lane_keeping(samples):
        half = (np.arange(len(samples)) // 500) % 2 == 1
        samples[half, MOTOR] *= -1.0

    finding = finding_of(lane_keeping)
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert "lane keeping" in finding.cause
    assert finding.evidence["opposed_torques_share"] == pytest.approx(0.5, abs=0.1)


def test_strokes_shorter_than_the_build_up_are_not_identifiable():
    time = np.arange(60_000) * 0.01
    rate = 0.12 * np.cos(2.0 * math.pi * 2.0 * time)
    angle = 0.12 * np.sin(2.0 * math.pi * 2.0 * time) / (2.0 * math.pi * 2.0)
    samples = np.zeros((len(time), 7))
    samples[:, ANGLE], samples[:, RATE], samples[:, SPEED] = angle, rate, 20.0
    stiffness = 4.0 / math.radians(6.0)
    total = 3.0 + stiffness * angle + 0.8 * rate
    samples[:, DRIVER], samples[:, MOTOR] = total / 3.0, total / 30.0
    finding = MONITOR.finding(scan(MONITOR, samples))
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert "strokes" in finding.cause


# ---- the running verdict alone, fed with estimates


def estimates(*stretches):
    """Estimates of a (seconds, friction) course with the gate always open."""
    course = np.concatenate([np.full(round(100 * seconds), friction) for seconds, friction in stretches])
    neutral = np.array([0.0, 0.05, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.9, 0.0, 0.8, 1.0])
    samples = np.tile(neutral, (len(course), 1))
    samples[:, 0] = course
    samples[:, 9] = np.where(np.arange(len(course)) // 100 % 2, 1.0, -1.0)
    return samples


def judged(verdict, samples):
    state, outputs = verdict.init(), []
    for row in samples.tolist():
        state, output = verdict.step(state, VerdictSample(*row))
        outputs.append(output)
    run = FrictionRun("test", verdict, state, VerdictSample(*samples[-1].tolist()), outputs[-1], calibrated=True)
    return outputs, state, judge(run)


def test_not_ready_before_the_ready_time():
    outputs, _, finding = judged(FrictionVerdict(LIMITS), estimates((49.0, 12.5)))
    assert {output.code for output in outputs} == {0.0}
    assert finding.status is Status.NOT_READY


def test_an_episode_that_is_over_is_suspect():
    _, state, finding = judged(FrictionVerdict(LIMITS), estimates((130.0, 4.0), (20.0, 5.5), (30.0, 4.0)))
    assert finding.status is Status.SUSPECT
    assert state.figures.alarm_seconds == pytest.approx(20.0, abs=3.0)


def test_the_level_is_frozen_while_friction_is_suspicious():
    _, state, finding = judged(FrictionVerdict(LIMITS), estimates((90.0, 4.0), (60.0, 4.7)))
    assert state.own.level == pytest.approx(4.0, abs=1e-9)
    assert state.own.seconds == pytest.approx(40.0, abs=0.1)
    assert finding.status is Status.HEALTHY


def test_a_short_excursion_is_ridden_out():
    _, _, finding = judged(FrictionVerdict(LIMITS), estimates((130.0, 4.0), (1.5, 5.5), (10.0, 4.0)))
    assert finding.status is Status.HEALTHY


@pytest.mark.parametrize(("friction", "status"), [(4.0, Status.HEALTHY), (5.5, Status.RISING), (9.0, Status.FAULT)])
def test_absolute_limits_judge_a_constant_friction(friction, status):
    assert judged(FrictionVerdict(LIMITS), estimates((80.0, friction)))[2].status is status


def test_without_limits_the_ratio_alone_speaks():
    verdict = FrictionVerdict(UNKNOWN_LIMITS)
    assert judged(verdict, estimates((130.0, 40.0)))[2].status is Status.HEALTHY
    assert judged(verdict, estimates((130.0, 40.0), (20.0, 80.0)))[2].status is Status.FAULT


def test_friction_far_below_the_learnt_level_is_said():
    finding = judged(FrictionVerdict(LIMITS, learnt_level=4.0), estimates((80.0, 2.8)))[2]
    assert finding.status is Status.HEALTHY
    assert any("0.70 times the own level" in warning for warning in finding.warnings)


def test_float_steps_agree_with_the_scan():
    verdict, samples = FrictionVerdict(LIMITS), estimates((75.0, 4.0), (10.0, 5.5))
    outputs, _, _ = judged(verdict, samples)
    assert scan(verdict, samples).values == pytest.approx(np.array(outputs), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("limits", [(4.0, 3.0, 7.5), (0.0, 1.0, 2.0), (4.0, 5.0, 5.0)])
def test_limits_out_of_order_are_refused(limits):
    with pytest.raises(ParameterError, match="must rise"):
        FrictionLimits(*limits)


def test_a_level_that_is_not_positive_is_refused():
    with pytest.raises(ParameterError, match="positive torque"):
        FrictionVerdict(LIMITS, learnt_level=-1.0)


def test_no_samples_are_refused():
    with pytest.raises(InputError, match="no samples"):
        MONITOR.finding(scan(MONITOR, np.empty((0, 7))))
