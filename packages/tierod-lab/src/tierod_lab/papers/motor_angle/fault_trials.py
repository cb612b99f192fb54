"""Trials of a fault: a fault-free drive up to a time at which the motor turns, continued with the fault."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.graph import Memory, Result, scan
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.papers.motor_angle.fault_drives import (
    RATE,
    SUBSTEPS,
    bench_inputs,
    course,
    drive,
    faulty_ports,
    noisy,
    recorded,
)
from tierod_lab.papers.motor_angle.fault_kinds import FAULTS, Fault
from tierod_lab.papers.motor_angle.healthy_drives import bench_monitor
from tierod_lab.studies.effort import Effort

EARLIEST, LATEST, AFTER = 5.5, 7.0, 1.5
"""Earliest and latest start of a fault, and time for which it is watched [s]."""

STROKE = 0.6
"""Time between reversals of the motor in drives at one speed [s]."""

SHARPNESS = 8.0
"""Steepness of the reversals, which take about 0.05 s [-]."""


class Trial(NamedTuple):
    """A drive for the injection of faults.

    Args:
        seed: seed of course and noise
        speed: speed of its strokes [rad/s]; None for a course of many speeds
    """

    seed: int
    speed: float | None


class Found(NamedTuple):
    """Outcome of one fault in one trial.

    Args:
        delay: detection delay from when the fault reaches five degrees to the first alarm [ms]; infinite if undetected
        turning: the same, counting only the time in which the motor turned fast enough for a valid angle [ms]
        first: test that alarmed first
    """

    delay: float
    turning: float
    first: str


NOTHING = Found(np.inf, np.inf, "")
"""Outcome of an undetected fault."""


@dataclass(frozen=True)
class Begun:
    """State of bench and monitor before a fault.

    Args:
        trial: the trial
        step: next step of the bench, the last fault-free one
        bench, monitor: their states before that step
    """

    trial: Trial
    step: int
    bench: Memory
    monitor: Memory


def target(trial: Trial, steps: int) -> np.ndarray:
    """Target angle of the motor every millisecond [rad]."""
    time = np.arange(steps) * SUBSTEPS / RATE
    if trial.speed is None:
        return course(time, trial.seed)
    phase = np.random.default_rng(trial.seed).uniform(0.0, 2.0 * np.pi)
    rate = trial.speed * np.tanh(SHARPNESS * np.sin(np.pi * time / STROKE + phase)) * np.clip(2.0 * time, 0.0, 1.0)
    return np.cumsum(rate) * SUBSTEPS / RATE


def found_in(trials: Sequence[Trial], effort: Effort) -> list[dict[str, Found]]:
    """Outcomes of every fault by name, for each trial in which the motor turns.

    Args:
        trials: the trials
        effort: runs them

    Raises:
        TierodError: a trial could not be simulated
    """
    return [each for each in effort.made(all_faults, trials) if each]


def found_anywhere(names: Sequence[str], seeds: Sequence[int], effort: Effort) -> dict[str, list[Found]]:
    """Outcomes of faults that begin at any time of a drive, by name; other arguments and errors as in `found_in`.

    Args:
        names: names of the faults
        seeds: seeds of the drives
    """
    tasks = [(name, seed) for name in names for seed in seeds]
    found = effort.made(_anywhere, tasks)
    return {name: [each for (other, _), each in zip(tasks, found, strict=True) if other == name] for name in names}


def _anywhere(task: tuple[str, int]) -> Found:
    name, seed = task
    return anywhere(next(fault for fault in FAULTS if fault.name == name), seed)


def all_faults(trial: Trial) -> dict[str, Found]:
    """Outcomes of every fault in one trial, by name; empty where the motor does not turn."""
    begun = begin(trial)
    return {} if begun is None else {fault.name: found(begun, fault) for fault in FAULTS}


def begin(trial: Trial) -> Begun | None:
    """Simulate up to a random time at which the motor turns; None where it does not turn."""
    # The interval from `EARLIEST` to `LATEST` runs twice: to find when the motor turns, then up to the chosen step.
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
    """Simulate a fault from that state on, and evaluate its outcome."""
    # One fault-free step comes first, so that a stuck sensor has a reading to hold.
    after = round(AFTER * RATE / SUBSTEPS)
    inputs = bench_inputs(target(begun.trial, begun.step + after)[begun.step :])
    since = np.arange(-1, after - 1) * SUBSTEPS / RATE
    inputs |= faulty_ports(fault, since, inputs["target_motor_angle"])
    ran = scan(MotorBench(), np.column_stack(list(inputs.values())), begun.bench)
    seen = noisy(recorded(ran, inputs, fault.quantum, SUBSTEPS / RATE), np.random.default_rng([begun.trial.seed, 78]))
    return delays(scan(bench_monitor(), seen.samples, begun.monitor), SUBSTEPS, fault)


def anywhere(fault: Fault, seed: int, seconds: float = 9.0) -> Found:
    """Outcome of a fault that begins at any time of a drive, at standstill and in the first seconds as well."""
    start = np.random.default_rng([seed, 3]).integers(500, round(1e3 * (seconds - AFTER))) * 1e-3
    outputs = scan(bench_monitor(), drive(seed, seconds, fault, start).samples)
    return delays(outputs, round(start * RATE), fault)


def delays(outputs: Result, start: int, fault: Fault) -> Found:
    """Outcome of a fault from the alarms of the monitor.

    Args:
        outputs: outputs of the monitor
        start: sample at which the fault begins
        fault: the fault
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
    """Samples from the start to the first alarm, for every test that alarms."""
    names = [name for name in outputs.names if name.startswith("alarms.") and (outputs[name][start:] > 0.5).any()]
    return {name.rsplit(".", 1)[-1]: int(np.argmax(outputs[name][start:] > 0.5)) for name in names}


def _on(
    bench: Memory | None, monitor: Memory | None, asked: np.ndarray, random: np.random.Generator
) -> tuple[Memory, Memory, np.ndarray]:
    """Advance bench and monitor; returns their states, and whether the observed angle was valid at each sample."""
    ran = scan(MotorBench(), asked, bench)
    names = dict(zip(bench_inputs(np.zeros(1)), asked.T, strict=True))
    outputs = scan(bench_monitor(), noisy(recorded(ran, names), random).samples, monitor)
    return ran.state, outputs.state, outputs["compared.known"]
