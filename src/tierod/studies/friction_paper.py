"""The figures of Mohtat et al. on virtual drives: its estimators as printed and as corrected, claim by claim.

`python -m tierod.studies.friction_paper` prints the tables of docs/friction.md; it takes about a minute.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tierod.graph import scan
from tierod.identification.hysteresis import HysteresisIdentification, Support, friction_increase
from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.baseline import BaselineFrictionMonitor, BaselineGate, BaselineParameters
from tierod.monitors.friction.joint_filter import equal_low_pass
from tierod.monitors.friction.refined import RefinedFrictionMonitor, consistent, printed, printed_open
from tierod.monitors.friction.refined_signals import FrictionSample
from tierod.monitors.friction.unscented import unscented
from tierod.proving_ground import EpsCar, FrictionCourse, Scatter, SensorNoise, drive, lock_to_lock
from tierod.recording import Aligned
from tierod.vehicles import load

RATE = 100.0
SETTLED = 50.0
"""Enabled time that the paper lets its filter converge for [s]."""
THRESHOLD = 7.5
LEVELS = (4.0, 8.0, 12.5)
SEEDS = (1, 2, 3)
HARD_SCATTER = Scatter(tyre_stiffness=0.2, mass=0.08, torque_delay=0.05)


@dataclass(frozen=True)
class Table:
    """Some figures with a sentence on what they are."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def markdown(self) -> str:
        """The table as it stands in the documentation."""
        lines = [self.header, ("---",) * len(self.header), *self.rows]
        return f"{self.title}\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def monitors() -> dict[str, RefinedFrictionMonitor]:
    """The paper's estimators by the name of their preset."""
    car = load("midsize-eps").parameters_for(FrictionParameters)
    return {
        "printed": printed(car),
        "printed, operating point estimated": printed(car, operating_point="estimate"),
        "printed, virtual rows of G one": printed(car, virtual_noise="per sample"),
        "printed_open": printed_open(car),
        "consistent": consistent(car),
        "unscented": unscented(car),
        "unscented, 0.05 rad/s": unscented(car, smoothing_rate=0.05),
    }


def tables() -> Iterator[Table]:
    """All tables, one after the other."""
    yield from (levels(degrees) for degrees in (0.01, 0.3, 1.0, 3.0))
    yield noisy_rate()
    yield scattered()
    yield step()
    yield baseline()
    yield hysteresis()


@lru_cache(maxsize=8)
def _driven(
    friction: float | FrictionCourse,
    seed: int,
    dahl_degrees: float = 1.0,
    rate_noise: float = 0.01,
    scatter: Scatter | None = None,
) -> Aligned:
    car = EpsCar()
    car = replace(car, steering=replace(car.steering, dahl_angle=math.radians(dahl_degrees)))
    sensors = SensorNoise()
    sensors = replace(sensors, steering_wheel_rate=replace(sensors.steering_wheel_rate, noise=rate_noise))
    recording = drive(car, 13.0, friction, seed=seed, noise=sensors, scatter=scatter or False)
    return recording.align((*FrictionSample._fields, "vehicle_speed"), RATE)


def _settled(monitor: RefinedFrictionMonitor, samples: Aligned) -> np.ndarray:
    run = scan(monitor, samples)
    return run["friction_torque"][np.cumsum(run["enabled"]) > SETTLED * RATE]


def _spread(values: list[np.ndarray]) -> str:
    pooled = np.concatenate(values)
    return f"{np.mean(pooled):.2f} ± {np.std(pooled):.2f}"


def levels(dahl_degrees: float) -> Table:
    """Every estimator at every level of friction, for one Dahl angle of the car."""
    friction = "Coulomb friction" if dahl_degrees < 0.1 else f"Dahl angle of {dahl_degrees:g}°"
    rows = {name: [name] for name in monitors()}
    for level in LEVELS:
        drives = [_driven(level, seed, dahl_degrees) for seed in SEEDS]
        for name, monitor in monitors().items():
            rows[name].append(_spread([_settled(monitor, one) for one in drives]))
    return Table(
        f"{friction}, three 13-minute drives a level, after {SETTLED:g} s enabled (mean ± standard deviation, N·m)",
        ("estimator", *(f"{level:g} N·m" for level in LEVELS)),
        tuple(tuple(row) for row in rows.values()),
    )


def noisy_rate() -> Table:
    """What a noisy rate costs, and what the equal low-pass gives back."""
    rows = []
    for name in ("printed", "consistent"):
        for cutoff in (None, 5.0):
            monitor = replace(monitors()[name], low_pass=equal_low_pass(cutoff) if cutoff else None)
            cells = []
            for level in LEVELS:
                drives = [_driven(level, seed, rate_noise=0.05) for seed in SEEDS]
                cells.append(_spread([_settled(monitor, one) for one in drives]))
            rows.append((name, f"{cutoff:g} Hz" if cutoff else "none", *cells))
    return Table(
        "Rate noise of 0.05 rad/s, Dahl 1 degree (N·m)",
        ("estimator", "equal low-pass", *(f"{level:g} N·m" for level in LEVELS)),
        tuple(rows),
    )


def scattered() -> Table:
    """Every estimator where car and sensors differ from drive to drive."""
    names = ("printed", "consistent", "unscented")
    cells: dict[str, list[str]] = {name: [name] for name in names}
    for level in LEVELS:
        drives = [_driven(level, seed, scatter=Scatter()) for seed in range(24)]
        for name in names:
            means = np.array([np.mean(_settled(monitors()[name], one)) for one in drives])
            cells[name].append(f"{np.mean(means):.2f} ± {np.std(means):.2f}")
    return Table(
        "With scatter of car and sensors, mean of each of 24 drives, Dahl 1 degree (N·m)",
        ("estimator", *(f"{level:g} N·m" for level in LEVELS)),
        tuple(tuple(row) for row in cells.values()),
    )


def step() -> Table:
    """How long each estimator takes to cross the threshold after friction has jumped."""
    at = 390.0
    course = FrictionCourse.step(4.0, 12.5, at)
    rows = []
    for name, monitor in monitors().items():
        times = []
        for seed in SEEDS:
            run = scan(monitor, _driven(course, seed))
            after = slice(round(at * RATE), None)
            crossed = int(np.argmax(run["friction_torque"][after] > THRESHOLD))
            times.append((np.sum(run["enabled"][after][:crossed]) / RATE, crossed / RATE))
        rows.append((name, *(f"{min(column):.0f} to {max(column):.0f}" for column in zip(*times, strict=True))))
    return Table(
        f"Step from 4 to 12.5 N·m: time to cross {THRESHOLD} N·m, three drives (s)",
        ("estimator", "enabled", "total"),
        tuple(rows),
    )


def baseline() -> Table:
    """Variance of the baseline monitor, with the right and with the printed sign, clean and with scatter."""
    right = BaselineFrictionMonitor(load("midsize-eps").parameters_for(BaselineParameters), math.inf, gate=None)
    variants = {
        "corrected sign": (right, None),
        "printed sign": (replace(right, literal_sign=True), None),
        "corrected sign, printed gate": (replace(right, gate=BaselineGate()), None),
        "corrected sign, scatter and 50 ms delay": (right, HARD_SCATTER),
    }
    rows = []
    for name, (monitor, scatter) in variants.items():
        cells, enabled = [], []
        for level in LEVELS:
            runs = [scan(monitor, _driven(level, seed, scatter=scatter)) for seed in SEEDS]
            windows = np.concatenate([run["variance"][run["ready"] > 0.0] for run in runs])
            enabled += [np.mean(run["enabled"]) for run in runs]
            cells.append(
                f"{np.median(windows):.0f} ({np.quantile(windows, 0.05):.0f} to {np.quantile(windows, 0.95):.0f})"
            )
        rows.append((name, *cells, f"{100.0 * np.mean(enabled):.1f} %"))
    return Table(
        "Baseline: variance over 15 s, median (5 to 95 %), (N·m)²",
        ("variant", *(f"{level:g} N·m" for level in LEVELS), "enabled"),
        tuple(rows),
    )


def hysteresis() -> Table:
    """Friction that was added, as the lock-to-lock loop finds it."""
    car = load("midsize-eps")
    method = HysteresisIdentification(
        car["motor_ratio"],
        car["column_inertia"],
        car["column_damping"],
        car.parameters["column_damping"].standard_deviation or 0.0,
    )
    rows = []
    supports: tuple[Support, ...] = ("hoist", "ground")
    for support in supports:
        hoist = support == "hoist"
        healthy = [method.identify(lock_to_lock(4.0, hoist, seed=seed), support) for seed in (1, 2)]
        cells = []
        for added in (0.0, 1.5, 4.0, 8.5):
            found = friction_increase(method.identify(lock_to_lock(4.0 + added, hoist, seed=3), support), healthy)
            cells.append(f"{found.value:.2f} ± {found.standard_deviation:.2f}")
        rows.append((support, f"{healthy[0].friction_torque:.2f} ± {healthy[0].standard_deviation:.2f}", *cells))
    return Table(
        "Hysteresis: friction of the sound car (4 N·m inside) and what was added (N·m)",
        ("support", "sound", "0 added", "1.5 added", "4 added", "8.5 added"),
        tuple(rows),
    )


if __name__ == "__main__":
    for table in tables():
        print(table.markdown(), flush=True)
