import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.methods.estimators import kernels
from tierod.methods.estimators import linear_algebra as la
from tierod_lab.methods.unscented import correct_jointly

seeds = st.integers(0, 10_000)


def problem(seed, n=4, m=3):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    P = root @ root.T + 0.1 * np.eye(n)
    C = rng.normal(size=(m, n))
    R = 0.1 + rng.random(m)
    r = rng.normal(size=m)
    r[rng.random(m) < 0.3] = np.nan
    return rng, P, C, R, r


def packed(matrix):
    return la.pack(matrix.tolist())


def full(values):
    return np.array(la.unpack(values), float)


def joint(P, C, R, r):
    used = np.isfinite(r)
    C, R, r = C[used], np.diag(R[used]), r[used]
    S = C @ P @ C.T + R
    K = P @ C.T @ np.linalg.inv(S)
    return K @ r, (np.eye(len(P)) - K @ C) @ P, r @ np.linalg.inv(S) @ r, int(used.sum())


@given(seeds)
def test_scalar_updates_are_the_joint_update(seed):
    _, P, C, R, r = problem(seed)
    shift, after, nis, count = joint(P, C, R, r)
    done = kernels.correct(packed(P), C.tolist(), r.tolist(), R.tolist())
    np.testing.assert_allclose(done.shift, shift, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(full(done.covariance), after, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(done.nis, nis, rtol=1e-9)
    assert done.present == count


@given(seeds)
def test_joint_kernel_agrees(seed):
    _, P, C, R, r = problem(seed)
    rows = kernels.correct(packed(P), C.tolist(), r.tolist(), R.tolist())
    cross, spread = C @ P, C @ P @ C.T + np.diag(R)
    done = correct_jointly(packed(P), cross.tolist(), packed(spread), r.tolist())
    np.testing.assert_allclose(done.shift, rows.shift, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(done.covariance, rows.covariance, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(done.nis, rows.nis, rtol=1e-8)
    assert done.present == rows.present


@given(seeds)
def test_consider_is_the_joseph_form_of_the_masked_gain(seed):
    rng, P, C, R, r = problem(seed)
    r = np.nan_to_num(r)
    mask = rng.choice([0.0, 1.0, 0.3], size=4)
    S = C @ P @ C.T + np.diag(R)
    gain = np.diag(mask) @ P @ C.T @ np.linalg.inv(S)
    left = np.eye(4) - gain @ C
    joseph = left @ P @ left.T + gain @ np.diag(R) @ gain.T
    done = kernels.correct(packed(P), C.tolist(), r.tolist(), R.tolist())
    structural = tuple(True if e == 1.0 else float(e) for e in mask)
    for given_mask in (tuple(mask.tolist()), structural):
        result = kernels.consider(packed(P), done.covariance, given_mask)
        np.testing.assert_allclose(full(result), joseph, rtol=1e-8, atol=1e-10)
    assert np.linalg.eigvalsh(full(result)).min() > -1e-12


def test_a_state_masked_with_zero_keeps_its_variance_exactly():
    _, P, C, R, r = problem(3)
    done = kernels.correct(packed(P), C.tolist(), r.tolist(), R.tolist())
    result = full(kernels.consider(packed(P), done.covariance, (True, True, True, 0.0)))
    assert result[3, 3] == P[3, 3]
    assert result[0, 0] < P[0, 0]


@pytest.mark.parametrize("with_input", [True, False])
def test_predicted_covariance(with_input):
    rng, P, _, _, _ = problem(5)
    F, G = rng.normal(size=(4, 4)), rng.normal(size=(4, 2))
    expected = F @ P @ F.T + np.diag([0.0, 1.0, 0.0, 2.0])
    extra = (G.tolist(), (0.5, 0.25)) if with_input else ()
    if with_input:
        expected = expected + G @ np.diag([0.5, 0.25]) @ G.T
    result = kernels.predict_covariance(F.tolist(), packed(P), (None, 1.0, 0.0, 2.0), *extra)
    np.testing.assert_allclose(full(result), expected, rtol=1e-12)
    held = kernels.held_covariance(packed(P), (None, 1.0, None, 2.0))
    np.testing.assert_allclose(full(held), P + np.diag([0.0, 1.0, 0.0, 2.0]))
