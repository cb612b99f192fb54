import numpy as np
import pytest
from scipy.linalg import expm

from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem, sampled
from tierod_lab.papers.column.control.lqr import lqr, require_stabilisable, with_delay, with_integral


def mass(sample_time=0.1):
    """x'' = u, the position as output."""
    continuous = LinearSystem(
        np.array([[0.0, 1.0], [0.0, 0.0]]),
        np.array([[0.0], [1.0]]),
        np.array([[1.0, 0.0]]),
        np.zeros((1, 1)),
        ("position", "speed"),
        ("force",),
        ("place",),
    )
    return sampled(continuous, sample_time)


def test_a_scalar_system_has_the_gain_of_its_quadratic_equation():
    system = LinearSystem.of([[1.2]], [[1.0]], [[1.0]])
    q, r, a = 2.0, 3.0, 1.2
    cost = 0.5 * (q - r * (1.0 - a * a) + np.sqrt((q - r * (1.0 - a * a)) ** 2 + 4.0 * q * r))
    found = lqr(system, [q], [r])
    assert found.cost[0, 0] == pytest.approx(cost, rel=1e-12)
    assert found.gain[0, 0] == pytest.approx(cost * a / (r + cost), rel=1e-12)


def test_short_samples_give_the_gain_of_the_continuous_mass():
    found = lqr(mass(1e-4), {"position": 1e-4, "speed": 0.0}, [1e-4])
    assert found.of("position") == pytest.approx(1.0, rel=2e-4)
    assert found.of("speed") == pytest.approx(np.sqrt(2.0), rel=2e-4)


def test_the_gain_costs_least():
    system, Q, R = mass(), np.diag([1.0, 0.3]), np.array([[0.2]])
    found = lqr(system, Q, R)
    start = np.array([1.0, -0.5])

    def cost(gain):
        x, total = start, 0.0
        for _ in range(600):
            u = -gain @ x
            total += x @ Q @ x + u @ R @ u
            x = system.A @ x + system.B @ u
        return total

    best = cost(found.gain)
    assert best == pytest.approx(start @ found.cost @ start, rel=1e-9)
    for change in ([[0.05, 0.0]], [[-0.05, 0.0]], [[0.0, 0.05]], [[0.0, -0.05]]):
        assert cost(found.gain + np.array(change)) > best


def test_weights_by_name_of_state_and_output():
    named = lqr(mass(), {"place": 2.0, "speed": 0.5}, [1.0])
    np.testing.assert_allclose(named.gain, lqr(mass(), np.diag([2.0, 0.5]), [1.0]).gain, rtol=1e-12)


def test_the_integral_removes_a_constant_disturbance():
    system = mass()
    found = lqr(with_integral(system, ("place",), 0.1), {"place": 1.0, "place_integral": 0.1}, [1.0])
    x, total = np.zeros(2), 0.0
    for _ in range(2000):
        force = -found.gain[0, :2] @ x - found.gain[0, 2] * total + 0.7
        total += 0.1 * x[0]
        x = system.A @ x + system.B[:, 0] * force
    assert abs(x[0]) < 1e-9


def test_a_delayed_system_is_the_system_one_sample_later():
    system, late = mass(), with_delay(mass())
    random = np.random.default_rng(0)
    forces = random.normal(size=20)
    x, z = np.zeros(2), np.zeros(3)
    for before, now in zip(np.concatenate([[0.0], forces]), forces, strict=False):
        np.testing.assert_allclose(z[:2], x, atol=1e-12)
        x = system.A @ x + system.B[:, 0] * before
        z = late.A @ z + late.B[:, 0] * now
    assert late.states == ("position", "speed", "previous_force")


def test_the_regulator_of_a_delayed_system_feeds_back_the_state_that_is_to_come():
    plain = lqr(mass(), {"place": 1.0}, [0.1])
    late = lqr(with_delay(mass()), {"place": 1.0}, [0.1])
    np.testing.assert_allclose(late.gain[0, :2], plain.gain[0] @ plain.system.A, rtol=1e-9)
    assert late.of("previous_force") == pytest.approx(float(plain.gain[0] @ plain.system.B[:, 0]), rel=1e-9)


def test_a_smoothed_input_moves_by_its_share():
    late = with_delay(mass(), 0.75)
    z = late.A @ np.array([0.0, 0.0, 2.0]) + late.B[:, 0] * 1.0
    assert z[2] == pytest.approx(0.75 * 2.0 + 0.25)
    with pytest.raises(ParameterError, match="kept is 1.0"):
        with_delay(mass(), 1.0)


def test_a_direction_that_no_input_moves_is_named():
    A = expm(np.diag([0.5, -1.0]) * 0.1)
    system = LinearSystem.of(A, [[1.0, 1.0]], [[0.0], [1.0]], states=("drift", "lag"))
    with pytest.raises(ParameterError, match=r"do not move .* drift \(eigenvalue 1.05127\)"):
        lqr(system, [1.0, 1.0], [1.0])
    require_stabilisable(LinearSystem.of(A, [[1.0, 1.0]], [[1.0], [0.0]]))


def test_a_direction_without_weight_is_named():
    with pytest.raises(ParameterError, match=r"does not weigh .* position \(eigenvalue 1\)"):
        lqr(mass(), {"speed": 1.0}, [1.0])


@pytest.mark.parametrize(
    ("state", "command", "says"),
    [
        ({"place": -1.0}, [1.0], "weight of place is -1.0"),
        ({"plaice": 1.0}, [1.0], "did you mean 'place'"),
        ([1.0, -1.0], [1.0], "state_weight has the eigenvalue -1"),
        ([1.0, 1.0], [0.0], "above zero"),
        ([1.0, 1.0], [-1.0], "above zero"),
        ([1.0], [1.0], "expected 2 finite weights"),
        ([1.0, np.nan], [1.0], "finite"),
    ],
)
def test_wrong_weights_are_refused(state, command, says):
    with pytest.raises(ParameterError, match=says):
        lqr(mass(), state, command)
