"""Files are whole or absent, one process writes at a time, and text of users is read through one door."""

from __future__ import annotations

import errno
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

import tierod
from tierod.core.errors import InputError, OutputError, ParameterError
from tierod.core.files import replacing, write_text
from tierod.core.processes import THREADS, interpreter
from tierod.core.user_files import MOST_BYTES, MOST_DEPTH, json_document, read_bytes, read_text, toml


def half_write(target, error):
    with replacing(target) as temporary:
        temporary.write_text("half")
        raise error


def test_writes_and_replaces(tmp_path):
    target = tmp_path / "out.txt"
    write_text(target, "old")
    write_text(target, "näw")
    assert target.read_text(encoding="utf-8") == "näw"
    assert [path.name for path in tmp_path.iterdir()] == ["out.txt"]


@pytest.mark.parametrize(
    ("number", "remedy"),
    [(errno.ENOSPC, "make room on the disk"), (errno.EIO, "check the disk"), (errno.EROFS, "name a place")],
)
def test_leaves_the_old_file_when_writing_fails(tmp_path, number, remedy):
    target = tmp_path / "out.txt"
    target.write_text("old")
    with pytest.raises(OutputError, match=remedy):
        half_write(target, OSError(number, os.strerror(number)))
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out.txt"]


def test_leaves_nothing_when_interrupted(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        half_write(tmp_path / "out.txt", KeyboardInterrupt())
    assert not list(tmp_path.iterdir())


def test_a_link_stays_and_its_file_is_replaced(tmp_path):
    real, link = tmp_path / "folder" / "real.txt", tmp_path / "link.txt"
    real.parent.mkdir()
    real.write_text("old")
    link.symlink_to(real)
    write_text(link, "new")
    assert link.is_symlink()
    assert real.read_text() == "new"


def test_what_a_killed_process_left_goes_after_an_hour_and_nothing_else(tmp_path):
    names = {".out.0123456789ab.txt": True, ".out.0123456789ab.html": False, ".outer.0123456789ab.txt": False,
             ".out.txt": False, ".out.0123456789abc.txt": False}  # fmt: skip
    for name in names:
        (tmp_path / name).write_text("half")
        os.utime(tmp_path / name, (0, 0))
    (tmp_path / ".out.ba9876543210.txt").write_text("just being written by another process")
    write_text(tmp_path / "out.txt", "text")
    gone = {name for name in names if not (tmp_path / name).exists()}
    assert gone == {name for name, ours in names.items() if ours}
    assert (tmp_path / ".out.ba9876543210.txt").exists()


PLANTED = ("tierod", "numpy", "json", "multiprocessing", "encodings", "typing", "can", "pyarrow", "fmpy", "ziglang")


@pytest.fixture
def planted(tmp_path):
    """A folder of files that have the names of modules and leave a trace when they are imported."""
    for name in PLANTED:
        (tmp_path / f"{name}.py").write_text(f"open('imported', 'a').write('{name} ')\n")
    return tmp_path


def ran(words, folder):
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert not (folder / "imported").exists(), (folder / "imported").read_text()
    return done


def test_a_child_interpreter_finds_the_package(planted):
    done = ran([*interpreter("-m", "tierod"), "--version"], planted)
    assert done.stdout == f"tierod {tierod.__version__}\n"


def test_every_command_line_of_an_interpreter_is_made_in_one_place():
    root = Path(tierod.__file__).parent
    naming = {str(path.relative_to(root)) for path in root.rglob("*.py") if "sys.executable" in path.read_text("utf-8")}
    # The addon of cppcheck is a script: the folder of a script is searched in place of the working folder.
    assert naming == {"core/processes.py", "export/evidence/checks.py"}


ASKED = "import os\nfrom tierod.cli import main\nmain(['monitors'])\nprint(os.environ['OPENBLAS_NUM_THREADS'])"


@pytest.mark.parametrize(("chosen", "used"), [(None, "1"), ("3", "3")])
def test_one_thread_unless_the_user_chose(monkeypatch, chosen, used):
    for name in THREADS:
        monkeypatch.delenv(name, raising=False)
    if chosen:
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", chosen)
    done = subprocess.run([sys.executable, "-c", ASKED], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == used


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"a = 1\n# caf\xe9", "not UTF-8 text in line 2"), ("a = 1".encode("utf-16"), "not UTF-8 text in line 1")],
)
def test_what_is_not_utf_8_is_refused_with_its_line(tmp_path, content, words):
    (tmp_path / "a.toml").write_bytes(content)
    with pytest.raises(ParameterError, match=f"the map .*a.toml cannot be read .*{words}.*; save it as UTF-8"):
        read_text(tmp_path / "a.toml", "the map", ParameterError)


def test_a_pipe_a_socket_a_device_and_a_folder_are_refused_before_they_are_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(tmp_path / "socket"))
        for path, words in (
            (tmp_path / "pipe", "a pipe"),
            (tmp_path / "socket", "a socket"),
            (Path("/dev/zero"), "a device"),
            (tmp_path, "a folder"),
            (tmp_path / "none", "no such file"),
            (tmp_path / "a\0b", "null"),
            (Path("~no-such-user-here/a"), "no such file"),
        ):
            with pytest.raises(InputError, match=f"the map .* cannot be read .*{words}.*; give another"):
                read_bytes(path, "the map", cure="give another")


def test_a_file_is_no_longer_than_allowed(tmp_path):
    with (tmp_path / "large").open("wb") as file:
        file.truncate(MOST_BYTES)
    assert len(read_bytes(tmp_path / "large", "the map")) == MOST_BYTES
    with (tmp_path / "large").open("wb") as file:
        file.truncate(100 * MOST_BYTES)
    with pytest.raises(InputError, match="the map .*large is longer than 1 MiB"):
        read_bytes(tmp_path / "large", "the map")
    with pytest.raises(InputError, match="longer than 10 bytes"):
        read_bytes("/proc/self/status", "the map", most=10)


@pytest.mark.parametrize(
    "text",
    [
        "a = " + 200_000 * "[",
        "a" + 50_000 * ".a" + " = 1",
        "[" + 50_000 * "a." + "a]",
        "b = [{c = 1, " + 50_000 * "a." + "a = 1}]",
        "\n".join(f"[{'.'.join(['a'] * depth)}]" for depth in range(1, MOST_DEPTH + 3)),
    ],
)
def test_toml_is_not_nested_deeply(text):
    with pytest.raises(ParameterError, match="here.toml.*more than 32 levels"):
        toml(text, "here.toml", ParameterError)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (1000 * "[" + 1000 * "]", "more than 32 levels"),
        ("{", "not JSON from line 1 on"),
        (b"\xff", "not UTF-8"),
        (r'{"a": "\ud800"}', "half of a character"),
        (r'{"\uDC00": 1}', "half of a character"),
    ],
)
def test_json_that_is_refused(text, words):
    with pytest.raises(ValueError, match=words):
        json_document(text)
