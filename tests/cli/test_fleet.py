"""`tierod fleet`: arguments, what is shown, JSON, exit codes, and an end in the middle."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from experiments.worker_tasks import environment
from fleet.drives import DAY, NOVEMBER, written
from tierod.cli import main
from tierod.fleet.results import findings_of, ledger_of


@pytest.fixture
def drives(tmp_path):
    for seed in (1, 2):
        written(tmp_path / f"drives/{seed}.parquet", seed=seed, start=NOVEMBER + seed * DAY)
    (tmp_path / "drives/torn.parquet").write_bytes(b"PAR1 torn PAR1")
    return tmp_path


def fleet(*arguments):
    return main(["fleet", *map(str, arguments)])


def test_a_folder_is_judged_and_shown(drives, capsys):
    arguments = (drives / "drives", "--vehicle", "midsize-eps", "-o", drives / "results", "--monitor", "friction")
    assert fleet(*arguments, "--workers", 2) == 0
    shown = capsys.readouterr()
    assert "3 recordings: 2 judged, 1 failed" in shown.out
    assert "friction  ? NOT READY         2" in shown.out
    assert "torn.parquet" in shown.out
    assert "3 of 3 recordings" in shown.err
    assert fleet(*arguments, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["recordings"] == {"found": 3, "kept": 3, "judged": 2, "failed": 1}
    assert document["statuses"] == {"friction": {"not ready": 2}}
    assert len(findings_of(drives / "results")) == 2


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_a_run_that_is_stopped_goes_on_where_it_was(tmp_path, how):
    for number in range(3):
        written(tmp_path / f"drives/{number}.parquet", seed=1 + number % 2, start=NOVEMBER + number * DAY)
    command = [sys.executable, "-m", "tierod", "fleet", tmp_path / "drives", "--vehicle", "midsize-eps", "-o",
               tmp_path / "results", "--monitor", "friction", "--workers", "1"]  # fmt: skip
    stopped = subprocess.Popen(command, env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + 60.0
    while not list((tmp_path / "results").rglob("*.arrow")):
        assert time.monotonic() < end
        time.sleep(0.01)
    stopped.send_signal(how)
    errors = stopped.communicate()[1]
    assert stopped.returncode == (-9 if how == signal.SIGKILL else 130)
    assert "Traceback" not in errors
    if how != signal.SIGKILL:
        assert "recordings are finished and kept in" in errors
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "results/parts").rglob("*.arrow")}
    assert main([str(each) for each in command[3:]]) == 0
    assert all(path.stat().st_mtime_ns == before for path, before in kept.items())
    assert len(findings_of(tmp_path / "results")) == 3
    assert {row["outcome"] for row in ledger_of(tmp_path / "results").to_pylist()} == {"judged"}


def test_a_name_that_is_not_utf_8_costs_no_other_recording(drives, capsys):
    named = drives / "drives" / os.fsdecode(b"M\xfcller.parquet")
    named.write_bytes((drives / "drives/1.parquet").read_bytes())
    (drives / "drives/1.parquet").unlink()
    arguments = (drives / "drives", "--vehicle", "midsize-eps", "-o", drives / "results", "--monitor", "friction")
    for kept in (0, 3):
        assert fleet(*arguments, "--workers", 1, "--json") == 0
        assert json.loads(capsys.readouterr().out)["recordings"] == {"found": 3, "kept": kept, "judged": 2, "failed": 1}
    names = findings_of(drives / "results")["recording_name"].to_pylist()
    assert [name.rpartition("/")[2] for name in names] == [r"M\udcfcller.parquet", "2.parquet"]
    assert fleet("report", drives / "results", "--json") == 2
    json.loads(capsys.readouterr().out.encode())
    given = drives / "drives" / os.fsdecode(b"M\xfc*")
    assert fleet(given, "--vehicle", "midsize-eps", "-o", drives / "results", "--monitor", "friction", "--json") == 0
    assert json.loads(capsys.readouterr().out)["recordings"]["kept"] == 1
