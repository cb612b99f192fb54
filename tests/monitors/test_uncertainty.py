"""Uncertain parameters in bands and verdicts, on a monitor whose result is known in closed form."""

from __future__ import annotations

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from rolling_car import OWN, car, monitor
from shared_data import shared_data
from tierod.core.findings import Status
from tierod.core.recording import Channel, Recording
from tierod.io.readers import read
from tierod.monitors import uncertainty
from tierod.monitors.diagnose import diagnose
from tierod.monitors.run import Run
from tierod.monitors.runner import find
from tierod.monitors.session import opened
from tierod.monitors.uncertainty import Uncertain
from tierod.vehicles import Vehicle, load
from tierod.vehicles.classes import WatchedParameters, may_move
from tierod_lab.ground import drive as driven
from tierod_lab.papers.own_car.brochure import brochure_car

COARSE = replace(monitor(), lane_rate=10.0)
"""The monitor at 50 Hz, whose lanes see every fifth sample."""


def drive(seconds=20.0, turns=(0.0, np.inf)):
    """A weave between two times, and a straight road before and after."""
    time = np.arange(0.0, seconds, 0.02)
    turning = (time >= turns[0]) & (time < turns[1])
    return Recording(
        {
            "yaw_rate": Channel("yaw_rate", time, np.where(turning, 0.3, 0.0005) * np.sin(time), "rad/s"),
            "vehicle_speed": Channel("vehicle_speed", time, 3.0 + 0.01 * np.cos(7.0 * time), "m/s"),
        }
    )


@pytest.mark.parametrize("watched", [monitor(), COARSE], ids=["every sample", "every fifth"])
@pytest.mark.parametrize("turns", [(0.0, np.inf), (0.0, 70.0), (101.0, 140.0), (170.0, 190.0)])
def test_a_parameter_widens_band_and_estimate_whenever_it_acts(turns, watched):
    found = diagnose(drive(200.0, turns), car(1.2, 0.2, 100.0), watched)
    estimate = found.findings[0].estimate
    assert estimate.value == pytest.approx(0.12, rel=0.01)
    assert estimate.standard_deviation == pytest.approx(np.hypot(OWN, 0.02), rel=0.02)
    (only,) = found.parameter_effects
    assert (only.name, only.share) == ("rear_distance", 1.0)
    assert only.effect == pytest.approx(0.02, rel=0.02)
    band, angle = found.traces["angle_standard_deviation"], found.traces["angle"]
    widest = np.hypot(OWN, np.maximum(np.abs(angle.lower), np.abs(angle.upper)) / 6.0)
    assert np.allclose(band.upper, widest, rtol=0.05, atol=0.0 if watched is not COARSE else 0.002)


def test_the_squares_of_independent_parameters_add_up():
    found = diagnose(drive(), car(1.2, 0.2, 170.0), monitor(laden=True))
    assert found.findings[0].estimate.standard_deviation == pytest.approx(
        np.sqrt(OWN**2 + 0.02**2 + 0.012**2), rel=0.02
    )
    assert [each.name for each in found.parameter_effects] == ["rear_distance", "mass"]


@pytest.mark.parametrize("watched", [monitor(), COARSE], ids=["every sample", "every fifth"])
def test_bands_do_not_depend_on_how_a_recording_is_cut(watched):
    whole, vehicle = drive(300.0, (30.0, 250.0)), car(1.2, 0.2, 500.0)

    def judged(cuts):
        run = Run(watched, watched.variants["only"], vehicle, uncertain=True)
        for begin, end in zip([0.0, *cuts], [*cuts, np.inf], strict=True):
            run.add(whole.slice(begin, end))
        return run.finish()

    at_once = judged([])
    for cuts in (np.arange(2.013, 300.0, 2.0), np.arange(1.7, 300.0, 33.313)):
        found = judged(cuts.tolist())
        assert found.findings[0].estimate == at_once.findings[0].estimate
        assert found.parameter_effects == at_once.parameter_effects
        mine, other = (each.traces["angle_standard_deviation"] for each in (found, at_once))
        assert (mine.upper.tolist(), mine.lower.tolist()) == (other.upper.tolist(), other.lower.tolist())


def test_the_finding_gives_the_wider_deviation_and_what_to_measure():
    finding = diagnose(drive(), car(1.2, 0.2), monitor()).findings[0]
    assert "6.9 ± 1.3 °" in finding.headline
    assert any("rear_distance ±0.2 m shifts it by ±1.1 degrees; measure it first" in each for each in finding.warnings)


def test_a_missing_deviation_is_that_of_the_class_and_said_so():
    found = diagnose(drive(), car(1.2, None), monitor())
    assert found.parameter_effects[0].standard_deviation == pytest.approx(0.09 * 1.2)
    assert "rear_distance has no standard deviation" in found.remarks["parameters"]
    assert "parameters" not in diagnose(drive(), car(1.2, 0.2), monitor()).remarks


@pytest.mark.parametrize("watched", [monitor(limit=0.1), replace(monitor(limit=0.1), lane_rate=10.0)])
def test_a_fault_that_turns_is_suspect_and_names_the_parameter(watched):
    found = diagnose(drive(), car(1.2, 0.2), watched)
    finding = found.findings[0]
    assert finding.status is Status.SUSPECT
    assert "rear_distance decides" in finding.headline
    assert "measure rear_distance first" in finding.action
    assert [each.status for each in found.elements] == [Status.SUSPECT]


def test_healthy_turns_where_an_estimate_passes_its_limit_and_not_where_a_car_only_fits_worse():
    turned = diagnose(drive(), car(1.2, 0.2), monitor(limit=0.15)).findings[0]
    assert turned.status is Status.NOT_IDENTIFIABLE
    assert "rear_distance" in turned.cause
    assert diagnose(drive(), car(1.2, 0.2), monitor(limit=0.15, misfit=True)).findings[0].status is Status.HEALTHY
    assert diagnose(drive(), car(1.2, 0.2), monitor(limit=0.3)).findings[0].status is Status.HEALTHY


TRUTHS = ("sideslip_angle", "truth_sideslip_angle")


def guessed(vehicle: Vehicle, **values: tuple[float, float | None]) -> Vehicle:
    parameters = dict(vehicle.parameters)
    for name, (value, deviation) in values.items():
        parameters[name] = dataclasses.replace(parameters[name], value=value, standard_deviation=deviation)
    return dataclasses.replace(vehicle, parameters=parameters)


@pytest.fixture(scope="module")
def slow_turns():
    path = shared_data("revsted_slip_angle", "obd.csv")
    return read(path, channel_map=load("revsted-car").channel_map)


def test_a_guessed_distance_gives_a_band_that_holds_the_truth_and_is_named(slow_turns):
    bare = Recording({name: each for name, each in slow_turns.channels.items() if name not in TRUTHS})
    found = diagnose(bare, guessed(load("revsted-car"), rear_distance=(1.2, 0.3)), "sideslip")
    finding, estimate = found.findings[0], found.findings[0].estimate
    assert finding.status is Status.ESTIMATED
    assert abs(np.degrees(estimate.value) + 9.5) < 1.96 * np.degrees(estimate.standard_deviation) < 10.0
    assert found.parameter_effects[0].name == "rear_distance"
    assert found.parameter_effects[0].share > 0.9
    assert any("rear_distance ±0.3 m shifts it by ±3" in each for each in finding.warnings)
    exact = diagnose(bare, guessed(load("revsted-car"), rear_distance=(1.2, 0.3)), "sideslip", spread=False)
    # Each headline takes the sample that is surely so large, with its own band.
    assert exact.findings[0].estimate.value == pytest.approx(estimate.value, rel=0.01)
    assert exact.findings[0].estimate.standard_deviation < 0.1 * estimate.standard_deviation
    assert "assumed to be exact" in exact.remarks["parameters"]


def test_the_file_of_the_car_is_consistent_with_its_reference(slow_turns):
    finding = diagnose(slow_turns, "revsted-car", "sideslip").findings[0]
    assert finding.status is Status.CONSISTENT
    assert finding.evidence["truth_within_wider_band_share"] > 0.95


@pytest.mark.usefixtures("kernels_in_a_moment")
def test_lanes_in_one_kernel_show_what_each_shows_alone_to_the_last_bit(monkeypatch):
    monkeypatch.setattr(uncertainty, "AT_ONCE", 1)
    whole, found = driven(minutes=1.5, seed=2), []
    for least in (np.inf, 0):
        monkeypatch.setattr(uncertainty, "ABREAST_FROM", least)
        found.append(diagnose(whole, brochure_car("unknown", "midsize", 1500.0, 2.7), "friction"))
    alone, abreast = found
    assert alone.findings == abreast.findings
    assert alone.parameter_effects == abreast.parameter_effects != ()
    for name, trace in alone.traces.items():
        np.testing.assert_array_equal(trace.upper, abreast.traces[name].upper, err_msg=name)


@pytest.mark.parametrize(
    ("monitor", "held"),
    [
        ("friction", set()),
        ("driver-torque", set()),
        ("sideslip", {"front_cornering_stiffness", "rear_cornering_stiffness"}),
    ],
)
def test_every_uncertain_parameter_that_a_monitor_reads_is_moved_but_those_in_its_own_band(monitor, held):
    car = brochure_car("unknown", "midsize", 1500.0, 2.7)
    definition, variant = find(monitor)
    read = WatchedParameters(car.parameters)
    opened(definition, variant, dataclasses.replace(car, parameters=read))
    uncertain = {name for name in read.read if may_move(name) and car.parameters[name].standard_deviation}
    assert set(Uncertain(definition, variant, car, None).names) >= uncertain - held - {"front_distance"}
    assert monitor == "sideslip" or "motor_ratio" in uncertain
