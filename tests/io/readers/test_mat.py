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


def _structures(kind, time, signals):
    """Variables of one recording as Simulink, its scope, ControlDesk and level 4 store them."""
    if kind == "level 4":
        return {"t": time, **signals}, {"format": "4"}
    if kind == "time series":
        return {"logsout": {n: {"Time": time, "Data": v.reshape(-1, 1)} for n, v in signals.items()}}, {}
    if kind == "time of each":
        return {**signals, **{f"{n}_time": time + at for at, n in enumerate(signals)}}, {}
    columns = {name: values.reshape(-1, 1) for name, values in signals.items()}
    if kind == "structure with time":
        return {n: {"time": time, "signals": {"values": v, "label": n}} for n, v in columns.items()}, {}
    kinds = ("values", "label") if kind == "scope" else ("Data", "Name")
    table = np.zeros((1, len(signals)), dtype=[(name, object) for name in kinds])
    for at, (name, values) in enumerate(columns.items()):
        table[0, at] = (values, name)
    if kind == "scope":
        return {"ScopeData": {"time": time, "signals": table}}, {}
    return {"rec": {"X": {"Name": "", "Data": time}, "Y": table}}, {}


@pytest.mark.parametrize(
    "kind", ["structure with time", "scope", "ControlDesk", "level 4", "time series", "time of each"]
)
def test_structures_with_names_and_times_in_fields(tmp_path, kind):
    time = np.arange(0, 20, 0.01)
    signals = {"steering_wheel_angle": 0.5 * np.sin(time), "yaw_rate": 0.1 * np.sin(time), "vehicle_speed": 15 + time}
    variables, options = _structures(kind, time, signals)
    path = tmp_path / "drive.mat"
    scipy.io.savemat(path, variables, **options)
    found = read(path)
    for name, values in signals.items():
        own = list(signals).index(name) if kind == "time of each" else 0
        assert found[name].time == pytest.approx(time + own)
        assert found[name].values == pytest.approx(values)


def test_signals_of_one_label_and_columns_of_a_matrix_are_all_read(tmp_path):
    table = np.zeros((1, 2), dtype=[("values", object), ("label", object)])
    table[0, 0], table[0, 1] = (TIME, "a"), (np.column_stack([TIME + 1, TIME + 2]), "a")
    saved(tmp_path, x={"time": TIME, "signals": table}, rest=np.arange(7.0))
    found = read(tmp_path / "drive.mat")
    assert [each.values[0] - TIME[0] for each in found.channels.values()] == pytest.approx([0, 1, 2])
    assert "vectors without a time of their length were left out: 1 (rest)" in " ".join(found.warnings)
