"""The condition monitor over whole recordings: odd ones accuse no element, faulty ones are named, cuts do not show."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from driven import odd_drives
from said import said
from tierod.core.recording import Channel, Recording
from tierod.core.statuses import Status
from tierod.monitors.condition.definition import CONDITION
from tierod.monitors.condition.elements import SLID
from tierod.monitors.condition.signals import ACTUATORS, OF_AUTOMATED, TARGETS
from tierod.monitors.run import Run
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import OFFSET, Drive, Injected
from tierod_lab.papers.condition.recorded import recorded, without

CAR = load("smartload")
FEW = ("wheel_speed_rear_right", "yaw_rate")
SENSORS = [name if name in FEW else pytest.param(name, marks=pytest.mark.slow) for name in OF_AUTOMATED]
"""One of those that come in pairs and one that does not; every sensor has a filter of the same structure."""
JUDGED = (Status.HEALTHY, Status.FAULT, Status.SUSPECT)


def run(*pieces):
    """The diagnosis, and the course of every trouble code."""
    made = Run(CONDITION, CONDITION.variants["bank"], CAR)
    for piece in pieces:
        made.add(piece)
    return made.finish("test"), made.code_courses


def states(diagnosis):
    return {each.name: each.status for each in diagnosis.elements}


def at_fault(diagnosis):
    return [each.name for each in diagnosis.elements if each.status in (Status.FAULT, Status.SUSPECT)]


def changed(recording, names, change):
    """The recording with some channels made of time and values anew."""
    found = {name: recording[name] for name in names}
    new = {name: replace(each, values=change(each.time, each.values)) for name, each in found.items()}
    return Recording({**recording.channels, **new}, recording.metadata)


def result(diagnosis):
    """All that is said of sensors and actuators; times to a microsecond, since every piece has a grid of its own."""
    return [
        (each.name, each.status, each.cause, each.substitute, [_rounded(episode) for episode in each.episodes])
        for each in diagnosis.elements
    ]


def _rounded(episode):
    return (episode.kind, round(episode.start, 6), episode.end and round(episode.end, 6), episode.magnitude)


@pytest.fixture(scope="module")
def fault_free():
    return recorded(Drive("short-round", 40.0, 1, 71))


@pytest.fixture(scope="module")
def odd():
    return odd_drives()


@pytest.fixture(scope="module")
def faulty():
    """The yaw rate off by 0.5 rad/s from 15 s to 25 s."""
    injected = Injected("yaw_rate", OFFSET, 0.5, start=15.0, end=25.0)
    return recorded(Drive("long-round", 40.0, 1, 11, (injected,)))


def test_a_fault_free_drive_is_fault_free(fault_free):
    diagnosis, courses = run(fault_free)
    assert diagnosis.findings[0].status is Status.HEALTHY
    assert set(states(diagnosis).values()) == {Status.HEALTHY}
    assert "all 10 judged fault-free over 40 s" in said(diagnosis.findings[0])
    assert "this vehicle is not calibrated" in diagnosis.findings[0].warnings[0]
    assert all(courses[name.replace("_", "-")][-1].status is not Status.FAULT for name in (*OF_AUTOMATED, *ACTUATORS))
    assert not any(name.startswith("supplied_") for name in diagnosis.traces)


def test_a_fault_is_named_with_time_kind_size_substitute_and_code(faulty):
    diagnosis, courses = run(faulty)
    assert at_fault(diagnosis) == ["yaw_rate"]
    element = diagnosis.elements[OF_AUTOMATED.index("yaw_rate")]
    (episode,) = element.episodes
    assert episode.start == pytest.approx(15.0, abs=0.3)
    assert episode.end == pytest.approx(25.0, abs=1.0)
    assert episode.kind == "positive offset"
    assert episode.magnitude.value == pytest.approx(0.5, rel=0.1)
    assert element.substitute.startswith("filter of the others (±")
    assert element.trouble_code == "C1A32-64"
    assert "yaw rate sensor: positive offset" in said(diagnosis.findings[0])
    assert Status.FAULT in [change.status for change in courses["yaw-rate"]]
    assert {"supplied_yaw_rate", "deviation_of_supplied_yaw_rate"} <= set(diagnosis.traces)
    assert "supplied_tie_rod_force" not in diagnosis.traces


def test_what_is_supplied_is_near_the_truth_while_the_sensor_is_not(faulty):
    diagnosis, _ = run(faulty)
    result = diagnosis.traces["supplied_yaw_rate"]
    truth = np.interp(result.time, faulty["yaw_rate"].time, faulty["truth_yaw_rate"].values)
    inside = (result.time > 15.5) & (result.time < 24.5)
    said = diagnosis.traces["deviation_of_supplied_yaw_rate"].mean[inside]
    assert np.sqrt(np.mean((result.mean - truth)[inside] ** 2)) < 1.5 * np.median(said) < 0.05


@pytest.mark.parametrize("cuts", [pytest.param((7.31,), marks=pytest.mark.slow), (14.9, 15.2, 25.01, 33.0)])
def test_the_result_does_not_depend_on_the_cuts(faulty, cuts):
    gone = changed(faulty, OF_AUTOMATED, lambda time, values: np.where((time > 28.0) & (time < 31.5), np.nan, values))
    edges = [float("-inf"), *sorted((*cuts, 29.0, 30.5)), float("inf")]
    pieces = [gone.slice(start, stop) for start, stop in pairwise(edges)]
    (whole, courses), (parts, courses_of_parts) = run(gone), run(*pieces)
    assert result(parts) == result(whole)
    assert list(courses_of_parts) == list(courses)
    for code, course in courses.items():
        assert [change.status for change in courses_of_parts[code]] == [change.status for change in course]
        np.testing.assert_allclose(
            [change.time for change in courses_of_parts[code]], [change.time for change in course], rtol=1e-12
        )
    assert whole.findings[0].evidence == parts.findings[0].evidence
    assert whole.findings[0].evidence["interruptions"] == 1.0
    for name in ("state_of_yaw_rate", "supplied_yaw_rate"):
        np.testing.assert_array_equal(parts.traces[name].mean, whole.traces[name].mean)


@pytest.mark.parametrize("name", SENSORS)
def test_a_missing_sensor_is_not_available_and_no_fault_is_declared(fault_free, name):
    diagnosis, _ = run(without(fault_free, name))
    found = states(diagnosis)
    assert found.pop(name) is Status.NOT_AVAILABLE
    assert at_fault(diagnosis) == []
    assert Status.HEALTHY in found.values()
    assert f"no {name.replace('_', ' ')}" in diagnosis.elements[OF_AUTOMATED.index(name)].cause


@pytest.mark.parametrize("name", SENSORS)
def test_a_sensor_that_falls_silent_is_not_available_from_then_on(fault_free, name):
    diagnosis, courses = run(changed(fault_free, (name,), lambda time, values: np.where(time < 25.0, values, np.nan)))
    assert at_fault(diagnosis) == []
    element, finding = diagnosis.elements[OF_AUTOMATED.index(name)], diagnosis.findings[0]
    assert element.status is Status.NOT_AVAILABLE
    assert element.cause.startswith("no reading since 25.00 s")
    assert (finding.status, finding.since) == (Status.NOT_AVAILABLE, pytest.approx(25.0))
    assert courses[name.replace("_", "-")][-1].status is Status.NOT_AVAILABLE


@pytest.mark.parametrize("name", ["longitudinal_acceleration", "lateral_acceleration"])
def test_a_missing_acceleration_declares_no_fault(fault_free, name):
    assert at_fault(run(without(fault_free, name))[0]) == []


@pytest.mark.parametrize("place", range(len(TARGETS)))
def test_without_a_target_nothing_is_testable(fault_free, place):
    diagnosis, _ = run(without(fault_free, TARGETS[place]))
    found = states(diagnosis)
    assert found.pop(ACTUATORS[place]) is Status.NOT_AVAILABLE
    assert set(found.values()) == {Status.NOT_TESTABLE}
    finding = diagnosis.findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert TARGETS[place] in finding.cause


def test_a_recording_of_something_else_has_nothing_to_judge():
    time = np.arange(1000) / 100.0
    other = Recording({"ambient_temperature": Channel("ambient_temperature", time, 20.0 + 0.0 * time, "degC")})
    diagnosis, _ = run(other)
    assert set(states(diagnosis).values()) == {Status.NOT_AVAILABLE}
    assert diagnosis.findings[0].status is Status.NOT_AVAILABLE


@pytest.mark.parametrize(
    ("lost", "since", "reason"),
    [
        (lambda values, at: np.nan, 20.0, "no sensor gives a reading"),
        (lambda values, at: 0.0, 20.0, "all sensors read exactly zero"),
        (lambda values, at: values[at], 20.06, "all sensors repeat their previous readings"),
    ],
    ids=["nothing", "zero", "held"],
)
def test_all_sensors_lost_at_once_is_the_fault_of_none_of_them_and_not_fault_free(fault_free, lost, since, reason):
    def change(time, values):
        return np.where(time < 20.0, values, lost(values, np.searchsorted(time, 20.0)))

    diagnosis, courses = run(changed(fault_free, OF_AUTOMATED, change))
    assert at_fault(diagnosis) == []
    found, finding = states(diagnosis), diagnosis.findings[0]
    assert {found[name] for name in OF_AUTOMATED} == {Status.NOT_AVAILABLE}
    assert {found[name] for name in ACTUATORS} == {Status.NOT_TESTABLE}
    assert finding.status is Status.NOT_AVAILABLE
    assert finding.since == pytest.approx(since, abs=0.011)
    assert finding.cause.startswith(reason)
    assert f"19 s were not judged: {reason}" in finding.warnings
    assert courses["yaw-rate"][-1].status is Status.NOT_AVAILABLE


def test_targets_that_end_accuse_no_sensor(fault_free):
    diagnosis, _ = run(changed(fault_free, TARGETS, lambda time, values: np.where(time < 20.0, values, np.nan)))
    assert at_fault(diagnosis) == []
    found = states(diagnosis)
    assert {found[name] for name in ACTUATORS} == {Status.NOT_AVAILABLE}
    assert {found[name] for name in OF_AUTOMATED} == {Status.NOT_TESTABLE}
    assert diagnosis.findings[0].status is not Status.HEALTHY


@pytest.mark.parametrize("value", [np.nan, 0.0])
def test_after_all_sensors_were_gone_it_begins_anew(fault_free, value):
    lost = changed(
        fault_free, OF_AUTOMATED, lambda time, values: np.where((time > 20.0) & (time < 23.0), value, values)
    )
    diagnosis, courses = run(lost)
    assert at_fault(diagnosis) == []
    assert diagnosis.findings[0].evidence["interruptions"] == 1.0
    assert courses["yaw-rate"][-1].status in (Status.HEALTHY, Status.NOT_TESTABLE)
    gap = diagnosis.traces["state_of_yaw_rate"]
    assert np.isnan(gap.mean[(gap.time > 21.1) & (gap.time < 22.9)]).all()


def test_targets_that_come_too_seldom_declare_no_fault(fault_free):
    slow = {
        name: replace(fault_free[name], time=fault_free[name].time[::4], values=fault_free[name].values[::4])
        for name in TARGETS
    }
    diagnosis, courses = run(Recording({**fault_free.channels, **slow}, fault_free.metadata))
    assert set(states(diagnosis).values()) == {Status.NOT_TESTABLE}
    assert "are sampled at 25 Hz" in diagnosis.findings[0].cause
    assert courses == {}


def test_of_a_glimpse_it_says_that_it_is_too_short(fault_free):
    begin = fault_free.span[0] + 20.0
    diagnosis, _ = run(fault_free.slice(begin, begin + 0.3))
    assert set(states(diagnosis).values()) == {Status.NOT_TESTABLE}
    assert "the recording is too short, 0.3 s" in diagnosis.findings[0].cause


def test_at_standstill_nothing_is_testable(odd):
    diagnosis, _ = run(odd["standstill"])
    assert set(states(diagnosis).values()) == {Status.NOT_TESTABLE}
    assert "the vehicle stood" in diagnosis.findings[0].cause


@pytest.mark.parametrize(
    "name",
    [
        "three-point turns with reversing",
        "ice on a bend",
        "ice on one side",
        "restart in mid-drive",
        "gaps of 0.3 s in all signals",
        "gaps of 2 s in the steering's signals",
    ],
)
def test_odd_driving_and_logging_declare_no_fault(odd, name):
    assert at_fault(run(odd[name])[0]) == []


def test_while_tyres_slide_nothing_is_reported_and_the_drive_says_so(odd, fault_free):
    diagnosis, courses = run(odd["ice on a bend"])
    slid = [each for each in diagnosis.findings[0].warnings if SLID in each]
    assert len(slid) == 1
    assert 2.0 < float(slid[0].split()[0]) < 8.0, "the ice is 32 m long, and driven over at 9 m/s"
    assert diagnosis.findings[0].status is Status.HEALTHY
    assert Status.NOT_TESTABLE in [each.status for each in courses["wheel-speed-rear-left"]]
    assert not any(SLID in each for each in run(fault_free)[0].findings[0].warnings)


@pytest.mark.parametrize(
    ("name", "cause"),
    [
        ("wheels swapped", "rear wheel speeds are swapped"),
        ("steering bus 0.3 s late", "late relative to the other signals"),
        ("steering bus 0.3 s late from 30 s on", "late relative to the other signals since about 30 s"),
    ],
)
def test_wrong_wiring_makes_nothing_testable_and_fills_no_memory(odd, name, cause):
    diagnosis, courses = run(odd[name])
    assert set(states(diagnosis).values()) == {Status.NOT_TESTABLE}
    assert cause in diagnosis.findings[0].cause
    assert courses == {}
