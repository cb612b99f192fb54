"""Damaged MF4 files: native code that reads them may die of it, tierod says one sentence."""

import gzip
import os
import re
import signal
import struct
import subprocess
import sys
import time
import warnings
import zlib
from pathlib import Path

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError, TierodError
from tierod.core.recording import Channel, Recording
from tierod.io.readers import content, open_chunks, read, reader_process
from tierod.io.readers.content import VARIABLE
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


def _alive(number: int) -> bool:
    try:
        return not re.search(r"State:\s+Z", Path(f"/proc/{number}/status").read_text())
    except OSError:
        return False


SMALL = "16MB"
"""The limit in these tests, which need not unfold gigabytes to pass it."""


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setenv(VARIABLE, SMALL)


def packed_text(path):
    with gzip.open(path, "wb", compresslevel=9) as file:
        file.write(b"time,speed [m/s]\n" + b"".join(b"%d,1\n" % k for k in range(1000)))
        for _ in range(25):
            file.write(b"1000,1\n" * 150_000)


def columns(path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    time = np.arange(2_500_000) // 1_000_000
    pq.write_table(pa.table({"time": time, "speed": np.zeros(len(time))}), path, compression="zstd")


def one_line(path):
    with gzip.open(path, "wb", compresslevel=9) as file:
        file.write(b"time,speed [m/s]\n0,1\n1,2\n")
        file.write(b"1" * 12_000_000)


def matlab(path):
    count = 25_000_000
    vector = struct.pack("<IIIIII", 6, 8, 9, 0, 5, 8) + struct.pack("<iiHHI", count, 1, 1, 1, ord("t"))
    vector += struct.pack("<II", 2, count) + bytes(count)
    packed = zlib.compress(struct.pack("<II", 14, len(vector)) + vector, 9)
    head = b"MATLAB 5.0 MAT-file".ljust(116) + bytes(8) + struct.pack("<H", 0x0100) + b"IM"
    path.write_bytes(head + struct.pack("<II", 15, len(packed)) + packed)


BOMBS = {"drive.csv.gz": packed_text, "drive.mat": matlab, "drive.parquet": columns}


@pytest.mark.parametrize("name", BOMBS)
def test_what_unfolds_to_too_much_is_refused_with_the_way_out(tmp_path, name):
    pytest.importorskip("can")
    path = tmp_path / name
    BOMBS[name](path)
    assert path.stat().st_size < 160_000, "a hundred times as much is below the limit"
    with pytest.raises(
        InputError, match=f"unpacks to .*set the environment variable {VARIABLE}, for example"
    ) as caught:
        read(path)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_line_without_an_end_is_refused(tmp_path):
    path = tmp_path / "drive.csv.gz"
    one_line(path)
    with pytest.raises(InputError, match="holds a line of more than 4.19 MB"):
        read(path)


def test_a_raised_limit_lets_it_in(tmp_path, monkeypatch):
    path = tmp_path / "drive.parquet"
    columns(path)
    monkeypatch.setenv(VARIABLE, "1GB")
    assert sum(len(part["vehicle_speed"].time) for part in open_chunks(path)) == 2_500_000


@pytest.mark.parametrize(("text", "size"), [("4GB", 4e9), ("1.5 GiB", 1.5 * 2**30), ("1000000", 1e6), ("200kb", 2e5)])
def test_the_limit_is_a_size(monkeypatch, text, size):
    monkeypatch.setenv(VARIABLE, text)
    assert content.limits().largest == size


@pytest.mark.parametrize("text", ["much", "-1GB", "4TB", "1e9", "9" * 400])
def test_what_is_no_size_is_said(monkeypatch, text):
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(ParameterError, match=f"{VARIABLE} = .* is not a size; write bytes, or for example 4GB"):
        content.limits()
