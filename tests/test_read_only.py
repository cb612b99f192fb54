"""Samples may be views of a file that cannot be written: nothing on their way writes to them or copies them."""

import numpy as np
import pytest

from blocks_of_graph import Everything
from tierod.core import frames as arrow
from tierod.core.decimation import Decimator
from tierod.core.graph import batch, scan
from tierod.core.graph.runtime import Memory
from tierod.core.recording import Channel, Recording
from tierod.io.derive import complete
from tierod.io.quality import channel_quality
from tierod.io.readers import open_chunks, read
from tierod.io.signs import sign_warnings
from tierod.io.writers import write

TIME = np.arange(0.0, 300.0, 0.01)
UNITS = {
    "steering_wheel_angle": "rad",
    "yaw_rate": "rad/s",
    "lateral_acceleration": "m/s**2",
    "wheel_speed_rear_left": "m/s",
    "wheel_speed_rear_right": "m/s",
}


def drive() -> Recording:
    channels = (Channel(name, TIME, 10.0 + np.sin(0.7 * TIME), unit) for name, unit in UNITS.items())
    return Recording({channel.name: channel for channel in channels})


def frozen(values: np.ndarray) -> np.ndarray:
    view = values.view()
    view.flags.writeable = False
    return view


def read_only(recording: Recording) -> Recording:
    channels = (
        Channel(name, frozen(channel.time), frozen(channel.values), channel.unit)
        for name, channel in recording.channels.items()
    )
    return Recording({channel.name: channel for channel in channels})


@pytest.fixture
def file(tmp_path, monkeypatch):
    """A Parquet file whose columns come as memory that cannot be written."""
    write(drive(), tmp_path / "drive.parquet")
    memory = arrow._memory
    monkeypatch.setattr(arrow, "_memory", lambda chunk, kind: frozen(memory(chunk, kind)))
    return tmp_path / "drive.parquet"


def test_values_pass_from_the_file_into_slices_without_a_copy(file):
    slices = list(open_chunks(file, seconds=100.0))
    assert sum(len(part["yaw_rate"].time) for part in slices) == len(TIME)
    assert all(not part[name].values.flags.writeable for part in slices[:1] for name in UNITS)
    assert all(not part["yaw_rate"].time.flags.writeable for part in slices[:1])


def test_derived_signals_of_slices_agree_with_the_whole(file):
    names = (*UNITS, "vehicle_speed", "steering_wheel_rate")
    whole = complete(drive(), names)
    slices = list(open_chunks(file, names=names, seconds=100.0))
    for name in names:
        joined = np.concatenate([part[name].values for part in slices])
        assert np.array_equal(joined, whole[name].values, equal_nan=True)


def test_everything_that_looks_at_a_recording_takes_it(tmp_path):
    free, locked = drive(), read_only(drive())
    assert sign_warnings(locked) == sign_warnings(free)
    for name in UNITS:
        assert channel_quality(locked[name]) == channel_quality(free[name])
        assert np.array_equal(locked.retime(0.01)[name].time, free.retime(0.01)[name].time)
        for method in ("hold", "linear"):
            aligned = (recording.align([name], 33.0, method) for recording in (locked, free))
            assert np.array_equal(*(one.values for one in aligned), equal_nan=True)
    write(locked, tmp_path / "again.parquet")
    assert np.array_equal(read(tmp_path / "again.parquet")["yaw_rate"].values, free["yaw_rate"].values)


def test_traces_agree():
    free, locked = Decimator("yaw_rate", "rad/s"), Decimator("yaw_rate", "rad/s")
    for time, values in zip(np.array_split(TIME, 3), np.array_split(drive()["yaw_rate"].values, 3), strict=True):
        free.add(time, values)
        locked.add(frozen(time), frozen(values))
    for edge in ("time", "lower", "upper", "mean"):
        assert np.array_equal(getattr(free.trace(), edge), getattr(locked.trace(), edge))


@pytest.mark.parametrize("engine", ["compiled", "virtual machine"])
def test_blocks_run_on_it_and_leave_it_as_it_is(engine):
    samples = np.random.default_rng(5).normal(size=(500, 2))
    locked = frozen(samples.copy())
    expected = scan(Everything(), samples, engine=engine)
    found = scan(Everything(), locked, engine=engine)
    assert np.array_equal(found.values, expected.values)
    assert np.array_equal(locked, samples)
    again = scan(Everything(), locked, Memory(frozen(expected.state.values), expected.state.count), engine=engine)
    assert np.array_equal(again.values, scan(Everything(), samples, expected.state, engine=engine).values)


def test_batches_run_on_it():
    samples = [np.random.default_rng(seed).normal(size=(50, 2)) for seed in range(20)]
    expected = batch(Everything(), samples)
    found = batch(Everything(), [frozen(part) for part in samples])
    assert all(np.array_equal(one.values, other.values) for one, other in zip(found, expected, strict=True))
