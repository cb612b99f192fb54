"""Drives simulated by motulator: machines of several ratings under its current vector control, and sensor readings."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.monitors.motor_angle.observer import MotorAngleSample

SAMPLE_TIME = 1e-4  # Sampling interval of control and recording [s]
CURRENT_NOISE, VOLTAGE_NOISE, ANGLE_NOISE = 2.5e-3, 2.3e-3, 5e-4
"""Standard deviations of noise: current over the largest current, voltage over the supply, shaft angle [rad]."""
HELD, RAMP = 0.5, 0.1  # Interval between changes of speed, and duration of the ramp to the next speed at its start [s]


class Machine(NamedTuple):
    """A permanent-magnet synchronous machine with its supply and load, in SI units."""

    resistance: float
    direct: float  # direct, quadrature: inductances of the d and q axes
    quadrature: float
    flux: float
    pole_pairs: int
    inertia: float  # of rotor and load
    supply: float  # supply voltage of the converter
    current: float  # largest amplitude of the phase current
    speed: float  # largest electrical speed
    load: float  # largest load torque


MACHINES = {
    "12 V, surface magnets": Machine(0.05, 1e-4, 1e-4, 0.0085, 4, 1.2e-3, 13.0, 60.0, 250.0, 1.0),
    "12 V, interior magnets": Machine(0.05, 0.8e-4, 1.3e-4, 0.0085, 4, 1.2e-3, 13.0, 60.0, 250.0, 1.0),
    "48 V, surface magnets": Machine(0.04, 1.5e-4, 1.5e-4, 0.02, 5, 2e-3, 48.0, 80.0, 500.0, 4.0),
    "48 V, interior magnets": Machine(0.04, 1.1e-4, 2.2e-4, 0.02, 5, 2e-3, 48.0, 80.0, 500.0, 4.0),
    "2.2 kW, surface magnets": Machine(3.6, 0.043, 0.043, 0.545, 3, 0.015, 540.0, 9.0, 280.0, 8.0),
    "2.2 kW, interior magnets": Machine(3.6, 0.036, 0.051, 0.545, 3, 0.015, 540.0, 9.0, 280.0, 8.0),
}
"""Machines by name; the last is motulator's own example, the others are assumed."""


class MotorDrive(NamedTuple):
    """A recorded drive."""

    samples: np.ndarray  # signals of `MotorAngleSample` every `SAMPLE_TIME`, (n, signals); NaN where a signal is absent
    angle: np.ndarray  # true mechanical angle of the shaft [rad], (n,)


@lru_cache(maxsize=4)
def motor_drive(name: str, seed: int, seconds: float) -> MotorDrive:
    """Simulate a drive in both directions under motulator's current vector control with a position sensor.

    Args:
        name: name in `MACHINES`

    Raises:
        InputError: motulator is not installed
    """
    machine, random = MACHINES[name], np.random.default_rng([seed, sorted(MACHINES).index(name)])
    current, voltage, angle = _simulated(machine, random, seconds)
    columns = dict[str, np.ndarray]()
    for what, true, noise in (
        ("current", current, CURRENT_NOISE * machine.current),
        ("voltage", voltage, VOLTAGE_NOISE * machine.supply),
    ):
        both = np.column_stack([true.real, true.imag]) + noise * random.normal(size=(len(angle), 2))
        columns |= {f"motor_{what}_alpha": both[:, 0], f"motor_{what}_beta": both[:, 1]}
    columns["motor_angle_mechanical"] = angle + ANGLE_NOISE * random.normal(size=len(angle))
    samples = np.full((len(angle), len(MotorAngleSample._fields)), np.nan)
    for each, values in columns.items():
        samples[:, MotorAngleSample._fields.index(each)] = values
    return MotorDrive(samples, angle)


def _simulated(
    machine: Machine, random: np.random.Generator, seconds: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Complex stator-frame currents [A] and mean voltages [V] of each sample, and mechanical shaft angle [rad]."""
    try:
        from motulator.drive import model
        from motulator.drive.control import sm
        from motulator.drive.utils import SynchronousMachinePars
    except ImportError:
        raise InputError("the drives of motulator are not here to judge on; pip install motulator") from None
    m = machine
    levels = m.speed * random.uniform(-1.0, 1.0, round(seconds / HELD) + 2)
    loads = m.load * random.uniform(-1.0, 1.0, len(levels))
    knots = [0.0] + [at for k in range(1, len(levels)) for at in (k * HELD, k * HELD + RAMP)]
    speeds = [0.0] + [speed for k in range(1, len(levels)) for speed in ([0.0, *levels[1:]][k - 1], levels[k])]
    given = SynchronousMachinePars(n_p=m.pole_pairs, R_s=m.resistance, L_d=m.direct, L_q=m.quadrature, psi_f=m.flux)
    load = lambda time: loads[np.minimum((np.asarray(time) / HELD).astype(int), len(loads) - 1)]  # noqa: E731
    drive = model.Drive(
        model.VoltageSourceConverter(u_dc=m.supply),
        model.SynchronousMachine(given),
        model.StiffMechanicalSystem(J=m.inertia, tau_L=load),
    )
    reference = sm.CurrentReferenceCfg(given, nom_w_m=2.0 * m.speed, max_i_s=m.current)
    control = sm.CurrentVectorControl(given, reference, T_s=SAMPLE_TIME, J=m.inertia, sensorless=False)
    control.ref.w_m = lambda time: float(np.interp(time, knots, speeds))
    model.Simulation(drive, control).simulate(t_stop=seconds)
    seen = control.data
    made = (2.0 / 3.0) * m.supply * (np.asarray(seen.ref.d_abc) @ np.exp(2j * np.pi / 3.0 * np.arange(3)))
    # The converter applies a command one sample after its computation and holds it for one sample, so that the mean
    # voltage of the interval that ends at sample k is the command of k - 2.
    voltage = np.concatenate([[0.0, 0.0], made[:-2]])
    return np.asarray(seen.fbk.i_ss), voltage, np.unwrap(np.asarray(seen.fbk.theta_m)) / m.pole_pairs
