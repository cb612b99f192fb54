"""Monitors over recordings of any length, and what stops them."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from driven import drive
from exact_vehicle import diagnose
from shared_data import shared_data
from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.core.statuses import Status
from tierod.monitors.diagnose import usual_monitor
from tierod.monitors.registry import MONITORS
from tierod.monitors.run import Run
from tierod.monitors.runner import find
from tierod.report.diagnosis import render
from tierod.vehicles import load
from tierod_lab.ground import FrictionCourse

VARIANTS = [("friction", variant) for variant in MONITORS["friction"].variants]


@pytest.fixture(scope="module")
def healthy():
    return drive(minutes=8.0, seed=3)


@pytest.fixture(scope="module")
def rising():
    return drive(minutes=13.0, friction=FrictionCourse.step(4.0, 8.0, at=390.0), seed=1)


def changed(recording: Recording, name: str, **fields) -> Recording:
    return recording.with_channels([dataclasses.replace(recording[name], **fields)])


@pytest.mark.parametrize(("monitor", "variant"), VARIANTS)
def test_every_variant_says_something_fault_free_of_a_healthy_drive(healthy, monitor, variant):
    diagnosis = diagnose(healthy, "midsize-eps", monitor, variant)
    finding = diagnosis.findings[0]
    assert finding.status in (Status.HEALTHY, Status.NOT_ENABLED, Status.NOT_READY), finding.headline
    assert finding.headline
    assert finding.cause
    assert finding.action
    assert {"enabled", "steering_wheel_angle"} <= set(diagnosis.traces)
    assert diagnosis.recording["duration_s"] == pytest.approx(480.0)


def test_a_vehicle_file_names_the_monitor_of_its_recordings(healthy):
    column = dataclasses.replace(load("midsize-eps"), monitor="driver-torque")
    assert usual_monitor(load("midsize-eps")) == "friction"
    assert usual_monitor(load("smartload")) == "condition"
    assert usual_monitor(column) == "driver-torque"
    with pytest.raises(ParameterError, match="no monitor 'frictoin'"):
        diagnose(healthy, dataclasses.replace(column, monitor="frictoin"))


def test_friction_that_rises_half_way_is_a_fault_since_then(rising):
    finding = diagnose(rising, "midsize-eps").findings[0]
    assert finding.status is Status.FAULT
    assert finding.status.exit_code == 1
    assert finding.since == pytest.approx(390.0, abs=30.0)
    assert finding.estimate.value == pytest.approx(8.0, abs=0.4)


@pytest.mark.parametrize("seed", [1, *(pytest.param(each, marks=pytest.mark.slow) for each in (2, 3))])
def test_the_baseline_dates_a_fault_to_the_window_it_begins_in(seed):
    course = FrictionCourse.step(4.0, 12.5, at=390.0)
    finding = diagnose(
        drive(minutes=13.0, friction=course, seed=seed), "midsize-eps", "friction", "baseline-ungated"
    ).findings[0]
    assert finding.status is Status.FAULT
    assert finding.since == pytest.approx(390.0, abs=15.0)


def test_a_value_that_is_withheld_is_shown_nowhere(healthy):
    diagnosis = diagnose(healthy.slice(0.0, 60.0), "midsize-eps")
    assert diagnosis.findings[0].estimate is None
    assert not {"friction_torque", "friction_torque_standard_deviation", "ratio_to_baseline"} & set(diagnosis.traces)
    assert {"enabled", "nis", "driver_torque"} <= set(diagnosis.traces)
    assert diagnosis.histograms == diagnosis.loops == {}
    assert "withheld" in diagnosis.remarks["estimate"]
    assert "withheld" in render(diagnosis)
    assert "Friction torque over time" not in render(diagnosis)


@pytest.mark.parametrize("variant", ["pre-sliding", "refined", "baseline-ungated"])
def test_parameters_of_the_vehicle_are_no_tuning_of_the_monitor(healthy, variant):
    rows = diagnose(healthy.slice(0.0, 60.0), "midsize-eps", "friction", variant).parameters
    tuning = {name.rpartition(".")[2] for name, *_, source in rows if source.startswith("tuning of")}
    assert tuning
    assert not tuning & {"mass", "trail", "column_inertia", "steering_ratio"}


def test_a_band_is_shown_only_where_the_estimator_claims_it(healthy):
    wide, strict = (diagnose(healthy, "midsize-eps", "friction", variant) for variant in ("pre-sliding", "refined"))
    assert "estimate" not in wide.remarks
    assert set(wide.consistency) == {"enabled_samples", "nis_mean"}
    assert {"nis_band_low", "nis_band_high", "nis_outside_95_share"} < set(strict.consistency)


def test_a_parameter_that_a_variant_lacks_is_reported_with_the_variant(healthy):
    with pytest.raises(ParameterError, match="cannot run as 'baseline': the vehicle 'rav4' lacks nominal_friction"):
        diagnose(healthy, "rav4", "friction", "baseline")


@pytest.mark.parametrize("cuts", [[100.0], [0.5, 0.51, 33.337, 200.0, 477.0]])
def test_the_result_does_not_depend_on_how_the_recording_is_cut(healthy, cuts):
    definition, variant = find("friction")
    run = Run(definition, variant, load("midsize-eps"))
    edges = [-np.inf, *cuts, np.inf]
    for low, high in itertools.pairwise(edges):
        run.add(healthy.slice(low, high))
    pieces, whole = run.finish(), diagnose(healthy, "midsize-eps")
    assert pieces.findings[0].evidence == whole.findings[0].evidence
    assert pieces.findings[0].estimate == whole.findings[0].estimate
    assert pieces.quality[0].samples == whole.quality[0].samples


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


def test_a_pause_of_ten_minutes_is_judged_as_a_whole(healthy):
    lengths = []
    run = Run(*find("friction"), load("midsize-eps"), kept=lambda time, shown: lengths.append(len(time)))
    run.add(later(healthy, 240.0, 599.0))
    run.finish()
    assert sum(lengths) == round((480.0 + 599.0) * 100.0)


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


def test_work_follows_the_samples_not_their_stamps(healthy):
    lengths = []
    run = Run(*find("friction"), load("midsize-eps"), kept=lambda time, shown: lengths.append(len(time)))
    run.add(healthy.slice(stop=60.0))
    rest = healthy.slice(60.0, 62.0)
    for hour in range(1, 25):
        run.add(later(rest, 0.0, 3600.0 * hour).slice(3600.0 * hour + 60.0, 3600.0 * hour + 60.02))
    assert sum(lengths) < 100.0 * (60.0 + 3600.0 + 600.0 + 25 * 11.0)
    assert run.finish().recording["duration_s"] == pytest.approx(24 * 3600.0 + 60.0, abs=1.0)


def test_a_recording_that_is_too_slow_is_refused_though_every_piece_holds_one_sample(healthy):
    run = Run(*find("friction"), load("midsize-eps"))
    run.add(healthy.slice(stop=0.005))
    with pytest.raises(InputError, match="is sampled at 0.0001 Hz; at least 20 Hz are needed"):
        run.add(later(healthy.slice(0.005, 0.015), 0.0, 9999.99))


def test_a_clock_that_was_set_is_refused(healthy):
    with pytest.raises(InputError, match="jumps ahead from about 239.99 s by 1.97e\\+04 days; cut the recording there"):
        diagnose(later(healthy, 240.0, 1.7e9), "midsize-eps")


def test_a_warning_that_shows_later_is_kept(healthy):
    run = Run(*find("friction"), load("midsize-eps"))
    run.add(healthy.slice(stop=200.0).warned("early"))
    run.add(healthy.slice(200.0).warned("early", "late"))
    assert {"early", "late"} <= set(run.finish().findings[0].warnings)


def test_what_is_missing_is_named_with_the_nearest_name(healthy):
    channels = dict(healthy.channels)
    channels["motor_torqe"] = dataclasses.replace(channels.pop("motor_torque"), name="motor_torqe")
    with pytest.raises(InputError, match="needs motor_torque.*did you mean 'motor_torqe'.*channel map"):
        diagnose(Recording(channels), "midsize-eps")


def test_slow_data_are_refused(healthy):
    slow = healthy["yaw_rate"]
    with pytest.raises(InputError, match="yaw_rate is sampled at 1 Hz; at least 20 Hz"):
        diagnose(changed(healthy, "yaw_rate", time=slow.time[::100], values=slow.values[::100]), "midsize-eps")


def test_milliseconds_taken_for_seconds_are_guessed(healthy):
    minute = healthy.slice(stop=60.0).channels.items()
    slow = Recording({name: dataclasses.replace(c, time=1e3 * c.time) for name, c in minute})
    with pytest.raises(InputError, match=r'0.1 Hz.*if its time counts milliseconds, call that column "time \[ms\]"'):
        diagnose(slow, "midsize-eps")


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


def test_degrees_taken_for_radians_are_reported_beside_the_verdict(healthy):
    wrong = changed(healthy, "yaw_rate", values=np.degrees(healthy["yaw_rate"].values))
    warnings = diagnose(wrong, "midsize-eps").findings[0].warnings
    assert any(warning.startswith("yaw_rate: ") and "leaves the plausible" in warning for warning in warnings)


@pytest.mark.parametrize("name", ["driver_torque", "steering_wheel_angle"])
def test_raw_counts_are_never_taken_for_a_unit(healthy, name):
    unit = healthy[name].unit.replace("*", "·")
    with pytest.raises(InputError, match=f"{name} is in raw counts, but the vehicle 'midsize-eps' needs {unit}; give"):
        diagnose(changed(healthy, name, unit="count"), "midsize-eps")


def test_a_wrong_sign_is_noticed(healthy):
    wrong = changed(healthy, "lateral_acceleration", values=-healthy["lateral_acceleration"].values)
    finding = diagnose(wrong, "midsize-eps").findings[0]
    assert "lateral_acceleration probably has the wrong sign" in "; ".join((finding.cause, *finding.warnings))
    assert not any("wrong sign" in warning for warning in diagnose(healthy, "midsize-eps").findings[0].warnings)


def test_holes_in_the_data_do_no_harm(healthy):
    values = healthy["driver_torque"].values.copy()
    values[10_000:10_700] = np.nan
    holed = changed(healthy, "driver_torque", values=values)
    finding = diagnose(holed, "midsize-eps").findings[0]
    assert finding.status is Status.HEALTHY
    assert finding.estimate.value == pytest.approx(4.0, abs=0.2)


def test_a_few_samples_are_not_called_constant(healthy):
    two = Recording({name: channel.sliced(1.0, 1.015) for name, channel in healthy.channels.items()})
    assert len(two["yaw_rate"].time) == 2
    still = two.with_channels([dataclasses.replace(c, values=0.0 * c.values) for c in two.channels.values()])
    with pytest.raises(InputError, match="2 samples, too few to judge anything"):
        diagnose(still, "midsize-eps")


def test_unknown_names_are_refused(healthy):
    with pytest.raises(ParameterError, match="no monitor 'fricton'; did you mean 'friction'"):
        diagnose(healthy, "midsize-eps", "fricton")
    with pytest.raises(ParameterError, match="no variant 'refind'; did you mean 'refined'"):
        diagnose(healthy, "midsize-eps", "friction", "refind")
    empty = {name: Channel(name, np.empty(0), np.empty(0), c.unit) for name, c in healthy.channels.items()}
    with pytest.raises(InputError, match="no samples"):
        diagnose(Recording(empty), "midsize-eps")


def test_the_highway_minute_says_what_it_can_and_what_it_cannot():
    log = shared_data("rav4_highway_minute", "can.log")
    diagnosis = diagnose(log, "rav4")
    finding = diagnosis.findings[0]
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert finding.status.exit_code == 2
    assert finding.estimate is None
    for part in ("raw counts", "lane keeping", "50 s are needed", "hysteresis of dry friction is present"):
        assert part in finding.cause
    assert 1.5 < finding.evidence["enabled_s"] < 4.0
    assert finding.evidence["hysteresis_share"] > 2.0 * finding.evidence["hysteresis_by_chance_share"]
    assert any("sign" in remark for row in diagnosis.quality for remark in row.remarks if "lateral" in row.name)


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
