"""Benches with salient motors and load steps, and the monitor with the values of a vehicle file for them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tierod.core.graph import scan
from tierod.monitors.motor_angle.definition import MotorAngleMonitor
from tierod_lab.ground.cars.benches import MotorBench
from tierod_lab.papers.motor_angle.bench import RATE, BenchDrive, bench, bench_time, clean_drive, course, noisy
from tierod_lab.papers.motor_angle.fault_trials import Found, bench_monitor, delays
from tierod_lab.papers.motor_angle.sensor_faults import Fault

LOAD = 1.6
"""Largest step of the load, half of the motor's torque; it changes the speed by 1.3 rad/s within a sample [N*m]."""
FAST, FAST_LOAD, LOW_SUPPLY = 165.0, 0.8, 11.0
"""Greatest speed of a fast drive [rad/s], largest load step that the motor then carries [N*m], and low supply [V].

At that speed the magnets alone induce more than the voltage that the inverter makes of the supply.
"""
BETWEEN = 0.5  # Mean time between two steps of the load [s]
WEAKENING = 0.9  # Share of the largest voltage above which the drive weakens the flux


@dataclass(frozen=True)
class Assumed:
    """Parameters of a motor in the vehicle file over the true ones."""

    direct: float = 1.0  # direct, quadrature: inductances of the d and q axes
    quadrature: float = 1.0
    resistance: float = 1.0  # resistance, flux: resistance of the winding, flux linkage of the magnets
    flux: float = 1.0


RIGHT = Assumed()


def salient_bench(ratio: float) -> MotorBench:
    """The bench with a salient motor, driven at the least current for a torque and with flux weakening.

    The ratio comes mostly from a smaller d-axis inductance, since a larger q-axis inductance would leave too little
    voltage to brake a load that drives the motor. The bench has no spring; its only load is the stepping one.
    """
    plant = bench(stiffness=0.0)
    machine, control = plant.motor.machine, plant.motor.control
    own = {"inductance_d": machine.inductance_d * ratio**-0.8, "inductance_q": machine.inductance_q * ratio**0.2}
    motor = replace(plant.motor, machine=replace(machine, **own), control=replace(control, weakening=WEAKENING, **own))
    return replace(plant, motor=motor)


@lru_cache(maxsize=64)
def salient_monitor(ratio: float, assumed: Assumed = RIGHT) -> MotorAngleMonitor:
    """The monitor of the motor of `salient_bench`."""
    monitor = bench_monitor()
    p = monitor.observer.parameters
    parameters = replace(
        p,
        motor_inductance=assumed.direct * p.motor_inductance * ratio**-0.8,
        motor_saliency=ratio * assumed.quadrature / assumed.direct,
        motor_resistance=assumed.resistance * p.motor_resistance,
        motor_flux=assumed.flux * p.motor_flux,
    )
    return replace(monitor, observer=replace(monitor.observer, parameters=parameters))


def stepping_load(seconds: float, seed: int, largest: float = LOAD) -> np.ndarray:
    """Piecewise constant load with steps at random times, every millisecond [N*m].

    Args:
        largest: largest step; the load lies within half of it of zero [N*m]
    """
    random = np.random.default_rng([seed, 3])
    steps = len(bench_time(seconds))
    starts = np.cumsum(np.maximum(random.exponential(BETWEEN, steps // 20 + 2), 0.02))
    sizes = np.where(
        random.random(len(starts)) < 0.7,
        random.choice([-1.0, 0.0, 1.0], len(starts)),
        random.uniform(-1.0, 1.0, len(starts)),
    )
    return np.asarray(0.5 * largest * sizes[np.searchsorted(starts, bench_time(seconds), side="right")])


def salient_drive(
    ratio: float, seed: int, seconds: float, fault: Fault | None = None, start: float = 0.0, largest: float = LOAD
) -> BenchDrive:
    """Simulate and record a drive of `salient_bench` under a stepping load, with a fault from `start` on [s]."""
    load = stepping_load(seconds, seed, largest)
    clean = clean_drive(seed, seconds, fault, start, salient_bench(ratio), load)
    return noisy(clean, np.random.default_rng([seed, 77]))


def fast_drive(ratio: float, seed: int, seconds: float) -> BenchDrive:
    """Simulate a drive on a low supply, so fast that the flux is weakened."""
    plant, time = salient_bench(ratio), bench_time(seconds)
    low = replace(plant.motor, inverter=replace(plant.motor.inverter, supply_voltage=LOW_SUPPLY))
    slow = course(time, seed) * np.clip(0.5 * time, 0.0, 1.0)
    target = FAST / float(np.abs(np.gradient(slow, time)).max()) * slow
    load = stepping_load(seconds, seed, FAST_LOAD)
    clean = clean_drive(seed, seconds, None, 0.0, replace(plant, motor=low), load, target)
    return noisy(clean, np.random.default_rng([seed, 77]))


def found_on_salient(ratio: float, seed: int, fault: Fault) -> Found | None:
    """Outcome of a fault that begins at a random time with a valid angle; None without such a time."""
    monitor, seconds = salient_monitor(ratio), 9.0
    known = scan(monitor, salient_drive(ratio, seed, 7.0).samples)["compared.known"] > 0.5
    # Faults begin after 5.5 s, as in `fault_trials`: in the first five seconds nothing is compared with the observer.
    instants = np.flatnonzero(known[55_000:]) + 55_000
    if not len(instants):
        return None
    start = int(np.random.default_rng(seed).choice(instants)) // 10
    seen = salient_drive(ratio, seed, seconds, fault, start * 1e-3)
    return delays(scan(monitor, seen.samples), round(start * 1e-3 * RATE), fault)
