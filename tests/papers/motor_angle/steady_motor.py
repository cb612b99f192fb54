"""A motor that turns at one speed with constant currents, in closed form: no plant, no integration."""

import numpy as np

TIME = 1e-4
POLE_PAIRS, FLUX, RESISTANCE, INDUCTANCE = 4.0, 0.0085, 0.05, 1e-4
DAMPING = 4e-4


def steady(speed, current_q, seconds=0.5, current_d=0.0, angle=0.1, noise=0.0):
    """Columns of a sample; voltages are exact means over the sample that ends."""
    time = np.arange(round(seconds / TIME)) * TIME
    electrical, turning = POLE_PAIRS * (angle + speed * time), POLE_PAIRS * speed
    rotor = np.exp(1j * electrical)
    current = (current_d + 1j * current_q) * rotor
    voltage = ((RESISTANCE + 1j * turning * INDUCTANCE) * (current_d + 1j * current_q) + 1j * turning * FLUX) * rotor
    half = 0.5 * turning * TIME
    mean = voltage * np.exp(-1j * half) * np.sinc(half / np.pi)
    columns = [current.real, current.imag, mean.real, mean.imag]
    random = np.random.default_rng(4)
    columns = [column + noise * random.normal(size=len(time)) for column in columns]
    return np.column_stack([*columns, angle + speed * time])


def load_torque(speed, current_q):
    """That balances the motor at a steady speed."""
    return 1.5 * POLE_PAIRS * FLUX * current_q - DAMPING * speed
