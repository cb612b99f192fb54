"""Playing a recording: what is encoded is decoded again, and what goes wrong follows from the seed."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from live_drives import drive, frames_of_drive, messages
from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.io.readers.channel_map import parse_channel_map
from tierod.io.writers import write
from tierod.live.decoding import Decoder
from tierod.live.frame import frames_of
from tierod.live.log import FrameLog
from tierod.live.replay import Disturbance, Played, disturbed, encoded, frames_of_file

pytest.importorskip("cantools")
can = pytest.importorskip("can")


def decoded(folder, frames, name):
    decoder = Decoder(messages(folder))
    arrays = frames_of(frames, 0.0)
    decoder.hear(arrays)
    (channel,) = decoder.channels(arrays, [name])
    return channel


@pytest.mark.parametrize(
    ("column", "name", "step"),
    [("EPS.steering_wheel_angle", "steering_wheel_angle", 5e-4), ("ESP.yaw_rate", "yaw_rate", 1e-4)],
)
def test_signals_come_back_within_half_a_step_of_their_bits(tmp_path, column, name, step):
    frames = frames_of_drive(tmp_path, 3.0)
    found = decoded(tmp_path, frames, column)
    np.testing.assert_allclose(found.values, drive(3.0)[name].values, atol=0.51 * step)
    times = drive(3.0)[name].time - min(each.time[0] for each in drive(3.0).channels.values())
    np.testing.assert_allclose(found.time - frames[0].time, times, atol=1e-6)


def test_a_channel_map_is_undone(tmp_path):
    entry = {"source": "ESP.lateral_acceleration", "sign": -1, "factor": 2.0, "unit": "m/s**2"}
    chosen = parse_channel_map({"signals": {"longitudinal_acceleration": entry}}, "map")
    values = drive(1.0)["lateral_acceleration"]
    recording = Recording({"longitudinal_acceleration": replace(values, name="longitudinal_acceleration")})
    write(recording, tmp_path / "one.parquet")
    frames = list(encoded(tmp_path / "one.parquet", messages(tmp_path), chosen))
    found = decoded(tmp_path, frames, "ESP.lateral_acceleration")
    np.testing.assert_allclose(found.values, values.values / -2.0, atol=6e-4)


def test_a_bus_log_is_played_as_it_is(tmp_path):
    frames = frames_of_drive(tmp_path, 1.0)
    log = FrameLog(tmp_path / "log.mf4", 0.0)
    log.append(frames)
    log.finish()
    again = list(frames_of_file(tmp_path / "log.mf4", [], None))
    assert [(each.identifier, each.data) for each in again] == [(each.identifier, each.data) for each in frames]
    assert again[0].time == 0.0


def test_a_recording_without_signals_of_the_database_is_refused(tmp_path):
    (tmp_path / "other.csv").write_text("time,foo\n0,1\n0.1,2\n0.2,3\n")
    with pytest.raises(InputError, match="has no signal of the databases"):
        list(encoded(tmp_path / "other.csv", messages(tmp_path), None))


def test_the_same_seed_gives_the_same_disturbance(tmp_path):
    frames = frames_of_drive(tmp_path, 10.0)
    how = Disturbance(7, loss=0.05, doubled=0.02, jitter=0.001, reordered=0.03, bus_off=20.0)
    first, second, third = Played(), Played(), Played()
    one = list(disturbed(iter(frames), how, first))
    assert one == list(disturbed(iter(frames), how, second))
    assert first == second
    other = list(disturbed(iter(frames), Disturbance(8, 0.05, 0.02, 0.001, 0.03, 20.0), third))
    assert other != one
    assert len(one) == len(frames) - first.lost + first.doubled
    assert first.off >= 1
    assert 0.03 * len(frames) < first.held < 0.05 * len(frames) or first.held > 0
    assert [each.time for each in one] == sorted(each.time for each in one)
    kept = Counter(each.data for each in frames)
    assert all(each.data in kept for each in one)


def test_nothing_goes_wrong_unless_asked(tmp_path):
    frames = frames_of_drive(tmp_path, 1.0)
    assert list(disturbed(iter(frames), Disturbance(), Played())) == frames
