"""Several faults of one port: each acts on what those before it have left."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.proving_ground.faults.behaviour import Change


class Levels(NamedTuple):
    """Gain and offset of a port at one step."""

    gain: float = 1.0
    offset: float = 0.0


class PortCourse:
    """A port over the steps of a piece: held where `held` is one, then gain * value + offset.

    Args:
        time: of the steps [s]
    """

    def __init__(self, time: np.ndarray):
        self.time = time
        self.gain, self.offset, self.held = np.ones(len(time)), np.zeros(len(time)), np.zeros(len(time))

    @property
    def last(self) -> Levels:
        """Of the last step."""
        return Levels(float(self.gain[-1]), float(self.offset[-1]))

    def add(self, during: np.ndarray, change: Change, before: Levels) -> Levels:
        """One more fault.

        Args:
            during: whether it lasts at each step
            change: what it does at those steps
            before: what `add` gave for the piece before, or `last` where the fault did not act

        Returns:
            gain and offset that go into the fault at the end of the piece, or have gone in when it began to hold
        """
        holds = np.zeros(len(self.time), dtype=bool)
        # There is nothing yet to hold at the first step of a run.
        holds[during] = change.held & (self.time[during] > 0.0)
        source = np.maximum.accumulate(np.where(holds, -1, np.arange(len(self.time))))
        for values, old in ((self.gain, before.gain), (self.offset, before.offset)):
            values[:] = np.where(source < 0, old, values[source])
        into = self.last
        self.gain[during] *= change.gain
        self.offset[during] = change.gain * self.offset[during] + change.offset
        self.held[holds] = 1.0
        return into

    def inputs(self, name: str) -> dict[str, np.ndarray]:
        """What a car takes for a port of this name."""
        return {f"ports.{name}.{part}": getattr(self, part) for part in ("gain", "offset", "held")}
