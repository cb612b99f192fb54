"""What a process finds of graphs that another one traced, and what it must not find."""

import os
import pickle
import re
import subprocess
import sys

import numpy as np
import pytest

from tierod.core.block import structure
from tierod.core.graph import compiler, kernel, known_graphs, scan
from tierod.core.graph.kernel import CompiledKernel
from tierod.core.graph.operations import program
from tierod.core.graph.trace import _trace, trace
from tierod.methods.detectors import Cusum

pytestmark = pytest.mark.skipif(compiler.compiler() is None, reason="no C compiler: nothing is compiled or kept")

BLOCKS = {
    "block": """
from tierod.methods.detectors import Cusum
block, count = Cusum(0.5, 4.0, 20.0), 1
""",
    "bank": """
from tierod.monitors.condition.definition import condition_monitor
from tierod.vehicles import load
block = condition_monitor(load("rav4"))
count = len(block.Sample._fields)
""",
}
SCRIPT = """
import sys
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


@pytest.fixture(name="cache")
def own_cache(tmp_path, monkeypatch):
    folder = tmp_path / "kernels"
    monkeypatch.setenv("TIEROD_CACHE", str(folder))
    monkeypatch.setenv("TIEROD_GRAPHS", "known")
    _trace.cache_clear()
    yield folder
    _trace.cache_clear()


class Plugin(Cusum):
    """A block of another package."""


def entry(block):
    return known_graphs.entry_of(structure(block), type(block).__name__)


@pytest.mark.parametrize(("kind", "parts"), [("block", 1), ("bank", 2)])
def test_a_second_process_neither_traces_nor_prints_and_gives_the_same_bits(cache, kind, parts):
    environment = os.environ | {"TIEROD_CACHE": str(cache), "TIEROD_CFLAGS": "-O0"}
    script = BLOCKS[kind] + SCRIPT
    runs = [
        subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    (first, made), (second, again) = (run.stdout.split() for run in runs)
    assert (made, again) == ("straight_line+" * parts + "print_c", "nothing")
    assert first == second


def test_a_known_graph_has_the_interface_and_on_demand_the_operations_of_a_traced_one(cache):
    block = Cusum(0.5, 4.0, 20.0)
    traced = trace(block)
    _trace.cache_clear()
    known = trace(block)
    assert known is not traced
    assert "function" not in vars(known)
    for name in ("name", "tuning", "state", "rings", "sample", "output", "sample_tree", "output_tree", "memory"):
        assert getattr(known, name) == getattr(traced, name), name
    assert type(known.output_tree) is type(traced.output_tree)
    assert program(known.function) == program(traced.function)


def test_blocks_with_entries_import_nothing_whose_sources_are_not_in_the_digest():
    imported = set()
    for package in known_graphs.SOURCES:
        for path in (known_graphs.PACKAGE / package).rglob("*.py"):
            imported |= set(re.findall(r"^\s*(?:from|import) tierod\.(\w+)", path.read_text("utf-8"), re.MULTILINE))
    assert imported == set(known_graphs.SOURCES)


def test_a_script_that_changes_constants_finds_no_entry(monkeypatch):
    monkeypatch.delenv("TIEROD_GRAPHS", raising=False)
    assert entry(Cusum(0.5, 4.0, 20.0)) is None


def test_a_block_that_is_not_of_tierod_has_no_entry(cache):
    assert entry(Cusum(0.5, 4.0, 20.0)) is not None
    assert entry(Plugin(0.5, 4.0, 20.0)) is None

    class Own(Cusum):
        """Under no address that another process finds."""

    assert entry(Own(0.5, 4.0, 20.0)) is None


@pytest.mark.parametrize("content", [b"", b"no pickle", pickle.dumps({"name": "less than a graph"})])
def test_an_entry_of_no_use_is_traced_anew(cache, content):
    block = Cusum(0.5, 4.0, 20.0)
    expected = scan(block, np.ones((9, 1))).values
    compiler.keep(entry(block), content)
    _trace.cache_clear()
    assert np.array_equal(scan(block, np.ones((9, 1))).values, expected)


def test_a_kernel_that_is_gone_is_compiled_anew(cache):
    block = Cusum(0.5, 4.0, 20.0)
    CompiledKernel(block)
    kernels = [path for path in cache.iterdir() if path.name.startswith("tierod_cusum-")]
    assert len(kernels) == 1
    kernels[0].unlink()
    kernel._attempted.cache_clear()
    _trace.cache_clear()
    CompiledKernel(block)
    assert kernels[0].is_file()
