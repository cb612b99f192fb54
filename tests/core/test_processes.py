"""Child interpreters import nothing from the working folder, whatever files lie there."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import tierod
from tierod.core.processes import THREADS, interpreter, safe_path

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


POOL = """
from tierod.work.pool import Executor
if __name__ == "__main__":
    with Executor(1) as pool:
        print(list(pool.run(abs, [-3])))
"""


def test_workers_of_a_pool_do_not_import_from_the_working_folder(planted, tmp_path_factory):
    script = tmp_path_factory.mktemp("scripts") / "pool.py"
    script.write_text(POOL)
    done = ran([sys.executable, str(script)], planted)
    assert done.stdout == "[(0, 3)]\n", done.stderr


def test_threads_that_start_processes_at_once_keep_it_and_leave_the_environment_as_it_was(monkeypatch):
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)

    def started(seconds):
        time.sleep(seconds)
        with safe_path():
            time.sleep(0.05)
            return os.environ.get("PYTHONSAFEPATH")

    with ThreadPoolExecutor(2) as threads:
        assert list(threads.map(started, (0.0, 0.02))) == ["1", "1"]
    assert "PYTHONSAFEPATH" not in os.environ


@pytest.mark.slow
def test_the_receiver_of_a_bus_does_not_import_from_the_working_folder(planted):
    pytest.importorskip("can")
    where = ["--interface", "udp_multicast", "--channel", "239.74.163.9", "--vehicle", "rav4", "--seconds", "1"]
    done = ran([*interpreter("-m", "tierod", "live"), *where, "--json"], planted)
    assert done.returncode in (0, 2, 3), done.stderr


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
