import importlib
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest

from tierod_lab.ground.recorder import TRUTH, Recorder, channel, channel_names, declared_units


def recorded(outputs, columns, instants, seconds, sizes):
    recorder = Recorder(columns, instants, 1e-3, seconds)
    start = 0
    for size in sizes:
        recorder.add(outputs[start : start + size])
        start += size
    assert start == len(outputs)
    return recorder.truths()


def plant(seconds=30.0):
    time = np.arange(round(seconds * 1e3)) * 1e-3
    return time, np.column_stack([np.sin(time), time**2])


def test_channels_are_read_at_their_own_instants_whatever_the_pieces():
    _, outputs = plant()
    instants = {"yaw_rate": np.arange(0.0, 29.9, 0.0137) + 0.00025, "vehicle_speed": np.arange(0.0, 30.0, 0.5)}
    columns = {"yaw_rate": [0], "vehicle_speed": [1]}
    one = recorded(outputs, columns, instants, 30.0, [30_000])
    many = recorded(outputs, columns, instants, 30.0, [200] * 149 + [7, 193])
    for name, values in one.items():
        assert np.array_equal(values, many[name])
    assert one["yaw_rate"] == pytest.approx(np.sin(instants["yaw_rate"]), abs=1e-6)
    assert np.array_equal(one["vehicle_speed"], (instants["vehicle_speed"]) ** 2)


def test_every_channel_has_its_truth_at_100_hz():
    time, outputs = plant(2.0)
    values = recorded(outputs, {"yaw_rate": [0], "truth_speed": [1]}, {"yaw_rate": np.zeros(0)}, 2.0, [2000])
    assert np.array_equal(values["truth_yaw_rate"], np.sin(time[::10]))
    assert np.array_equal(values["truth_speed"], time[::10] ** 2)
    assert len(values["yaw_rate"]) == 0


def test_sub_samples_are_put_in_a_row():
    fine = np.arange(40_000) * 1e-4
    outputs = np.sin(30.0 * fine).reshape(4000, 10)
    columns = {"motor_current_alpha": list(range(10))}
    instants = np.arange(39_990) * 1e-4
    values = recorded(outputs, columns, {"motor_current_alpha": instants}, 4.0, [1500, 2500])
    assert values["motor_current_alpha"] == pytest.approx(np.sin(30.0 * instants), abs=1e-12)


def test_a_missing_truth_stays_where_it_was():
    outputs = np.array([[0.0], [1.0], [np.nan], [3.0], [4.0]])
    columns = {"yaw_rate": [0]}
    values = recorded(outputs, columns, {"yaw_rate": np.arange(5) * 1e-3}, 0.005, [5])
    assert np.array_equal(values["yaw_rate"], outputs[:, 0], equal_nan=True)


def test_of_no_outputs_there_is_nothing():
    values = recorded(np.zeros((0, 1)), {"yaw_rate": [0]}, {"yaw_rate": np.arange(5) * 1e-3}, 0.005, [0])
    assert {name: len(each) for name, each in values.items()} == {"yaw_rate": 0, "truth_yaw_rate": 0}


@pytest.mark.parametrize("fine", [1e-3, 0.7e-3, 1.0 / 16e3])
def test_after_ten_hours_a_sample_is_still_that_very_sample(fine):
    begin = round(36_000.0 / fine)
    numbers = np.arange(begin, begin + 14_000, dtype=float)
    instants = numbers[::7] * fine
    recorder = Recorder({"yaw_rate": [0]}, {"yaw_rate": instants}, fine, 0.0)
    recorder.first = begin
    for start in range(0, len(numbers), 200):
        recorder.add(numbers[start : start + 200, None])
    assert np.array_equal(recorder.truths()["yaw_rate"], numbers[::7])


class Inner(NamedTuple):
    yaw_rate: Annotated[Any, "rad/s"]
    torques: Annotated[tuple[float, float], "N*m"]


class Outer(NamedTuple):
    inner: Inner
    truth_mass: Annotated[Any, "kg"]


def test_units_come_from_the_catalogue_or_from_the_plant():
    described = declared_units(Outer(Inner(0.0, (0.0, 0.0)), 0.0))
    none = np.zeros(0)
    assert described["truth_mass"] == "kg"
    assert channel("truth_mass", none, none, described).unit == "kg"
    assert channel("truth_yaw_rate", none, none, {}).unit == "rad/s"
    assert channel("yaw_rate", none, none, {}).unit == "rad/s"


@pytest.mark.parametrize(
    "kind", ["eps_car.EpsCar", "steer_by_wire_car.SteerByWireCar", "active_front_car.ActiveFrontCar"]
)
def test_the_truth_of_a_channel_has_a_name_of_its_own(kind):
    module, _, name = kind.partition(".")
    car = getattr(importlib.import_module(f"tierod_lab.ground.cars.{module}"), name)()
    names = channel_names(car)
    assert not [each for each in names if TRUTH + each in names]
