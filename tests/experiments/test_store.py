"""The folder of a campaign: what is whole is found again, everything else is not."""

import json
import subprocess
import sys

import numpy as np
import pytest

from tierod.core.errors import OutputError
from tierod.core.recording import Channel, Recording
from tierod_lab.campaign.store import Store, slug

KEY = "0123456789abcdef" * 4


@pytest.fixture
def store(tmp_path):
    store = Store(tmp_path / "runs")
    store.prepare()
    return store


def recording():
    time = np.arange(50) / 10.0
    channels = [Channel("yaw_rate", time, np.sin(time), "rad/s"), Channel("truth_x", time[::2], time[::2] ** 2, "N*m")]
    return Recording({channel.name: channel for channel in channels}, {"seed": 3})


@pytest.mark.parametrize("damage", [lambda text: text[:40], lambda text: "", lambda text: "[]", lambda text: "{}",
                                    lambda text: text.replace("drive/1", "drive/0")])  # fmt: skip
def test_a_damaged_record_does_not_count(store, damage):
    store.keep_drive("a", KEY, {"outcome": "driven"})
    assert store.drive("a", KEY)["outcome"] == "driven"
    path = next((store.folder / "drives").iterdir())
    path.write_text(damage(path.read_text()))
    assert store.drive("a", KEY) is None


def test_a_recording_that_is_gone_cut_or_changed_does_not_count(store):
    drive = {"recording": store.keep_recording("a", KEY, recording())}
    path = store.folder / drive["recording"]["file"]
    whole = path.read_bytes()
    assert store.recording(drive).names == recording().names
    path.write_bytes(whole[:-1])
    assert not store.has_recording(drive)
    path.write_bytes(whole[:-1] + b"x")
    assert store.recording(drive) is None
    path.unlink()
    assert not store.has_recording(drive)
    assert store.recording(drive) is None
    assert not store.has_recording({"recording": None})


def test_what_a_killed_process_left_is_removed_and_nothing_else(store):
    left = store.folder / "verdicts" / ".a-0123456789ab.0a1b2c3d4e5f.json"
    own = store.folder / ".notes.json"
    for path in (left, own):
        path.write_text(json.dumps({}))
    store.prepare()
    assert left.exists()
    with store.alone():
        assert not left.exists()
    assert own.exists()


def test_one_campaign_at_a_time_in_a_folder_until_its_process_ends(store):
    code = (
        "import os, sys, pathlib; from tierod_lab.campaign.store import Store\n"
        "with Store(pathlib.Path(sys.argv[1])).alone(): os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", code, store.folder], check=False).returncode == 9
    with store.alone(), pytest.raises(OutputError, match="another campaign is running in"), Store(store.folder).alone():
        pass
    with store.alone():
        pass


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be used .*name another one with --output"):
        Store(tmp_path / "file" / "runs").prepare()


def test_names_of_files_are_safe_and_short():
    assert slug({"vehicle": "mid size/../x", "size": 1.5, "friction": "+2 N*m"}) == "mid-size-..-x_1.5_+2-N-m"
    assert len(slug({"a": "x" * 500})) == 120
    assert slug({"a": "***"}) == "0"
