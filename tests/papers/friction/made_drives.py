"""Synthetic drives: digests in which every estimator behaves as the test prescribes."""

import math

import numpy as np

from tierod.core.statuses import Status
from tierod_lab.papers.friction.cases import HEALTHY, Case
from tierod_lab.papers.friction.digest import Course, Digest, Verdict, Windows
from tierod_lab.papers.friction.estimators import BASELINES, DEFAULT, ESTIMATORS
from tierod_lab.papers.friction.runs import Drives
from tierod_lab.papers.friction.study import WANTS
from tierod_lab.studies.effort import Effort

QUICK = Effort(quick=True)
ENABLED = 0.36


def right(level, estimator, chance):
    return level + 0.05 * chance.standard_normal()


def judged(level):
    return Status.HEALTHY if level < 1.2 * HEALTHY else Status.RISING if level < 1.6 * HEALTHY else Status.FAULT


def made_drives(estimate=right, verdict=judged, effort=QUICK):
    """Digests of every drive that the study wants.

    Args:
        estimate: (level [N*m], name of the estimator, generator) -> settled estimate [N*m]
        verdict: level [N*m] -> status
        effort: of the study
    """
    wanted = {}
    for wants in WANTS:
        for case, names in wants(effort).items():
            wanted.setdefault(case, set()).update(names)
            if case.reference is not None:
                wanted.setdefault(case.reference, set())
    return Drives({case: made_digest(case, names, estimate, verdict) for case, names in wanted.items()})


def made_digest(case: Case, names, estimate, verdict) -> Digest:
    chance = np.random.default_rng(case.route)
    time = np.arange(0.0, 60.0 * case.minutes, 0.2)
    names = sorted({DEFAULT, *names})
    assert all(name in BASELINES or name in ESTIMATORS or name == DEFAULT for name in names)
    courses = {name: made_course(estimate(case.level, name, chance), time) for name in names if name not in BASELINES}
    spread = np.exp(0.2 * chance.standard_normal(200))
    variance = 100.0 * case.level**2 * spread
    windows = {name: Windows(variance, variance, 0.3, 0.2, variance) for name in names}
    status = verdict(case.level)
    worst = {Status.HEALTHY: 2.0, Status.RISING: 3.0}.get(status, 4.0)
    level = (courses[DEFAULT].friction[-1], 0.1)
    said = Verdict(status, worst, (0.98, 1.02), (3.0, math.inf), False, level)
    return Digest(60.0 * case.minutes, np.sin(time), courses, windows, said)


def made_course(settled, time):
    """From the paper's start at 3 N*m to the settled estimate, with a time constant of 10 s enabled."""
    enabled = ENABLED * time
    return Course(settled + (3.0 - settled) * np.exp(-enabled / 10.0), enabled, 0.3)


def claims_of(part, drives, effort=QUICK):
    return {item.id: item for item in part(drives, effort) if hasattr(item, "met")}
