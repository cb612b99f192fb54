"""Signals that the filters take in and that are wrong: they are named, and no actuator is blamed for them."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from said import said
from tierod.cli import main
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.monitors.condition.definition import CONDITION
from tierod.monitors.condition.signals import ACCELERATIONS, ACTUATORS, OF_AUTOMATED, TARGETS
from tierod.monitors.diagnose import diagnose
from tierod.monitors.run import Run
from tierod.vehicles import load
from tierod_lab.ground.scenarios import load as load_scenario
from tierod_lab.papers.condition.drives import OFFSET, Drive, Injected, lost
from tierod_lab.papers.condition.recorded import recorded

ALONG, ACROSS = ACCELERATIONS
CAR = load("smartload")
SECONDS, SINCE = 60.0, 20.0


def diagnosed(*pieces):
    made = Run(CONDITION, CONDITION.variants["bank"], CAR)
    for piece in pieces:
        made.add(piece)
    return made.finish("test"), made.code_courses


def changed(recording, since=0.0, **new):
    """The recording with the values of some channels replaced from an instant on."""
    channels = {
        name: replace(recording[name], values=np.where(recording[name].time < since, recording[name].values, values))
        for name, values in new.items()
    }
    return Recording({**recording.channels, **channels}, recording.metadata)


def declared(diagnosis):
    return [each.name for each in diagnosis.elements if each.status in (Status.FAULT, Status.SUSPECT)]


def spiked(values):
    values = values.copy()
    values[np.random.default_rng(3).choice(len(values), 9, replace=False)] = 3 * [1e300, -1e12, np.inf]
    return values


@pytest.fixture(scope="module")
def drive():
    return recorded(Drive("short-round", SECONDS, 2, 7701))


@pytest.fixture(scope="module")
def off():
    """The yaw rate off by 5 degrees per second from 35 s to 50 s."""
    injected = Injected("yaw_rate", OFFSET, np.deg2rad(5.0), start=35.0, end=50.0)
    return recorded(Drive("short-round", SECONDS, 1, 7706, (injected,)))


CHANGES = {
    "across stuck": {ACROSS: lambda of: np.full_like(of(ACROSS), of(ACROSS)[2000])},
    "across off by its deviation": {ACROSS: lambda of: of(ACROSS) + np.std(of(ACROSS))},
    "across off": {ACROSS: lambda of: of(ACROSS) + 2.46},
    "across noisy": {ACROSS: lambda of: of(ACROSS) + np.random.default_rng(1).normal(0.0, 2.0, len(of(ACROSS)))},
    "along of the wrong sign": {ALONG: lambda of: -of(ALONG)},
    "along halved": {ALONG: lambda of: 0.5 * of(ALONG)},
    "along and target angle swapped": {
        ALONG: lambda of: of("target_steering_wheel_angle"),
        "target_steering_wheel_angle": lambda of: of(ALONG),
    },
    "both swapped": {ALONG: lambda of: of(ACROSS), ACROSS: lambda of: of(ALONG)},
}


LATER = ("across off", "along of the wrong sign", "both swapped")
"""Changes that are also made in the middle of the drive: one of each kind."""


@pytest.mark.parametrize(("change", "since"), [*((each, 0.0) for each in CHANGES), *((each, SINCE) for each in LATER)])
def test_a_wrong_acceleration_is_named_and_nothing_else(drive, change, since):
    new = {name: values(lambda each: drive[each].values) for name, values in CHANGES[change].items()}
    diagnosis, courses = diagnosed(changed(drive, since, **new))
    finding, wrong = diagnosis.findings[0], [name for name in ACCELERATIONS if name in CHANGES[change]]
    assert finding.status is Status.FAULT
    assert declared(diagnosis) == wrong
    for name in wrong:
        plain = name.replace("_", " ")
        assert f"{plain} sensor: " in said(finding).lower()
        assert f"{plain} contradicts" in finding.cause
        element = next(each for each in diagnosis.elements if each.name == name)
        assert (element.substitute, element.episodes[0].end) == ("", None)
        assert since - 0.5 <= element.episodes[0].start <= since + 20.0
    assert all(change.status not in (Status.FAULT, Status.SUSPECT) for course in courses.values() for change in course)
    assert finding.evidence["sensors_and_actuators_judged"] == len((*OF_AUTOMATED, *ACTUATORS))


def test_the_rest_of_the_drive_is_judged_without_it(off):
    diagnosis, _ = diagnosed(changed(off, **{ACROSS: off[ACROSS].values + 2.46}))
    assert declared(diagnosis) == ["yaw_rate", ACROSS]
    yaw = next(each for each in diagnosis.elements if each.name == "yaw_rate")
    assert yaw.episodes[0].start == pytest.approx(35.0, abs=0.5)
    assert "yaw rate sensor: positive offset" in said(diagnosis.findings[0])
    assert diagnosis.findings[0].since < 10.0


def test_a_fault_of_an_actuator_stands_after_an_acceleration_has_failed():
    recording = recorded(Drive("short-round", SECONDS, 3, 7707, (lost("drive_left", 1.0, 40.0, 60.0),)))
    diagnosis, _ = diagnosed(changed(recording, SINCE, **{ALONG: -recording[ALONG].values}))
    assert declared(diagnosis) == ["drive_left", ALONG]


@pytest.mark.parametrize("cuts", [pytest.param((23.17,), marks=pytest.mark.slow), (0.3, 20.0, 21.5, 44.4)])
def test_the_result_does_not_depend_on_the_cuts(off, cuts):
    wrong = changed(off, SINCE, **{ACROSS: off[ACROSS].values + 2.46})
    pieces = [wrong.slice(*edges) for edges in pairwise((-np.inf, *cuts, np.inf))]
    (whole, courses), (parts, of_parts) = diagnosed(wrong), diagnosed(*pieces)
    assert parts.findings[0].headline == whole.findings[0].headline
    assert [(each.name, each.status, each.cause) for each in parts.elements] == [
        (each.name, each.status, each.cause) for each in whole.elements
    ]
    assert {name: [each.status for each in course] for name, course in of_parts.items()} == {
        name: [each.status for each in course] for name, course in courses.items()
    }


@pytest.mark.parametrize("name", [ACROSS, ALONG, "yaw_rate", TARGETS[0]])
def test_an_impossible_value_is_removed_before_it_decides_and_is_named(drive, name):
    diagnosis, _ = diagnosed(changed(drive, **{name: spiked(drive[name].values)}))
    finding = diagnosis.findings[0]
    assert declared(diagnosis) == []
    assert finding.status is Status.HEALTHY
    assert any(f"9 impossible values of {name.replace('_', ' ')}" in each for each in finding.warnings)


@pytest.mark.parametrize(
    ("target", "factor"),
    [
        *((target, factor) for target in TARGETS[::2] for factor in (-1.0, 0.0, 2.0)),
        *(
            pytest.param(target, factor, marks=pytest.mark.slow)
            for target in TARGETS[1::2]
            for factor in (-1.0, 0.0, 2.0)
        ),
    ],
)
def test_a_wrong_target_is_named_as_a_cause(drive, target, factor):
    diagnosis, _ = diagnosed(changed(drive, SINCE, **{target: factor * drive[target].values}))
    finding = diagnosis.findings[0]
    assert finding.status in (Status.FAULT, Status.SUSPECT, Status.NOT_TESTABLE)
    assert target.replace("_", " ") in finding.cause


def test_a_drive_that_was_hardly_judged_is_not_healthy(drive):
    target = "target_drive_torque_left"
    diagnosis, _ = diagnosed(changed(drive, SINCE, **{target: 0.0 * drive[target].values}))
    finding = diagnosis.findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert "too little of the drive was judged" in finding.headline
    assert "s of driving were not judged: the tyres slid" in finding.cause
    assert finding.action.startswith("drive on a dry road")


@pytest.mark.parametrize(
    "heads", [("time", "lateral_acceleration"), ("time", "vehicle_speed", "longitudinal_acceleration")]
)
def test_accelerations_alone_are_too_few_sensors_and_no_crash(heads, tmp_path, capsys):
    rows = [
        ",".join(f"{value:.3f}" for value in (0.01 * k, *(12.0 + math.sin(0.01 * k),) * (len(heads) - 1)))
        for k in range(1001)
    ]
    (tmp_path / "few.csv").write_text("\n".join((",".join(heads), *rows)) + "\n")
    assert main(["new", str(tmp_path / "own.toml"), "--class", "midsize", "mass=1500"]) == 0
    assert main(["inspect", str(tmp_path / "few.csv")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "condition: cannot run - fewer than 4 sensors give a reading" in said
    assert main(["diagnose", str(tmp_path / "few.csv"), "--vehicle", str(tmp_path / "own.toml"), "--no-report"]) == 3
    assert "fewer than 4 sensors give a reading; the recording has no wheel speed" in capsys.readouterr().err


def test_a_longitudinal_acceleration_that_is_late_is_named_and_no_drive_is_blamed():
    sound = replace(load_scenario("demonstrator-healthy"), faults=()).with_run(100.0, 142).run().recording
    along = sound[ALONG]
    late = changed(sound, **{ALONG: np.interp(along.time - 0.1, along.time, along.values)})
    found = diagnose(late, CAR, "condition", spread=False)
    assert declared(found) == []
    assert found.findings[0].status is Status.NOT_TESTABLE
    assert "longitudinal acceleration: 0.1" in found.findings[0].cause
    assert "late relative to the wheel speeds" in found.findings[0].cause
