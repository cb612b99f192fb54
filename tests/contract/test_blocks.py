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
from contract.block_examples import BASES, EXAMPLES, PARTS, SET_UPS, WITHIN
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
    """What is printed counts here; kernels as shipped, which compile six times as long, run in core/graph.

    Every kernel is compiled without a warning, or the test that runs it fails.
    """
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


def blocks() -> list[type]:
    """Every block class of the package, plants and the set-ups of campaigns left out (they have tests of their own)."""
    found = []
    product, lab = (pkgutil.walk_packages(each.__path__, f"{each.__name__}.") for each in (tierod, tierod_lab))
    for info in (*product, *lab):
        if any(part in info.name for part in (".cli.", ".ground.", ".campaign.", "__main__")):
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
    values[4] = values[200:230] = np.nan
    return values


KINDS = blocks()


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: kind.__name__)
def block(request):
    return example(request.param)


@pytest.fixture(
    scope="module",
    params=[pytest.param(kind, marks=[pytest.mark.slow] if kind in WITHIN else []) for kind in KINDS],
    ids=lambda kind: kind.__name__,
)
def whole(request):
    """A block that no other example contains; the others are compiled with it."""
    return example(request.param)


def inner(value) -> set[type]:
    if dataclasses.is_dataclass(value):
        fields = [getattr(value, field.name) for field in dataclasses.fields(value)]
        return {type(each) for each in fields}.union(*map(inner, fields))
    return {type(each) for each in value}.union(*map(inner, value)) if isinstance(value, tuple) else set()


@pytest.mark.parametrize(("part", "composite"), WITHIN.items(), ids=lambda kind: kind.__name__)
def test_what_is_left_to_a_composite_block_is_part_of_it(part, composite):
    assert composite not in WITHIN
    there = {composite} | inner(example(composite))
    assert part in there or inner(example(part)) <= there


def test_it_is_frozen_and_its_signals_are_named(block):
    with pytest.raises(dataclasses.FrozenInstanceError):
        block.anything = 1.0
    names = [name for name, _ in leaves(skeleton(block.Sample))]
    assert len(names) == len(set(names)) == len(units(block.Sample))
    assert all(
        np.isfinite(value) or not np.isnan(value) for _, value in leaves(block.init()) if isinstance(value, float)
    )


def test_every_driver_gives_the_same_numbers(whole):
    samples = samples_of(whole)
    offline = scan(whole, samples)
    live = Stream(whole)
    pushed = np.empty_like(offline.values)
    for row, out in zip(samples, pushed, strict=True):
        live.inputs[:] = row
        live.advance()
        out[:] = live.outputs
    np.testing.assert_array_equal(pushed, offline.values)
    backwards = samples[::-1][:300]
    alone = (offline.values, scan(whole, backwards).values)
    for number, lane in enumerate(batch(whole, [samples, backwards] * 8)):
        np.testing.assert_array_equal(lane.values, alone[number % 2])


def test_the_virtual_machine_agrees_with_compiled_code(whole):
    samples = samples_of(whole)[:250]
    interpreted = scan(whole, samples, engine="virtual machine")
    np.testing.assert_allclose(interpreted.values, scan(whole, samples).values, rtol=1e-6, atol=1e-9)


def test_plain_floats_agree_with_the_virtual_machine(block):
    if trace(block).rings:
        return  # plain floats need a driver that turns the delay lines: tests/graph/test_drivers.py
    samples = samples_of(block)[:8]
    state, sample = block.init(), skeleton(block.Sample)
    for row, expected in zip(samples, scan(block, samples, engine="virtual machine").values, strict=True):
        state, output = block.step(state, rebuild(sample, row.tolist()))
        np.testing.assert_allclose([value for _, value in leaves(output)], expected, rtol=1e-6, atol=1e-9)


def engine_of(block) -> str:
    return "virtual machine" if type(block) in WITHIN else "auto"


def test_missing_samples_never_reach_the_state(block):
    engine = engine_of(block)
    clean = np.nan_to_num(samples_of(block))
    holed = clean.copy()
    holed[100:130] = np.nan
    holed[200:260, 0] = np.nan
    holed[0:3] = np.inf
    after = scan(block, holed, engine=engine).values[-100:]
    assert (np.isfinite(after) | ~np.isfinite(scan(block, clean, engine=engine).values[-100:])).all()
    nothing = scan(block, np.full_like(clean, np.nan), engine=engine)
    assert np.isfinite(scan(block, clean, nothing.state, engine=engine).values[-1]).any()


def test_tuning_does_not_shape_the_graph(block):
    other = with_tuning(block, [1.01 * value for _, value in tuning(block)])
    assert trace(other) is trace(block)


def test_a_run_can_be_cut_anywhere(block):
    samples, engine = samples_of(block), engine_of(block)
    at_once, first = scan(block, samples, engine=engine), scan(block, samples[:211], engine=engine)
    second = scan(block, samples[211:], first.state, engine=engine)
    np.testing.assert_array_equal(np.vstack([first.values, second.values]), at_once.values)


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_its_c_is_clean_in_single_precision_and_in_lanes_with_tunings_of_their_own(whole):
    graph = trace(whole)
    check = [*compiler(), *STRICT, "-fsyntax-only", "-x", "c", "-"]
    lanes = () if isinstance(graph, BankGraph) else ((print_lanes(graph, True),),)
    for source, *extra in ((printed(graph), "-DTIEROD_FLOAT32"), *lanes):
        run = subprocess.run([*check, *extra], input=source, capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stderr


@pytest.mark.slow
def test_compiled_as_shipped_it_gives_the_same_numbers(block, monkeypatch):
    samples = samples_of(block)
    at_once = scan(block, samples).values
    _attempted.cache_clear()
    monkeypatch.delenv("TIEROD_CFLAGS")
    np.testing.assert_array_equal(scan(block, samples).values, at_once)
    _attempted.cache_clear()
