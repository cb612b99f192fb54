"""Bias of the estimated speed by an unmodelled load: predicted from the gains, and measured on the bench."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tierod.core.block import Block
from tierod.core.claims import Claim, at_most, between
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Points, Table
from tierod.physics.pm_motor import back_emf_constant, torque_constant
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.dq_motor import DqMotorParameters, q_axis_motor, with_load
from tierod_lab.papers.motor_angle.fault_drives import SUBSTEPS
from tierod_lab.papers.motor_angle.luenberger import full_observer, reduced_observer, speed_per_load
from tierod_lab.papers.motor_angle.observer_drives import SAMPLE_TIME, ObserverDrive, bench, drive, locked
from tierod_lab.papers.motor_angle.printed_observers import (
    FULL_POLES,
    LOAD_POLE,
    REDUCED_POLES,
    extended_kalman,
    luenberger,
    reduced_luenberger,
)
from tierod_lab.papers.motor_angle.reported import LOAD, SEEDS
from tierod_lab.studies.effort import Effort

LEVELS = (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6)
"""Levels of the load, besides the dry friction [N*m]."""
SPEED = 40.0
"""Speed of the motor [rad/s]."""
STEPS = 500
"""Steps of the bench at every level, of which the second half is in steady state and evaluated."""
WARMER = 1.2
"""True resistance over the assumed one: a winding that is some 50 K warmer."""


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "A load that is not known makes the speed wrong",
        (
            "The observers of the paper leave out the load: so the balance of torques, not the current, gives them the "
            "speed. In steady state the error follows from the gains: -1/(b + c_M (K_t - J k_2)/(R + L k_1)) for the "
            "full observer, 1/(J p) for the reduced one. Park's transform turns by the measured angle here.",
        ),
    )
    repeats = 1 if effort.quick else 4
    drives = [stepped(seed) for seed in SEEDS.of(LOAD, repeats)]
    slopes = {name: slope(observer, drives) for name, observer in _observers().items()}
    computed = predicted()
    yield _table(slopes, computed)
    yield _chart(drives[0])
    yield from _claims(slopes, computed)
    yield _standing_claim()


def standing() -> tuple[float, float]:
    """Speed estimated by the observer with load for a warm motor at standstill: measured and predicted [rad/s]."""
    p, torque = load("motor-bench").parameters_for(DqMotorParameters), 0.6
    seen = locked(bench(), np.full(1000, torque), 5)
    estimated = seen.observed(_observers()["full, with load, R 20 % higher than known"])["motor_speed"][5000:].mean()
    current = torque / torque_constant(p.motor_pole_pairs, p.motor_flux)
    missing = p.motor_resistance * (1.0 - 1.0 / WARMER)
    return float(estimated), missing * current / back_emf_constant(p.motor_pole_pairs, p.motor_flux)


def stepped(seed: int) -> ObserverDrive:
    """A drive of the bench at one speed, with a step of the load every half second."""
    time = np.arange(STEPS * len(LEVELS)) * SUBSTEPS * SAMPLE_TIME
    return drive(bench(stiffness=0.0), SPEED * time, np.repeat(LEVELS, STEPS), seed)


def settled(observer: Block, seen: ObserverDrive) -> tuple[np.ndarray, np.ndarray]:
    """Mean load [N*m] and mean speed error, true less estimated [rad/s], in steady state at every level."""

    def mean(values: np.ndarray) -> np.ndarray:
        halves = values.reshape(len(LEVELS), -1)
        return np.asarray(halves[:, halves.shape[1] // 2 :].mean(axis=1))

    return mean(seen.load), mean(seen.speed - seen.observed(observer)["motor_speed"])


def slope(observer: Block, drives: list[ObserverDrive]) -> float:
    """Measured speed error per load [rad/s per N*m]."""
    return float(np.mean([np.polyfit(*settled(observer, seen), 1)[0] for seen in drives]))


def predicted() -> dict[str, float]:
    """Speed error per load predicted from the gains, by observer [rad/s per N*m]."""
    p = load("motor-bench").parameters_for(DqMotorParameters)
    true, printed = q_axis_motor(p), q_axis_motor(p, "printed")
    loaded = with_load(true, p.motor_inertia)
    warm = replace(p, motor_resistance=p.motor_resistance / WARMER)
    cold = with_load(q_axis_motor(warm), p.motor_inertia)
    return {
        "full": speed_per_load(full_observer(true, FULL_POLES), true, p),
        "full, torque constant as printed": speed_per_load(full_observer(printed, FULL_POLES), true, p),
        "full, with load": speed_per_load(full_observer(loaded, (*FULL_POLES, LOAD_POLE)), true, p),
        "full, with load, R 20 % higher than known": speed_per_load(
            full_observer(cold, (*FULL_POLES, LOAD_POLE)), true, p
        ),
        "reduced": speed_per_load(reduced_observer(true, REDUCED_POLES), true, p),
        "reduced, with load": speed_per_load(reduced_observer(loaded, (*REDUCED_POLES, LOAD_POLE)), true, p),
    }


def _observers() -> dict[str, Block]:
    p = load("motor-bench").parameters_for(DqMotorParameters)
    colder = replace(p, motor_resistance=p.motor_resistance / WARMER)
    return {
        "full": luenberger(p, load=False, sample_time=SAMPLE_TIME, axes="measured"),
        "full, torque constant as printed": luenberger(
            p, load=False, torque_constant="printed", sample_time=SAMPLE_TIME, axes="measured"
        ),
        "full, with load": luenberger(p, sample_time=SAMPLE_TIME, axes="measured"),
        "full, with load, R 20 % higher than known": luenberger(colder, sample_time=SAMPLE_TIME, axes="measured"),
        "reduced": reduced_luenberger(p, load=False, sample_time=SAMPLE_TIME, axes="measured"),
        "reduced, with load": reduced_luenberger(p, sample_time=SAMPLE_TIME, axes="measured"),
        "Kalman filter": extended_kalman(p, load=False, sample_time=SAMPLE_TIME, axes="measured"),
        "Kalman filter, with load": extended_kalman(p, sample_time=SAMPLE_TIME, axes="measured"),
    }


def _table(slopes: dict[str, float], computed: dict[str, float]) -> Table:
    rows = tuple(
        (name, f"{computed[name]:.2f}" if name in computed else "", f"{value:.2f}") for name, value in slopes.items()
    )
    return Table(
        "Error of the speed per load, true less estimated (rad/s per N·m)",
        ("observer", "computed", "measured"),
        rows,
        f"{len(LEVELS)} levels of load at {SPEED:g} rad/s, the dry friction of the motor included in the load.",
    )


def _chart(seen: ObserverDrive) -> Chart:
    observers, marks = _observers(), []
    for name in ("full", "reduced", "Kalman filter", "full, with load"):
        loads, errors = settled(observers[name], seen)
        marks.append(Points(name, loads, errors))
    span = np.array([seen.load.min(), seen.load.max()])
    computed = predicted()
    lines = tuple(Lines(name, span, computed[name] * span, dashed=True) for name in ("full", "reduced"))
    panel = Panel("", "load (N·m)", "speed less estimate (rad/s)", (*marks, *lines))
    return Chart(
        "motor-angle-load-bias",
        "Error of the speed over the load",
        "Marks are measured on the bench; dashed lines follow from the gains.",
        "Three observers without load err in proportion to it, one with the load as a state does not.",
        (panel,),
    )


def _standing_claim() -> Claim:
    measured, computed = standing()
    return Claim(
        "motor-angle.standstill.printed",
        "Held still by a torque, with a resistance 20 % above the known one, an observer estimates a speed dR i/c_M",
        "Reinelt et al., Figure 7: an offset as soon as the motor stands still",
        None,
        100.0 * abs(measured / computed - 1.0),
        at_most(5.0),
        "percent",
        f"Measured {measured:.2f}, computed {computed:.2f} rad/s at 0.6 N·m; integrated, the angle runs away.",
    )


def _claims(slopes: dict[str, float], computed: dict[str, float]) -> Iterator[Claim]:
    for name, key in (("full", "full"), ("reduced", "reduced")):
        yield Claim(
            f"motor-angle.load-bias.{key}",
            f"The {name} Luenberger observer without load errs as its gains say",
            "Reinelt et al., final value of the error's equation (24)",
            None,
            slopes[name],
            between(*sorted((0.98 * computed[name], 1.02 * computed[name]))),
            "rad/s/(N*m)",
            derived=round(computed[name], 2),
        )
    for name, key in (("full", "full"), ("reduced", "reduced"), ("Kalman filter", "kalman")):
        value = abs(slopes[f"{name}, with load"])
        yield Claim(
            f"motor-angle.load-state.{key}",
            "With the load as a state the speed is right under load",
            "requirement",
            None,
            value,
            at_most(0.1),
            "rad/s/(N*m)",
            f"{name}, Park's transform by the measured angle, the resistance right; a wrong one errs by dR/(c_M K_t).",
        )
