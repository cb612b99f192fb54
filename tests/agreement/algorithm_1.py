"""Algorithm 1 of the friction paper (Table 3), slow and plain in NumPy matrices: the oracle of the refined monitor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tierod.models.steering_column import FrictionParameters


@dataclass(frozen=True)
class Oracle:
    """Table 3 with every choice that the monitor offers."""

    car: FrictionParameters
    noise: tuple[float, float, float, float, float]
    rows_of_dt: bool = True
    consistent: bool = False
    measured_operating_point: bool = True
    sticking: bool = False
    initial_friction_variance: float = 1.0

    def matrices(self, direction: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A, B and G of eqs (7) to (9)."""
        c, dt = self.car, self.car.sample_time
        a = np.exp(-dt * c.column_damping / c.column_inertia)
        beta = (1.0 - a) / c.column_damping
        wheelbase = c.front_distance + c.rear_distance
        A = np.eye(5)
        A[0, 1] = dt
        A[1, 1], A[1, 3], A[1, 4] = a, -beta * c.steering_ratio, -beta * direction
        A[2, 3] = dt * wheelbase / (c.trail * c.yaw_inertia)
        B = np.zeros((5, 3))
        B[1, 0], B[1, 1] = beta, c.motor_ratio * beta
        B[2, 2] = -dt * c.rear_distance * c.mass / c.yaw_inertia
        G = np.zeros((5, 5))
        G[:, :3] = B
        G[3, 3] = G[4, 4] = dt if self.rows_of_dt else 1.0
        return A, B, G

    def run(self, samples: np.ndarray) -> dict[str, np.ndarray]:
        """Columns angle, rate, driver, motor, yaw rate, lateral acceleration -> friction, deviation, torque, nis."""
        C, R = np.eye(3, 5), 1e-4 * np.eye(3)
        x = np.array([0.0, 0.0, 0.0, 0.0, 3.0])
        P = np.diag([1e-2, 1e-2, 1e-2, 100.0, self.initial_friction_variance])
        u, measured_rate, rows = np.zeros(3), 0.0, []
        for angle, rate, driver, motor, yaw_rate, acceleration in samples:
            operating = measured_rate if self.measured_operating_point else x[1]
            stands = self.sticking and abs(operating) < 0.05
            A, B, G = self.matrices(0.0 if stands else np.sign(operating))
            Q = np.diag(self.noise) + np.diag([16.0 if stands else 0.0, 0, 0, 0, 0])
            x, P = A @ x + B @ u, A @ P @ A.T + G @ Q @ G.T
            y = np.array([angle, rate, yaw_rate])
            there = np.isfinite(y)
            H, r = C[there], R[np.ix_(there, there)]
            whole = np.isfinite([angle, rate, driver, motor, yaw_rate, acceleration]).all()
            enabled = bool(whole and abs(driver) > 0.5 and np.sign(driver) == np.sign(motor) and 0.05 < abs(rate) < 1.0)
            E = np.diag([1.0, 1.0, 1.0, 1.0, float(enabled)])
            S = H @ P @ H.T + r
            K = P @ H.T @ np.linalg.inv(S)
            innovation = y[there] - H @ x
            x = x + E @ K @ innovation
            gain = E @ K if self.consistent else K
            I_KC = np.eye(5) - gain @ H
            P = I_KC @ P @ I_KC.T + gain @ r @ gain.T if self.consistent else I_KC @ P
            u = np.where(np.isfinite([driver, motor, acceleration]), [driver, motor, acceleration], u)
            measured_rate = rate if np.isfinite(rate) else measured_rate
            nis = innovation @ np.linalg.solve(S, innovation)
            rows.append([x[4], np.sqrt(P[4, 4]), float(enabled), x[3], nis])
        names = ("friction_torque", "friction_deviation", "enabled", "self_aligning_torque", "nis")
        return dict(zip(names, np.array(rows).T, strict=True))
