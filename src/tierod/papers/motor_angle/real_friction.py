"""Friction and inertia of a real drive, in amperes: current across the flux over speed and position."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim, between
from tierod.core.content import Heading, Item, Table
from tierod.core.recording import Recording
from tierod.methods.identification.modulation import Modulation
from tierod.methods.identification.regression import Fit, Rows, regress

_STANDS = 0.05
"""Speed [1/s] around which dry friction is smeared."""


def column(recording: Recording, name: str) -> np.ndarray:
    """A channel by the last part of its name."""
    return recording[next(each for each in recording.names if each.rpartition(".")[2] == name)].values


def items(speed: Recording, position: Recording) -> Iterator[Item]:
    """Current across the flux over speed and position: friction and inertia in amperes."""
    fit, step = motion(position)
    there, needed = float(np.mean(column(speed, "UserSpeed"))), float(np.mean(column(speed, "motor_current_q")))
    foretold = fit.values[1] * there + fit.values[2]
    names = ("acceleration (A per 1/s²)", "speed (A per 1/s)", "dry friction (A)", "constant (A)")
    rows = tuple((n, f"{v:.3g}", f"{d:.2g}") for n, v, d in zip(names, fit.values, fit.deviations, strict=True))
    yield Heading(
        "Friction in amperes",
        (
            f"One file holds current and position of a motion to and fro, every {1e3 * step:.3g} ms. "
            "The unit of its position is the recorder's, and no torque constant is known: inertia and friction come in "
            "amperes.",
        ),
    )
    yield Table("Current across the flux explained by the motion", ("by", "value", "σ"), rows)
    yield Claim(
        "real.friction",
        "Current that this friction needs at the speed of the other file, over what was recorded there.",
        "another recording of the same drive",
        None,
        float(foretold / needed),
        between(0.9, 1.1),
    )


def motion(recording: Recording) -> tuple[Fit, float]:
    """Current over acceleration, speed and direction of the position; and the time between samples [s]."""
    name = next(each for each in recording.names if each.rpartition(".")[2] == "PosFeedBack")
    step = float(np.median(np.diff(recording[name].time)))
    window, place = Modulation(16, 2, step), recording[name].values
    direction = np.tanh(column(recording, "UserSpeed") / _STANDS)
    columns = [window.acceleration(place), window.rate(place), window.mean(direction)]
    regressors = np.column_stack([*columns, np.ones_like(columns[0])])
    return regress([Rows(window.mean(column(recording, "motor_current_q")), regressors, regressors)]), step
