"""Torque of the driver's hands: the observers of the paper, tierod's own, and what wrong parameters cost."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.content import Heading, Item
from tierod.experiments.effort import Effort
from tierod.papers.column import (
    observer_consistency,
    observer_sensitivity,
    observers_compared,
    observers_elsewhere,
)

TEXT = (
    "The motor of the simulated bench sweeps the column by ±30° from 0.1 to 3 Hz, as in figure 10 of the paper, every "
    "octave in the same time. The hands first pull by a sine of 1.5 N·m, then twice by 2 N·m for 4 s: four edges in "
    "40 s, as steps or as ramps of 100 ms. Noise of 0.05° on the wheel's angle, 0.2° on the motor's, 0.02 N·m on the "
    "bar's torque; 1 kHz. Friction at the motor is 0.1 N·m by Dahl's law, of which the observers know nothing unless "
    "it is said. Tuned on two runs with a linear sweep, reported on five others.",
    "The paper gives neither noises nor figures. A step weighs heavily: within the 15 ms until it can be told from "
    "noise the error is 2 N·m, so that the error over a run depends on how many steps it has.",
)


def items(effort: Effort) -> Iterator[Item]:
    """Section 5 of the paper, and what can be had beyond it."""
    yield Heading("Torque of the driver's hands", TEXT)
    yield from observers_compared.items(effort)
    yield from observer_sensitivity.items(effort)
    yield from observers_elsewhere.items(effort)
    yield from observer_consistency.items(effort)
