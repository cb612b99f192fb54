"""A kernel counts only as it was written, what is not used goes; graphs that another process traced are found."""

import os
import pickle
import random
import subprocess
import sys

import numpy as np
import pytest

from tierod.core.block import structure
from tierod.core.graph import compiler, known_graphs, scan
from tierod.core.graph.kernel_cache import KernelCache
from tierod.core.graph.trace import _trace
from tierod.methods.detectors import Cusum
from tierod.methods.estimators.shapes import augment
from tierod.models.lateral_motion import lateral_motion
from tierod.models.linear import discretise
from tierod.models.steering_column import SteeringWheel

NAME = "tierod_kernel-0123456789abcdef01234567"
CODE = bytes(random.Random(1).randbytes(70_000))


LEARNT = ("inertia_error", "steering_wheel_damping", "torque_offset")


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


@pytest.mark.parametrize("seed", range(8))
def test_neither_a_cut_nor_a_flipped_bit_passes(cache, file, seed):
    whole, chance = file.read_bytes(), random.Random(seed)
    damaged = bytearray(whole)
    damaged[chance.randrange(len(damaged))] ^= 1 << chance.randrange(8)
    for each in (damaged, whole[: chance.randrange(len(whole))]):
        file.write_bytes(each)
        assert cache.kept(NAME) is None


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


pytestmark = pytest.mark.skipif(compiler.compiler() is None, reason="no C compiler: nothing is compiled or kept")

SCRIPT = """
import sys
from tierod.monitors.condition.definition import condition_monitor
from tierod.vehicles import load
block = condition_monitor(load("rav4"))
count = len(block.Sample._fields)
import numpy as np
from tierod.core.graph import scan
called = []
for module, name in (("kernel", "print_c"), ("trace", "straight_line"), ("bank", "straight_line")):
    module = sys.modules["tierod.core.graph." + module]
    def counted(*given, usual=getattr(module, name), name=name):
        called.append(name)
        return usual(*given)
    setattr(module, name, counted)
result = scan(block, np.sin(np.arange(50.0))[:, None] * np.ones(count))
print(result.values.tobytes().hex(), "+".join(called) or "nothing")
"""


@pytest.fixture
def graphs(tmp_path, monkeypatch):
    folder = tmp_path / "kernels"
    monkeypatch.setenv("TIEROD_CACHE", str(folder))
    monkeypatch.setenv("TIEROD_GRAPHS", "known")
    _trace.cache_clear()
    yield folder
    _trace.cache_clear()


def entry(block):
    return known_graphs.entry_of(structure(block), type(block).__name__)


def test_a_second_process_neither_traces_nor_prints_and_gives_the_same_bits(graphs):
    environment = os.environ | {"TIEROD_CACHE": str(graphs), "TIEROD_CFLAGS": "-O0"}
    runs = [
        subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    (first, made), (second, again) = (run.stdout.split() for run in runs)
    assert (made, again) == ("straight_line+" * 2 + "print_c", "nothing")
    assert first == second


@pytest.mark.parametrize("content", [b"", b"no pickle", pickle.dumps({"name": "less than a graph"})])
def test_an_entry_of_no_use_is_traced_anew(graphs, content):
    block = Cusum(0.5, 4.0, 20.0)
    expected = scan(block, np.ones((9, 1))).values
    compiler.keep(entry(block), content)
    _trace.cache_clear()
    assert np.array_equal(scan(block, np.ones((9, 1))).values, expected)


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lateral_motion, ("bank_angle", "side_force")),
        (lambda names: discretise(augment(SteeringWheel, *names), "midpoint"), LEARNT),
    ],
)
def test_a_class_made_at_run_time_is_known_by_its_maker_and_arguments(graphs, make, names):
    def known(names):
        return known_graphs.entry_of((type, make(names)), "filter")

    first = known(names)
    for maker in (lateral_motion, augment, discretise):
        maker.cache_clear()
    assert first is not None
    assert known(names) == first
    assert known(names[:1]) != first


def test_a_class_that_a_plug_in_makes_has_no_entry(graphs):
    foreign = type("Wheel", (), {**vars(SteeringWheel), "__module__": "foreign"})
    assert known_graphs.entry_of((type, foreign), "filter") is None
    assert known_graphs.entry_of((type, augment(foreign, *LEARNT)), "filter") is None
