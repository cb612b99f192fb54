"""A bank gives the same numbers from every driver, and what its parts give one by one."""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
import pytest

from bank_of_graph import HighestJudge, Lane, Marked, Pair, bank, ringed
from tierod.core.block import leaves
from tierod.core.errors import TraceError
from tierod.core.graph import Bank, JudgeSample, Stream, Verdict, batch, scan, trace
from tierod.core.graph.trace import flat_memory


@pytest.fixture
def samples():
    values = np.random.default_rng(1).normal(size=(400, 2))
    values[10], values[20, 0], values[30, 1] = np.nan, np.inf, np.nan
    return values


def by_hand(bank_, samples):
    """Lanes one by one, the judge, then the copies; a deque for the judge's delay line. Output and final levels."""
    states, judged, said = [lane.init() for lane in bank_.lanes], bank_.judge.init(), bank_.judge.feedback()
    line = deque([judged[1].initial] * judged[1].size)
    rows = []
    for row in samples:
        sample = Pair(*row.tolist())
        stepped = [lane.step(state, sample, said) for lane, state in zip(bank_.lanes, states, strict=True)]
        judged = (judged[0], judged[1]._replace(oldest=line.popleft()))
        judged, verdict = bank_.judge.step(judged, JudgeSample(sample, tuple(out for _, out in stepped)))
        line.append(judged[1].newest)
        after, said = [state for state, _ in stepped], verdict.feedback
        states = [after[int(j)] if j >= 0.0 else own for j, own in zip(verdict.adopt, after, strict=True)]
        rows.append(tuple(verdict.output))
    return np.array(rows), states


@pytest.mark.parametrize("count", [2, 8, 11])
def test_it_gives_what_its_parts_give_one_by_one(samples, count):
    result = scan(bank(count), samples)
    expected, states = by_hand(bank(count), samples)
    np.testing.assert_allclose(result.values, expected, rtol=1e-9, atol=1e-12)
    lanes = flat_memory(bank(count).init()._replace(lanes=tuple(states)))[: trace(bank(count)).lanes_memory]
    shape = (-1, 3, 8)
    mine = result.state.values[: len(lanes)].reshape(shape).transpose(0, 2, 1).reshape(-1, 3)[:count]
    np.testing.assert_allclose(mine, np.array(states), rtol=1e-9, atol=1e-12)
    assert (result["level"] > 0.0).any(), "lanes take over states"


def test_stream_and_batch_equal_a_scan_to_the_last_bit(samples):
    offline, live = scan(bank(), samples), Stream(bank())
    pushed = np.array([live.push(row) for row in samples])
    np.testing.assert_array_equal(pushed, offline.values)
    np.testing.assert_array_equal(live.state.values, offline.state.values)
    banks = [replace(bank(), judge=HighestJudge(11, behind)) for behind in np.linspace(0.01, 0.2, 20)]
    for each, result in zip(banks, batch(banks, [samples] * 20), strict=True):
        np.testing.assert_array_equal(result.values, scan(each, samples).values)


@dataclass(frozen=True)
class Silent:
    """Gives no feedback and adopts the given lanes, whether they exist or not."""

    adopt: tuple[float, ...]

    def feedback(self):
        return ()

    def init(self):
        return ()

    def step(self, state, sample):
        return state, Verdict(sample.lanes[1], self.adopt)


@dataclass(frozen=True)
class Sum:
    """Adds up; without feedback."""

    gain: float = 1.0
    Sample = Pair

    def init(self):
        return 0.0

    def step(self, state, sample):
        total = state + self.gain * sample.a
        return total, Marked(total, sample.b)


@pytest.mark.parametrize("adopt", [(-1.0, 0.0), (1.0, 0.0), (7.0, float("nan")), (0.5, -0.2)])
def test_every_driver_copies_alike_and_not_at_all_where_no_such_lane_is(adopt):
    block, samples = Bank((Sum(1.0), Sum(2.0)), Silent(adopt)), np.arange(20.0).reshape(10, 2)
    expected, state = [], block.init()
    for row in samples:
        state, output = block.step(state, Pair(*row.tolist()))
        expected.append([leaf for _, leaf in leaves(output)])
    np.testing.assert_array_equal(scan(block, samples).values, expected)
    np.testing.assert_array_equal(scan(block, samples, engine="virtual machine").values, expected)


def test_what_cannot_be_a_bank_is_refused():
    with pytest.raises(TraceError, match="delay line"):
        trace(ringed())
    with pytest.raises(TraceError, match="differ in more than their floats"):
        trace(Bank((Lane(), Sum()), HighestJudge(2)))
    with pytest.raises(TraceError, match="3 lanes to adopt for 2 lanes"):
        trace(Bank((Sum(), Sum()), Silent((-1.0, -1.0, -1.0))))
    with pytest.raises(TraceError, match="no lanes"):
        trace(Bank((), Silent(())))
