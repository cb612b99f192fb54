"""Recordings and results in an S3 storage: a server of moto on this machine."""

from urllib.request import Request, urlopen

import pytest

from fleet.drives import DAY, NOVEMBER, Here, judged, written
from tierod.core.errors import InputError, OutputError
from tierod.fleet import fleet_file, levels
from tierod.fleet.places import place_of
from tierod.fleet.results import findings_of, ledger_of

pytest.importorskip("moto.server", reason="moto[server] is not installed")
s3fs = pytest.importorskip("s3fs", reason="s3fs is not installed")


@pytest.fixture
def storage(monkeypatch):
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer("127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    for name, value in {
        "AWS_ENDPOINT_URL": f"http://{host}:{port}",
        "AWS_ACCESS_KEY_ID": "test",
        "AWS_SECRET_ACCESS_KEY": "test",
        "AWS_DEFAULT_REGION": "us-east-1",
        "NO_PROXY": "127.0.0.1",
    }.items():
        monkeypatch.setenv(name, value)
    s3fs.S3FileSystem.clear_instance_cache()
    urlopen(Request(f"http://{host}:{port}/moto-api/reset", method="POST")).close()
    made = s3fs.S3FileSystem()
    made.mkdir("drives")
    made.mkdir("results")
    yield made
    s3fs.S3FileSystem.clear_instance_cache()
    server.stop()


def test_recordings_and_results_lie_in_a_bucket(storage, tmp_path):
    for number in (1, 2):
        written(tmp_path / f"{number}.parquet", seed=number, start=NOVEMBER + number * DAY)
        storage.put(str(tmp_path / f"{number}.parquet"), f"drives/2026/car-{number}/{number}.parquet")
    storage.pipe_file("drives/2026/car-1/torn.parquet", b"PAR1 torn PAR1")
    storage.pipe_file("drives/2026/readme.md", b"not a recording")
    (tmp_path / "fleet.toml").write_text(
        "[[recordings]]\npattern = '/(?P<vehicle>car-[0-9]+)/'\nparameters = 'midsize-eps'\n"
    )
    fleet = fleet_file.load(tmp_path / "fleet.toml")
    judged("s3://drives/2026/", "s3://results/fleet", fleet)
    found = findings_of("s3://results/fleet")
    assert found["vehicle"].to_pylist() == ["car-1", "car-2"]
    assert found["recording_name"].to_pylist()[0] == "s3://drives/2026/car-1/1.parquet"
    rows = ledger_of("s3://results/fleet").to_pylist()
    assert [(row["outcome"], row["reason"][:12]) for row in rows] == [
        ("judged", ""), ("failed", "s3://drives/"), ("judged", "")]  # fmt: skip
    zoomed = levels.zoom("s3://results/fleet", found["key"][0].as_py(), "enabled")
    assert len(zoomed) > 30
    local = tmp_path / "here"
    judged(tmp_path / "*.parquet", local, fleet_file.one_vehicle("midsize-eps"))
    for column in ("estimate", "deviation", "status", "recording"):
        assert findings_of(local)[column].equals(found[column])
    workers = Here()
    judged("s3://drives/2026/**/*.parquet", "s3://results/fleet", fleet, workers=workers)
    assert workers.tasks == []


def test_a_bucket_that_is_not_there_is_one_sentence(storage, tmp_path):
    with pytest.raises(InputError, match=r"s3://absent/x.* (cannot be read|no recording matches)"):
        judged("s3://absent/x/", tmp_path / "results")
    path = written(tmp_path / "a.parquet")
    with pytest.raises(OutputError, match="s3://absent/results/about.json cannot be written"):
        judged(path, "s3://absent/results")


def test_a_bucket_that_vanishes_ends_the_run_and_what_is_done_is_kept(storage, tmp_path):
    for number in (1, 2, 3):
        written(tmp_path / f"{number}.parquet", seed=number)
    place = place_of("s3://results/fleet")

    class Vanishing(Here):
        def run(self, work, tasks):
            for answer in super().run(work, tasks):
                yield answer
                kept.update({name: storage.cat_file(name) for name in storage.find("results")})
                storage.rm("results", recursive=True)

    kept = {}
    with pytest.raises(OutputError, match=r"s3://results/fleet/.* cannot be written"):
        judged(tmp_path / "*.parquet", "s3://results/fleet", workers=Vanishing())
    storage.mkdir("results")
    for name, content in kept.items():
        storage.pipe_file(name, content)
    judged(tmp_path / "*.parquet", "s3://results/fleet")
    assert len(findings_of("s3://results/fleet")) == 3
    assert len(place.files("parts", ".arrow")) == 3
