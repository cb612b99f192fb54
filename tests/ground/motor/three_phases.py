"""An independent motor: three phases in star with inductances that depend on the angle, integrated by SciPy."""

import numpy as np
from scipy.integrate import solve_ivp

SHIFT = 2.0 * np.pi / 3.0


class ThreePhases:
    """Textbook machine in phase coordinates; torque is the derivative of the coenergy.

    Args:
        machine: its numbers: resistance, inductances, flux, pole pairs, inertia, damping
        load: opposing torque [N*m]
    """

    def __init__(self, machine, load=0.0):
        self.machine, self.load = machine, load
        leakage = 0.2 * min(machine.inductance_d, machine.inductance_q)
        self.leakage = leakage
        self.mean = (machine.inductance_d + machine.inductance_q - 2.0 * leakage) / 3.0
        self.swing = (machine.inductance_d - machine.inductance_q) / 3.0

    def inductance(self, electrical, derivative=False):
        place = np.arange(3)
        angle = 2.0 * electrical - SHIFT * (place[:, None] + place[None, :])
        if derivative:
            return -2.0 * self.swing * np.sin(angle)
        mutual = np.where(np.eye(3, dtype=bool), self.mean, -0.5 * self.mean)
        return mutual + self.swing * np.cos(angle) + self.leakage * np.eye(3)

    def magnets(self, electrical, derivative=False):
        angle = electrical - SHIFT * np.arange(3)
        return self.machine.flux * (-np.sin(angle) if derivative else np.cos(angle))

    def slope(self, _time, state, voltage):
        machine, current, (speed, angle) = self.machine, state[:3], state[3:]
        electrical = machine.pole_pairs * angle
        change = self.inductance(electrical, derivative=True) @ current + self.magnets(electrical, derivative=True)
        induced = machine.pole_pairs * speed * change
        current_slope = np.linalg.solve(self.inductance(electrical), voltage - machine.resistance * current - induced)
        reluctance = 0.5 * current @ self.inductance(electrical, derivative=True) @ current
        torque = machine.pole_pairs * (reluctance + current @ self.magnets(electrical, derivative=True))
        return [*current_slope, (torque - machine.damping * speed - self.load) / machine.inertia, speed]

    def run(self, voltages, period):
        """State (phase currents, speed, angle) after every period of phase voltages, shape (n, 3)."""
        state, states = np.zeros(5), []
        for voltage in voltages:
            solved = solve_ivp(self.slope, (0.0, period), state, args=(voltage,), rtol=1e-9, atol=1e-9)
            state = solved.y[:, -1]
            states.append(state)
        return np.array(states)
