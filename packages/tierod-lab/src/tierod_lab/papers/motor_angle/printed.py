"""The observers as printed, corrected, and with a load state: effect of the misprints, and accuracy over drives."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from tierod.core.claims import Claim, at_least, between
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.physics.pm_motor import torque_constant
from tierod_lab.papers.motor_angle.dq_motor import q_axis_motor
from tierod_lab.papers.motor_angle.feedforward import FeedforwardAngle
from tierod_lab.papers.motor_angle.luenberger import full_observer, printed_reduced_observer, speed_per_load
from tierod_lab.papers.motor_angle.observer_drives import (
    SAMPLE_TIME,
    SPEEDS,
    Accuracy,
    ObserverDrive,
    accuracy,
    bench,
    by_speed,
    drive,
    methods,
    parameters,
    to_and_fro,
)
from tierod_lab.papers.motor_angle.printed_observers import FULL_POLES, REDUCED_POLES, extended_kalman
from tierod_lab.papers.motor_angle.reported import SEEDS, SIDE_BY_SIDE
from tierod_lab.studies.effort import Effort

ROOM = 298.15
"""Temperature of a second motor [K]: resistance 2 % above and flux 0.6 % below those of the vehicle file."""


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "The observers as printed",
        (
            "Four methods of the paper, sampled at 10 kHz, beside a flux observer of today's practice and the default "
            "of tierod. The paper's observers estimate a speed and integrate it from the sensor's first angle. Their "
            "axes are turned by the measured angle, as printed, or by the observer's own.",
        ),
    )
    seconds = 6.0 if effort.quick else 20.0
    seeds = SEEDS.of(SIDE_BY_SIDE, 1 if effort.quick else 3)
    right = [to_and_fro(seed, seconds) for seed in seeds]
    warm = [to_and_fro(seed, seconds, ROOM) for seed in seeds]
    found = {name: accuracy(observer, right) for name, observer in methods().items()}
    warmer = {name: accuracy(observer, warm) for name, observer in methods().items()}
    yield from _misprints(right)
    yield _followed(found, warmer)
    yield _by_speed(right)
    yield _chart(right[0])
    yield from _claims(found)


def inductive_error(current: float) -> float:
    """Electrical angle by which +L di/dt turns the back-EMF in steady state [rad].

    Args:
        current: q-axis current [A]
    """
    p = parameters()[0]
    return math.atan(2.0 * p.motor_inductance * current / p.motor_flux)


def turned_by_printed_sign(current: float, speed: float = 40.0) -> float:
    """The same angle measured on the bench: feedforward as printed less corrected [rad].

    Args:
        current: q-axis current [A]
        speed: speed of the motor [rad/s]
    """
    p, fixed = parameters()
    time = np.arange(1500) * 1e-3
    torque = torque_constant(p.motor_pole_pairs, p.motor_flux) * current - p.motor_damping * speed
    plant = bench(stiffness=0.0)
    friction = plant.motor.machine.friction
    seen = drive(plant, speed * time, np.full(len(time), torque - friction), 3)
    ends = [
        seen.observed(FeedforwardAngle(fixed, reading=reading))["motor_angle"][-5000:]
        for reading in ("printed", "corrected")
    ]
    return float(abs(p.motor_pole_pairs * np.mean(ends[0] - ends[1])))


def _misprints(drives: list[ObserverDrive]) -> Iterator[Item]:
    p = parameters()[0]
    motor = q_axis_motor(p)
    pole = float(printed_reduced_observer(p, motor, REDUCED_POLES[0]).A[0, 0])
    slopes = [speed_per_load(full_observer(q_axis_motor(p, r), FULL_POLES), motor, p) for r in ("corrected", "printed")]
    swapped = accuracy(extended_kalman(p, SAMPLE_TIME, axes="measured", jacobian="printed"), drives).speed
    right = accuracy(extended_kalman(p, SAMPLE_TIME, axes="measured"), drives).speed
    turned = turned_by_printed_sign(12.0)
    rows = (
        ("(14), (16), (20)", "torque constant 3/2 c_M", "c_M", f"speed per load {slopes[0]:.1f}, {slopes[1]:.1f}"),
        ("(32)", "-b/J + K c_M/L", "-b/J + c_M/L", f"pole {REDUCED_POLES[0]:.0f} 1/s, {pole:+.0f} 1/s: diverges"),
        ("(32)", "K R/L, -K/L U", "z_p R/L, +K/L U", "wrong speed, were it stable"),
        ("(40)", "torque in the column of i_sq", "of i_sd", f"speed {right:.3f}, {swapped:.3f} rad/s rms, with load"),
        ("(40)", "F[2,1] over L_sq", "over L_sd", "none where both are equal"),
        ("(46)", "-L dI/dt, two arguments", "+L dI/dt, quotient", f"turned by {turned:.2f} rad electrical at 12 A"),
    )
    yield Table("Misprints and what they do: right, printed", ("equation", "right", "printed", "effect"), rows)
    yield Claim(
        "motor-angle.printed.reduced-pole",
        "The reduced observer (32), as printed, diverges",
        "Reinelt et al., eq (32): -b/J + c_M/L",
        None,
        pole,
        at_least(0.0),
        "1/s",
        "Corrected, the pole is where it was chosen.",
    )
    yield Claim(
        "motor-angle.printed.inductive-sign",
        "With +L di/dt the angle of (46) is turned by atan(2 L i/psi)",
        "Reinelt et al., eq (46)",
        None,
        turned,
        between(0.95 * inductive_error(12.0), 1.05 * inductive_error(12.0)),
        "rad",
        "At 12 A, electrical, on the bench at 40 rad/s.",
        derived=round(inductive_error(12.0), 3),
    )


def _followed(found: dict[str, Accuracy], warmer: dict[str, Accuracy]) -> Table:
    rows = tuple(
        (
            name,
            f"{each.speed:.2f}",
            f"{each.angle:.4f}",
            f"{each.largest:.3f}",
            f"{warmer[name].angle:.4f}",
            f"{warmer[name].largest:.3f}",
        )
        for name, each in found.items()
    )
    return Table(
        "Errors over drives against a spring: speed (rad/s), angle of the shaft (rad)",
        ("observer", "speed, rms", "angle, rms", "angle, most", "angle, rms, at 25 °C", "angle, most, at 25 °C"),
        rows,
        "Up to 115 rad/s, load up to 0.9 N·m. The vehicle file holds at 20 °C; at 25 °C the resistance is 2 % higher, "
        "the flux 0.6 % lower. An angle that nothing corrects keeps what it once lost.",
    )


def _by_speed(drives: list[ObserverDrive]) -> Table:
    header = [f"{low:g} to {high:g}" if high < math.inf else f"above {low:g}" for low, high in pairwise(SPEEDS)]
    chosen = ("feedforward, increments when slow", "feedforward, increments, with load", "flux observer", "default")
    observers = methods()
    rows = tuple((name, *(f"{value:.4f}" for value in by_speed(observers[name], drives))) for name in chosen)
    return Table(
        "Electrical error by speed (rad rms), whole turns left out", ("observer, speed in rad/s", *header), rows
    )


def _chart(seen: ObserverDrive) -> Chart:
    observers, kept = methods(), slice(None, None, 40)
    drawn = ("Luenberger, as printed", "Kalman filter, with load", "feedforward, held when slow", "flux observer")
    angles = [Lines("true", seen.time[kept], seen.angle[kept])]
    errors = []
    for name in (*drawn, "default"):
        angle = seen.observed(observers[name])["motor_angle"]
        angles.append(Lines(name, seen.time[kept], angle[kept], dashed=True))
        if name != drawn[0]:
            errors.append(Lines(name, seen.time[kept], (angle - seen.angle)[kept]))
    return Chart(
        "motor-angle-printed",
        "The printed observers over a drive (Figures 4 and 5)",
        "Above: angle of the motor. Below: errors of all but the first, which leaves out the load.",
        "The observer without load leaves the true angle by many radians; the others stay near it.",
        (
            Panel("", "time (s)", "angle (rad)", tuple(angles)),
            Panel("", "time (s)", "error of the angle (rad)", tuple(errors)),
        ),
    )


def _claims(found: dict[str, Accuracy]) -> Iterator[Claim]:
    for name, key in (
        ("Luenberger", "luenberger"),
        ("reduced Luenberger", "reduced"),
        ("Kalman filter", "kalman"),
    ):
        without, loaded = found[f"{name}, as printed"], found[f"{name}, with load"]
        yield Claim(
            f"motor-angle.printed.load-gain-{key}",
            "The load as a state makes the angle better by an order of magnitude and more",
            "tierod",
            None,
            without.angle / loaded.angle,
            at_least(10.0),
            "",
            f"{name}: {without.angle:.2f} against {loaded.angle:.3f} rad rms.",
        )
