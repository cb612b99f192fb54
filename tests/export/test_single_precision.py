"""Single precision stays close to double: how that is measured, and growth that is not rounded away."""

import shutil
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from blocks_of_graph import Pair
from exported_c import exported, needs_gcc, reference, rounded, run
from tierod.core.graph.maths import where
from tierod.export.evidence import comparison as single_precision
from tierod.export.evidence.comparison import Aim, aim_of, apart, beside_double
from tierod.export.subject import subject_of_block
from tierod.export.vectors import random_inputs
from watched_torque import Watch


class Level(NamedTuple):
    """What the variance is."""

    level: float


@dataclass(frozen=True)
class Variance:
    """Variance of a number that is measured again and again, and wanders."""

    growth: Annotated[float, ""] = 2.9e-8
    noise: Annotated[float, ""] = 1e7
    Sample = Pair

    def init(self):
        return Level(1.0)

    def step(self, state, sample):
        gain = state.level / (state.level + self.noise)
        level = state.level - gain * state.level
        level = level + where(sample.a > 0.0, self.growth, 0.0)
        return Level(level), Level(level)


@pytest.fixture(scope="module")
def watch():
    return subject_of_block("watch", Watch(), 100.0, "A watch")


@needs_gcc
def test_growth_that_is_less_than_the_last_bit_of_a_variance_is_not_rounded_away(tmp_path):
    subject = subject_of_block("variance", Variance(), 100.0, "A variance")
    inputs = np.ones((200_000, 2))
    face = exported(subject, tmp_path, inputs=inputs[:100], precision="single")
    found, wanted = run(face, tmp_path, inputs)[-1, 0], reference(subject, inputs)[-1, 0]
    assert abs(found - wanted) < 5e-3


@needs_gcc
def test_the_estimate_and_the_longest_stretch_of_another_status_are_measured(watch, tmp_path, monkeypatch):
    face = exported(watch, tmp_path)
    (tmp_path / "build").mkdir()
    assert aim_of(face) is None
    output = face.subject.graph.output[0]
    monkeypatch.setitem(single_precision.AIMS, watch.monitor, Aim(output, 1e-3, "N"))
    samples = {"random": rounded(random_inputs(watch, 500))}
    found = apart(face, tmp_path, samples)
    assert [each.hours for each in found] == [0.0, 100.0]
    assert all(each.within(aim_of(face)) and each.steps == 500 for each in found)
    file = tmp_path / f"{face.prefix}_parameters.c"
    file.write_text(file.read_text().replace(".limit = 2.0", ".limit = 1.0"))
    worse = apart(face, tmp_path, {"high": np.full((100, 1), 5.0)})
    assert worse[0].longest > 0.0
    assert not worse[0].within(aim_of(face))
    shown = beside_double(face, found)
    assert shown.rows[1][1] == "100 h"
    assert "may differ by 0.001 N" in shown.note


def test_an_absent_compiler_is_a_row(watch, tmp_path, monkeypatch):
    face = exported(watch, tmp_path)
    monkeypatch.setenv("PATH", "")
    assert shutil.which("gcc") is None
    (row,) = beside_double(face, apart(face, tmp_path, {})).rows
    assert row[1].startswith("not run: could not be run")
