"""Recordings and results in a storage of fsspec: its file system in memory."""

import fsspec
import pytest

from fleet.drives import DAY, NOVEMBER, Here, judged, written
from tierod.core.errors import InputError, OutputError
from tierod.fleet import fleet_file, levels
from tierod.fleet.results import findings_of, ledger_of


@pytest.fixture
def storage():
    made = fsspec.filesystem("memory")
    yield made
    made.store.clear()
    made.pseudo_dirs[:] = [""]


def test_recordings_and_results_lie_in_a_storage(storage, tmp_path):
    for number in (1, 2):
        written(tmp_path / f"{number}.parquet", seed=number, start=NOVEMBER + number * DAY)
        storage.put(str(tmp_path / f"{number}.parquet"), f"drives/2026/car-{number}/{number}.parquet")
    storage.pipe_file("drives/2026/car-1/torn.parquet", b"PAR1 torn PAR1")
    storage.pipe_file("drives/2026/readme.md", b"not a recording")
    (tmp_path / "fleet.toml").write_text(
        "[[recordings]]\npattern = '/(?P<vehicle>car-[0-9]+)/'\nparameters = 'midsize-eps'\n"
    )
    fleet = fleet_file.load(tmp_path / "fleet.toml")
    judged("memory://drives/2026/", "memory://results/fleet", fleet)
    found = findings_of("memory://results/fleet")
    assert found["vehicle"].to_pylist() == ["car-1", "car-2"]
    assert found["recording_name"].to_pylist()[0] == "memory:///drives/2026/car-1/1.parquet"
    rows = ledger_of("memory://results/fleet").to_pylist()
    assert [(row["outcome"], row["reason"][:12]) for row in rows] == [
        ("judged", ""), ("failed", "memory:///dr"), ("judged", "")]  # fmt: skip
    zoomed = levels.zoom("memory://results/fleet", found["key"][0].as_py(), "enabled")
    assert len(zoomed) > 30
    local = tmp_path / "here"
    judged(tmp_path / "*.parquet", local, fleet_file.one_vehicle("midsize-eps"))
    for column in ("estimate", "deviation", "status", "recording"):
        assert findings_of(local)[column].equals(found[column])
    workers = Here()
    judged("memory://drives/2026/**/*.parquet", "memory://results/fleet", fleet, workers=workers)
    assert workers.tasks == []


def test_a_place_without_recordings_is_one_sentence(storage, tmp_path):
    with pytest.raises(InputError, match="memory://absent/x/ cannot be read|no recording matches memory://absent/x/"):
        judged("memory://absent/x/", tmp_path / "results")


def test_a_storage_that_vanishes_ends_the_run_and_what_is_done_is_kept(storage, tmp_path, monkeypatch):
    for number in (1, 2, 3):
        written(tmp_path / f"{number}.parquet", seed=number)

    def gone(*_, **__):
        raise PermissionError(13, "Access Denied")

    class Vanishing(Here):
        def run(self, work, tasks):
            for answer in super().run(work, tasks):
                yield answer
                monkeypatch.setattr(type(storage), "pipe_file", gone)

    with pytest.raises(OutputError, match=r"memory://results/fleet/.* cannot be written \(Access Denied"):
        judged(tmp_path / "*.parquet", "memory://results/fleet", workers=Vanishing())
    monkeypatch.undo()
    judged(tmp_path / "*.parquet", "memory://results/fleet")
    assert len(findings_of("memory://results/fleet")) == 3
    assert len(storage.glob("results/fleet/parts/**/*.arrow")) == 3
