"""What a monitor reads and estimates goes into a recording, sample by sample and whatever the cuts."""

import numpy as np

from tierod.monitors.diagnose import OverTime


def test_pieces_become_one_recording_of_the_signals_that_are_asked_for():
    time, speed = np.arange(100) / 10.0, np.linspace(0.0, 9.9, 100)
    kept = OverTime()
    for part in (slice(0, 30), slice(30, 31), slice(31, 100)):
        kept.add(time[part], {"speed": speed[part], "state": np.ones(100)[part], "withheld": speed[part]})
    recording = kept.recording({"speed": "m/s", "state": ""}, "tierod")
    assert set(recording.names) == {"speed", "state"}
    np.testing.assert_array_equal(recording["speed"].values, speed)
    np.testing.assert_array_equal(recording["speed"].time, time)
    assert (recording["speed"].unit, recording["speed"].source) == ("m/s", "tierod")
