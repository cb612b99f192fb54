"""Estimates in levels: nothing is hidden, and a zoom reads little."""

import numpy as np
import pyarrow.parquet as pq
import pytest

from fleet.drives import judged, written
from tierod.core.errors import InputError
from tierod.core.findings import Trace
from tierod.fleet import levels
from tierod.fleet.results import findings_of


def trace(count, width=0.5, name="torque"):
    time = width * np.arange(count)
    values = np.sin(0.01 * time)
    values[count // 2] = 7.0
    return Trace(name, "N*m", time, values - 1.0, values + 1.0, values)


def test_the_levels_of_a_trace_keep_its_extremes():
    made = levels.pyramid(trace(40000))
    assert [len(each.time) for each in made] == [20, 79, 313, 1250, 5000, 20000]
    assert [np.diff(each.time)[0] for each in made] == [1024.0, 256.0, 64.0, 16.0, 4.0, 1.0]
    assert {float(np.nanmax(each.upper)) for each in made} == {8.0}


def kept(folder, traces):
    path = folder / levels.path_of("ab12")
    path.parent.mkdir(parents=True)
    path.write_bytes(levels.content_of({"friction": {each.name: each for each in traces}}))
    return path


def test_a_zoom_reads_the_coarsest_level_that_is_fine_enough(tmp_path, monkeypatch):
    path = kept(tmp_path, [trace(40000), trace(40000, name="angle")])
    whole = levels.zoom(tmp_path, "ab12", "torque", points=60)
    assert (whole["level"][0].as_py(), len(whole)) == (1, 79)
    read, original = [], pq.ParquetFile.read_row_groups

    def counted(file, groups):
        read.extend(groups)
        return original(file, groups)

    monkeypatch.setattr(pq.ParquetFile, "read_row_groups", counted)
    part = levels.zoom(tmp_path, "ab12", "torque", 10000.0, 10060.0, points=50)
    assert (part["level"][0].as_py(), len(part), part["time_s"][0].as_py()) == (5, 60, 10000.0)
    assert max(part["upper"].to_pylist()) == 8.0
    assert len(read) < pq.ParquetFile(path).metadata.num_row_groups / 2


def test_what_is_not_there_is_named(tmp_path):
    kept(tmp_path, [trace(100)])
    with pytest.raises(InputError, match="no estimate 'angle'"):
        levels.zoom(tmp_path, "ab12", "angle")
    with pytest.raises(InputError, match="without --no-levels"):
        levels.zoom(tmp_path, "cd34", "angle")


def test_a_run_keeps_the_estimates_of_its_monitors(tmp_path):
    written(tmp_path / "a.parquet")
    judged(tmp_path / "a.parquet", tmp_path / "results")
    (key,) = findings_of(tmp_path / "results")["key"].to_pylist()
    found = levels.zoom(tmp_path / "results", key, "enabled")
    assert found["monitor"][0].as_py() == "friction"
    assert 30 <= len(found) <= 41
    judged(tmp_path / "a.parquet", tmp_path / "without", with_levels=False)
    assert not (tmp_path / "without/levels").exists()
