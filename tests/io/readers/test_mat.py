"""MATLAB files: vectors, structures, sampling periods, and what has no time."""

import numpy as np
import pytest
import scipy.io

from tierod.core.errors import InputError
from tierod.io.readers import read

TIME = np.arange(0.0, 1.0, 0.01)


def saved(tmp_path, **content):
    path = tmp_path / "drive.mat"
    scipy.io.savemat(path, content)
    return path


def test_vectors_beside_a_time(tmp_path):
    path = saved(tmp_path, t=TIME, yaw_rate=TIME, other=np.arange(7), text="words", matrix=np.ones((3, 3)))
    recording = read(path)
    assert recording.names == ("yaw_rate",)
    assert np.array_equal(recording["yaw_rate"].time, TIME)


def test_a_structure_with_a_period(tmp_path):
    recording = read(saved(tmp_path, rec={"Ts": 0.5, "speed": np.arange(4.0), "note": "x"}))
    assert recording["vehicle_speed"].time.tolist() == [0.0, 0.5, 1.0, 1.5]
    assert recording["vehicle_speed"].source == "rec.speed"


def test_structures_within_structures(tmp_path):
    recording = read(saved(tmp_path, log={"fast": {"t": TIME, "ay": TIME}, "slow": {"time": TIME[:5], "vx": TIME[:5]}}))
    assert len(recording["lateral_acceleration"].time) == 100
    assert len(recording["vehicle_speed"].time) == 5


def test_general_words_in_one_of_several_structures_are_not_taken_for_the_vehicle(tmp_path):
    both = {"engine": {"t": TIME, "speed": TIME}, "eps": {"t": TIME, "driver_torque": TIME}}
    assert read(saved(tmp_path, **both)).names == ("engine.speed", "driver_torque")


def test_no_time(tmp_path):
    with pytest.raises(InputError, match="no vectors beside a time vector; save a vector 'time' in seconds"):
        read(saved(tmp_path, speed=TIME))
