"""A kernel counts only as it was written; what is not used goes."""

import os
import random
import subprocess
import sys
import time

import pytest

from tierod.core.errors import OutputError
from tierod.core.graph.kernel_cache import Bounds, KernelCache

NAME = "tierod_kernel-0123456789abcdef01234567"
CODE = bytes(random.Random(1).randbytes(70_000))


def name(number):
    return f"tierod_kernel-{number:024x}"


@pytest.fixture
def cache(tmp_path):
    cache = KernelCache(tmp_path)
    cache.keep(NAME, CODE)
    return cache


@pytest.fixture
def file(cache):
    return cache.folder / f"{NAME}.kernel"


def test_what_is_kept_is_read_again(cache):
    assert cache.kept(NAME) == CODE
    assert cache.kept(name(0)) is None
    assert KernelCache(cache.folder / "absent").kept(NAME) is None


@pytest.mark.parametrize("seed", range(20))
def test_a_cut_never_passes(cache, file, seed):
    whole = file.read_bytes()
    file.write_bytes(whole[: random.Random(seed).randrange(len(whole))])
    assert cache.kept(NAME) is None


@pytest.mark.parametrize("seed", range(20))
def test_a_flipped_bit_never_passes(cache, file, seed):
    damaged = bytearray(file.read_bytes())
    damaged[random.Random(seed).randrange(len(damaged))] ^= 1 << random.Random(seed).randrange(8)
    file.write_bytes(damaged)
    assert cache.kept(NAME) is None


@pytest.mark.parametrize("content", [b"", b"garbage", CODE])
def test_what_has_no_digest_never_passes(cache, file, content):
    file.write_bytes(content)
    assert cache.kept(NAME) is None


def test_bytes_after_the_end_do_not_pass(cache, file):
    with file.open("ab") as opened:
        opened.write(b"x")
    assert cache.kept(NAME) is None


def test_one_kernel_under_the_name_of_another_does_not_pass(cache, file):
    file.rename(cache.folder / f"{name(1)}.kernel")
    assert cache.kept(name(1)) is None


def test_a_file_that_others_may_write_does_not_pass(cache, file):
    file.chmod(0o666)
    assert cache.kept(NAME) is None


def test_the_folder_and_its_files_are_the_users_alone(tmp_path):
    cache = KernelCache(tmp_path / "new" / "folder")
    with cache.building(NAME) as build:
        assert list(build.iterdir()) == []
        cache.keep(NAME, CODE)
    assert [path.name for path in cache.folder.iterdir()] == [f"{NAME}.kernel"]
    assert cache.folder.stat().st_mode & 0o777 == 0o700
    assert (cache.folder / f"{NAME}.kernel").stat().st_mode & 0o777 == 0o600


def aged(cache, number, days, size=1000):
    path = cache.folder / f"{name(number)}.kernel"
    cache.keep(name(number), bytes(size))
    then = time.time() - 86400.0 * days
    os.utime(path, (then, then))
    return path


def left(cache):
    return {int(path.stem.rpartition("-")[2], 16) for path in cache.folder.glob("tierod_kernel-0000*.kernel")}


def test_what_was_not_used_for_long_goes(tmp_path):
    cache = KernelCache(tmp_path)
    aged(cache, 1, 89.0)
    aged(cache, 2, 91.0)
    cache.prune()
    assert left(cache) == {1}


@pytest.mark.parametrize("bounds", [Bounds(count=2), Bounds(bytes=2500)])
def test_of_too_many_or_too_much_the_least_recently_used_go(tmp_path, bounds):
    cache = KernelCache(tmp_path)
    for number in range(1, 5):
        aged(cache, number, float(number))
    assert cache.kept(name(4)), "reading is using"
    KernelCache(tmp_path, bounds).prune()
    assert left(cache) == {1, 4}


def test_what_was_used_just_now_stays_beyond_all_bounds(tmp_path):
    cache = KernelCache(tmp_path, Bounds(count=0, bytes=0, unused=0.0))
    cache.keep(name(1), CODE)
    cache.keep(name(2), CODE)
    assert left(cache) == {1, 2}


def test_a_kernel_that_is_removed_between_two_looks_is_absent_and_no_error(cache, file):
    file.unlink()
    assert cache.kept(NAME) is None


def test_files_of_others_stay_and_those_of_former_versions_go(tmp_path):
    cache = KernelCache(tmp_path)
    for title in ("notes.kernel", "tierod.so", name(1) + ".so", f".{name(2)}.0123456789ab.kernel", ".notes.kernel"):
        path = tmp_path / title
        path.write_text("")
        os.utime(path, (0, 0))
    cache.prune()
    assert {path.name for path in tmp_path.iterdir()} == {"notes.kernel", "tierod.so", ".notes.kernel"}


KILLED = (
    "import os, pathlib, sys; from tierod.core.graph.kernel_cache import KernelCache\n"
    "with KernelCache(pathlib.Path(sys.argv[1])).building(sys.argv[2]) as build:\n"
    "    (build / 'half').write_text('x'); os._exit(9)"
)


def test_what_a_killed_process_left_goes_and_a_living_one_keeps_its_folder(tmp_path):
    cache = KernelCache(tmp_path)
    assert subprocess.run([sys.executable, "-c", KILLED, tmp_path, name(1)], check=False).returncode == 9
    assert len(list(tmp_path.iterdir())) == 1
    with cache.building(name(2)) as build:
        cache.prune()
        assert build.is_dir()
        assert len(list(tmp_path.iterdir())) == 1
    assert list(tmp_path.iterdir()) == []


def test_the_folder_of_a_killed_process_is_free_for_the_next(tmp_path):
    subprocess.run([sys.executable, "-c", KILLED, tmp_path, name(1)], check=False)
    with KernelCache(tmp_path).building(name(1)) as build:
        assert list(build.iterdir()) == []
    assert list(tmp_path.iterdir()) == []


def test_a_process_that_hangs_while_it_compiles_is_not_waited_for_without_end(tmp_path):
    cache = KernelCache(tmp_path, Bounds(waited=0.05))
    with cache.building(NAME), pytest.raises(OutputError, match=r"has been compiling in .* for 0\.05 s; end it"):
        cache.building(NAME).__enter__()


def test_a_build_folder_of_a_former_version_stays_until_it_is_old(tmp_path):
    build = tmp_path / "build-k3x_01ab"
    build.mkdir()
    KernelCache(tmp_path).prune()
    assert build.is_dir()
    os.utime(build, (0, 0))
    KernelCache(tmp_path).prune()
    assert not build.exists()
