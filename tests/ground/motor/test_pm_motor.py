"""The motor with its drive, beside an independent machine and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ground.rigs import Run
from tierod.physics.motor import StatorVector, inverse_clarke
from tierod_lab.ground.cars.benches import MotorBench
from tierod_lab.ground.motor import AFS_MOTOR, EPS_MOTOR, Inverter, Warming

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


PERIOD = 1e-4
IDEAL = Inverter(dead_time=0.0, forward_drop=0.0)
TORQUE_CONSTANT = 0.051
COLD = Warming(ambient_temperature=293.15)
"""Resistance and flux are stated at this temperature."""


def smooth(motor=AFS_MOTOR, **changed):
    machine = replace(motor.machine, **{"friction": 0.0, "cogging": 0.0} | changed)
    return replace(motor, machine=machine, inverter=IDEAL, warming=COLD)


def bench(motor):
    return MotorBench(motor, load_stiffness=0.0)


@pytest.mark.parametrize("motor", [smooth(), smooth(EPS_MOTOR)])
def test_it_turns_as_three_phases_do(motor):
    """The same voltages fed to an independent machine in phase coordinates, open loop, up to 0.09 rad per period."""
    run = Run(bench(motor), 60, motor_torque=1.2, load_torque=0.1)
    voltages = StatorVector(run["motor_voltage_alpha"][1:], run["motor_voltage_beta"][1:])
    phases = np.column_stack(inverse_clarke(voltages))
    states = ThreePhases(motor.machine, load=0.1).run(phases, PERIOD)
    assert np.max(states[:, 3]) > 100.0
    size = np.max(np.abs(states[:, 0]))
    np.testing.assert_allclose(run["motor_current_alpha"][1:], states[:, 0], atol=0.01 * size)
    np.testing.assert_allclose(
        run["motor_current_beta"][1:], (states[:, 1] - states[:, 2]) / 3.0**0.5, atol=0.01 * size
    )
    np.testing.assert_allclose(run["motor_speed"][1:], states[:, 3], rtol=1e-3, atol=0.05)
    np.testing.assert_allclose(run["motor_angle_mechanical"][1:], states[:, 4], atol=2e-3)


def test_energy_goes_in_and_is_accounted_for():
    motor = replace(AFS_MOTOR, warming=COLD)
    time = np.arange(600) * 1e-3
    run = Run(replace(bench(motor), load_damping=0.01), 600, motor_torque=1.2 * np.sin(25.0 * time))
    machine, current = motor.machine, np.array([run["motor_current_alpha"], run["motor_current_beta"]])
    speed, voltage = run["motor_speed"], np.array([run["motor_voltage_alpha"], run["motor_voltage_beta"]])
    middle = 0.5 * (current[:, 1:] + current[:, :-1])
    electric = PERIOD * np.sum(1.5 * voltage[:, 1:] * middle)
    heat = PERIOD * np.sum(1.5 * machine.resistance * middle**2)
    viscous = PERIOD * np.sum((machine.damping + 0.01) * speed**2)
    dry = 1e-3 * np.sum(run["truth_motor_friction_torque"] * speed[::10])
    stored = 0.5 * machine.inertia * speed[-1] ** 2 + 0.75 * machine.inductance_d * np.sum(current[:, -1] ** 2)
    assert electric == pytest.approx(heat + viscous + dry + stored, rel=0.01)
    assert 0.1 < (viscous + dry) / electric < 0.9


def test_the_winding_warms_up_to_the_closed_form():
    warming = Warming(winding_capacity=0.5, housing_capacity=0.4, ambient_temperature=293.15)
    motor = replace(smooth(flux=AFS_MOTOR.machine.flux), warming=warming)
    run = Run(bench(motor), 12_000, motor_torque=0.5, locked=1.0)
    current = 0.5 / TORQUE_CONSTANT
    rise = 1.0 / warming.winding_conductance + 1.0 / warming.housing_conductance
    cold_heat = 1.5 * 0.05 * current**2
    expected = cold_heat * rise / (1.0 - cold_heat * rise / 255.0)
    assert run["motor_temperature"][-1] - 293.15 == pytest.approx(expected, rel=0.01)
    assert run["truth_motor_resistance"][-1] == pytest.approx(0.05 * (1.0 + expected / 255.0), rel=0.01)
    assert run["truth_motor_flux"][-1] < motor.machine.flux
