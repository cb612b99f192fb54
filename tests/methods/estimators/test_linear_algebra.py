import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.graph.maths import is_symbol
from tierod.methods.estimators import linear_algebra as la
from tierod_lab.methods.unscented import cholesky

sizes = st.integers(1, 6)
seeds = st.integers(0, 10_000)


def spd(rng, n):
    root = rng.normal(size=(n, n))
    return root @ root.T + 0.1 * np.eye(n)


def full(packed):
    return np.array(la.unpack(packed), float)


def as_floats(matrix):
    return [[float(value) for value in row] for row in matrix]


@given(sizes, seeds)
def test_congruence_is_the_product_of_three_matrices(n, seed):
    rng = np.random.default_rng(seed)
    P, M = spd(rng, n), rng.normal(size=(3, n)) * (rng.random((3, n)) < 0.6)
    result = full(la.congruence(as_floats(M), la.pack(as_floats(P))))
    np.testing.assert_allclose(result, M @ P @ M.T, rtol=1e-12, atol=1e-12)


@given(sizes, sizes, seeds)
def test_scaled_congruence_is_g_q_g(n, m, seed):
    rng = np.random.default_rng(seed)
    G, q = rng.normal(size=(n, m)), rng.random(m)
    result = full(la.scaled_congruence(as_floats(G), q.tolist()))
    np.testing.assert_allclose(result, G @ np.diag(q) @ G.T, rtol=1e-12, atol=1e-12)


@given(sizes, seeds)
def test_cholesky(n, seed):
    P = spd(np.random.default_rng(seed), n)
    packed = la.pack(as_floats(P))
    np.testing.assert_allclose(cholesky(packed), np.linalg.cholesky(P), rtol=1e-9, atol=1e-12)


@given(st.integers(2, 6), seeds)
def test_cholesky_of_a_semidefinite_matrix_is_finite_and_multiplies_back(n, seed):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n - 1))
    P = root @ root.T
    P[0, :] = P[:, 0] = 0.0
    factor = np.array(cholesky(la.pack(as_floats(P))), float)
    assert np.isfinite(factor).all()
    np.testing.assert_allclose(factor @ factor.T, P, atol=1e-5 * np.abs(P).max())


def test_packing_round_trip():
    packed = tuple(map(float, range(10)))
    assert la.pack(la.unpack(packed)) == packed
    assert la.order(packed) == 4
    assert la.diagonal(packed) == (0.0, 4.0, 7.0, 9.0)
    assert la.diagonal(la.from_diagonal((1.0, 2.0))) == (1.0, 2.0)


def test_structural_zeros_and_ones_leave_no_operation():
    x, y = casadi.SX.sym("x"), casadi.SX.sym("y")
    assert la.times(0.0, x) == 0.0
    assert la.times(1.0, x) is x
    assert la.dot((0.0, 1.0, 0.0), (x, y, x)) is y
    assert is_symbol(la.times(2.0, x))
    unit_rows = ((1.0, 0.0), (0.0, 1.0))
    packed = tuple(casadi.SX.sym(name) for name in "abc")
    assert all(kept is given_ for kept, given_ in zip(la.congruence(unit_rows, packed), packed, strict=True))


@pytest.mark.parametrize("n", [1, 2, 5])
def test_product_and_add(n):
    rng = np.random.default_rng(n)
    M, v = rng.normal(size=(n, n)), rng.normal(size=n)
    np.testing.assert_allclose(la.product(as_floats(M), v.tolist()), M @ v)
    np.testing.assert_allclose(la.add(v.tolist(), v.tolist()), 2.0 * v)
