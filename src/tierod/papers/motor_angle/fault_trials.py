"""Trials of a fault: a drive of the bench up to an instant at which its motor turns, and from there with the fault."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.graph import Memory, Result, scan
from tierod.experiments.effort import Effort
from tierod.papers.motor_angle.fault_drives import (
    RATE,
    SUBSTEPS,
    bench_inputs,
    course,
    drive,
    faulty_ports,
    noisy,
    recorded,
)
from tierod.papers.motor_angle.fault_kinds import FAULTS, Fault
from tierod.papers.motor_angle.healthy_drives import bench_monitor
from tierod.proving_ground.cars.motor_bench import MotorBench

EARLIEST, LATEST, AFTER = 5.5, 7.0, 1.5
"""Of the begin of a fault, and how long it is watched then [s]."""

STROKE = 0.6
"""Time in which the motor turns one way at a given speed [s]."""

SHARPNESS = 8.0
"""Of its reversals: they take about 0.05 s."""


class Trial(NamedTuple):
    """A drive into which faults are put.

    Args:
        seed: of course and noise
        speed: of its strokes [rad/s]; None for a course of many speeds
    """

    seed: int
    speed: float | None


class Found(NamedTuple):
    """Outcome of one fault in one trial.

    Args:
        delay: from when it is as large as five degrees to the first alarm [ms]; infinite where none came
        turning: the same, of time in which the motor turned fast enough for its angle to be known [ms]
        first: test that alarmed first
    """

    delay: float
    turning: float
    first: str


NOTHING = Found(np.inf, np.inf, "")


@dataclass(frozen=True)
class Begun:
    """A bench and its monitor at the instant before a fault.

    Args:
        trial: which
        step: of the bench that comes next, the last fault-free one
        bench, monitor: between two steps
    """

    trial: Trial
    step: int
    bench: Memory
    monitor: Memory


def target(trial: Trial, steps: int) -> np.ndarray:
    """Angle that is asked of the motor, every millisecond [rad]."""
    time = np.arange(steps) * SUBSTEPS / RATE
    if trial.speed is None:
        return course(time, trial.seed)
    phase = np.random.default_rng(trial.seed).uniform(0.0, 2.0 * np.pi)
    rate = trial.speed * np.tanh(SHARPNESS * np.sin(np.pi * time / STROKE + phase)) * np.clip(2.0 * time, 0.0, 1.0)
    return np.cumsum(rate) * SUBSTEPS / RATE


def found_in(trials: Sequence[Trial], effort: Effort) -> list[dict[str, Found]]:
    """Every fault in every trial, by the fault's name; nothing of a trial in which the motor does not turn.

    Args:
        trials: drives
        effort: that makes them

    Raises:
        TierodError: a trial could not be simulated
    """
    return [each for each in effort.made(all_faults, trials) if each]


def found_anywhere(names: Sequence[str], seeds: Sequence[int], effort: Effort) -> dict[str, list[Found]]:
    """Faults that begin at any instant of drives, by name; further arguments and errors as of `found_in`.

    Args:
        names: of the faults
        seeds: of the drives
    """
    tasks = [(name, seed) for name in names for seed in seeds]
    found = effort.made(_anywhere, tasks)
    return {name: [each for (other, _), each in zip(tasks, found, strict=True) if other == name] for name in names}


def _anywhere(task: tuple[str, int]) -> Found:
    name, seed = task
    return anywhere(next(fault for fault in FAULTS if fault.name == name), seed)


def all_faults(trial: Trial) -> dict[str, Found]:
    """Every fault in one trial."""
    begun = begin(trial)
    return {} if begun is None else {fault.name: found(begun, fault) for fault in FAULTS}


def begin(trial: Trial) -> Begun | None:
    """Up to a random instant at which the motor turns; None where it does not."""
    early, late = (round(seconds * RATE / SUBSTEPS) for seconds in (EARLIEST, LATEST))
    asked = np.column_stack(list(bench_inputs(target(trial, late)).values()))
    random = np.random.default_rng([trial.seed, 77])
    bench, monitor, known = _on(None, None, asked[:early], random)
    _, _, known = _on(bench, monitor, asked[early:], random)
    turning = np.flatnonzero(known > 0.5)
    if not len(turning):
        return None
    step = early + int(np.random.default_rng(trial.seed).choice(turning)) // SUBSTEPS
    bench, monitor, _ = _on(bench, monitor, asked[early : step - 1], random)
    return Begun(trial, step - 1, bench, monitor)


def found(begun: Begun, fault: Fault) -> Found:
    """Outcome of a fault from there on."""
    after = round(AFTER * RATE / SUBSTEPS)
    inputs = bench_inputs(target(begun.trial, begun.step + after)[begun.step :])
    since = np.arange(-1, after - 1) * SUBSTEPS / RATE
    inputs |= faulty_ports(fault, since, inputs["target_motor_angle"])
    ran = scan(MotorBench(), np.column_stack(list(inputs.values())), begun.bench)
    seen = noisy(recorded(ran, inputs, fault.quantum, SUBSTEPS / RATE), np.random.default_rng([begun.trial.seed, 78]))
    return delays(scan(bench_monitor(), seen.samples, begun.monitor), SUBSTEPS, fault)


def anywhere(fault: Fault, seed: int, seconds: float = 9.0) -> Found:
    """A fault that begins at any instant of a drive, standing and in the first seconds included."""
    start = np.random.default_rng([seed, 3]).integers(500, round(1e3 * (seconds - AFTER))) * 1e-3
    outputs = scan(bench_monitor(), drive(seed, seconds, fault, start).samples)
    return delays(outputs, round(start * RATE), fault)


def delays(outputs: Result, start: int, fault: Fault) -> Found:
    """Delay until the first alarm.

    Args:
        outputs: of the monitor
        start: sample at which the fault begins
        fault: which
    """
    alarms = alarms_after(outputs, start)
    if not alarms:
        return NOTHING
    name = min(alarms, key=lambda each: alarms[each])
    grown = round(fault.size * RATE)
    delay = 1e3 * (alarms[name] - grown) / RATE
    turned = 1e3 * float(outputs["compared.known"][start + grown : start + alarms[name]].sum()) / RATE
    return Found(delay, min(turned, delay), name)


def alarms_after(outputs: Result, start: int) -> dict[str, int]:
    """Samples from the start to the begin of every alarm."""
    names = [name for name in outputs.names if name.startswith("alarms.") and (outputs[name][start:] > 0.5).any()]
    return {name.rsplit(".", 1)[-1]: int(np.argmax(outputs[name][start:] > 0.5)) for name in names}


def _on(
    bench: Memory | None, monitor: Memory | None, asked: np.ndarray, random: np.random.Generator
) -> tuple[Memory, Memory, np.ndarray]:
    """Bench and monitor some steps on, and whether the angle was known."""
    ran = scan(MotorBench(), asked, bench)
    names = dict(zip(bench_inputs(np.zeros(1)), asked.T, strict=True))
    outputs = scan(bench_monitor(), noisy(recorded(ran, names), random).samples, monitor)
    return ran.state, outputs.state, outputs["compared.known"]
