import numpy as np
import pytest

from tierod.errors import InputError, ParameterError
from tierod.monitors.named_vehicle import other_vehicle, vehicle_named_in
from tierod.proving_ground.cars.catalogue import shipped as cars
from tierod.recording import Channel, Recording
from tierod.vehicles import shipped
from tierod.writers import write


def recording(**metadata):
    time = np.arange(100) * 0.01
    return Recording({"yaw_rate": Channel("yaw_rate", time, np.sin(time), "rad/s")}, metadata)


def test_a_virtual_car_is_judged_with_the_vehicle_of_its_name(tmp_path):
    made = recording(virtual_car="midsize-eps", vehicle={"mass": 1600.0})
    assert vehicle_named_in(made) == "midsize-eps"
    path = tmp_path / "drive.parquet"
    write(made, path)
    assert vehicle_named_in(path) == "midsize-eps"


@pytest.mark.parametrize(
    ("metadata", "sentence"), [({}, "names none"), ({"virtual_car": "my-car"}, "names 'my-car', which tierod does not")]
)
def test_where_it_names_none_that_is_shipped_the_user_must(metadata, sentence):
    with pytest.raises(ParameterError, match=sentence):
        vehicle_named_in(recording(**metadata))


def test_a_file_that_is_not_there_is_told_as_such(tmp_path):
    with pytest.raises(InputError, match="there is no file"):
        vehicle_named_in(tmp_path / "absent.parquet")


def test_a_file_that_cannot_be_read_is_told_as_such(tmp_path):
    path = tmp_path / "empty.mf4"
    path.touch()
    with pytest.raises(InputError, match="empty.mf4 is empty"):
        vehicle_named_in(path)


def test_some_virtual_cars_have_a_vehicle():
    assert {"midsize-eps", "column-bench"} <= set(cars()) & set(shipped())


@pytest.mark.parametrize(
    ("metadata", "judged_as", "told"),
    [
        ({"virtual_car": "steer-by-wire"}, "midsize-eps", True),
        ({"vehicle": "steer-by-wire"}, "midsize-eps", True),
        ({"virtual_car": "steer-by-wire", "vehicle": {"mass": 1640.0}}, "steer-by-wire", False),
        ({"virtual_car": "my-car"}, "midsize-eps", False),
        ({}, "midsize-eps", False),
    ],
)
def test_another_vehicle_than_the_recording_names_is_told(metadata, judged_as, told):
    warning = other_vehicle(metadata, judged_as)
    assert (warning is not None) == told
    if told:
        assert "made with the vehicle 'steer-by-wire', but is judged as 'midsize-eps'" in warning
