"""What every block of the package promises; a new one gets these tests free."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import pkgutil
import subprocess

import numpy as np
import pytest

import tierod
from contract.block_examples import BASES, EXAMPLES, PARTS, SET_UPS
from tierod.core.block import leaves, rebuild, skeleton, tuning, units, with_tuning
from tierod.core.graph import Stream, batch, scan, trace
from tierod.core.graph.bank_graph import BankGraph
from tierod.core.graph.compiler import compiler
from tierod.core.graph.kernel import _attempted, print_c
from tierod.core.graph.printer import print_lanes

COUNT = 600


@pytest.fixture(scope="module", autouse=True)
def compiled_in_a_moment():
    """What is printed counts here; kernels as shipped, which compile six times as long, run in core/graph."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TIEROD_CFLAGS", "-O0")
        _attempted.cache_clear()
        yield
    _attempted.cache_clear()  # later tests of the same process run faster kernels


def blocks() -> list[type]:
    """Every block class of the package, plants and the set-ups of campaigns left out (they have tests of their own)."""
    found = []
    for info in pkgutil.walk_packages(tierod.__path__, "tierod."):
        if any(part in info.name for part in (".cli.", ".proving_ground.", ".experiments.", "__main__")):
            continue
        module = importlib.import_module(info.name)
        for name, member in vars(module).items():
            own = inspect.isclass(member) and member.__module__ == info.name and dataclasses.is_dataclass(member)
            if own and hasattr(member, "init") and hasattr(member, "step") and name not in BASES | PARTS | SET_UPS:
                found.append(member)
    return found


def example(kind: type):
    assert kind in EXAMPLES, f"add an example of {kind.__name__} to tests/contract/block_examples.py"
    return EXAMPLES[kind]()


def samples_of(block) -> np.ndarray:
    random = np.random.default_rng(3)
    width = len(list(leaves(skeleton(block.Sample))))
    values = random.normal(size=(COUNT, width)).cumsum(axis=0) * 0.05 + random.normal(size=(COUNT, width)) * 0.3
    values[random.random(values.shape) < 0.03] = np.nan
    values[200:230] = np.nan
    return values


@pytest.fixture(params=blocks(), ids=lambda kind: kind.__name__)
def block(request):
    return example(request.param)


def test_it_is_frozen_and_its_signals_are_named(block):
    with pytest.raises(dataclasses.FrozenInstanceError):
        block.anything = 1.0
    names = [name for name, _ in leaves(skeleton(block.Sample))]
    assert len(names) == len(set(names)) == len(units(block.Sample))
    assert all(
        np.isfinite(value) or not np.isnan(value) for _, value in leaves(block.init()) if isinstance(value, float)
    )


def test_every_driver_gives_the_same_numbers(block):
    samples = samples_of(block)
    offline = scan(block, samples)
    live = Stream(block)
    pushed = np.empty_like(offline.values)
    for row, out in zip(samples, pushed, strict=True):
        live.inputs[:] = row
        live.advance()
        out[:] = live.outputs
    np.testing.assert_array_equal(pushed, offline.values)
    backwards = samples[::-1][:300]
    alone = (offline.values, scan(block, backwards).values)
    for number, lane in enumerate(batch(block, [samples, backwards] * 8)):
        np.testing.assert_array_equal(lane.values, alone[number % 2])


def test_plain_floats_and_the_virtual_machine_agree_with_compiled_code(block):
    samples = samples_of(block)[:250]
    compiled = scan(block, samples)
    interpreted = scan(block, samples, engine="virtual machine")
    np.testing.assert_allclose(interpreted.values, compiled.values, rtol=1e-6, atol=1e-9)
    if trace(block).rings:
        return  # plain floats need a driver that turns the delay lines: tests/graph/test_drivers.py
    state, sample = block.init(), skeleton(block.Sample)
    for row, expected in zip(samples[:20], compiled.values, strict=False):
        state, output = block.step(state, rebuild(sample, row.tolist()))
        np.testing.assert_allclose([value for _, value in leaves(output)], expected, rtol=1e-6, atol=1e-9)


def test_missing_samples_never_reach_the_state(block):
    clean = np.nan_to_num(samples_of(block))
    holed = clean.copy()
    holed[100:130] = np.nan
    holed[200:260, 0] = np.nan
    holed[0:3] = np.inf
    after = scan(block, holed).values[-100:]
    assert (np.isfinite(after) | ~np.isfinite(scan(block, clean).values[-100:])).all()
    nothing = scan(block, np.full_like(clean, np.nan))
    assert np.isfinite(scan(block, clean, nothing.state).values[-1]).any()


def test_tuning_does_not_shape_the_graph(block):
    other = with_tuning(block, [1.01 * value for _, value in tuning(block)])
    assert trace(other) is trace(block)


def test_a_run_can_be_cut_anywhere(block):
    samples = samples_of(block)
    whole, first = scan(block, samples), scan(block, samples[:211])
    second = scan(block, samples[211:], first.state)
    np.testing.assert_array_equal(np.vstack([first.values, second.values]), whole.values)


STRICT = (
    "-std=c99",
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Wno-unknown-pragmas",
    "-Werror",
    "-fsyntax-only",
    "-x",
    "c",
    "-",
)


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_its_c_is_clean_in_double_and_single_precision(block):
    graph = trace(block)
    lanes = () if isinstance(graph, BankGraph) else ((print_lanes(graph, True),),)
    for source, *extra in ((print_c(graph),), (print_c(graph), "-DTIEROD_FLOAT32"), *lanes):
        run = subprocess.run([*compiler(), *STRICT, *extra], input=source, capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stderr


@pytest.mark.slow
def test_compiled_as_shipped_it_gives_the_same_numbers(block, monkeypatch):
    samples = samples_of(block)
    at_once = scan(block, samples).values
    _attempted.cache_clear()
    monkeypatch.delenv("TIEROD_CFLAGS")
    np.testing.assert_array_equal(scan(block, samples).values, at_once)
    _attempted.cache_clear()
