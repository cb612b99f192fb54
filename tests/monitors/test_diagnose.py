"""Monitors over recordings of any length, and what stops them."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from driven import drive
from exact_vehicle import diagnose
from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.core.statuses import Status
from tierod.monitors.run import Run
from tierod.monitors.runner import find
from tierod.report.diagnosis import render
from tierod.vehicles import load
from tierod_lab.ground import FrictionCourse


@pytest.fixture(scope="module")
def healthy():
    return drive(minutes=8.0, seed=3)


@pytest.fixture(scope="module")
def rising():
    return drive(minutes=13.0, friction=FrictionCourse.step(4.0, 8.0, at=390.0), seed=1)


def changed(recording: Recording, name: str, **fields) -> Recording:
    return recording.with_channels([dataclasses.replace(recording[name], **fields)])


def test_friction_that_rises_half_way_is_a_fault_since_then(rising):
    finding = diagnose(rising, "midsize-eps").findings[0]
    assert finding.status is Status.FAULT
    assert finding.status.exit_code == 1
    assert finding.since == pytest.approx(390.0, abs=30.0)
    assert finding.estimate.value == pytest.approx(8.0, abs=0.4)


def test_a_value_that_is_withheld_is_shown_nowhere(healthy):
    diagnosis = diagnose(healthy.slice(0.0, 60.0), "midsize-eps")
    assert diagnosis.findings[0].estimate is None
    assert not {"friction_torque", "friction_torque_standard_deviation", "ratio_to_baseline"} & set(diagnosis.traces)
    assert {"enabled", "nis", "driver_torque"} <= set(diagnosis.traces)
    assert diagnosis.histograms == diagnosis.loops == {}
    assert "withheld" in diagnosis.remarks["estimate"]
    assert "withheld" in render(diagnosis)
    assert "Friction torque over time" not in render(diagnosis)


def later(recording: Recording, at: float, pause: float) -> Recording:
    shifted = (
        dataclasses.replace(channel, time=np.where(channel.time < at, channel.time, channel.time + pause))
        for channel in recording.channels.values()
    )
    return Recording({channel.name: channel for channel in shifted})


def test_an_hour_between_two_drives_is_judged_for_ten_minutes_and_skipped(healthy):
    lengths = []
    run = Run(*find("friction"), load("midsize-eps"), kept=lambda time, shown: lengths.append(len(time)))
    run.add(later(healthy, 240.0, 3600.0))
    found, undisturbed = run.finish().findings[0], diagnose(healthy, "midsize-eps").findings[0]
    assert sum(lengths) == pytest.approx((480.0 + 600.0) * 100.0, abs=2)
    assert max(lengths) <= 600.0 * 100.0
    assert found.status is undisturbed.status
    assert found.estimate.value == pytest.approx(undisturbed.estimate.value, abs=0.1)


def test_cuts_between_the_steps_of_the_grid_change_nothing(healthy):
    """Channels of clocks of their own, cut where no step of the grid is."""
    chance = np.random.default_rng(4)
    part = healthy.slice(stop=60.0)
    shifted = [
        dataclasses.replace(each, time=each.time + chance.uniform(0.0, 0.009)) for each in part.channels.values()
    ]
    part, places = part.with_channels(shifted), [0.0, *np.sort(chance.uniform(1.0, 59.0, 7)), 100.0]
    found = []
    for cuts in ([0.0, 100.0], places):
        run = Run(*find("friction"), load("midsize-eps"))
        for begin, end in itertools.pairwise(cuts):
            run.add(part.slice(begin, end))
        found.append(run.finish())
    for name, trace in found[0].traces.items():
        np.testing.assert_array_equal(trace.mean, found[1].traces[name].mean, err_msg=name)
    assert found[0].findings == found[1].findings


def test_a_clock_that_was_set_is_refused(healthy):
    with pytest.raises(InputError, match="jumps ahead from about 239.99 s by 1.97e\\+04 days; cut the recording there"):
        diagnose(later(healthy, 240.0, 1.7e9), "midsize-eps")


def test_what_is_missing_is_named_with_the_nearest_name(healthy):
    channels = dict(healthy.channels)
    channels["motor_torqe"] = dataclasses.replace(channels.pop("motor_torque"), name="motor_torqe")
    with pytest.raises(InputError, match="needs motor_torque.*did you mean 'motor_torqe'.*channel map"):
        diagnose(Recording(channels), "midsize-eps")


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        (lambda v: np.full_like(v, np.nan), "every sample of driver_torque is missing"),
        (lambda v: 0.0 * v + 3.0, "constant at 3"),
    ],
)
def test_a_dead_channel_is_refused(healthy, values, sentence):
    with pytest.raises(InputError, match=sentence):
        diagnose(changed(healthy, "driver_torque", values=values(healthy["driver_torque"].values)), "midsize-eps")


@pytest.mark.parametrize("name", ["driver_torque", "steering_wheel_angle"])
def test_raw_counts_are_never_taken_for_a_unit(healthy, name):
    unit = healthy[name].unit.replace("*", "·")
    with pytest.raises(InputError, match=f"{name} is in raw counts, but the vehicle 'midsize-eps' needs {unit}; give"):
        diagnose(changed(healthy, name, unit="count"), "midsize-eps")


def test_unknown_names_are_refused(healthy):
    with pytest.raises(ParameterError, match="no monitor 'fricton'; did you mean 'friction'"):
        diagnose(healthy, "midsize-eps", "fricton")
    with pytest.raises(ParameterError, match="no variant 'refind'; did you mean 'refined'"):
        diagnose(healthy, "midsize-eps", "friction", "refind")
    empty = {name: Channel(name, np.empty(0), np.empty(0), c.unit) for name, c in healthy.channels.items()}
    with pytest.raises(InputError, match="no samples"):
        diagnose(Recording(empty), "midsize-eps")


def test_the_running_verdict_is_reported_at_every_change_however_the_drive_is_cut(rising):
    courses = []
    for cuts in ((), (100.0, 391.0, 700.0)):
        run = Run(*find("friction"), load("midsize-eps"))
        for start, stop in itertools.pairwise((-np.inf, *cuts, np.inf)):
            run.add(rising.slice(start, stop))
        run.finish()
        courses.append(run.course)
    whole = courses[0]
    assert [change.status for change in whole] == [Status.NOT_READY, Status.HEALTHY, Status.RISING, Status.FAULT]
    assert whole[0].time == 0.0
    assert 390.0 < whole[2].time < whole[3].time < 600.0
    assert courses[1] == whole
