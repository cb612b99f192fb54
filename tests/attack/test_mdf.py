"""Damaged MF4 files: native code that reads them may die of it, tierod says one sentence."""

import os
import re
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from can_logs import log_of
from tierod.core.errors import InputError, TierodError
from tierod.core.recording import Channel, Recording
from tierod.io.readers import read, reader_process
from tierod.io.readers.mdf import open_mdf
from tierod.io.readers.reader_process import Budget, MdfProcess
from tierod.io.writers import write

asammdf = pytest.importorskip("asammdf")

STAMPS = np.arange(0.0, 60.0, 0.01)


@pytest.fixture(scope="module")
def packed(tmp_path_factory) -> bytes:
    """A file with packed records."""
    folder = tmp_path_factory.mktemp("mdf")
    channels = (Channel(name, STAMPS, np.sin(STAMPS), "rad/s") for name in ("yaw_rate", "steering_wheel_rate"))
    write(Recording({channel.name: channel for channel in channels}), folder / "plain.mf4")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = asammdf.MDF(folder / "plain.mf4")
        file.save(folder / "packed.mf4", compression=2)
        file.close()
    return (folder / "packed.mf4").read_bytes()


def damaged(folder: Path, whole: bytes, block: bytes, offset: int) -> Path:
    """The file with two bytes of a block's header set to 255 and 201."""
    at = whole.index(block) + offset
    path = folder / "damaged.mf4"
    path.write_bytes(whole[:at] + b"\xff\xc9" + whole[at + 2 :])
    return path


def attempt(path: Path, dbc: str | None = None) -> tuple[Recording | None, str]:
    """The recording, or the sentence on why there is none."""
    try:
        return read(path, dbc=dbc), ""
    except TierodError as error:
        said = str(error)
    assert "\n" not in said
    return None, said


@pytest.mark.parametrize("offset", [28, 32, 35, 37, 39, 40, 46])
def test_a_packed_block_of_another_size_than_it_says(tmp_path, packed, offset):
    path = damaged(tmp_path, packed, b"##DZ", offset)
    recording, said = attempt(path)
    assert len(said) < 300
    if recording is not None:
        assert recording.warnings or np.array_equal(recording["yaw_rate"].values, np.sin(STAMPS))


def test_lost_records_are_remarked(tmp_path):
    stamps = np.arange(0.0, 600.0, 0.01)
    write(Recording({"yaw_rate": Channel("yaw_rate", stamps, stamps, "rad/s")}), tmp_path / "drive.mf4")
    whole = (tmp_path / "drive.mf4").read_bytes()
    at = whole.index(b"##DT") + 8
    size = int.from_bytes(whole[at : at + 8], "little") - 16 * 500
    (tmp_path / "drive.mf4").write_bytes(whole[:at] + size.to_bytes(8, "little") + whole[at + 8 :])
    recording = read(tmp_path / "drive.mf4")
    assert len(recording["yaw_rate"].time) == 59_500
    assert "the file is damaged: 500 of 60000 samples of 'yaw_rate' are lost" in recording.warnings


def child_code(monkeypatch, tmp_path, at_import: str, at_answer: str) -> None:
    """Put a script in the place of the one that reads."""
    script = tmp_path / "child.py"
    script.write_text(
        f"""
import json, os, signal, sys, time
def say(text):
    for number in range(3, 30):
        try:
            os.write(number, text.encode())
        except OSError:
            pass
class Reader:
    def __init__(self, path):
        pass
    @staticmethod
    def prepare():
        {at_import}
    def answer(self, request):
        {at_answer}
"""
    )
    monkeypatch.setattr(reader_process.mdf_child, "__file__", str(script))


@pytest.mark.parametrize(
    ("at_import", "at_answer", "said"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", "pass", "asammdf ended with SIGSEGV on it"),
        ("pass", "os.kill(os.getpid(), signal.SIGSEGV)", "asammdf ended with SIGSEGV on it"),
        ("os._exit(3)", "pass", "asammdf ended with 3 on it"),
        ("pass", "os._exit(3)", "asammdf ended with 3 on it"),
        ("pass", "os.kill(os.getpid(), signal.SIGXCPU)", "takes more than 5 s of computing"),
        ("pass", "say('no document\\n'); os._exit(0)", "asammdf ended with 0"),
        ("pass", "time.sleep(60)", "it gives no answer within 1 s"),
        ("pass", "say(json.dumps({'arrays': {'x': ['|O', [3]]}}) + '\\n'); os._exit(0)", "ended with 0"),
    ],
)
def test_every_death_is_one_sentence(tmp_path, monkeypatch, at_import, at_answer, said):
    child_code(monkeypatch, tmp_path, at_import, at_answer)
    if "no answer" in said:
        monkeypatch.setattr(reader_process, "BUDGET", Budget(seconds=1.0, patience=1.0))
    path = tmp_path / "drive.mf4"
    path.write_bytes(b"MDF     4.10    ")
    with pytest.raises(InputError, match=f"drive.mf4 is damaged or cut off and cannot be read as MDF .*{said}"):
        read(path)


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory and time are those of Linux")
@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("bytearray(1 << 32)", "takes over 1 GB of memory; TIEROD_LARGEST"),
        ("\n            while True: pass", "computing"),
    ],
)
def test_memory_and_time_are_limited(tmp_path, monkeypatch, body, said):
    source = Path(reader_process.mdf_child.__file__).read_text()
    script = tmp_path / "child.py"
    script.write_text(
        source.replace(
            "        if self._file is None:\n", f"        if self._file is None:\n            {body.strip()}\n"
        )
    )
    monkeypatch.setattr(reader_process.mdf_child, "__file__", str(script))
    monkeypatch.setattr(reader_process, "BUDGET", Budget(seconds=1.0, patience=100.0))
    path = tmp_path / "drive.mf4"
    path.write_bytes(b"MDF     4.10    ")
    with pytest.raises(InputError, match=said):
        read(path)


@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")
def test_the_process_ends_with_what_started_it(tmp_path):
    write(Recording({"yaw_rate": Channel("yaw_rate", STAMPS, STAMPS, "rad/s")}), tmp_path / "drive.mf4")
    process = MdfProcess(tmp_path / "drive.mf4")
    process.ask({})
    number = process._reader.pid
    assert Path(f"/proc/{number}").exists()
    del process
    assert not Path(f"/proc/{number}").exists(), "neither running nor a zombie"
    code = (
        "import sys, time\nfrom pathlib import Path\nfrom tierod.io.readers.reader_process import MdfProcess\n"
        "process = MdfProcess(Path(sys.argv[1]))\nprocess.ask({})\nprint(process._reader.pid, flush=True)\n"
        "time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code, str(tmp_path / "drive.mf4")], stdout=subprocess.PIPE) as parent:
        number = int(parent.stdout.readline())
        os.kill(number, signal.SIGSTOP)
        os.kill(number, signal.SIGCONT)
        parent.kill()
        parent.wait()
    end = time.monotonic() + 30.0
    while _alive(number) and time.monotonic() < end:
        time.sleep(0.01)
    assert not _alive(number)


@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")
def test_files_are_read_by_forks_of_one_process_which_is_replaced_when_it_was_killed(tmp_path):
    write(Recording({"yaw_rate": Channel("yaw_rate", STAMPS, STAMPS, "rad/s")}), tmp_path / "drive.mf4")
    parents = []
    for kill in (False, True, False):
        process = MdfProcess(tmp_path / "drive.mf4")
        process.ask({})
        status = Path(f"/proc/{process._reader.pid}/status").read_text()
        parents.append(int(re.search(r"PPid:\s+(\d+)", status)[1]))
        if kill:
            os.kill(parents[-1], signal.SIGKILL)
        del process
    assert parents[0] == parents[1] != parents[2]


def _alive(number: int) -> bool:
    try:
        return not re.search(r"State:\s+Z", Path(f"/proc/{number}/status").read_text())
    except OSError:
        return False


def test_a_bus_log_is_read_by_the_other_process_too(tmp_path):
    from shared_data import shared_data

    whole = next(shared_data("reader_samples", "mf4_css").glob("*2F6913DB*5CD.MF4")).read_bytes()
    dbc = next(shared_data("reader_samples", "mf4_css").glob("*dbc_files_gnss.dbc"))
    (tmp_path / "whole.mf4").write_bytes(whole)
    log = open_mdf(tmp_path / "whole.mf4")
    assert type(log) is type(log_of())
    for offset in (24, 35, 40):
        at = whole.find(b"##DZ")
        path = damaged(tmp_path, whole, b"##DZ" if at >= 0 else b"##DT", offset)
        recording, said = attempt(path, str(dbc))
        assert said or (recording is not None and len(recording.names) > 0)
