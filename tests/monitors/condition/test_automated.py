"""The automated vehicle over whole recordings: odd ones accuse no element, faulty ones are named, cuts do not show."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from driven import odd_drives
from said import said
from tierod.core.recording import Channel, Recording
from tierod.core.statuses import Status
from tierod.monitors.condition.definition import CONDITION
from tierod.monitors.condition.signals import ACCELERATIONS, ACTUATORS, MOTORS, OF_AUTOMATED, TARGETS
from tierod.monitors.run import Run
from tierod.vehicles import load
from tierod_lab.ground.scenarios import load as load_scenario
from tierod_lab.papers.condition.drives import OFFSET, Drive, Injected, lost
from tierod_lab.papers.condition.recorded import recorded, without

CAR = load("smartload")
ALONG, ACROSS = ACCELERATIONS
SINCE = 20.0


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


def changed(recording, since=SINCE, **new):
    """The recording with the values of some channels replaced from an instant on."""
    channels = {
        name: replace(recording[name], values=np.where(recording[name].time < since, recording[name].values, values))
        for name, values in new.items()
    }
    return Recording({**recording.channels, **channels}, recording.metadata)


@pytest.fixture(scope="module")
def fault_free():
    return recorded(Drive("short-round", 40.0, 1, 71))


@pytest.fixture(scope="module")
def odd():
    return odd_drives()


@pytest.fixture(scope="module")
def faulty():
    """The yaw rate off by 0.5 rad/s from 15 s to 25 s."""
    return recorded(Drive("long-round", 40.0, 1, 11, (Injected("yaw_rate", OFFSET, 0.5, start=15.0, end=25.0),)))


@pytest.fixture(scope="module")
def drive():
    return recorded(Drive("short-round", 60.0, 2, 7701))


def test_a_fault_free_drive_is_fault_free(fault_free):
    diagnosis, courses = run(fault_free)
    finding = diagnosis.findings[0]
    assert set(states(diagnosis).values()) == {finding.status} == {Status.HEALTHY}
    assert finding.headline == "Sensors and actuators: healthy, all 10 judged fault-free over 40 s"
    assert "this vehicle is not calibrated" in finding.warnings[0]
    assert all(courses[name.replace("_", "-")][-1].status is not Status.FAULT for name in (*OF_AUTOMATED, *ACTUATORS))
    assert not any(name.startswith("supplied_") for name in diagnosis.traces)


def test_a_fault_is_named_with_time_kind_size_substitute_and_code_and_its_signal_is_supplied(faulty):
    diagnosis, courses = run(faulty)
    assert at_fault(diagnosis) == ["yaw_rate"]
    element, finding = diagnosis.elements[OF_AUTOMATED.index("yaw_rate")], diagnosis.findings[0]
    (episode,) = element.episodes
    assert (episode.start, episode.end) == (pytest.approx(15.0, abs=0.05), pytest.approx(25.0, abs=0.1))
    assert (episode.kind, episode.magnitude.value) == ("positive offset", pytest.approx(0.5, rel=0.1))
    assert element.substitute.startswith("filter of the others (±")
    assert element.trouble_code == "C1A32-64"
    assert "yaw rate sensor: positive offset of 30.2 °/s from 15.00 s to 25.00 s" in said(finding)
    assert "residuals of readings and torques exceed" in finding.cause
    assert Status.FAULT in [change.status for change in courses["yaw-rate"]]
    assert "supplied_tie_rod_force" not in diagnosis.traces
    supplied, spread = (diagnosis.traces[f"{what}supplied_yaw_rate"] for what in ("", "deviation_of_"))
    inside = (supplied.time > 15.5) & (supplied.time < 24.5)
    truth = np.interp(supplied.time, faulty["yaw_rate"].time, faulty["truth_yaw_rate"].values)
    assert np.sqrt(np.mean((supplied.mean - truth)[inside] ** 2)) < 1.5 * np.median(spread.mean[inside]) < 0.05


def test_the_result_does_not_depend_on_the_cuts(faulty):
    """A fault, a gap in all sensors, and an acceleration that fails."""
    values = {name: faulty[name].values.copy() for name in OF_AUTOMATED}
    for name, each in values.items():
        each[(faulty[name].time > 28.0) & (faulty[name].time < 31.5)] = np.nan
    gone = changed(faulty, -1.0, **values)
    gone = changed(gone, 33.0, **{ACROSS: gone[ACROSS].values + 2.46})
    pieces = [gone.slice(*edges) for edges in pairwise((-np.inf, 14.9, 15.2, 25.01, 29.0, 30.5, 33.0, 34.2, np.inf))]
    (whole, courses), (parts, courses_of_parts) = run(gone), run(*pieces)
    assert at_fault(whole) == ["yaw_rate", ACROSS]
    assert _result(parts) == _result(whole)
    assert list(courses_of_parts) == list(courses)
    for code, course in courses.items():
        found = courses_of_parts[code]
        assert [change.status for change in found] == [change.status for change in course]
        np.testing.assert_allclose([each.time for each in found], [each.time for each in course], rtol=1e-12)
    assert whole.findings[0].evidence == parts.findings[0].evidence
    assert whole.findings[0].evidence["interruptions"] == 1.0
    for name in ("state_of_yaw_rate", "supplied_yaw_rate"):
        np.testing.assert_array_equal(parts.traces[name].mean, whole.traces[name].mean)


def _result(diagnosis):
    """All that is said of sensors and actuators; times to a microsecond, since every piece has a grid of its own."""
    return [
        (
            *(each.name, each.status, each.cause, each.substitute),
            [(one.kind, round(one.start, 6), one.end and round(one.end, 6), one.magnitude) for one in each.episodes],
        )
        for each in diagnosis.elements
    ]


@pytest.mark.parametrize("name", ["wheel_speed_rear_right", "yaw_rate"])
def test_a_missing_sensor_and_one_that_falls_silent_are_not_available_and_no_fault_is_declared(fault_free, name):
    diagnosis, _ = run(without(fault_free, name))
    assert states(diagnosis)[name] is Status.NOT_AVAILABLE
    assert at_fault(diagnosis) == []
    assert f"not judged: {name.replace('_', ' ')} (not in the recording)" in diagnosis.findings[0].details
    diagnosis, courses = run(changed(fault_free, 25.0, **{name: np.nan}))
    element, finding = diagnosis.elements[OF_AUTOMATED.index(name)], diagnosis.findings[0]
    assert at_fault(diagnosis) == []
    assert element.cause.startswith("no reading since 25.00 s; ")
    assert (element.status, finding.status, finding.since) == (*[Status.NOT_AVAILABLE] * 2, pytest.approx(25.0))
    assert courses[name.replace("_", "-")][-1].status is Status.NOT_AVAILABLE


def test_without_a_target_nothing_is_testable_and_targets_that_end_or_come_seldom_accuse_no_sensor(fault_free):
    diagnosis, _ = run(without(fault_free, TARGETS[0]))
    found = states(diagnosis)
    assert found.pop(ACTUATORS[0]) is Status.NOT_AVAILABLE
    assert {*found.values(), diagnosis.findings[0].status} == {Status.NOT_TESTABLE}
    assert TARGETS[0] in diagnosis.findings[0].cause
    diagnosis, _ = run(changed(fault_free, **dict.fromkeys(TARGETS, np.nan)))
    assert {states(diagnosis)[name] for name in ACTUATORS} == {Status.NOT_AVAILABLE}
    assert {states(diagnosis)[name] for name in OF_AUTOMATED} == {Status.NOT_TESTABLE}
    slow = {name: replace(fault_free[name], time=fault_free[name].time[::4], values=fault_free[name].values[::4])
            for name in TARGETS}  # fmt: skip
    diagnosis, courses = run(Recording({**fault_free.channels, **slow}, fault_free.metadata))
    assert {*states(diagnosis).values()} == {Status.NOT_TESTABLE}
    assert "the targets of the actuators are sampled at 25 Hz" in diagnosis.findings[0].cause
    assert courses == {}


@pytest.mark.parametrize(
    ("value", "since", "reason"),
    [
        (lambda values, at: np.nan, 20.0, "no sensor gives a reading"),
        (lambda values, at: 0.0, 20.0, "all sensors read exactly zero"),
        (lambda values, at: values[at], 20.06, "all sensors repeat their previous readings"),
    ],
    ids=["nothing", "zero", "held"],
)
def test_all_sensors_lost_at_once_is_the_fault_of_none_of_them_and_not_fault_free(fault_free, value, since, reason):
    at = np.searchsorted(fault_free["yaw_rate"].time, SINCE)
    diagnosis, courses = run(changed(fault_free, **{name: value(fault_free[name].values, at) for name in OF_AUTOMATED}))
    assert at_fault(diagnosis) == []
    found, finding = states(diagnosis), diagnosis.findings[0]
    assert {found[name] for name in OF_AUTOMATED} == {finding.status} == {Status.NOT_AVAILABLE}
    assert {found[name] for name in ACTUATORS} == {Status.NOT_TESTABLE}
    assert finding.since == pytest.approx(since, abs=0.011)
    assert finding.cause.startswith(reason)
    assert finding.details == ("nothing is judged from then on",)
    assert f"19 s were not judged: {reason}" in finding.warnings
    assert courses["yaw-rate"][-1].status is Status.NOT_AVAILABLE


def test_something_else_a_glimpse_and_a_standstill_are_not_judged(fault_free, odd):
    time = np.arange(1000) / 100.0
    other = Recording({"ambient_temperature": Channel("ambient_temperature", time, 20.0 + 0.0 * time, "degC")})
    assert {run(other)[0].findings[0].status, *states(run(other)[0]).values()} == {Status.NOT_AVAILABLE}
    begin = fault_free.span[0] + 20.0
    for recording, cause in (
        (fault_free.slice(begin, begin + 0.3), "the recording is too short, 0.3 s"),
        (odd["standstill"], "the vehicle stood"),
    ):
        diagnosis, _ = run(recording)
        assert set(states(diagnosis).values()) == {Status.NOT_TESTABLE}
        assert cause in diagnosis.findings[0].cause


@pytest.mark.parametrize(
    "name",
    [
        "three-point turns with reversing",
        "ice on one side",
        "restart in mid-drive",
        "gaps of 0.3 s in all signals",
        "gaps of 2 s in the steering's signals",
    ],
)
def test_odd_driving_and_logging_declare_no_fault(odd, name):
    assert at_fault(run(odd[name])[0]) == []


def test_while_tyres_slide_nothing_is_declared_and_the_drive_says_so(odd):
    diagnosis, courses = run(odd["ice on a bend"])
    (slid,) = [each for each in diagnosis.findings[0].warnings if "the tyres slid" in each]
    assert 2.0 < float(slid.split()[0]) < 8.0, "the ice is 32 m long, and driven over at 9 m/s"
    assert diagnosis.findings[0].status is Status.HEALTHY
    assert Status.NOT_TESTABLE in [each.status for each in courses["wheel-speed-rear-left"]]


@pytest.mark.parametrize(
    ("name", "cause"),
    [
        ("wheels swapped", "rear wheel speeds are swapped"),
        ("steering bus 0.3 s late from 30 s on", "late relative to the other signals since about 30 s"),
    ],
)
def test_wrong_wiring_makes_nothing_testable_and_fills_no_memory(odd, name, cause):
    diagnosis, courses = run(odd[name])
    assert set(states(diagnosis).values()) == {Status.NOT_TESTABLE}
    assert cause in diagnosis.findings[0].cause
    assert courses == {}


def test_where_both_motors_lost_torque_what_feeds_both_is_looked_at_first():
    made = recorded(Drive("long-round", 40.0, 1, 11, tuple(lost(name, 1.0, 15.0, 40.0) for name in MOTORS)))
    finding = run(made)[0].findings[0]
    assert finding.action.startswith("check steering motor 1 and steering motor 2: the supply and the enabling of both")
    assert "the recorded targets (steering motor 1 target torque and steering motor 2 target torque)" in finding.cause


CHANGES = {
    "across stuck": {ACROSS: lambda of: np.full_like(of(ACROSS), of(ACROSS)[2000])},
    "across off by its deviation": {ACROSS: lambda of: of(ACROSS) + np.std(of(ACROSS))},
    "across off": {ACROSS: lambda of: of(ACROSS) + 2.46},
    "across late": {ACROSS: lambda of: np.roll(of(ACROSS), 50)},
    "across noisy": {ACROSS: lambda of: of(ACROSS) + np.random.default_rng(1).normal(0.0, 2.0, len(of(ACROSS)))},
    "along of the wrong sign": {ALONG: lambda of: -of(ALONG)},
    "along halved": {ALONG: lambda of: 0.5 * of(ALONG)},
    "along clipped": {ALONG: lambda of: np.clip(of(ALONG), -1.0, 1.0)},
    "both swapped": {ALONG: lambda of: of(ACROSS), ACROSS: lambda of: of(ALONG)},
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_wrong_acceleration_is_named_and_no_element_is_accused_for_it(drive, change):
    new = {name: made(lambda each: drive[each].values) for name, made in CHANGES[change].items()}
    diagnosis, courses = run(changed(drive, **new))
    finding, wrong = diagnosis.findings[0], [name for name in ACCELERATIONS if name in new]
    assert (finding.status, at_fault(diagnosis)) == (Status.FAULT, wrong)
    for name in wrong:
        plain = name.replace("_", " ")
        assert f"{plain} sensor: " in said(finding).lower()
        assert f"{plain} {'stays the same and ' if 'stuck' in change else ''}contradicts" in finding.cause
        element = next(each for each in diagnosis.elements if each.name == name)
        assert (element.substitute, element.episodes[0].end) == ("", None)
        assert SINCE - 0.5 <= element.episodes[0].start <= SINCE + 15.0
        assert ("stuck" in element.episodes[0].kind) == ("stuck" in change)
    assert all(change.status not in (Status.FAULT, Status.SUSPECT) for course in courses.values() for change in course)
    assert finding.evidence["sensors_and_actuators_judged"] == len((*OF_AUTOMATED, *ACTUATORS))


@pytest.mark.parametrize("name", [ACROSS, "yaw_rate", TARGETS[0]])
def test_an_impossible_value_is_removed_before_it_decides_and_is_named(drive, name):
    values = drive[name].values.copy()
    values[np.random.default_rng(3).choice(len(values), 9, replace=False)] = 3 * [1e300, -1e12, np.inf]
    diagnosis, _ = run(changed(drive, 0.0, **{name: values}))
    assert diagnosis.findings[0].status is Status.HEALTHY
    assert any(f"9 impossible values of {name.replace('_', ' ')}" in each for each in diagnosis.findings[0].warnings)


@pytest.mark.parametrize(("target", "factor"), [(TARGETS[0], -1.0), (TARGETS[0], 2.0), (TARGETS[2], 2.0)])
def test_a_wrong_target_is_named_as_a_cause(drive, target, factor):
    finding = run(changed(drive, **{target: factor * drive[target].values}))[0].findings[0]
    assert finding.status in (Status.FAULT, Status.SUSPECT, Status.NOT_TESTABLE)
    assert target.replace("_", " ") in finding.cause


def test_a_drive_that_was_hardly_judged_is_not_healthy(drive):
    finding = run(changed(drive, **{TARGETS[2]: 0.0}))[0].findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert "too little of the drive was judged" in finding.headline
    assert "s of driving were not judged: the tyres slid" in finding.cause
    assert finding.action.startswith("drive on a dry road, below 6 m/s² lateral acceleration")


def test_a_longitudinal_acceleration_that_is_late_is_named_and_no_drive_is_blamed():
    sound = replace(load_scenario("demonstrator-healthy"), faults=()).with_run(100.0, 142).run().recording
    late = np.interp(sound[ALONG].time - 0.1, sound[ALONG].time, sound[ALONG].values)
    diagnosis, _ = run(changed(sound, 0.0, **{ALONG: late}))
    assert (at_fault(diagnosis), diagnosis.findings[0].status) == ([], Status.NOT_TESTABLE)
    assert "longitudinal acceleration: 0.1" in diagnosis.findings[0].cause
    assert "late relative to the wheel speeds" in diagnosis.findings[0].cause
