"""Endpoints over an analysed recording: signals, stretches, exports, findings, reports."""

import io
import json
import re
import struct

import numpy as np
import pyarrow.csv
import pyarrow.parquet as pq
import pytest

from live_drives import drive
from tierod.monitors.diagnose import diagnose

FILE = "drives/weave.parquet"


def unpacked(content):
    (length,) = struct.unpack_from("<I", content)
    place, found = 4 + length, {}
    for each in json.loads(content[4:place]):
        count = each["count"]
        time = np.frombuffer(content, "<f8", count, place)
        place += 8 * count
        lower = np.frombuffer(content, "<f4", count, place)
        place += 4 * count
        upper = lower
        if not each["exact"]:
            upper = np.frombuffer(content, "<f4", count, place)
            place += 4 * count
        place += -place % 8
        found[each["name"]] = time, lower, upper
    assert place == len(content)
    return found


def test_the_list_names_what_is_analysed(client):
    assert [each["name"] for each in client.get("/api/files").json()["entries"]] == ["drives", "uploads"]
    entries = client.get("/api/files", params={"folder": "drives"}).json()["entries"]
    assert [(each["name"], each["folder"], each["analysed"]) for each in entries] == [
        ("deep", True, False),
        ("weave.parquet", False, True),
    ]
    assert client.get("/api/files", params={"folder": "drives/.."}).status_code == 404


def test_signals_come_with_unit_and_meaning(client, analysed):
    found = client.get(f"/api/series/{analysed.series}").json()
    by_name = {each["name"]: each for each in found["signals"]}
    angle = by_name["steering_wheel_angle"]
    assert (angle["label"], angle["group"]) == ("°", "Steering")
    assert angle["factor"] == pytest.approx(57.29578)
    assert by_name["slow"]["group"] == "Other channels"
    assert found["span"][1] == pytest.approx(40.0, abs=0.1)


def test_a_packet_holds_what_was_recorded(client, analysed):
    names = ["driver_torque", "yaw_rate", "slow"]
    answer = client.get(f"/api/series/{analysed.series}/window", params={"name": names, "points": 10_000})
    recorded = drive(40.0)
    for name, (time, lower, upper) in unpacked(answer.content).items():
        if name in recorded:
            np.testing.assert_array_equal(time, recorded[name].time)
            np.testing.assert_array_equal(lower, recorded[name].values.astype("f4"))
        assert lower is upper
    coarse = unpacked(client.get(f"/api/series/{analysed.series}/window", params={"name": names, "points": 50}).content)
    time, lower, upper = coarse["driver_torque"]
    assert len(time) <= 102
    assert upper.max() == pytest.approx(recorded["driver_torque"].values.max(), rel=1e-6)
    assert lower.min() == pytest.approx(recorded["driver_torque"].values.min(), rel=1e-6)


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_an_export_holds_every_sample_of_the_stretch(client, analysed, kind):
    parameters = {"name": ["driver_torque"], "start": 10.0, "stop": 20.0, "kind": kind}
    answer = client.get(f"/api/series/{analysed.series}/export", params=parameters)
    assert "attachment" in answer.headers["content-disposition"]
    content = io.BytesIO(answer.content)
    table = (
        pyarrow.csv.read_csv(content, pyarrow.csv.ReadOptions(skip_rows=1)) if kind == "csv" else pq.read_table(content)
    )
    recorded = drive(40.0)["driver_torque"]
    inside = recorded.values[(recorded.time >= 10.0) & (recorded.time <= 20.0)]
    column = next(name for name in table.column_names if "driver_torque" in name and "time" not in name)
    np.testing.assert_allclose(table[column].drop_null().to_numpy(), inside, rtol=1e-9)


def test_the_verdict_is_that_of_diagnose(client, analysed):
    found = client.get(f"/api/results/{analysed.result}").json()
    alone = diagnose(analysed.folder / "weave.parquet", "midsize-eps", "friction", spread=False)
    judged = found["monitors"]["friction"]["findings"][0]
    assert judged["status"] == str(alone.findings[0].status)
    assert judged["headline"] == alone.findings[0].headline
    assert judged["evidence"].keys() == alone.findings[0].evidence.keys()
    for name, value in alone.findings[0].evidence.items():
        assert judged["evidence"][name] == (pytest.approx(value) if np.isfinite(value) else None)
    assert "condition" in found["not_run"]
    assert found["path"] == "weave.parquet"


def test_estimates_are_signals_of_the_result(client, analysed):
    found = client.get(f"/api/results/{analysed.result}").json()
    by_name = {each["name"]: each for each in found["signals"]}
    angle = by_name["sideslip/sideslip_angle"]
    assert (angle["group"], angle["label"]) == ("Estimates of sideslip", "°")
    parameters = {"name": "sideslip/sideslip_angle", "result": analysed.result, "points": 10_000}
    packet = unpacked(client.get(f"/api/series/{analysed.series}/window", params=parameters).content)
    time, lower, _ = packet["sideslip/sideslip_angle"]
    alone = diagnose(analysed.folder / "weave.parquet", "midsize-eps", "sideslip", spread=False)
    last = alone.traces["sideslip_angle"]
    assert len(time) == angle["count"] > 1000
    assert lower[-1] == pytest.approx(last.mean[-1], rel=1e-5)


def test_a_report_runs_apart_from_the_page(client, analysed):
    answer = client.get(f"/api/results/{analysed.result}/report/friction")
    assert "<html" in answer.text
    assert answer.headers["content-security-policy"].startswith("sandbox allow-scripts")
    assert "allow-same-origin" not in answer.headers["content-security-policy"]
    assert client.get(f"/api/results/{analysed.result}/report/..%2Fresult").status_code == 404


def test_a_vehicle_shows_spread_and_origin(client):
    found = client.get("/api/vehicle").json()
    mass = next(each for each in found["parameters"] if each["name"] == "mass")
    assert mass["standard_deviation"] > 0.0
    assert mass["assumed"]
    assert client.get("/api/vehicle", params={"name": "/etc/passwd"}).status_code == 400


def test_an_upload_becomes_a_recording(client, bench):
    answer = client.post("/api/uploads?name=small.csv", content=b"time,yaw_rate\n0,1\n")
    assert answer.status_code == 201
    assert answer.json()["file"] == "uploads/small.csv"
    assert (bench.uploads / "small.csv").read_text() == "time,yaw_rate\n0,1\n"
    for name in ("../x.csv", "a/b.csv", ".hidden", "", "a\0b", "x" * 201, "..", "C:x"):
        assert client.post("/api/uploads", params={"name": name}, content=b"x").status_code in (403, 422)
    assert client.post("/api/uploads?name=empty.csv", content=b"").status_code == 400
    assert [each.name for each in bench.uploads.iterdir()] == ["small.csv"]


def test_what_was_swept_is_a_sentence(client, analysed, bench):
    import shutil

    shutil.rmtree(bench.store.path("series", analysed.series))
    answer = client.get(f"/api/series/{analysed.series}")
    assert answer.status_code == 404
    assert "open it again" in answer.json()["error"]
    assert client.get("/api/opened", params={"file": FILE}).json()["state"]["series"] == ""


def test_the_files_of_the_page_are_kept_under_their_content(client):
    html = client.get("/").text
    modules = re.findall(r'="(/static/[0-9a-f]{16}/[^"]+)"', html)
    assert {each.split("/")[-1] for each in modules} >= {"main.js", "page.css", "uPlot.iife.min.js"}
    for address in modules:
        answer = client.get(address)
        assert answer.status_code == 200
        assert "immutable" in answer.headers["cache-control"]
    plain = client.get("/static/main.js")
    assert plain.content == client.get(next(each for each in modules if each.endswith("/main.js"))).content
    assert plain.headers["cache-control"] == "no-cache"
    tag = {"if-none-match": plain.headers["etag"]}
    assert client.get("/static/main.js", headers=tag).status_code == 304
    assert client.get("/static/0123456789abcdef/main.js").status_code == 404


def test_a_recording_opens_with_its_signals_and_findings(client, analysed):
    found = client.get("/api/opened", params={"file": FILE}).json()
    assert found["series"] == client.get(f"/api/series/{analysed.series}").json()
    assert found["result"] == client.get(f"/api/results/{analysed.result}").json()
    assert client.get("/api/opened", params={"file": "drives/gone.parquet"}).status_code == 404


def test_what_another_version_has_kept_is_worked_out_anew(client, bench, monkeypatch):
    assert client.get("/api/opened", params={"file": FILE}).json()["state"]["series"] != ""
    monkeypatch.setattr("tierod.web.store.__version__", "0.0.1")
    assert client.get("/api/opened", params={"file": FILE}).json()["state"]["series"] == ""


TEXTS = ["", "a", "../../etc/passwd", "%2e%2e%2f", "\0", "\ud7ff", "x" * 5000, "<script>alert(1)</script>",
         "'; DROP TABLE", "-1", "1e999", "nan", "inf", "null", "[]", "{}", "drives/weave.parquet", "drives",
         "uploads/x", "/etc/passwd", "http://evil.com/", "file:///etc/passwd", "s3://bucket/x", "0x41", "\u202e",
         "é" * 300, "drives/deep/notes.txt"]  # fmt: skip

PARAMETERS = ["folder", "search", "sort", "offset", "count", "file", "name", "start", "stop", "points", "result",
              "kind", "vehicle", "state", "cohort", "token"]  # fmt: skip

VALUES = [None, True, -1, 0, 1e308, 2**70, "x", "", [], {}, ["x"], {"a": {"b": []}}, "../..", "x" * 3000]

CONTENTS = ["application/json", "text/plain", "multipart/form-data", ""]

METHODS = ["GET", "POST", "DELETE", "PUT", "HEAD", "OPTIONS", "PATCH"]

FIELDS = ["file", "vehicle", "channel_map", "spread", "scenario", "car", "course", "seconds", "seed", "faults", "other"]


def paths(analysed):
    series, result = f"/api/series/{analysed.series}", f"/api/results/{analysed.result}"
    return [
        "/", "/recording", "/nothing", "/static/main.js", "/static/../app.py", "/static/%2e%2e/app.py",
        "/static//etc/passwd", "/api/site", "/api/files", "/api/opened", "/api/analyses",
        "/api/proposals", "/api/inspections", "/api/uploads", "/api/jobs", "/api/jobs/x", "/api/scenarios",
        "/api/vehicle", "/api/fleets/x", "/api/fleets/x/cars", "/api/fleets/x/car", "/api/live",
        "/api/results/x", "/api/results/x/report/y", result, f"{result}/report/friction", "/api/series/x/window",
        series, *(f"{series}/{each}" for each in ("window", "export")),
    ]  # fmt: skip


def body_of(chance):
    kind = chance.integers(5)
    if kind == 0:
        return chance.bytes(int(chance.integers(200)))
    content = {str(chance.choice(FIELDS)): VALUES[chance.integers(len(VALUES))] for _ in range(chance.integers(4))}
    if kind == 1:
        content["file"] = "drives/deep/notes.txt"
        content["channel_map"] = {"signals": {"yaw_rate": VALUES[chance.integers(len(VALUES))]}}
    text = json.dumps(content)
    return {2: text[: len(text) // 2], 3: "[" * 3000}.get(kind, text).encode()


def snapshot(folder):
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*")}


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 4))])
def test_no_mutated_request_does_harm(client, bench, analysed, tmp_path, seed):
    chance = np.random.default_rng(seed)
    every, served = paths(analysed), snapshot(analysed.folder)
    page = client.get("/nothing").text
    for _ in range(500):
        path = str(chance.choice(every))
        method = str(chance.choice(METHODS, p=[0.5, 0.3, *5 * [0.04]]))
        query = [
            (str(chance.choice(PARAMETERS)), TEXTS[chance.integers(len(TEXTS))]) for _ in range(chance.integers(5))
        ]
        headers = {"content-type": str(chance.choice(CONTENTS))}
        if chance.random() < 0.1:
            headers |= {"range": "bytes=5-1,9-", "if-none-match": "*", "cookie": "tierod=\x7f; =;"}
        content = body_of(chance) if method in ("POST", "PUT", "PATCH") else None
        answer = client.request(method, path, params=query, headers=headers, content=content)
        assert answer.status_code < 500, (method, path, query, content, answer.text[:300])
        assert "root:" not in answer.text[:200]
        assert "Traceback" not in answer.text[:2000]
        if answer.status_code >= 400 and method != "HEAD":
            # An address without view is answered with the page, which is the same for all.
            alike = answer.status_code == 404 and answer.text == page and not path.startswith("/api/")
            assert alike or set(answer.json()) == {"error"}
    assert snapshot(analysed.folder) == served
    assert not any((bench.store.folder.parent / each).exists() for each in ("x", "x.csv"))
    asked = {job.given.get("path", "") for job in bench.jobs.all()}
    assert all(not each or each.startswith((str(analysed.folder), str(bench.uploads))) for each in asked)
