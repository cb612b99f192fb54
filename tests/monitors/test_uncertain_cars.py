"""Uncertain parameters on monitors and cars that ship: the band holds the truth, and what decides is named."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from shared_data import shared_data
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.io.readers import read
from tierod.monitors import uncertainty
from tierod.monitors.diagnose import diagnose
from tierod.monitors.runner import find
from tierod.monitors.session import opened
from tierod.monitors.uncertainty import Uncertain
from tierod.vehicles import Vehicle, load
from tierod.vehicles.uncertain import WatchedParameters, may_move
from tierod_lab.ground import drive
from tierod_lab.papers.own_car.brochure import brochure_car

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


def test_with_the_reference_the_same_guess_is_inconsistent_and_its_wider_band_holds_it(slow_turns):
    finding = diagnose(slow_turns, guessed(load("revsted-car"), rear_distance=(1.2, 0.3)), "sideslip").findings[0]
    assert finding.status is Status.INCONSISTENT
    assert finding.evidence["truth_within_band_share"] < 0.7
    assert finding.evidence["truth_within_wider_band_share"] > 0.9


def test_the_file_of_the_car_is_consistent_with_its_reference(slow_turns):
    finding = diagnose(slow_turns, "revsted-car", "sideslip").findings[0]
    assert finding.status is Status.CONSISTENT
    assert finding.evidence["truth_within_wider_band_share"] > 0.95


@pytest.mark.usefixtures("kernels_in_a_moment")
def test_lanes_in_one_kernel_show_what_each_shows_alone_to_the_last_bit(monkeypatch):
    monkeypatch.setattr(uncertainty, "AT_ONCE", 1)
    whole, found = drive(minutes=1.5, seed=2), []
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
