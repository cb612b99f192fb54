"""Descriptions that tierod wrote into its files: damaged ones cost their units, never the program."""

import json

import numpy as np
import pytest

from tierod import read
from tierod.core.recording import Channel, Recording
from tierod.io.formats import DAMAGED, description_in
from tierod.io.writers import write

WHOLE = {
    "layout": 1,
    "origin": 0.0,
    "clocks": [{"time": "time", "channels": ["yaw_rate"]}],
    "channels": {"yaw_rate [rad/s]": {"unit": "rad/s", "source": "imu", "note": "", "name": "yaw_rate"}},
    "metadata": {"warnings": ["cut"]},
}

CHANNEL = WHOLE["channels"]["yaw_rate [rad/s]"]

BROKEN = (
    [],
    "text",
    WHOLE | {"channels": []},
    WHOLE | {"channels": {"yaw_rate [rad/s]": {}}},
    WHOLE | {"channels": {"yaw_rate [rad/s]": "rad/s"}},
    WHOLE | {"channels": {"yaw_rate [rad/s]": CHANNEL | {"name": ["yaw_rate"]}}},
    WHOLE | {"channels": {"yaw_rate [rad/s]": {key: CHANNEL[key] for key in ("source", "note")}}},
    WHOLE | {"channels": {"yaw_rate [rad/s]": CHANNEL | {"unit": 3}}},
    WHOLE | {"channels": {"yaw_rate [rad/s]": CHANNEL | {"note": None}}},
    WHOLE | {"origin": "now"},
    WHOLE | {"origin": float("inf")},
    WHOLE | {"metadata": ["cut"]},
    WHOLE | {"metadata": {"warnings": 3}},
    WHOLE | {"metadata": {"warnings": [["cut"]]}},
    WHOLE | {"clocks": {}},
    WHOLE | {"clocks": ["time"]},
    WHOLE | {"clocks": [{"time": 3, "channels": []}]},
    WHOLE | {"clocks": [{"time": "time", "channels": "yaw_rate"}]},
)


def test_a_whole_description_is_taken_as_it_is():
    assert description_in(json.dumps(WHOLE)) == WHOLE


@pytest.mark.parametrize("about", BROKEN, ids=lambda about: json.dumps(about)[:60])
def test_a_table_with_a_broken_description_is_read_without_it(tmp_path, about):
    rows = "".join(f"{0.01 * place:.2f},{0.1 * (place % 7):.1f}\n" for place in range(50))
    (tmp_path / "a.csv").write_text(f"# tierod {json.dumps(about)}\ntime [s],yaw_rate [rad/s]\n{rows}")
    recording = read(tmp_path / "a.csv")
    assert recording["yaw_rate"].unit == "rad/s"
    assert any(DAMAGED in warning for warning in recording.warnings)


@pytest.mark.parametrize("about", BROKEN, ids=lambda about: json.dumps(about)[:60])
def test_a_parquet_file_with_a_broken_description_is_read_without_it(tmp_path, about):
    import pyarrow.parquet as pq

    channel = Channel("yaw_rate", 0.01 * np.arange(50), np.arange(50.0) % 7, "rad/s")
    write(Recording({"yaw_rate": channel}), tmp_path / "a.parquet")
    table = pq.read_table(tmp_path / "a.parquet")
    pq.write_table(table.replace_schema_metadata({"tierod": json.dumps(about)}), tmp_path / "a.parquet")
    assert read(tmp_path / "a.parquet")["yaw_rate"].unit == "rad/s"
