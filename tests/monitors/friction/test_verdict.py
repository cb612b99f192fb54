"""The running verdict on friction alone, fed with estimates."""

import numpy as np
import pytest

from tierod.core.facts import assemble
from tierod.core.findings import Status
from tierod.core.graph import scan
from tierod.core.statuses import STATUSES
from tierod.monitors.friction.facts import FrictionRun, verdict_of_run
from tierod.monitors.friction.verdict import FrictionLimits, FrictionVerdict

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
        (((80.0, 5.0),), Status.HEALTHY),
        (((80.0, 5.5),), Status.RISING),
        (((80.0, 9.0),), Status.FAULT),
        (((130.0, 4.0), (1.5, 5.5), (10.0, 4.0)), Status.HEALTHY),
    ],
    ids=[
        "before the ready time",
        "nominal",
        "within the margin",
        "rising",
        "fault",
        "a short excursion",
    ],
)
def test_a_course_of_friction_has_the_status_of_its_limits(course, status):
    running, _, finding = judged(FrictionVerdict(LIMITS), estimates(*course))
    assert finding.status is running[-1] is status


def test_a_verdict_by_the_ratio_says_so_and_draws_it():
    finding = judged(FrictionVerdict(LIMITS), estimates((160.0, 4.0), (30.0, 7.32)))[2]
    assert finding.status is Status.FAULT
    assert finding.headline == "Friction: fault, 7.3 ± 0.6 N·m since 160 s"
    assert "1.83 times the 4.00 N·m learnt in this recording, fault from 1.6 times" in finding.details
    assert "7.5" not in said(finding)
    assert "fault from 1.6 times (6.40 N·m)" in finding.cause
    assert finding.estimate.reference["fault"] == pytest.approx(6.4)
    assert finding.estimate.reference["rising"] == pytest.approx(4.8)
