"""Files of kilobytes that unfold to gigabytes are refused before they do; a limit that is raised lets them in."""

import gzip
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.io.readers import content, open_chunks, read
from tierod.io.readers.content import VARIABLE, Limits

SMALL = "16MB"
"""The limit in these tests, which need not unfold gigabytes to pass it."""

LARGER = 4
"""Times as much as passes the limit, where it is seen in the memory that a process takes."""


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setenv(VARIABLE, SMALL)


def packed_text(path, times=1):
    with gzip.open(path, "wb", compresslevel=9) as file:
        file.write(b"time,speed [m/s]\n" + b"".join(b"%d,1\n" % k for k in range(1000)))
        for _ in range(25 * times):
            file.write(b"1000,1\n" * 150_000)


def packed_log(path):
    with gzip.open(path, "wb", compresslevel=9) as file:
        for _ in range(25):
            file.write(b"(1.000000) can0 260#0001000000000000\n" * 30_000)


def matlab(path, times=1):
    count = 25_000_000 * times
    vector = struct.pack("<IIIIII", 6, 8, 9, 0, 5, 8) + struct.pack("<iiHHI", count, 1, 1, 1, ord("t"))
    vector += struct.pack("<II", 2, count) + bytes(count)
    packed = zlib.compress(struct.pack("<II", 14, len(vector)) + vector, 9)
    head = b"MATLAB 5.0 MAT-file".ljust(116) + bytes(8) + struct.pack("<H", 0x0100) + b"IM"
    path.write_bytes(head + struct.pack("<II", 15, len(packed)) + packed)


def container(path, declared=None):
    plain = bytes(40_000_000)
    packed = zlib.compress(plain, 9)
    head = struct.pack("<4sLBBBBBBBBQQLL", b"LOGG", 144, 5, 0, 0, 0, 2, 6, 8, 1, 0, 0, 0, 0).ljust(144, b"\0")
    body = struct.pack("<H6xL4x", 2, len(plain) if declared is None else declared) + packed
    path.write_bytes(head + struct.pack("<4sHHLL", b"LOBJ", 16, 1, 16 + len(body), 10) + body)


def container_that_lies(path):
    container(path, 100)


def columns(path, times=1):
    import pyarrow as pa
    import pyarrow.parquet as pq

    time = np.arange(2_500_000 * times) // 1_000_000
    pq.write_table(pa.table({"time": time, "speed": np.zeros(len(time))}), path, compression="zstd")


def one_line(path):
    with gzip.open(path, "wb", compresslevel=9) as file:
        file.write(b"time,speed [m/s]\n0,1\n1,2\n")
        file.write(b"1" * 12_000_000)


def records(path):
    """An MF4 file whose packed records are zeros."""
    asammdf = pytest.importorskip("asammdf")
    file = asammdf.MDF(version="4.10")
    time = np.arange(1_500_000) * 1e-3
    file.append([asammdf.Signal(np.zeros(len(time)), np.round(time), name="yaw_rate", unit="rad/s")])
    file.save(path, compression=2)
    file.close()


BOMBS = {
    "drive.csv.gz": packed_text,
    "can.log.gz": packed_log,
    "drive.mat": matlab,
    "can.blf": container,
    "lying.blf": container_that_lies,
    "drive.parquet": columns,
}


@pytest.mark.parametrize("name", BOMBS)
def test_what_unfolds_to_too_much_is_refused_with_the_way_out(tmp_path, name):
    pytest.importorskip("can")
    path = tmp_path / name
    BOMBS[name](path)
    assert path.stat().st_size < 160_000, "a hundred times as much is below the limit"
    with pytest.raises(
        InputError, match=f"unpacks to .*set the environment variable {VARIABLE}, for example"
    ) as caught:
        read(path, dbc="rav4" if "can" in name or "lying" in name else None)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(sys.platform != "linux", reason="memory is looked up in /proc")
@pytest.mark.parametrize("name", ["drive.parquet", "drive.mat", "drive.csv.gz"])
def test_little_memory_is_taken_before_it_is_refused(tmp_path, name):
    path = tmp_path / name
    BOMBS[name](path, LARGER)
    code = (
        "import re, sys\nfrom pathlib import Path\nfrom tierod.core.errors import InputError\n"
        "from tierod.io.readers import read\ntry:\n    read(sys.argv[1])\n"
        "except InputError as error:\n    assert 'unpacks' in str(error), error\n"
        "print(re.search(r'VmHWM:\\s+(\\d+)', Path('/proc/self/status').read_text())[1])"
    )
    shown = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True).stdout
    assert int(shown) < 250_000


def test_samples_are_counted_where_the_file_is_read_whole(tmp_path):
    path = tmp_path / "drive.mf4"
    records(path)
    with pytest.raises(InputError, match="unpacks to more than"):
        read(path)


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


def test_ten_hours_at_a_hundred_hertz_are_allowed_whatever_they_are_packed_to():
    assert Limits().largest > 36 * 8 * 10 * 3600 * 100
