import numpy as np
from scipy.linalg import solve_discrete_are

from tierod.models.linear import LinearSystem
from tierod_lab.papers.sideslip.schedule import error_radius, stationary_covariance


def test_the_covariance_of_an_optimal_gain_is_that_of_the_riccati_equation():
    system = LinearSystem.of([[0.9, 0.1], [0.0, 0.8]], [[1.0, 0.0]])
    process, reading = np.diag([0.1, 0.2]), np.array([[0.5]])
    predicted = solve_discrete_are(system.A.T, system.C.T, process, reading)
    innovation = system.C @ predicted @ system.C.T + reading
    gain = predicted @ system.C.T / innovation
    found = stationary_covariance(system, gain, (0.1, 0.2), (0.5,))
    np.testing.assert_allclose(found.corrected, (np.eye(2) - gain @ system.C) @ predicted, atol=1e-9)
    np.testing.assert_allclose(found.innovation, innovation, atol=1e-9)
    assert error_radius(system, gain) < 0.9
