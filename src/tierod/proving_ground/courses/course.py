"""What every course is: inputs of a car over time and over the way it has gone, computed piece by piece."""

from __future__ import annotations

from typing import Annotated, NamedTuple, Protocol

import numpy as np

from tierod.core.fields import NOT_NEGATIVE

Columns = dict[str, np.ndarray]
"""Values by dotted name of `tierod.proving_ground.parts`: "road.curvature", "demand.speed", "wind.crosswind_speed"."""

FACTORS = frozenset(
    (
        "road.adhesion_left",
        "road.adhesion_right",
        "road.support",
        "demand.grip",
        "demand.attention",
    )
)
"""Columns that are one where nothing is said, and that multiply where several things are said; all others add."""


class Start(NamedTuple):
    """How a run over a course begins.

    Args:
        speed: rolling straight ahead
    """

    speed: Annotated[float, "m/s", NOT_NEGATIVE] = 0.0


class Course(Protocol):
    """What is asked of a car and its driver, and the road and air around them."""

    @property
    def name(self) -> str:
        """For messages and provenance."""

    @property
    def duration(self) -> float:
        """How long it takes as planned [s]."""

    @property
    def start(self) -> Start:
        """How a run begins."""

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        """Inputs at some instants; what is left out is as usual: flat dry road, no wind, hands on the wheel.

        Args:
            time: instants [s]
            distance, speed: of the car along the path, as foreseen for these instants [m], [m/s]
            ahead: how much earlier the driver wants to know the curvature [s]
        """


def combine(columns: Columns, more: Columns) -> None:
    """Add what else acts to columns that are there already, in place; shares are multiplied."""
    for name, values in more.items():
        if name not in columns:
            columns[name] = values
        elif name in FACTORS:
            columns[name] = columns[name] * values
        else:
            columns[name] = columns[name] + values
