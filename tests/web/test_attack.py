"""Two thousand mutated requests: nothing is read, written or run that was not served, and nothing ends with a 500."""

import json

import numpy as np
import pytest

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


def test_a_hostile_name_stays_a_text(client, analysed):
    name = "<img src=x onerror=alert(1)>.csv"
    path = analysed.folder / name
    path.write_text("time,a\n0,1\n")
    try:
        entries = client.get("/api/files", params={"folder": "drives"}).json()["entries"]
        assert name in [each["name"] for each in entries]
    finally:
        path.unlink()
