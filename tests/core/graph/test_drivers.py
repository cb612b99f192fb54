"""The three drivers and both engines give the same numbers."""

from collections import deque

import numpy as np
import pytest

from blocks_of_graph import Everything
from tierod.core.block import Ring, leaves, rebuild
from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import Memory, Scanner, Stream, batch, scan
from tierod.core.recording import Aligned

pytestmark = pytest.mark.usefixtures("shipped_kernels")


@pytest.fixture
def samples():
    values = np.random.default_rng(1).normal(size=(2500, 2))
    values[10], values[20, 0], values[30, 1] = np.nan, np.inf, np.nan
    return values


def by_hand(block, samples):
    """The slow, obvious driver: plain floats, a deque for each delay line."""
    state = block.init()
    lines = {path: deque([leaf.initial] * leaf.size) for path, leaf in leaves(state) if isinstance(leaf, Ring)}
    rows = []
    for row in samples:
        heads = [leaf._replace(oldest=lines[path].popleft()) if path in lines else leaf for path, leaf in leaves(state)]
        state, output = block.step(rebuild(state, heads), block.Sample(*row.tolist()))
        for path, leaf in leaves(state):
            if path in lines:
                lines[path].append(leaf.newest)
        rows.append([leaf for _, leaf in leaves(output)])
    return np.array(rows)


def test_scan_gives_what_plain_floats_give(samples):
    result = scan(Everything(), samples)
    np.testing.assert_allclose(result.values, by_hand(Everything(), samples), rtol=1e-12, atol=1e-12)
    assert result.names == ("result", "nested.a", "nested.b")


def test_the_virtual_machine_gives_what_compiled_code_gives(samples):
    interpreted = scan(Everything(), samples, engine="virtual machine")
    compiled = scan(Everything(), samples, engine="compiled")
    np.testing.assert_allclose(interpreted.values, compiled.values, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(interpreted.state.values, compiled.state.values, rtol=1e-12, atol=1e-12)


def test_lanes_equal_scans_to_the_last_bit(samples):
    blocks = [Everything(gain=0.01 * lane) for lane in range(70)]
    lengths = [2500 - 30 * lane for lane in range(70)]
    results = batch(blocks, [samples[:length] for length in lengths])
    for block, length, result in zip(blocks, lengths, results, strict=True):
        alone = scan(block, samples[:length])
        np.testing.assert_array_equal(result.values, alone.values)
        np.testing.assert_array_equal(result.state.values, alone.state.values)


@pytest.mark.parametrize("engine", ["compiled", "virtual machine"])
def test_a_scanner_goes_on_from_piece_to_piece(samples, engine):
    block = Everything(gain=0.21)
    whole, scanner = scan(block, samples, engine=engine), Scanner(block, engine)
    first = scanner.scan(samples[:701])
    second = scanner.scan(samples[701:], first.state)
    np.testing.assert_array_equal(np.vstack([first.values, second.values]), whole.values)
    assert second.state.count == len(samples)
    with pytest.raises(InputError, match="remembers"):
        scanner.scan(samples, Memory(np.zeros(2), 5))


def test_wrong_samples_are_refused(samples):
    with pytest.raises(InputError, match=r"2 signals \(a, b\).*\(2500, 1\)"):
        scan(Everything(), samples[:, :1])
    with pytest.raises(InputError, match="needs the signal 'b'; did you mean 'bb'"):
        scan(Everything(), Aligned(np.arange(2500), samples, ("a", "bb")))
    with pytest.raises(InputError, match="no 'b'.*NaN stands for a measurement"):
        Stream(Everything()).push({"a": 1.0})
    with pytest.raises(InputError, match=r"needs 2 numbers \(a, b\)"):
        Stream(Everything()).push((1.0, 2.0, 3.0))
    with pytest.raises(InputError, match="no output 'resul'; did you mean 'result'"):
        scan(Everything(), samples)["resul"]
    with pytest.raises(InputError, match="3 recordings came with 2 blocks"):
        batch([Everything(), Everything()], [samples] * 3)
    with pytest.raises(ParameterError, match="'jit' is unknown"):
        scan(Everything(), samples, engine="jit")
    with pytest.raises(InputError, match="not all numbers.*NaN where one is missing"):
        scan(Everything(), [["a", "b"]])
    with pytest.raises(InputError, match=r"needs 2 numbers \(a, b\).*own Sample"):
        Stream(Everything()).push(1.0)
    with pytest.raises(InputError, match=r"needs 2 numbers \(a, b\)"):
        Stream(Everything()).push({"a": 1.0, "b": None})


@pytest.mark.parametrize("state", [Memory(np.zeros(2), 0), Memory(np.zeros(9), -1), (1.0,)])
def test_the_state_of_another_block_is_refused(samples, state):
    with pytest.raises(InputError, match="remembers 9 numbers; go on from the state of a block of the same structure"):
        scan(Everything(), samples, state)
