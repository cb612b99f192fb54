"""Compilers that refuse, hang, lie or are absent; caches that are full, planted or in the way."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tierod.core.errors import CompileError, KernelWarning, OutputError
from tierod.core.graph import batch, compiler, kernel_cache, scan
from tierod.core.graph import kernel as kernels
from tierod.core.graph.kernel_cache import KernelCache

pytestmark = pytest.mark.usefixtures("shipped_kernels")

SOURCE = "int one(void); int one(void) { return 1; }"
PLANTED = "int one(void); int one(void) { return 666; }"


@pytest.fixture(autouse=True)
def places(monkeypatch, tmp_path):
    """A cache and a temporary folder of the test's own, in a process that has not warned yet."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setenv("TIEROD_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(compiler.tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.setattr(compiler, "_WARNED", set())
    monkeypatch.setattr(kernels, "_INTERPRETED", set())
    return tmp_path


def file_of(cache, source=SOURCE):
    return cache / f"{compiler.kernel_name(compiler.compiler(), source, 'kernel')}.kernel"


def files(folder):
    return sorted(path.name for path in folder.rglob("*") if not path.is_dir())


def use(monkeypatch, places, script):
    path = places / "cc"
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    monkeypatch.setattr(compiler, "compiler", lambda: (str(path),))


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("exit 0", "ended well but wrote nothing"),
        ('while [ "$1" != -o ]; do shift; done; : > "$2"', "ended well but wrote nothing"),
        ('while [ "$1" != -o ]; do shift; done; echo no library > "$2"', "cannot be loaded"),
        ("printf '\\377\\376 error' >&2; exit 1", "refused generated code"),
        ("exec sleep 60", "did not end within"),
    ],
)
def test_a_compiler_that_makes_no_library_is_named_and_nothing_is_kept(monkeypatch, places, script, says):
    use(monkeypatch, places, script)
    monkeypatch.setattr(compiler, "LONGEST", 0.2)
    with pytest.raises(CompileError, match=says):
        compiler.load(SOURCE, "kernel")
    assert files(places) == ["cc"]


@dataclass(frozen=True)
class Doubled:
    """Twice its input."""

    class Sample(NamedTuple):
        value: float

    def init(self):
        return ()

    def step(self, state, sample):
        return state, self.Sample(2.0 * sample.value)


def test_where_nothing_can_be_compiled_the_virtual_machine_runs_and_says_so_once(monkeypatch, places):
    use(monkeypatch, places, "exit 0")
    kernels._attempted.cache_clear()
    monkeypatch.delenv("TIEROD_ENGINE", raising=False)
    with pytest.warns(KernelWarning, match="wrote nothing.*The virtual machine is used"):
        assert scan(Doubled(), np.ones(4))["value"].tolist() == [2.0] * 4
    assert scan(Doubled(), np.ones(4))["value"].tolist() == [2.0] * 4, "a second warning would be an error here"
    assert batch(Doubled(), [np.ones(4)] * 20)[19]["value"].tolist() == [2.0] * 4
    with pytest.raises(CompileError, match="wrote nothing"):
        scan(Doubled(), np.ones(4), engine="compiled")
    kernels._attempted.cache_clear()


def planted(folder):
    """A folder in which another user has put a whole kernel under the very name that is looked for."""
    folder.mkdir(exist_ok=True)
    with KernelCache(folder).building("planted") as build:
        code = compiler._compiled(compiler.compiler(), PLANTED, build)
    target = file_of(folder)
    KernelCache(folder).keep(target.stem, code)
    return target


def test_a_planted_kernel_is_not_run_from_a_folder_that_others_may_write(places):
    planted(places / "cache")
    assert compiler.load(SOURCE, "kernel").one() == 666, "the test plants what would run"
    (places / "cache").chmod(0o777)
    with pytest.warns(KernelWarning, match="other users may write there.*chmod go-w.*are kept in .*temporary"):
        assert compiler.load(SOURCE, "kernel").one() == 1
    assert compiler.load(SOURCE, "kernel").one() == 1, "a second warning would be an error here"


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give a folder away")
@pytest.mark.parametrize("what", ["folder", "file"])
def test_a_planted_kernel_of_another_user_is_not_run(places, what):
    target = planted(places / "cache")
    os.chown(target.parent if what == "folder" else target, 12345, 12345)
    if what == "file":
        assert compiler.load(SOURCE, "kernel").one() == 1
        return
    with pytest.warns(KernelWarning, match="belongs to another user"):
        assert compiler.load(SOURCE, "kernel").one() == 1


@pytest.mark.parametrize("in_the_way", ["folder", "pipe", "link", "device", "nothing"])
def test_what_is_in_the_place_of_a_kernel_is_no_obstacle(places, in_the_way):
    compiler.load(SOURCE, "kernel")
    target = file_of(places / "cache")
    whole = places / "whole"
    target.rename(whole)
    if in_the_way == "folder":
        (target / "below").mkdir(parents=True)
        with pytest.warns(KernelWarning, match="there is a folder .* remove it.*kept in .*temporary"):
            assert compiler.load(SOURCE, "kernel").one() == 1
        return
    if in_the_way == "pipe":
        os.mkfifo(target)
    else:
        target.symlink_to({"link": whole, "device": "/dev/zero", "nothing": "absent"}[in_the_way])
    assert compiler.load(SOURCE, "kernel").one() == 1
    assert not target.is_symlink()
    assert target.is_file()


def test_a_full_disk_is_reported_and_no_obstacle(places, monkeypatch):
    real = kernel_cache.replacing

    def full(path, **options):
        if path.parent == places / "cache":
            raise OutputError(f"{path} cannot be written: no space left on device; make room")
        return real(path, **options)

    monkeypatch.setattr(kernel_cache, "replacing", full)
    with pytest.warns(KernelWarning, match="no space left on device.*are kept in .*temporary"):
        assert compiler.load(SOURCE, "kernel").one() == 1
    assert files(places / "cache") == []
    assert files(places / "temporary") == [file_of(places).name]


def test_where_no_byte_can_be_written_the_virtual_machine_runs(places):
    code = (
        "import resource, numpy, sys; sys.path.insert(0, sys.argv[1])\n"
        "from core.graph.test_compiler import Doubled; from tierod.core.graph import scan\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\n"
        "assert scan(Doubled(), numpy.ones(2))['value'].tolist() == [2.0, 2.0]"
    )
    tests = str(Path(__file__).parents[2])
    run = subprocess.run([sys.executable, "-c", code, tests], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert "The virtual machine is used" in run.stderr
    assert "Traceback" not in run.stderr


def test_a_kernel_in_use_survives_whatever_becomes_of_its_file(places):
    library = compiler.load(SOURCE, "kernel")
    os.truncate(file_of(places / "cache"), 0)
    shutil.rmtree(places / "cache")
    assert library.one() == 1
