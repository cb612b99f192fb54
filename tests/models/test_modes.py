import numpy as np
import pytest

from tierod.models.linear import LinearSystem, describe, modes, scaled


def test_a_hidden_mode_is_found_with_its_direction():
    turn = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, -1.0], [1.0, 0.0, 1.0]])
    A = turn @ np.diag([0.9, 0.5, 0.2]) @ np.linalg.inv(turn)
    C = np.array([[1.0, 0.0, 1.0]]) @ np.linalg.inv(turn)
    found = modes(LinearSystem.of(A, C, states=("a", "b", "c")))
    assert found[0].margin < 1e-12
    assert found[1].margin > 1e-3
    assert found[0].eigenvalue == pytest.approx(0.5)
    np.testing.assert_allclose(found[0].direction / found[0].direction[0], turn[:, 1] / turn[0, 1], atol=1e-9)
    assert found[0].number == "0.5"
    assert describe(found[0].direction, ("a", "b", "c")) == "1 a + 0.5 b"


def test_a_finely_sampled_system_keeps_its_modes_apart():
    M = np.array([[-1.0, 1.0], [0.0, -2.0]])
    for outputs, hidden in (([[1.0, 0.0]], False), ([[0.0, 1.0]], True)):
        margin = modes(LinearSystem.of(np.eye(2) + 1e-8 * M, outputs))[0].margin
        assert (margin < 1e-7) == hidden


def test_complex_modes():
    found = modes(LinearSystem.of([[0.0, 1.0], [-1.0, 0.0]], [[1.0, 0.0]]))
    assert sorted(mode.eigenvalue.imag for mode in found) == pytest.approx([-1.0, 1.0])
    assert found[0].margin > 0.1
    assert "j" in found[0].number


def test_scaling_of_units_leaves_the_margin_alone():
    rng = np.random.default_rng(0)
    A, C = rng.normal(size=(3, 3)), rng.normal(size=(2, 3))
    units = np.array([1e6, 1.0, 1e-6])
    plain = modes(LinearSystem.of(A, C))[0].margin
    scaled_margin = modes(LinearSystem.of(A * units[:, None] / units, C / units * 1e-3))[0].margin
    assert 0.1 < scaled_margin / plain < 10.0


def test_an_identity_has_size_one():
    form = scaled(LinearSystem.of(np.eye(2), np.eye(2)))
    assert form.size == 1.0
    np.testing.assert_array_equal(form.A, 0.0)
