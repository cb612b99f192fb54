"""What every block of the package promises; a new one gets these tests free."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import pkgutil
import subprocess
from functools import lru_cache

import numpy as np
import pytest

import tierod
import tierod_lab
from contract.block_examples import BASES, EXAMPLES, PARTS, SET_UPS
from tierod.core.block import leaves, rebuild, skeleton, tuning, units, with_tuning
from tierod.core.graph import Stream, batch, scan, trace
from tierod.core.graph.bank import BankGraph
from tierod.core.graph.compiler import compiler
from tierod.core.graph.kernel import _attempted, print_c
from tierod.core.graph.printer import print_lanes

COUNT = 600

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wno-unknown-pragmas", "-Werror")


@pytest.fixture(scope="module", autouse=True)
def compiled_in_a_moment():
    """Every kernel is compiled quickly and without a warning, or the test that runs it fails."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TIEROD_CFLAGS", " ".join(("-O0", *STRICT)))
        if compiler() is not None:
            patch.setenv("TIEROD_ENGINE", "compiled")
        patch.setattr("tierod.core.graph.kernel.print_c", printed)
        patch.setattr("tierod.core.graph.kernel.BLOCK", 100)  # some of the samples in blocks, the rest singly
        _attempted.cache_clear()
        yield
    _attempted.cache_clear()  # later tests of the same process run faster kernels
    printed.cache_clear()


printed = lru_cache(maxsize=None)(print_c)  # C of a graph, printed once


def blocks() -> set[type]:
    """Every block class of the package, plants and the set-ups of campaigns left out (they have tests of their own)."""
    found = set()
    product, lab = (pkgutil.walk_packages(each.__path__, f"{each.__name__}.") for each in (tierod, tierod_lab))
    for info in (*product, *lab):
        if any(part in info.name for part in (".cli.", ".ground.", ".campaign.", "__main__")):
            continue
        module = importlib.import_module(info.name)
        for name, member in vars(module).items():
            own = inspect.isclass(member) and member.__module__ == info.name and dataclasses.is_dataclass(member)
            if own and hasattr(member, "init") and hasattr(member, "step") and name not in BASES | PARTS | SET_UPS:
                found.add(member)
    return found


def inner(value) -> set[type]:
    if dataclasses.is_dataclass(value):
        fields = [getattr(value, field.name) for field in dataclasses.fields(value)]
        return {type(value)}.union(*map(inner, fields))
    return {type(value)}.union(*map(inner, value)) if isinstance(value, tuple) else {type(value)}


def samples_of(block) -> np.ndarray:
    random = np.random.default_rng(3)
    width = len(list(leaves(skeleton(block.Sample))))
    values = random.normal(size=(COUNT, width)).cumsum(axis=0) * 0.05 + random.normal(size=(COUNT, width)) * 0.3
    values[random.random(values.shape) < 0.03] = np.nan
    values[4] = values[200:230] = np.nan
    return values


@pytest.fixture(scope="module", params=EXAMPLES, ids=lambda kind: kind.__name__)
def block(request):
    return EXAMPLES[request.param]()


def test_every_block_has_an_example_or_is_part_of_one():
    covered = set().union(*(inner(make()) for make in EXAMPLES.values()))
    assert {kind.__name__ for kind in blocks() - covered} == set(), "add them to tests/contract/block_examples.py"


def test_it_is_frozen_and_its_signals_are_named(block):
    with pytest.raises(dataclasses.FrozenInstanceError):
        block.anything = 1.0
    names = [name for name, _ in leaves(skeleton(block.Sample))]
    assert len(names) == len(set(names)) == len(units(block.Sample))


def test_every_driver_gives_the_same_numbers_and_a_run_can_be_cut(block):
    samples = samples_of(block)
    offline, live = scan(block, samples), Stream(block)
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
    first = scan(block, samples[:211])
    np.testing.assert_array_equal(scan(block, samples[211:], first.state).values, offline.values[211:])


def test_the_virtual_machine_and_plain_floats_agree_with_compiled_code(block):
    samples = samples_of(block)[:250]
    compiled = scan(block, samples).values
    interpreted = scan(block, samples, engine="virtual machine").values
    np.testing.assert_allclose(interpreted, compiled, rtol=1e-6, atol=1e-9)
    if trace(block).rings:
        return  # plain floats need a driver that turns the delay lines: tests/core/graph/test_drivers.py
    state, sample = block.init(), skeleton(block.Sample)
    for row, expected in zip(samples[:8], interpreted, strict=False):
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


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_its_c_is_clean_in_single_precision_and_in_lanes_with_tunings_of_their_own(block):
    graph = trace(block)
    check = [*compiler(), *STRICT, "-fsyntax-only", "-x", "c", "-"]
    lanes = () if isinstance(graph, BankGraph) else ((print_lanes(graph, True),),)
    for source, *extra in ((printed(graph), "-DTIEROD_FLOAT32"), *lanes):
        run = subprocess.run([*check, *extra], input=source, capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stderr
