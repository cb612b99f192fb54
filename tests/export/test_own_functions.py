"""The export with the kernels' own sine, logarithm and the like is the kernel, to the last bit."""

import re
import shutil
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from exported_c import exported, needs_gcc, reference, rounded, run, worst_share
from tierod.core.block import Scalar
from tierod.core.graph.maths import (
    arcsin,
    arctan,
    arctan2,
    cos,
    exp,
    expm1,
    hypot,
    log,
    power,
    sin,
    tan,
    tanh,
)
from tierod.export.subject import subject_of, subject_of_block
from tierod.export.vectors import random_inputs

OF_ONE = {each.__name__: each for each in (arcsin, arctan, cos, exp, expm1, log, sin, tan, tanh)}
OF_TWO = {each.__name__: each for each in (arctan2, hypot, power)}
KERNEL_FLAGS = ("-O3", "-march=native", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")

Values = NamedTuple("Values", [(name, Annotated[Scalar, ""]) for name in (*OF_ONE, *OF_TWO)])


class Point(NamedTuple):
    """What the functions are taken of."""

    x: Annotated[Scalar, ""]
    y: Annotated[Scalar, ""]


@dataclass(frozen=True)
class Functions:
    """Every function that has no instruction of its own."""

    Sample = Point

    def init(self) -> tuple[()]:
        return ()

    def step(self, state: tuple[()], sample: Point) -> tuple[tuple[()], Values]:
        return state, Values(*(f(sample.x) for f in OF_ONE.values()), *(f(sample.x, sample.y) for f in OF_TWO.values()))


POINTS = np.array([[0.3, -0.7], [-0.9, 2.0], [0.0, 0.0], [1.0, 30.0], [np.nan, 1.0], [3e6, 1e-3], [-2.0, 3.0]])


@needs_gcc
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize(("precision", "share"), [("double", 1e-14), ("single", 1e-6)])
def test_every_function_compiles_without_a_warning_and_agrees(tmp_path, precision, share, compiler):
    if not shutil.which(compiler):
        pytest.skip(f"no {compiler} is installed")
    subject = subject_of_block("functions", Functions(), 100.0)
    inputs = rounded(POINTS)
    face = exported(subject, tmp_path, POINTS, precision=precision, libm=False)
    found, wanted = run(face, tmp_path, inputs, compiler=compiler), reference(subject, inputs)
    assert np.array_equal(np.isnan(found), np.isnan(wanted))
    finite = np.isfinite(wanted)
    assert np.array_equal(found[~finite], wanted[~finite], equal_nan=True)
    assert np.all(np.abs(found[finite] - wanted[finite]) <= share * np.maximum(np.abs(wanted[finite]), 1.0))


@needs_gcc
def test_on_the_same_compiler_the_export_is_the_kernel_to_the_last_bit(tmp_path):
    subject = subject_of("sideslip", "midsize-eps")
    inputs = rounded(random_inputs(subject, 2000, seed=3))
    face = exported(subject, tmp_path, inputs[:200], precision="double", libm=False)
    assert worst_share(run(face, tmp_path, inputs, flags=KERNEL_FLAGS), reference(subject, inputs)).max() == 0.0


def test_only_square_root_absolute_value_and_roundings_are_left_of_the_library(tmp_path):
    subject = subject_of("sideslip", "midsize-eps")
    exported(subject, tmp_path, libm=False)
    code = re.sub(r"/\*.*?\*/", "", (tmp_path / "tierod_sideslip.c").read_text(), flags=re.DOTALL)
    called = set(re.findall(r"\b([a-z]\w*)\(", code)) - {"if", "for", "while", "sizeof", "return"}
    foreign = {name for name in called if not name.startswith("tierod_")}
    assert foreign <= {"fabsf", "sqrtf", "floorf", "ceilf", "fmaf", "memcpy"}
    assert "tierod_sideslip_atan2" in called
    assert "tierod_sideslip_pow" not in called
