"""Judges of banks, drawn at random: in C equal to `scan` to the last bit, in functions of bounded length."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from blocks_of_graph import Pair
from exported_c import exported, needs_gcc, reference, run
from tierod.core.block import Ring
from tierod.core.graph import KEEP, Bank, Verdict, maths
from tierod.export.segments import LONGEST
from tierod.export.subject import subject_of_block
from tierod.export.vectors import random_inputs

COUNT = 9
NATIVE = ("-O1", "-march=native", "-ffp-contract=off")


class Level(NamedTuple):
    level: float
    rate: float


@dataclass(frozen=True)
class Lag:
    """Low-pass of an input; a missing one is held."""

    gain: Annotated[float, ""]
    Sample = Pair

    def init(self):
        return 0.0

    def step(self, state, sample):
        given = maths.where(maths.present(sample.a), sample.a, state)
        value = state + self.gain * (given - state)
        return value, Level(value, sample.b - value)


class Outputs(NamedTuple):
    """What a random judge states."""

    results: tuple
    number: float


@dataclass(frozen=True)
class RandomJudge:
    """Loops over lanes, drawn at random: element by element, tied to neighbours, handed on, special for some lanes."""

    seed: int
    limits: tuple[Annotated[float, ""], ...]
    delays: tuple[tuple[int, ...], ...] = ((2, 3, 5, 7), (2, 3, 5, 7), (2, 4, 6, 8, 9))

    def feedback(self):
        return ()

    def init(self):
        lines = tuple(tuple(Ring(delay, 0.5 * row) for delay in own) for row, own in enumerate(self.delays))
        return (0.0,) * COUNT, tuple(float(k) for k in range(COUNT)), 0.0, lines, (0.0,) * COUNT

    def step(self, state, sample):
        generator = np.random.default_rng(self.seed)
        first, second, number, lines, waited = state
        # Clocks, which single precision counts in whole numbers.
        waited = [
            maths.where(maths.present(maths.where(lane.rate > 2.0 + 0.1 * k, np.inf, lane.rate)), 0.0, each + 1.0)
            for k, (lane, each) in enumerate(zip(sample.lanes, waited, strict=True))
        ]
        vectors = [
            list(first), list(second), list(self.limits),
            [lane.level for lane in sample.lanes], [lane.rate for lane in sample.lanes],
        ]  # fmt: skip
        scalars = [number, sample.sample.a, sample.lanes[0].level]
        read = [line.oldest for row in lines for line in row]
        vectors += [
            [read[k % len(read)] for k in range(COUNT)],
            [maths.where(each > 3.0, 1.0, each) for each in waited],
        ]
        for _ in range(14):
            self._grow(generator, vectors, scalars)
        pushed = [maths.where(maths.present(each), each, 0.25) for each in vectors[-1][: len(lines)]]
        after = tuple(tuple(line.push(value) for line in row) for row, value in zip(lines, pushed, strict=True))
        kept = [[maths.limit(maths.where(maths.present(v), v, 0.0), -9.0, 9.0) for v in each] for each in vectors[-2:]]
        chosen = maths.where(maths.present(scalars[-1]), maths.floor(maths.limit(scalars[-1], 0.0, 8.0)), 0.0)
        adopt = [maths.where(kept[0][k] > self.limits[k] + 3.0, chosen, KEEP) for k in range(COUNT)]
        since = [maths.where(each > 3.0, 1.0, 0.25 * each) for each in waited]
        output = Outputs(tuple(vectors[-1] + vectors[-3] + since), chosen)
        return (tuple(kept[0]), tuple(kept[1]), chosen, after, tuple(waited)), Verdict(output, tuple(adopt))

    def _grow(self, generator, vectors, scalars):
        a, b = (vectors[k] for k in generator.integers(len(vectors), size=2))
        scalar = scalars[generator.integers(len(scalars))]
        turned = (
            list(np.roll(np.arange(COUNT), generator.integers(-2, 3))) if generator.random() < 0.4 else range(COUNT)
        )
        b = [b[int(k)] for k in turned]
        special = set(generator.integers(COUNT, size=2).tolist()) if generator.random() < 0.4 else set()
        sets = [sorted(set(generator.integers(12, size=4).tolist())) for _ in range(COUNT)]
        kind = int(generator.integers(8))
        made = []
        best, top = 0.0, scalar
        for k in range(COUNT):
            if k in special:
                made.append(a[k] if kind % 2 else 0.0)
            elif kind == 0:
                made.append(a[k] + 0.5 * b[k])
            elif kind == 1:
                made.append(maths.where(a[k] < b[k], a[k], scalar - b[k]))
            elif kind == 2:
                made.append(maths.where(maths.both(a[k] > scalar, maths.present(b[k])), 1.0, 0.0))
            elif kind == 3:
                made.append(maths.any_of(0.0, *(number == each for number in [scalars[0]] for each in sets[k])))
            elif kind == 4:
                made.append(maths.where(maths.any_of(*(scalars[0] == each for each in sets[k])), a[k], -b[k]))
            elif kind in (5, 6):
                better = maths.both(b[k] < 3.0, a[k] > top)
                best, top = maths.where(better, float(k), best), maths.where(better, a[k], top)
                made.append(best if kind == 5 else top)
            else:
                made.append(maths.absolute(a[k]) / (1.0 + maths.absolute(b[k])))
        vectors.append(made)
        if kind in (5, 6):
            scalars += [best, top]
        elif kind == 2:
            scalars.append(sum(made))


def random_bank(seed):
    generator = np.random.default_rng(seed)
    limits = tuple(generator.normal(size=COUNT).round(2).tolist())
    return Bank(tuple(Lag(0.05 + 0.02 * k) for k in range(COUNT)), RandomJudge(seed, limits))


def equal(folder, seed):
    """The export of a random judge equals `scan` to the last bit; the longest of its functions in lines."""
    subject = subject_of_block("drawn", random_bank(seed), 100.0, "A judge drawn at random")
    inputs = random_inputs(subject, 300, seed)
    inputs[::97] *= -0.0
    inputs[5::101, 1] = np.inf
    face = exported(subject, folder, inputs=inputs, precision="double", libm=False)
    found, wanted = run(face, folder, inputs, flags=NATIVE), reference(subject, inputs)
    same = found.view(np.int64) == wanted.view(np.int64)
    assert (same | (np.isnan(found) & np.isnan(wanted))).all(), np.argwhere(~same)[:5]
    return max(each.count("\n") for each in (folder / "tierod_drawn.c").read_text().split("\n}\n"))


@needs_gcc
@pytest.mark.parametrize("seed", range(3))
def test_judges_equal_scan_to_the_last_bit_in_functions_of_bounded_length(tmp_path, seed):
    assert equal(tmp_path, seed) < 4 * LONGEST
