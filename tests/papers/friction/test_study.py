"""Datasets of the study in a small size, against what must come out."""

import math

import numpy as np
import pytest

from tierod.core.statuses import Status
from tierod_lab.papers.friction import default_datasets, judging, paper_datasets
from tierod_lab.papers.friction.cases import HEALTHY, STATES, USUAL, Case
from tierod_lab.papers.friction.judging import Course, reached
from tierod_lab.papers.friction.paper_datasets import TABLE_1, WORST, Seen, brake_torque, distributions, set_drives
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Frame

QUICK = Effort(quick=True)


def seen(estimate, early=0.0):
    """The paper's drives, on which every method estimates what the test prescribes."""
    methods = (*judging.FILTERS, judging.DEFAULT)
    found = []
    for drive in set_drives(QUICK):
        values = estimate(STATES[drive.state]) + 0.05 * np.random.default_rng(drive.case.route).standard_normal(200)
        windows = dict.fromkeys(judging.BASELINES, values**2) if drive.part == "development" else {}
        shares = dict.fromkeys([*methods, *windows], 0.3)
        found.append(Seen(drive, {**dict.fromkeys(methods, values), **windows}, shares, {}, early > 0.0))
    return Frame.of("sets", distributions(found))


def test_a_right_filter_separates_and_one_that_sees_nothing_does_not():
    right, blind = seen(lambda level: level), seen(lambda level: 4.0)
    worst = {"method": judging.PRINTED, "state": WORST}
    for frame, accuracy in ((right, 1.0), (blind, 0.5)):
        (row,) = (frame.where(worst)[name] for name in ("accuracy",))
        assert row[0] == pytest.approx(accuracy, abs=0.1)
    assert right.where(worst)["error"][0] == pytest.approx(0.0, abs=0.01)
    assert blind.where(worst)["error"][0] == pytest.approx(-8.5, abs=0.01)
    assert right.where(worst)["tyres"][0] == 1.0
    assert (right.where({"method": judging.CORRECTED, "state": WORST})["overlap"] == 0.0).all()
    bars = right.where({"figure": "7", "group": "Healthy"})
    assert bars["share"].sum() == pytest.approx(1.0, abs=0.02)


def test_the_paper_s_minutes_are_driven():
    drives = set_drives(Effort())
    minutes = {
        (part, state): sum(each.case.minutes for each in drives if (each.part, each.state) == (part, state))
        for part in ("development", "test")
        for state in STATES
    }
    assert [minutes["development", state] for state in STATES] == [98.0, 7.0, 7.0, 7.0]
    assert [minutes["test", state] for state in STATES] == [78.0, 6.0, 6.0, 6.0]
    worst = {each.case.tyres for each in drives if each.state == WORST}
    assert worst == {each.case.tyres for each in drives if each.state == "Healthy"}


def test_convergence_is_read_off_the_course():
    enabled = np.arange(0.0, 100.0, 0.072)
    course = Course(12.5 - 9.5 * np.exp(-enabled / 10.0), enabled, math.nan)
    # 80 % of the way to the truth with a time constant of 10 s.
    assert reached(course, 12.5) == (pytest.approx(16.1, abs=0.1), pytest.approx(16.1 / 0.36, abs=0.3))
    assert reached(course, 20.0) == (math.inf, math.inf)


@pytest.fixture(scope="module")
def positions():
    (drives,) = (each for each in paper_datasets.position_drives(QUICK) if each.condition == USUAL)
    return Frame.of("positions", paper_datasets.over_positions(drives._replace(minutes=4.5)))


def test_below_the_bar_the_printed_filter_reads_higher_and_subtracting_the_twist_does_the_same(positions):
    printed = positions.where({"reading": judging.PRINTED, "start": 1.0})
    reads = {each: printed.where({"position": each})["reads"][0] for each in paper_datasets.POSITIONS}
    assert reads[paper_datasets.BELOW] > reads[paper_datasets.ABOVE] + 1.0
    assert reads[paper_datasets.TWIST] == pytest.approx(reads[paper_datasets.BELOW], abs=0.3)
    fast = positions.where({"reading": judging.PER_SAMPLE, "position": paper_datasets.BELOW})
    assert fast["enabled"][0] < 5.0
    assert fast["faulty"][0] > printed.where({"position": paper_datasets.BELOW})["healthy"][0]


def test_the_brake_goes_through_the_middles_of_table_1_and_turns_find_what_it_added():
    for pwm, (low, high) in TABLE_1.items():
        assert brake_torque(pwm) == pytest.approx(0.5 * (low + high), rel=0.01)
    assert max(row["miss"] for row in paper_datasets.turns(True)) < 0.1


def test_a_drive_is_judged_and_a_step_is_found():
    (row,) = default_datasets.over_steps((0, 12.5, 5.0))
    assert row["early"] == 0.0
    assert 0.0 < row["delay"] < 20.0


def test_what_the_drawn_gains_explain_is_the_floor():
    random = np.random.default_rng(3)
    made = []
    for car in range(12):
        gains = {f"{name}_gain": 1.0 + 0.1 * random.standard_normal() for name in ("driver_torque", "motor_torque")}
        error = HEALTHY * (0.3 * gains["driver_torque_gain"] + 0.7 * gains["motor_torque_gain"] - 1.0)
        row = {"car": car, "state": "Healthy", "level": HEALTHY, "error": error, **gains}
        made.append([row, {**row, "state": WORST, "error": math.nan}])
    frame = Frame.of("fleet", default_datasets.with_floor(made)).where({"state": "Healthy"})
    np.testing.assert_allclose(frame["floor"], frame["error"], atol=1e-9)


def test_a_car_keeps_its_sensors_on_another_route_and_a_case_its_drive():
    gains = {Case(route, car=3).setup().sensors["driver_torque"].gain for route in (1, 2)}
    assert len(gains) == 1
    assert Case(1, car=4).setup().sensors["driver_torque"].gain not in gains
    assert Case(1).setup().sensors["driver_torque"].gain == 1.0
    case = Case(7, 5.5, 0.2, car=3, tyres="winter", law="LuGre", condition="rate noise 0.05 rad/s")
    first, second = (case.recording()["driver_torque"].values for _ in range(2))
    assert np.array_equal(first, second)
    assert Status.RISING in judging.FOUND
