"""Metadata of an MDF file beside its channels."""

import datetime
import time
import warnings

import numpy as np
import pytest

from tierod.io.readers import read

asammdf = pytest.importorskip("asammdf")


@pytest.mark.parametrize("zone", ["UTC", "Asia/Tokyo"])
def test_a_local_start_without_its_zone_means_the_same_everywhere(tmp_path, monkeypatch, zone):
    if not hasattr(time, "tzset"):
        pytest.skip("the time zone of a process cannot be set on this system")
    stamps = np.arange(5.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = asammdf.MDF(version="4.10")
        file.append(asammdf.Signal(stamps, stamps, name="yaw_rate", unit="rad/s"))
        file.header.start_time = datetime.datetime(2024, 1, 1, 12)
        file.save(tmp_path / "drive.mf4")
        file.close()
    monkeypatch.setenv("TZ", zone)
    time.tzset()
    try:
        recording = read(tmp_path / "drive.mf4")
    finally:
        monkeypatch.undo()
        time.tzset()
    assert recording.metadata["origin"] == datetime.datetime(2024, 1, 1, 12, tzinfo=datetime.UTC).timestamp()
    assert recording.metadata["start_time"] == "2024-01-01T12:00:00"
