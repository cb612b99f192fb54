"""Exported C of random steps against a plain interpreter of their operations, to the last bit."""

import functools
import shutil

import pytest

from exported_c import needs_gcc
from exported_programs import compiled, interface_of_program, same_bits
from interpreted_programs import Interpreter
from random_programs import random_samples, random_step
from tierod.core.graph import operations as branches
from tierod.export import c_source
from tierod.export.cut_printer import CutPrinter

STEPS = 40
TOGETHER = 10  # Steps that are compiled into one library
MANY = 300  # Steps of each compiler and option: some minutes for all


def wrong_seeds(seeds, folder, compiler, flags, **options):
    made = {seed: random_step(seed) for seed in seeds}
    faces = {seed: interface_of_program(each, f"p{seed}", **options) for seed, each in made.items()}
    single, wrong = options["precision"] == "single", []
    for seed, run in zip(seeds, compiled(list(faces.values()), folder, compiler, flags), strict=True):
        face, samples = faces[seed], random_samples(made[seed], STEPS, seed)
        # In single precision the order of sums is the export's own.
        step = face.program if single else made[seed].step
        interpreter = Interpreter(step, single, face.options.fused, face.clocks)
        if not same_bits(run(samples), interpreter.run(made[seed], samples)):
            wrong.append(seed)
    return wrong


@pytest.fixture
def short(monkeypatch):
    """Functions of few operations, and branches for few: many values cross both."""
    monkeypatch.setattr(branches, "FEWEST", 3)
    monkeypatch.setattr(c_source, "CutPrinter", functools.partial(CutPrinter, longest=9))


@needs_gcc
@pytest.mark.parametrize("precision", ["double", "single"])
def test_random_steps_give_the_same_bits(tmp_path, precision):
    assert wrong_seeds(range(TOGETHER), tmp_path, "gcc", ("-O1",), precision=precision) == []


@needs_gcc
@pytest.mark.parametrize(("precision", "validity"), [("double", True), ("single", False)])
def test_random_steps_that_are_cut_often_give_the_same_bits(tmp_path, short, precision, validity):
    seeds = range(TOGETHER, 2 * TOGETHER)
    assert wrong_seeds(seeds, tmp_path, "gcc", ("-O1",), precision=precision, validity=validity) == []


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize(
    ("compiler", "level", "fused", "first"),
    [
        ("gcc", "-O0", True, 1000),
        ("gcc", "-O2", False, 2000),
        ("gcc", "-O3", True, 3000),
        ("clang", "-O0", False, 4000),
        ("clang", "-O2", True, 5000),
    ],
)
def test_many_random_steps_give_the_same_bits(tmp_path, request, cut, precision, compiler, level, fused, first):
    # A fused operation is called, never an instruction: of -fma(a, b, c) GCC 12 makes one that mistakes a zero's sign.
    if not shutil.which(compiler):
        pytest.skip(f"no {compiler} is installed")
    if cut:
        request.getfixturevalue("short")
    wrong = []
    for start in range(first, first + MANY, TOGETHER):
        folder = tmp_path / f"{start}"
        seeds = range(start, start + TOGETHER)
        wrong += wrong_seeds(seeds, folder, compiler, (level,), precision=precision, fused=fused)
        shutil.rmtree(folder)
    assert wrong == []
