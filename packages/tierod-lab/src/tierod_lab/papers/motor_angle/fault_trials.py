"""The bench's monitor, faults put into a drive of it, and the delays until its alarms."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
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
    bench_inputs,
    course,
    faulty_ports,
    noisy,
    recorded,
    with_true,
)
from tierod_lab.papers.motor_angle.sensor_faults import Fault

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
