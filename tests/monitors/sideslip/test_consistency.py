"""Which signal or parameter disagrees with the others, and by how much, on a made-up drive without tyres' slip."""

import math
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tierod.monitors.sideslip.consistency import Tolerances, consistency_of
from tierod.monitors.sideslip.observables import WHEELS, ObservablesOverDrive, OwnMotionLimits, OwnMotionOverDrive
from tierod.vehicles import load
from tierod_lab.papers.own_car.brochure import brochure_car

RATE = 50.0
TIME = np.arange(9000) / RATE
CAR = brochure_car("midsize", "midsize", 1550.0, 2.7)


@cache
def signals():
    """Turns at 4 to 16 m/s of a car that follows its file, with noise."""
    speed = 10.0 + 4.0 * np.sin(0.21 * TIME) + 2.0 * np.sin(0.53 * TIME)
    yaw = (0.2 * np.sin(0.37 * TIME) + 0.15 * np.sin(0.83 * TIME + 1.0)) * 8.0 / speed
    wheelbase, rear, track = CAR["front_distance"] + CAR["rear_distance"], CAR["rear_distance"], CAR["track_width"]
    changed = np.gradient(yaw) * RATE
    noise = np.random.default_rng(1).normal(size=(9, len(TIME)))
    there = {
        "vehicle_speed": speed + 0.02 * noise[0],
        "yaw_rate": yaw + 0.002 * noise[1],
        "lateral_acceleration": 0.97 * speed * yaw + (rear - 0.2) * changed + 0.05 * noise[2],
        "longitudinal_acceleration": np.gradient(speed) * RATE + 0.05 * noise[3],
        "angle": wheelbase * yaw / speed + 0.0035 * speed * yaw + 2e-4 * noise[4],
    }
    sides = zip(WHEELS, (-0.5, 0.5, -0.5, 0.5), strict=True)
    return there | {name: speed + side * track * yaw + 0.03 * noise[5 + at] for at, (name, side) in enumerate(sides)}


def over(vehicle=CAR, pieces=1, missing=(), added=None, **factors):
    """The consistency of the drive with a file, some signals scaled and then others added to some."""
    there = {name: factors.get(name, 1.0) * values for name, values in signals().items()}
    there |= {name: there[name] + more for name, more in (added or {}).items()}
    there |= {name: np.full(len(TIME), math.nan) for name in missing}
    drive = ObservablesOverDrive(RATE)
    for at in np.array_split(np.arange(len(TIME)), pieces):
        piece = {name: values[at] for name, values in there.items()}
        drive.add(piece, piece.pop("angle"))
    return consistency_of(drive, vehicle, Tolerances())


def test_a_drive_that_fits_its_file_has_nothing_wrong_however_it_is_cut():
    assert over().wrong() is None
    assert over(pieces=13).evidence() == pytest.approx(over().evidence(), rel=1e-6, abs=1e-9)


def test_tight_turns_at_walking_pace_say_nothing_about_the_file():
    """A steering whose ratio falls by a fifth towards its stops, as in parking."""
    speed = 3.7 + 0.4 * np.sin(0.21 * TIME)
    angle = 0.5 * np.sin(0.37 * TIME)
    yaw = speed * np.tan(angle) / (CAR["front_distance"] + CAR["rear_distance"])
    drive = ObservablesOverDrive(RATE)
    across = speed * yaw + CAR["rear_distance"] * np.gradient(yaw) * RATE
    there = {"vehicle_speed": speed, "yaw_rate": yaw, "lateral_acceleration": across}
    drive.add(there | {"longitudinal_acceleration": np.gradient(speed) * RATE}, angle * (1.0 - 0.4 * np.abs(angle)))
    consistency = consistency_of(drive, CAR, Tolerances())
    assert consistency.wrong() is None
    assert math.isnan(consistency.shown.understeer)


@pytest.mark.parametrize("factor", [0.8, 1.25])
@pytest.mark.parametrize("name", ["yaw_rate", "vehicle_speed", "lateral_acceleration"])
def test_a_signal_of_another_scale_is_named_with_it(name, factor):
    wrong = over(**{name: factor}).wrong()
    assert wrong is not None
    assert wrong.decisive
    assert name in wrong.names
    best = over(**{name: factor}).explanations[0]
    assert best.name == name
    assert math.exp(best.size) == pytest.approx(factor, rel=0.1)


@pytest.mark.parametrize(("name", "offset"), [("vehicle_speed", 2.5), ("wheel_speed_rear_left", 5.0)])
def test_an_offset_of_a_speed_is_not_called_a_scale_alone(name, offset):
    found = over(added={name: offset}).wrong()
    assert name in found.names
    assert ("vehicle_speed" in found.names) == (name == "vehicle_speed")
    assert "offset" in found.sentence


def test_a_scale_of_a_single_rear_wheel_is_given_beside_that_of_both():
    found = over(wheel_speed_rear_left=0.5).wrong()
    assert float(
        re.search(r"the rear wheel speeds .*or one of them ([\d.]+) times", found.sentence)[1]
    ) == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize(
    ("added", "factors", "wrong"),
    [
        ({"yaw_rate": TIME / 300.0}, {"wheel_speed_rear_right": 0.75}, "yaw_rate"),
        ({}, {"angle": 2.0, "wheel_speed_rear_right": 0.5}, "steering_wheel_angle"),
        ({"longitudinal_acceleration": 0.0}, {"lateral_acceleration": 1.5, "vehicle_speed": 0.7}, "vehicle_speed"),
    ],
)
def test_of_two_wrong_signals_none_is_accused_alone(added, factors, wrong):
    found = over(added=added, **factors).wrong()
    assert wrong in found.names
    assert len(found.names) > 2
    assert "more than one of" in found.sentence
    assert "times the right value" not in found.sentence


def test_several_wrong_signals_that_hardly_move_the_sideslip_are_named_and_withhold_nothing():
    found = over(longitudinal_acceleration=2.0, wheel_speed_rear_left=0.5).wrong()
    assert {"longitudinal_acceleration", "wheel_speed_rear_left"} <= set(found.names)
    assert not found.decisive


def test_without_wheel_speeds_and_acceleration_along_a_scale_is_still_found():
    wrong = over(missing=(*WHEELS, "longitudinal_acceleration"), yaw_rate=1.25).wrong()
    assert wrong is not None
    assert {"yaw_rate", "lateral_acceleration"} & set(wrong.names)


@pytest.mark.parametrize(("across", "shown"), [(0.02, False), (0.5, True)])
def test_a_straight_road_shows_nothing_of_yaw_rate_and_lateral_acceleration(across, shown):
    """Steps of a tenth of a degree per second in a yaw rate that hardly moves would make its scale seem too large."""
    missing = np.full(len(TIME), math.nan)
    piece = dict.fromkeys(signals(), missing)
    across, step = across * np.sin(0.7 * TIME), math.radians(0.1)
    noise = 0.002 * np.random.default_rng(2).normal(size=len(TIME))
    piece |= {"vehicle_speed": 30.0 + 0.0 * TIME, "yaw_rate": step * np.round((across / 30.0 + noise) / step)}
    piece["lateral_acceleration"] = 0.97 * across
    drive = ObservablesOverDrive(RATE)
    drive.add(piece, piece["angle"])
    found = consistency_of(drive, CAR, Tolerances())
    assert math.isfinite(found.shown.turn) is shown
    assert found.wrong() is None


def test_a_zero_of_the_steering_angle_is_named():
    drive = ObservablesOverDrive(RATE)
    drive.add(signals(), signals()["angle"] + 0.02)
    wrong = consistency_of(drive, CAR, Tolerances()).wrong()
    assert wrong is not None
    assert wrong.sentence.endswith("degrees")
    assert "straight at +1.1" in wrong.sentence


@pytest.mark.parametrize(("shown", "track"), [(1e-6, 0.0), (-1e-6, 0.0), (-1.0, -1.0)])
def test_wheel_speeds_that_show_no_track_or_one_of_the_other_sign_withhold_nothing(shown, track):
    """Both rear wheels from one channel, or left and right exchanged: no scale explains that, and it moves nothing."""
    found = over()
    expected = found.expected.values.track
    found = replace(found, shown=found.shown._replace(track=shown * expected))
    wrong = found.wrong()
    assert wrong.names == ("track_width",)
    assert not wrong.decisive
    assert f"{track * expected:.2f} m in the drive, {expected:.2f} ± " in wrong.sentence.replace("-0.00", "0.00")
    best = found.explanations[0]
    assert best.size == pytest.approx(shown - 1.0)


def test_a_track_width_that_is_too_small_in_the_file_is_shown_beside_that_of_the_drive():
    small = replace(CAR.parameters["track_width"], value=0.7 * CAR["track_width"], standard_deviation=0.02)
    wrong = over(replace(CAR, parameters={**CAR.parameters, "track_width": small})).wrong()
    assert wrong.names == ("track_width",)
    assert f"{CAR['track_width']:.2f} m in the drive, {small.value:.2f} ± " in wrong.sentence


@pytest.mark.parametrize("name", ["smartload", "revsted-car"])
def test_the_file_of_another_car_is_named(name):
    wrong = over(load(name)).wrong()
    assert wrong is not None
    assert wrong.decisive


def test_a_guess_with_its_spread_contradicts_nothing():
    guess = replace(CAR.parameters["steering_ratio"], value=1.12 * CAR["steering_ratio"])
    assert over(replace(CAR, parameters={**CAR.parameters, "steering_ratio": guess})).wrong() is None


def test_too_little_driving_says_nothing():
    drive = ObservablesOverDrive(RATE)
    short = {name: values[:200] for name, values in signals().items()}
    drive.add(short, short["angle"])
    found = consistency_of(drive, load("midsize-eps"), Tolerances())
    assert found.wrong() is None
    assert found.file_weight() == 0.0


@pytest.mark.parametrize(("factor", "deviation", "said"), [(1.0, 0.2, False), (3.0, 0.2, True), (3.0, 5.0, False)])
def test_an_estimate_that_moves_more_than_the_car_is_named_unless_its_band_holds_that(factor, deviation, said):
    there, motion = signals(), OwnMotionOverDrive(RATE)
    angle = np.radians(2.0 * np.sin(1.1 * TIME))
    speed, yaw = 20.0 + 0.0 * TIME, there["yaw_rate"]
    lateral = speed * yaw + np.gradient(speed * np.tan(angle)) * RATE
    for at in np.array_split(np.arange(len(TIME)), 7):
        motion.add(speed[at], yaw[at], lateral[at], factor * angle[at])
        motion.deviations(np.full(len(at), math.radians(deviation)))
    assert (motion.wrong() is not None) is said
    assert motion.share()[0] == pytest.approx(1.0 / factor, rel=0.05)


@pytest.mark.parametrize(("separable", "objects"), [(OwnMotionLimits().separable, False), (0.0, True)])
def test_an_estimate_that_changes_with_the_yaw_rate_alone_is_not_judged_by_its_small_errors(separable, objects):
    yaw, speed = 0.3 * np.sin(0.37 * TIME) + 0.2 * np.sin(0.83 * TIME), np.full(len(TIME), 20.0)
    across, error = 3.0 * yaw, 0.05 * np.sin(1.1 * TIME)
    motion = OwnMotionOverDrive(RATE, OwnMotionLimits(separable=separable))
    motion.add(speed, yaw, speed * yaw + np.gradient(across) * RATE, np.arctan((across + error) / speed))
    motion.deviations(np.full(len(TIME), math.radians(0.2)))
    assert abs(motion.share()[0]) < 0.1
    assert (motion.wrong() is not None) is objects
