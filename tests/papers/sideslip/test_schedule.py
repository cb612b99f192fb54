"""Gains that follow the speed: lines between rows, errors that decay at every speed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.vehicles import load
from tierod_lab.methods.pole_placement import discrete_poles
from tierod_lab.papers.sideslip.observers import placed
from tierod_lab.papers.sideslip.schedule import (
    SPEEDS,
    Scheduling,
    error_radius,
    scheduled,
)
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle, TorqueShownVehicle
from tierod_lab.papers.sideslip.two_stage import decoupled

CAR = dataclasses.replace(load("steer-by-wire").parameters_for(SteeredVehicle.Parameters), road_wheel_friction=0.0)
VEHICLE = load("steer-by-wire").parameters_for(TorqueShownVehicle.Parameters)
DT = 1e-3
FOUR = Scheduling(SteeredVehicle, CAR, lambda speed: (0.0, speed), DT)
TWO = Scheduling(TorqueShownVehicle, VEHICLE, lambda speed: (0.0, speed), DT)


@pytest.mark.parametrize("speed", [0.5, 25.0])
def test_placed_poles_are_where_they_should_be(speed):
    design = FOUR.at(speed)
    gain = placed(design, 3.0, DT)
    closed = (np.eye(4) - gain @ design.system.C) @ design.system.A
    sizes = np.maximum(np.abs(np.linalg.eigvals(design.continuous.A)), 2.0)
    np.testing.assert_allclose(
        np.poly(closed), np.poly(np.real(discrete_poles(-3.0 * sizes, DT))), rtol=1e-6, atol=1e-9
    )


@pytest.mark.parametrize("speed", [0.5, 6.7])
def test_the_second_stage_gives_every_error_a_pole_of_its_own(speed):
    design = TWO.at(speed)
    closed = (np.eye(2) - decoupled(design, 2.0, DT) @ design.system.C) @ design.system.A
    sizes = np.maximum(np.sort(np.abs(np.linalg.eigvals(design.continuous.A))), 2.0)
    np.testing.assert_allclose(closed, np.diag(np.real(discrete_poles(-2.0 * sizes, DT))), atol=1e-9)


@pytest.mark.parametrize(("model", "gain", "rows"), [(FOUR, placed, 4), (TWO, decoupled, 2)])
@pytest.mark.parametrize("factor", [2.0, 10.0])
def test_the_interpolated_gain_is_stable_between_all_speeds_of_the_table(model, gain, rows, factor):
    process, reading = (1e-6,) * rows, (1e-6, 1e-6)
    schedule = scheduled(model, lambda each: gain(each, factor, DT), lambda _: np.eye(rows)[:1], process, reading)
    for speed in np.geomspace(SPEEDS[0], SPEEDS[-1], 150):
        between = np.array(schedule.at(float(speed))[: 2 * rows]).reshape(rows, 2)
        assert error_radius(model.at(float(speed)).system, between) < 1.0


def test_a_gain_that_is_not_stable_is_refused_with_the_speed():
    with pytest.raises(ParameterError, match="m/s"):
        scheduled(TWO, lambda _: np.full((2, 2), 50.0), lambda _: np.eye(2)[:1], (1e-6,) * 2, (1e-6, 1e-6))
