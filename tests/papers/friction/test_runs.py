import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError, TierodError
from tierod.core.statuses import Status
from tierod.work.pool import Failure
from tierod_lab.ground import FrictionCourse
from tierod_lab.papers.friction.cases import Case
from tierod_lab.papers.friction.digest import digest, lag_between
from tierod_lab.papers.friction.estimators import BASELINE, DEFAULT, PRINTED
from tierod_lab.papers.friction.runs import run_drives
from tierod_lab.studies.effort import Effort


def silent(share, what):
    """Ignores the progress."""


@pytest.fixture(scope="module")
def driven():
    return digest(Case(5, 8.0, 4.0), (PRINTED, BASELINE))


def test_a_drive_is_judged_by_everyone_asked(driven):
    assert set(driven.courses) == {DEFAULT, PRINTED}
    assert set(driven.windows) == {BASELINE}
    assert driven.seconds == pytest.approx(240.0, abs=0.02)
    course = driven.courses[PRINTED]
    assert len(course.friction) == len(driven.angle) == 1200
    assert course.friction[0] == pytest.approx(3.0, abs=0.2)
    assert (np.diff(course.enabled_seconds) >= 0.0).all()
    assert 0.0 < course.aligning_error < 1.5


def test_the_default_estimator_finds_the_friction(driven):
    assert driven.mean(DEFAULT) == pytest.approx(8.0, abs=0.5)
    assert driven.verdict.status in (Status.RISING, Status.FAULT)


def test_windows_are_those_of_the_baseline(driven):
    windows = driven.windows[BASELINE]
    assert len(windows.variance) == len(windows.realigned) > 200
    assert len(windows.warped) == len(windows.variance)
    assert windows.variance.min() > 0.0
    assert np.median(windows.warped) < 0.9 * np.median(windows.variance)
    assert windows.enabled_share == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("lag", [-0.3, 0.0, 0.07, 0.5])
def test_the_lag_between_two_torques(lag):
    time = np.arange(3000) * 0.01
    early, late = (np.sin(1.3 * t) + np.sin(3.1 * t + 1.0) + 2.0 for t in (time, time - lag))
    assert lag_between(late, early) == pytest.approx(lag, abs=0.011)


def test_an_estimate_that_never_settles_has_no_mean():
    assert math.isnan(digest(Case(5, 8.0, 0.2), ()).mean(DEFAULT))


def test_the_same_case_gives_the_same_drive():
    case = Case(7, 5.5, 0.2, car=3, tyres="winter", law="LuGre", condition="rate noise 0.05 rad/s")
    first, second = (case.recording()["driver_torque"].values for _ in range(2))
    assert np.array_equal(first, second)


def test_a_car_keeps_its_sensors_on_another_route():
    gains = {Case(route, car=3).setup().sensors["driver_torque"].gain for route in (1, 2)}
    assert len(gains) == 1
    assert Case(1, car=4).setup().sensors["driver_torque"].gain not in gains
    assert Case(1).setup().sensors["driver_torque"].gain == 1.0


def test_below_the_bar_the_angle_lacks_the_twist():
    conditions = ("as usual", "angle measured below the torsion bar")
    above, below = (Case(7, 8.0, 0.5, condition=name).recording() for name in conditions)
    twist = above["steering_wheel_angle"].values - below["steering_wheel_angle"].values
    torque = np.interp(above["steering_wheel_angle"].time, above["driver_torque"].time, above["driver_torque"].values)
    assert np.corrcoef(twist, torque)[0, 1] > 0.9


@pytest.mark.parametrize("wrong", [{"tyres": "sumer"}, {"law": "Dahl"}, {"condition": "usual"}, {"scatter": "none"}])
def test_a_case_with_an_unknown_name_is_refused(wrong):
    with pytest.raises(ParameterError, match="does not know"):
        Case(1, **wrong)


def test_drives_run_once_in_worker_processes_references_first():
    reference = Case(11, 4.0, 0.2)
    judged = Case(12, 5.5, 0.2, reference=reference)
    reports = []
    drives = run_drives(
        [{judged: (PRINTED,)}, {judged: (BASELINE,)}],
        Effort(processes=1),
        lambda share, what: reports.append((share, what)),
    )
    assert set(drives.digests) == {reference, judged}
    assert set(drives.digests[judged].courses) == {DEFAULT, PRINTED}
    assert set(drives.digests[judged].windows) == {BASELINE}
    assert reports[-1] == (1.0, "2 drives, 0.0 h")
    assert drives.hours == pytest.approx(0.4 / 60.0, abs=1e-4)


def test_a_drive_that_fails_is_reported_and_stops_nothing(monkeypatch):
    def outcomes(effort, work, tasks):
        for number, task in enumerate(tasks):
            yield number, Failure("it left the road", True) if task.case.route == 2 else digest(task.case, ())

    monkeypatch.setattr(Effort, "outcomes", outcomes)
    good, bad = Case(1, 4.0, 0.1), Case(2, 4.0, 0.1)
    drives = run_drives([{good: (), bad: ()}], Effort(), silent)
    assert drives.failures == ((bad, "it left the road"),)
    assert len(drives.of([good, bad])) == 1
    with pytest.raises(TierodError, match="no drive .* it left the road"):
        run_drives([{bad: ()}], Effort(), silent)


def test_the_level_before_a_change():
    assert Case(1, FrictionCourse.step(4.0, 12.5, at=3.0)).level == 4.0
    assert Case(1, 5.5).level == 5.5
