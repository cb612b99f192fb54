"""A bank in C: one function for all lanes with tables, its judge, and lanes that take over the states of others."""

import subprocess
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bank_of_graph import bank
from blocks_of_graph import Pair
from exported_c import exported, needs_gcc, reference, run, worst_share
from tierod.core.block import Ring
from tierod.core.graph.trace import initial_memory
from tierod.export.c_export import interface_of
from tierod.export.evidence.comparison import _after
from tierod.export.interface import Options
from tierod.export.segments import LONGEST
from tierod.export.subject import subject_of, subject_of_block
from tierod.export.vectors import random_inputs


@dataclass(frozen=True)
class LateReader:
    """Pushes its input at once, and takes the oldest value after more operations than one function holds."""

    gain: Annotated[float, ""] = 0.99
    Sample = Pair

    def init(self):
        return Ring(3, 0.25)

    def step(self, state, sample):
        value = sample.a
        for k in range(3 * LONGEST):
            value = self.gain * value + float(k)
        return state.push(sample.b), Level(value + state.oldest)


class Level(NamedTuple):
    """What the late reader states."""

    level: float


NATIVE = ("-O3", "-march=native", "-ffp-contract=off")


@pytest.fixture(scope="module")
def small():
    return subject_of_block("small", bank(), 100.0, "A bank")


@needs_gcc
@pytest.mark.parametrize(("precision", "validity", "share"), [("double", False, 1e-13), ("single", True, 1e-4)])
def test_a_bank_with_feedback_delay_lines_and_exchanged_lanes_states_what_scan_states(
    small, tmp_path, precision, validity, share
):
    inputs = random_inputs(small, 400)
    face = exported(small, tmp_path, inputs=inputs, precision=precision, validity=validity)
    wanted = reference(small, inputs)
    assert np.ptp(wanted[:, 1]) > 0.0  # lanes are taken over, now these, now those
    assert worst_share(run(face, tmp_path, inputs), wanted).max() <= share


@needs_gcc
def test_with_the_kernels_functions_a_bank_equals_scan_to_the_last_bit(small, tmp_path):
    inputs = random_inputs(small, 400)
    face = exported(small, tmp_path, inputs=inputs, precision="double", libm=False)
    assert np.array_equal(run(face, tmp_path, inputs, flags=NATIVE), reference(small, inputs), equal_nan=True)


@needs_gcc
def test_make_compares_a_bank(small, tmp_path):
    exported(small, tmp_path)
    done = subprocess.run(["make", "-s", "-C", tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr + done.stdout


def test_lanes_share_one_function_and_the_parameters_in_which_they_agree(tmp_path):
    lanes = subject_of("condition", "smartload")
    face = exported(lanes, tmp_path, inputs=random_inputs(lanes, 20))
    source = (tmp_path / "tierod_condition.c").read_text()
    assert source.count("tierod_condition_lane(c, &c->lane[i], &x->lanes[i], u, &x->said[i]);") == 1
    assert f"i < {face.bank.count}U" in source
    values = (tmp_path / "tierod_condition_parameters.c").read_text()
    assert values.count(".trusted_yaw_rate =") == face.bank.count
    assert values.count(".lanes_vehicle_mass =") == 1


def test_clocks_that_have_run_are_those_of_the_judge():
    face = interface_of(subject_of("condition", "smartload"), Options("single"))
    before, after = initial_memory(face.subject.block), _after(face, 500).values
    (place,) = np.flatnonzero(before != after)
    assert face.bank.state[place] == "judge.spans.time"
    assert after[place] == 5.0


@pytest.mark.slow
@needs_gcc
@pytest.mark.parametrize(("vehicle", "validity"), [("smartload", False), ("smartload", True), ("rav4", False)])
def test_the_condition_bank_equals_scan_to_the_last_bit(tmp_path, vehicle, validity):
    subject = subject_of("condition", vehicle)
    inputs = random_inputs(subject, 1500)
    face = exported(subject, tmp_path, inputs=inputs[:50], precision="double", libm=False, validity=validity)
    found, wanted = run(face, tmp_path, inputs, flags=("-O1", *NATIVE[1:])), reference(subject, inputs)
    assert np.array_equal(found, wanted, equal_nan=True)
    assert (np.nanmax(wanted, axis=0) != np.nanmin(wanted, axis=0)).sum() > 30


@needs_gcc
def test_a_delay_line_is_read_before_it_is_overwritten_in_an_earlier_function(tmp_path):
    late = subject_of_block("late", LateReader(), 100.0, "A late reader")
    inputs = np.arange(40.0).reshape(20, 2)
    face = exported(late, tmp_path, inputs=inputs, precision="double")
    assert worst_share(run(face, tmp_path, inputs), reference(late, inputs)).max() <= 1e-13
