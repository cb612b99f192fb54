"""Guaranteed intervals of resistance, inductance and flux, compared with statistical intervals."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Heading, Item, Table
from tierod.core.errors import InputError
from tierod.methods.identification.experiment import INTERVAL
from tierod.methods.identification.motor import identify_motor
from tierod.methods.identification.motor_recording import motor_recording
from tierod.models.stator_frame_motor import MotorParameters
from tierod.physics.pm_motor import flux_at, resistance_at
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.identified import Drawn, drawn, recording
from tierod_lab.papers.motor_angle.motor_bounds import NAMES, MotorErrorBounds, guaranteed_motor
from tierod_lab.papers.motor_angle.observer_drives import NOISE, ObserverDrive, noises
from tierod_lab.papers.motor_angle.reported import GUARANTEED, SEEDS
from tierod_lab.papers.motor_angle.set_membership import Box
from tierod_lab.studies.effort import Effort

_SECONDS = 4.0
"""Duration of a drive [s]."""
_WIDE = math.sqrt(3.0)
"""Half width of a uniform distribution over its standard deviation."""
CURVATURE = 2e7
"""Assumed bound of the second derivative of a current [A/s**2]: a rate of 60 A/ms that decays within 3 ms."""
TEXT = (
    "The paper names estimation with unknown but bounded errors for the motor's parameters. Here the errors are "
    "uniform, with the deviations of the other parts (0.15 A, 0.03 V, 0.0005 rad), and their bounds are known. All "
    "parameters that no reading contradicts form a polytope, whose box linear programmes find; it holds without any "
    "assumption on the errors but their bounds. Beside it stand the statistical intervals from the same drives.",
)


class Both(NamedTuple):
    """Guaranteed and statistical results of one motor, relative to the true values.

    Args:
        low, high: ends of the guaranteed intervals, less one
        errors, deviations: errors and standard deviations of the statistical estimate
        normal: whether bounds of three standard deviations contain the truth for normal errors: 1 yes, 0 no, NaN where
            no parameters are consistent
    """

    low: np.ndarray
    high: np.ndarray
    errors: np.ndarray
    deviations: np.ndarray
    normal: float


def bounds(width: float = _WIDE) -> MotorErrorBounds:
    """Bounds of the measurement errors.

    Args:
        width: bounds over standard deviations
    """
    current, _, voltage, _, angle = (width * each for each in NOISE)
    return MotorErrorBounds(current, voltage, angle, CURVATURE)


def bounded(motor: Drawn, seed: int, seconds: float = _SECONDS) -> tuple[ObserverDrive, ObserverDrive]:
    """A drive with normal errors, and the same drive with uniform errors of the same standard deviation.

    Args:
        motor: motor on the bench
        seed: seed of course and errors
        seconds: duration [s]
    """
    seen = motor.driven(seed, seconds)
    shape = seen.samples.shape
    uniform = np.random.default_rng([seed, 6]).uniform(-_WIDE, _WIDE, shape) * NOISE
    clean = seen.samples - noises(seed, shape)
    return seen, ObserverDrive(clean + uniform, *(getattr(seen, name) for name in _OTHERS))


_OTHERS = ("angle", "speed", "load", "commands", "resistance")


def both(seed: int) -> Both:
    """Identify a drawn motor by both methods.

    Args:
        seed: seed of the motor and its drive
    """
    motor = drawn(seed)
    normal, uniform = bounded(motor, seed)
    machine, known = motor.machine, load("motor-bench").parameters_for(MotorParameters)
    warm = float(resistance_at(motor.temperature, 1.0))
    true = np.array([warm * machine.resistance, machine.inductance_q, float(flux_at(motor.temperature, machine.flux))])
    box = _box(uniform, known.motor_pole_pairs, _WIDE)
    found = identify_motor(known, {"drive": recording(uniform, motor.temperature)}).electrical
    statistical = np.array([found.resistance, found.inductance, found.flux])
    # The statistical method gives the resistance at 20 degrees, the guaranteed one at the temperature of the drive.
    cold = np.array([warm, 1.0, 1.0])
    three = _three_deviations(normal, known.motor_pole_pairs, true)
    return Both(
        box.low / true - 1.0,
        box.high / true - 1.0,
        cold * statistical[:, 0] / true - 1.0,
        cold * statistical[:, 1] / true,
        three,
    )


def _box(seen: ObserverDrive, pole_pairs: float, width: float) -> Box:
    made = motor_recording("drive", recording(seen), pole_pairs)
    return guaranteed_motor([made], pole_pairs, bounds(width))


def _three_deviations(seen: ObserverDrive, pole_pairs: float, true: np.ndarray) -> float:
    try:
        box = _box(seen, pole_pairs, 3.0)
    except InputError:
        return math.nan
    return float(((box.low <= true) & (true <= box.high)).all())


def items(effort: Effort) -> Iterator[Item]:
    count = 3 if effort.quick else 30
    found = effort.made(both, SEEDS.of(GUARANTEED, count))
    yield Heading("Guaranteed intervals from bounded errors", TEXT)
    low, high, errors, deviations = (np.stack([getattr(each, name) for each in found]) for name in Both._fields[:4])
    held = (low <= 0.0) & (high >= 0.0)
    covered = np.abs(errors) <= INTERVAL * deviations
    rows = tuple(
        (
            name,
            f"{50.0 * np.mean(high - low, axis=0)[k]:.2f} %",
            f"{held[:, k].sum()} of {count}",
            f"{100.0 * INTERVAL * np.mean(deviations, axis=0)[k]:.3f} %",
            f"{covered[:, k].sum()} of {count}",
        )
        for k, name in enumerate(NAMES)
    )
    header = ("parameter", "guaranteed, half width", "true value within", "95 % interval, half width", "within")
    normal = np.array([each.normal for each in found])
    note = (
        f"Drives of {_SECONDS:g} s. With normal errors and bounds of three deviations, which some readings exceed, no "
        f"parameters are left in {int(np.isnan(normal).sum())} of {count} drives, and the box misses the truth in "
        f"{int((normal == 0.0).sum())}."
    )
    yield Table("Guaranteed and statistical intervals, mean half width", header, rows, note)
    yield Claim(
        "identified.guaranteed",
        "Share of the motors whose three true values lie in their guaranteed intervals, errors within their bounds.",
        "Reinelt et al., models of the motor: unknown-but-bounded approaches",
        None,
        float(held.all(axis=1).mean()),
        at_least(1.0),
        "",
        f"{count} motors.",
    )
    yield Claim(
        "identified.guaranteed-width",
        "Largest mean half width of the guaranteed intervals, in parts of the true value: narrow enough to see a "
        "winding that is 20 % warmer.",
        "goal of tierod",
        None,
        float(0.5 * np.mean(high - low, axis=0).max()),
        at_most(0.2),
    )
