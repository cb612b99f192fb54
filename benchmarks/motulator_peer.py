"""Default motor angle observer compared with motulator's sensorless one, on motulator's own 2.2 kW machine.

`python -m benchmarks.motulator_peer` prints the table of docs/explanation/motor-angle.md in half a minute; it is not
part of `make bench`.
"""

from __future__ import annotations

import sys
from functools import lru_cache
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.models.stator_frame_motor import SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleTuning

SAMPLE_TIME = 250e-6
RESISTANCE, ALONG, ACROSS, FLUX, PAIRS, INERTIA = 3.6, 0.036, 0.051, 0.545, 3, 0.015
"""Parameters of motulator's permanent-magnet machine, example "2.2-kW PMSM" [SI units]."""

SUPPLY, TORQUE = 540.0, 14.0  # Supply voltage of the converter [V], and rated torque of the machine [N*m]

COURSE = (0.0, 0.05, -0.02, 0.1, -0.05, 0.02, -0.1, 0.0)
"""Speeds, per unit of 75 Hz, each for `HELD`, with 40 % of the rated torque in the second half of each."""

HELD, SETTLED = 0.8, 0.2  # Duration of each speed, and settling time after each change that is not evaluated [s]

CURRENT_NOISE, ANGLE_NOISE = 0.02, 5e-4
"""Noise added to the currents of both observers [A], and to the sensor that initialises ours [rad]."""

TUNING = MotorAngleTuning(
    current_noise=CURRENT_NOISE,
    voltage_noise=0.2,
    speed_wander=0.02,
    load_wander=0.1,
    least_current=0.3,
    standing_speed=0.3,
    slow_speed=1.0,
    first_load=3.0,
    first_speed=5.0,
)
"""Tuning for a machine of 540 V and 4.3 A, chosen on a different course with different noise."""

WARM = 1.2  # Ratio of the machine's resistance to that assumed by both observers


class Drive(NamedTuple):
    """Measurements, with vectors as complex numbers, and the true angle."""

    time: np.ndarray  # of the samples [s]
    current: np.ndarray  # in stator coordinates [A]
    voltage: np.ndarray  # mean over the preceding sampling interval [V]
    # voltage input of motulator's observer: mean of this interval's and the next one's voltage [V]
    realised: np.ndarray
    angle: np.ndarray  # true electrical angle [rad]


def _machine(factor: float = 1.0):
    from motulator.drive.utils import SynchronousMachinePars

    return SynchronousMachinePars(n_p=PAIRS, R_s=factor * RESISTANCE, L_d=ALONG, L_q=ACROSS, psi_f=FLUX)


@lru_cache(maxsize=4)
def drive(warm: float) -> Drive:
    """Simulation by motulator with its own current vector control and a sensor.

    Args:
        warm: ratio of the machine's resistance to that assumed by the control
    """
    from motulator.common.utils import abc2complex
    from motulator.drive import model
    from motulator.drive.control import sm
    from motulator.drive.utils import BaseValues, NominalValues

    base = BaseValues.from_nominal(NominalValues(U=370, I=4.3, f=75, P=2.2e3, tau=TORQUE), n_p=PAIRS)
    machine = model.Drive(
        model.VoltageSourceConverter(u_dc=SUPPLY),
        model.SynchronousMachine(_machine(warm)),
        model.StiffMechanicalSystem(J=INERTIA, tau_L=lambda time: 0.4 * TORQUE * (time % HELD > 0.5 * HELD)),
    )
    reference = sm.CurrentReferenceCfg(_machine(), nom_w_m=base.w, max_i_s=1.5 * base.i)
    control = sm.CurrentVectorControl(_machine(), reference, T_s=SAMPLE_TIME, J=INERTIA, sensorless=False)
    knots = [0.0] + [at for k in range(1, len(COURSE)) for at in (k * HELD, k * HELD + 0.1)]
    speeds = [COURSE[0]] + [speed for k in range(1, len(COURSE)) for speed in COURSE[k - 1 : k + 1]]
    control.ref.w_m = lambda time: base.w * float(np.interp(time, knots, speeds))
    model.Simulation(machine, control).simulate(t_stop=HELD * len(COURSE))
    seen = control.data
    made = abc2complex(np.asarray(seen.ref.d_abc).T) * SUPPLY
    # A voltage command takes effect one sample after its computation, and remains for one sample.
    voltage = np.concatenate([[0.0, 0.0], made[:-2]])
    angle = np.unwrap(np.asarray(seen.fbk.theta_m))
    return Drive(np.asarray(seen.ref.t), np.asarray(seen.fbk.i_ss), voltage, np.asarray(seen.fbk.u_ss), angle)


def theirs(seen: Drive, current: np.ndarray, bandwidth: float) -> np.ndarray:
    """Electrical angle estimated by motulator's sensorless observer, initialised at the true angle [rad].

    Args:
        seen: measurements
        current: with noise [A]
        bandwidth: of its speed estimator [rad/s]
    """
    from motulator.drive.control.sm import Observer, ObserverCfg

    observer = Observer(ObserverCfg(_machine(), True, alpha_o=bandwidth))
    observer.est.theta_m = float(seen.angle[0])
    found = np.empty(len(seen.time))
    for k, (voltage, measured) in enumerate(zip(seen.realised, current, strict=True)):
        signals = SimpleNamespace(u_ss=voltage, i_ss=measured)
        observer.output(signals)
        found[k] = signals.theta_m
        observer.update(SAMPLE_TIME, signals)
    return found


def ours(seen: Drive, current: np.ndarray, increments: bool) -> np.ndarray:
    """Electrical angle estimated by the default observer [rad].

    With the q-axis inductance, its flux is the active flux psi + (L_d - L_q) i_d of a salient machine.

    Args:
        seen: measurements
        current: with noise [A]
        increments: whether the sensor is used at low speed, or only for initialisation
    """
    parameters = SampledMotorParameters(RESISTANCE, ACROSS, FLUX, float(PAIRS), INERTIA, 0.0, SAMPLE_TIME)
    sensor = seen.angle / PAIRS + ANGLE_NOISE * np.random.default_rng(11).normal(size=len(seen.time))
    if not increments:
        sensor[1:] = np.nan
    samples = np.column_stack([current.real, current.imag, seen.voltage.real, seen.voltage.imag, sensor])
    return PAIRS * scan(MotorAngleObserver(parameters, TUNING), samples)["motor_angle"]


def by_speed(seen: Drive, found: np.ndarray) -> dict[float, float]:
    """Root-mean-square electrical error without whole turns, by per-unit speed [rad]."""
    error = np.angle(np.exp(1j * (found - seen.angle)))
    step = np.minimum((seen.time / HELD).astype(int), len(COURSE) - 1)
    speed, settled = np.abs(np.array(COURSE))[step], seen.time - step * HELD > SETTLED
    return {
        float(each): float(np.sqrt(np.mean(error[settled & (speed == each)] ** 2)))
        for each in np.unique(np.abs(COURSE))
    }


def run() -> list[dict]:
    """Rows: ratio of resistances, observer, error by per-unit speed [rad]."""
    rows = []
    for warm in (1.0, WARM):
        seen = drive(warm)
        random = np.random.default_rng(7)
        noise = CURRENT_NOISE * (random.normal(size=len(seen.time)) + 1j * random.normal(size=len(seen.time)))
        current = seen.current + noise
        found = {
            "ours, increments when slow": ours(seen, current, True),
            "ours, sensor to begin only": ours(seen, current, False),
            "motulator, 40 Hz": theirs(seen, current, 2.0 * np.pi * 40.0),
            "motulator, 100 Hz": theirs(seen, current, 2.0 * np.pi * 100.0),
        }
        rows += [
            {"resistance": warm, "observer": name, "error": by_speed(seen, angle)} for name, angle in found.items()
        ]
    return rows


def main() -> int:
    """Print the table, or with --json the rows; returns the exit code."""
    rows = run()
    if "--json" in sys.argv:
        import json

        print(json.dumps(rows))
        return 0
    from rich.console import Console
    from rich.table import Table

    speeds = sorted(rows[0]["error"])
    table = Table("resistance over known", "observer", *(f"{speed:g} pu" for speed in speeds))
    for row in rows:
        table.add_row(f"{row['resistance']:g}", row["observer"], *(f"{row['error'][speed]:.4f}" for speed in speeds))
    Console(width=120).print("Error of the electrical angle, rms in rad, by speed per unit of 75 Hz", table, sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
