import os

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.io.writers import write
from tierod.monitors.acceptance import other_vehicle, vehicle_named_in
from tierod.monitors.diagnose import diagnose
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
