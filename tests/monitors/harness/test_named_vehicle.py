import os

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.io.writers import write
from tierod.monitors.diagnose import diagnose
from tierod.monitors.harness.named_vehicle import other_vehicle, vehicle_named_in
from tierod.vehicles import shipped
from tierod_lab.ground.cars.catalogue import load as load_car
from tierod_lab.ground.cars.catalogue import shipped as cars
from tierod_lab.ground.scenarios import load


def recording(**metadata):
    time = np.arange(100) * 0.01
    return Recording({"yaw_rate": Channel("yaw_rate", time, np.sin(time), "rad/s")}, metadata)


def test_a_virtual_car_is_judged_with_the_vehicle_of_its_name(tmp_path):
    made = recording(virtual_car="midsize-eps", vehicle={"mass": 1600.0})
    assert vehicle_named_in(made) == "midsize-eps"
    path = tmp_path / "drive.parquet"
    write(made, path)
    assert vehicle_named_in(path) == "midsize-eps"


def test_a_virtual_car_of_another_name_shows_the_vehicle_with_which_it_is_judged(tmp_path):
    drive = load("demonstrator-lap").with_run(seconds=1.0).run().recording
    assert vehicle_named_in(drive) == "smartload"
    assert other_vehicle(drive.metadata, "smartload") is None
    assert "made with the vehicle 'smartload'" in (other_vehicle(drive.metadata, "rav4") or "")
    with pytest.raises(InputError, match="made with the vehicle 'smartload'.*judge it with --vehicle smartload"):
        diagnose(drive, vehicle="midsize-eps", monitor="friction")


@pytest.mark.parametrize("car", cars())
def test_the_vehicle_that_a_virtual_car_names_is_shipped(car):
    assert load_car(car).vehicle in ("", *shipped())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_pipe_is_not_read_for_the_name_of_a_vehicle_since_it_could_not_be_read_again(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="is a pipe, which can be read once only; give --vehicle"):
        vehicle_named_in(tmp_path / "pipe")


@pytest.mark.parametrize(
    ("metadata", "sentence"), [({}, "names none"), ({"virtual_car": "my-car"}, "names 'my-car', which tierod does not")]
)
def test_where_it_names_none_that_is_shipped_the_user_must(metadata, sentence):
    with pytest.raises(ParameterError, match=sentence):
        vehicle_named_in(recording(**metadata))


def test_a_file_that_is_not_there_is_reported_as_such(tmp_path):
    with pytest.raises(InputError, match="there is no file"):
        vehicle_named_in(tmp_path / "absent.parquet")


def test_a_file_that_cannot_be_read_is_reported_as_such(tmp_path):
    path = tmp_path / "empty.mf4"
    path.touch()
    with pytest.raises(InputError, match="empty.mf4 is empty"):
        vehicle_named_in(path)


def test_some_virtual_cars_have_a_vehicle():
    assert {"midsize-eps", "column-bench"} <= set(cars()) & set(shipped())


@pytest.mark.parametrize(
    ("metadata", "judged_as", "result"),
    [
        ({"virtual_car": "steer-by-wire"}, "midsize-eps", True),
        ({"vehicle": "steer-by-wire"}, "midsize-eps", True),
        ({"virtual_car": "steer-by-wire", "vehicle": {"mass": 1640.0}}, "steer-by-wire", False),
        ({"virtual_car": "my-car"}, "midsize-eps", False),
        ({}, "midsize-eps", False),
    ],
)
def test_another_vehicle_than_the_recording_names_is_reported(metadata, judged_as, result):
    warning = other_vehicle(metadata, judged_as)
    assert (warning is not None) == result
    if result:
        assert "made with the vehicle 'steer-by-wire', but is judged as 'midsize-eps'" in warning
