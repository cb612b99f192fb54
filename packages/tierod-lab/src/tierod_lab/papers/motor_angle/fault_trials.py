"""The bench's monitor, faults put into a drive of it, delays until its alarms; the same with salient motors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar, Tree
from tierod.core.graph import Memory, Result, scan
from tierod.core.graph.maths import greatest_of, maximum
from tierod.monitors.motor_angle.definition import MotorAngleMonitor
from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import MotorBench
from tierod_lab.papers.motor_angle.bench import (
    FLUX,
    INDUCTANCE,
    RATE,
    RESISTANCE,
    SUBSTEPS,
    BenchDrive,
    Fault,
    bench,
    bench_inputs,
    bench_time,
    clean_drive,
    course,
    faulty_ports,
    noisy,
    recorded,
    with_true,
)

EARLIEST, LATEST, AFTER = 5.5, 7.0, 1.5  # Earliest and latest start of a fault, and time for which it is watched [s]
STEPS = (0.819173, 0.671044, 0.549700)
"""Increments of an additive recurrence that fills three ranges evenly: powers of 1/1.220744, root of x^4 = x + 1."""


@cache
def bench_monitor() -> MotorAngleMonitor:
    """The monitor of the bench, with the parameters of its vehicle file."""
    return MotorAngleMonitor.of_vehicle(load("motor-bench"), 1.0 / RATE)


def other_motor(number: int) -> MotorAngleMonitor:
    """The bench's monitor with the parameters of another motor; successive numbers fill three ranges evenly."""
    monitor = bench_monitor()
    shares = [(0.5 + number * step) % 1.0 for step in STEPS]
    factors = [
        low + share * (high - low) for (low, high), share in zip((RESISTANCE, FLUX, INDUCTANCE), shares, strict=True)
    ]
    assumed = with_true(monitor.observer.parameters, *factors)
    return replace(monitor, observer=replace(monitor.observer, parameters=assumed))


@dataclass(frozen=True)
class AlarmWatch:
    """A monitor reduced to the outputs that a count of false alarms needs."""

    monitor: MotorAngleMonitor

    Sample = MotorAngleSample

    class State(NamedTuple):
        monitor: Tree
        alarmed: Scalar

    class Output(NamedTuple):
        known: Annotated[float, ""]
        alarmed: Annotated[float, ""]

    def init(self) -> State:
        return self.State(self.monitor.init(), 0.0)

    def step(self, state: State, sample: MotorAngleSample) -> tuple[State, Output]:
        after, output = self.monitor.step(state.monitor, sample)
        alarmed = maximum(state.alarmed, greatest_of(*output.alarms.in_order()))
        return self.State(after, alarmed), self.Output(output.compared.known, alarmed)


class Found(NamedTuple):
    """Outcome of one fault in one trial."""

    # detection delay from when the fault reaches five degrees to the first alarm [ms]; infinite if undetected
    delay: float
    turning: float  # the same, counting only the time in which the motor turned fast enough for a valid angle [ms]
    first: str  # test that alarmed first


@dataclass(frozen=True)
class Begun:
    """State of bench and monitor before a fault, and the next step of the bench, the last fault-free one."""

    seed: int
    step: int
    bench: Memory
    monitor: Memory


def _target(seed: int, steps: int) -> np.ndarray:
    """Target angle of the motor every millisecond [rad]."""
    return course(np.arange(steps) * SUBSTEPS / RATE, seed)


def begin(seed: int) -> Begun | None:
    """Simulate up to a random time at which the motor turns; None where it does not turn."""
    # The interval from `EARLIEST` to `LATEST` runs twice: to find when the motor turns, then up to the chosen step.
    early, late = (round(seconds * RATE / SUBSTEPS) for seconds in (EARLIEST, LATEST))
    asked = np.column_stack(list(bench_inputs(_target(seed, late)).values()))
    random = np.random.default_rng([seed, 77])
    bench, monitor, known = _on(None, None, asked[:early], random)
    _, _, known = _on(bench, monitor, asked[early:], random)
    turning = np.flatnonzero(known > 0.5)
    if not len(turning):
        return None
    step = early + int(np.random.default_rng(seed).choice(turning)) // SUBSTEPS
    bench, monitor, _ = _on(bench, monitor, asked[early : step - 1], random)
    return Begun(seed, step - 1, bench, monitor)


def found(begun: Begun, fault: Fault) -> Found:
    """Simulate a fault from that state on, and evaluate its outcome."""
    # One fault-free step comes first, so that a stuck sensor has a reading to hold.
    after = round(AFTER * RATE / SUBSTEPS)
    inputs = bench_inputs(_target(begun.seed, begun.step + after)[begun.step :])
    since = np.arange(-1, after - 1) * SUBSTEPS / RATE
    inputs |= faulty_ports(fault, since, inputs["target_motor_angle"])
    ran = scan(MotorBench(), np.column_stack(list(inputs.values())), begun.bench)
    seen = noisy(recorded(ran, inputs, fault.quantum, SUBSTEPS / RATE), np.random.default_rng([begun.seed, 78]))
    return delays(scan(bench_monitor(), seen.samples, begun.monitor), SUBSTEPS, fault)


def delays(outputs: Result, start: int, fault: Fault) -> Found:
    """Outcome of a fault that begins at a sample, from the outputs of the monitor."""
    alarms = {
        name.rsplit(".", 1)[-1]: int(np.argmax(outputs[name][start:] > 0.5))
        for name in outputs.names
        if name.startswith("alarms.") and (outputs[name][start:] > 0.5).any()
    }
    if not alarms:
        return Found(np.inf, np.inf, "")
    name = min(alarms, key=lambda each: alarms[each])
    grown = round(fault.size * RATE)
    delay = 1e3 * (alarms[name] - grown) / RATE
    turned = 1e3 * float(outputs["compared.known"][start + grown : start + alarms[name]].sum()) / RATE
    return Found(delay, min(turned, delay), name)


def _on(
    bench: Memory | None, monitor: Memory | None, asked: np.ndarray, random: np.random.Generator
) -> tuple[Memory, Memory, np.ndarray]:
    """Advance bench and monitor; returns their states, and whether the observed angle was valid at each sample."""
    ran = scan(MotorBench(), asked, bench)
    names = dict(zip(bench_inputs(np.zeros(1)), asked.T, strict=True))
    outputs = scan(bench_monitor(), noisy(recorded(ran, names), random).samples, monitor)
    return ran.state, outputs.state, outputs["compared.known"]


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


def salient_drive(ratio: float, seed: int, seconds: float) -> BenchDrive:
    """Simulate and record a drive of `salient_bench` under a stepping load."""
    clean = clean_drive(seed, seconds, None, 0.0, salient_bench(ratio), stepping_load(seconds, seed))
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
