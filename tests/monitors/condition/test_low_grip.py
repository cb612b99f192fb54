"""Tyres that slide: when they are said to, on made-up likelihoods, and on drives of a car that is not the model."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from monitors.condition.nominal_filter import nominal_filter
from tierod.core.graph import scan
from tierod.monitors.condition.limits import aligned
from tierod.monitors.condition.low_grip import Lack, LowGrip, sliding
from tierod.monitors.condition.signals import DRIVES, Hypothesis
from tierod.vehicles import load
from tierod_lab.ground.courses import load as course
from tierod_lab.ground.courses.course import Adhesion, Along
from tierod_lab.ground.courses.roads import Halt
from tierod_lab.ground.run import run
from tierod_lab.papers.condition.drives import Drive, lost, vehicle
from tierod_lab.papers.condition.recorded import as_recorded, recorded

OTHERS = (0.0, -5.0, -8.0)
NONE = Lack(0.0, 0.0, 0.0)
MASS, RADIUS = (load("smartload").parameters[name].value for name in ("mass", "wheel_radius"))
"""Of the demonstrator [kg], [m]."""
BEND, BRAKES = Lack(0.4, 0.0, 0.0), Lack(0.0, 0.2, 0.2)


def steps(count, likelihood, lack, state=None, others=OTHERS, drives=OTHERS[1:], moving=1.0):
    rule, found = LowGrip(), []
    state = rule.init() if state is None else state
    for _ in range(count):
        state, slides = rule.after(state, likelihood, others, drives, lack, moving, 0.01)
        found.append(bool(slides))
    return state, found


@pytest.mark.parametrize(
    ("likelihood", "lack", "slides"), [(8.0, BEND, True), (8.0, Lack(0.05, 0.0, 0.0), False), (1.0, BEND, False)]
)
def test_tyres_slide_where_forces_are_lacking_and_that_explains_most(likelihood, lack, slides):
    assert steps(30, likelihood, lack)[1][-1] is slides


def test_it_takes_the_mean_of_some_samples_and_stays_for_a_while():
    """The mean of a ratio of 8 is beyond 3 after log(8 / 5) of its time constant, which is 2.3 samples."""
    state, found = steps(10, 8.0, BEND)
    assert found.index(True) == 2
    _, after = steps(100, -5.0, NONE, state)
    assert sum(after) == pytest.approx(50, abs=5)
    assert not after[-1]


def test_they_slide_for_as_long_as_force_is_lacking_and_until_the_filters_have_found_back():
    state, _ = steps(10, 8.0, BEND)
    state, on = steps(300, -5.0, BRAKES, state)
    assert all(on)
    _, lost_ones = steps(300, -5.0, NONE, state, others=(-40.0, 0.0, 0.0))
    assert sum(lost_ones) == pytest.approx(50 / LowGrip().slower, abs=5)
    assert all(steps(300, -5.0, NONE, state, moving=0.0)[1])


def test_a_sample_all_but_impossible_counts_no_more_than_its_limit():
    state, _ = steps(1, 1e6, BEND)
    assert state.lead == pytest.approx(20.0 * (1.0 - np.exp(-0.2)))


@pytest.mark.parametrize(
    ("drives", "lack", "slides"),
    [
        ((9.9, 9.9), BRAKES, True),
        ((12.0, 9.9), BRAKES, False),
        ((12.0, 12.0), BRAKES, False),
        ((9.9, 9.9), Lack(0.0, 0.03, 0.2), False),
        ((9.9, 9.9), Lack(0.0, 0.2, 0.01), False),
    ],
    ids=["both sides alike", "left drive", "both better", "hardly any lack", "no force at all"],
)
def test_force_that_lacks_along_is_that_of_sliding_tyres_where_no_drive_explains_it_better(drives, lack, slides):
    """Fault-free is 10 nat less likely; a lost drive turns the vehicle, which sliding tyres do not explain."""
    assert any(steps(60, 9.5, lack, others=(0.0, *drives), drives=drives)[1]) is slides


def test_a_filter_that_takes_a_moment_to_see_a_lost_drive_makes_no_tyres_slide():
    state, _ = steps(200, 8.8, NONE, others=(10.0, 9.8, 9.8), drives=(9.8, 9.8))
    state, at_once = steps(3, 8.0, BRAKES, state, others=(-30.0, 0.0, -5.0), drives=(0.0, -5.0))
    _, then = steps(40, 8.0, BRAKES, state, others=(-60.0, 10.0, 2.0), drives=(10.0, 2.0))
    assert not any(at_once + then)


@pytest.mark.parametrize(("given", "slides"), [(0.5, False), (1.0, True)], ids=["half of it", "all of it"])
def test_drives_that_give_too_little_of_less_than_ice_held_have_lost_torque(given, slides):
    """Ice that held a force of 0.2 gives all of 0.14 that is asked for; what is lacking of that is no fault of it."""
    likely = {"others": (0.0, 9.9, 9.9), "drives": (9.9, 9.9)}
    state, found = steps(60, 9.5, BRAKES, **likely)
    assert found[-1]
    state, _ = steps(20, 9.5, Lack(0.0, 0.14 * (1.0 - given), 0.14 * given), state, **likely)
    state, _ = steps(60, 9.5, BRAKES, state, **likely)
    assert bool(state.left > 0.5) is slides


@lru_cache(maxsize=1)
def filters():
    """The fault-free filter, those of single drives, and that of sliding tyres."""
    base = nominal_filter()
    return [base, *(base.leaving_out(Hypothesis(name, (), (name,))) for name in DRIVES), sliding(base)]


def slides_in(recording):
    samples = aligned(recording)
    results = [scan(each, samples) for each in filters()]
    values = [result["log_likelihood"] for result in results]
    last, rule, found = results[-1], LowGrip(), []
    state = rule.init()
    for k in range(len(values[0])):
        others = [each[k] for each in values[:-1]]
        lack = Lack(*(last[name][k] for name in ("lack", "lack_along", "given_along")))
        state, slides = rule.after(state, values[-1][k], others, others[1:], lack, last["moving"][k], 0.01)
        found.append(bool(slides))
    return np.array(found)


def on_ice(adhesion, seconds=14.0):
    """Brakes for a halt after 60 m of the long round, the last 30 m of ice."""
    car, sensors = vehicle(0)
    ice = Adhesion(window=Along(30.0, 76.0, 1.0), left=adhesion, right=adhesion)
    way = replace(course("long-round"), time=seconds, speed=9.0, halts=(Halt(60.0, 2.0),), conditions=(ice,))
    return as_recorded(run(car, way, seconds, 5, sensors).recording)


@pytest.mark.parametrize("adhesion", [0.2, 0.35])
def test_tyres_slide_soon_after_the_car_brakes_harder_than_ice_holds_and_as_long_as_it_does(adhesion):
    drive = on_ice(adhesion)
    asked = -(drive["truth_drive_torque_left"].values + drive["truth_drive_torque_right"].values) / RADIUS
    lacks = asked - MASS * -drive["truth_longitudinal_acceleration"].values > 250.0
    found, moving = slides_in(drive), drive["truth_speed"].values > 1.0
    assert 0 < np.argmax(found) - np.argmax(lacks & moving) < 12
    assert found[lacks & moving].mean() > 0.95
    assert not found[: np.argmax(lacks & moving)].any()


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_no_tyres_slide_where_a_drive_has_lost_torque(share):
    drive = recorded(Drive("long-round", 46.0, 0, 300, (lost("drive_left", share, 41.0, 46.0),)))
    assert np.max(np.abs(drive["target_drive_torque_left"].values[4100:])) > 100.0
    assert not slides_in(drive).any()
