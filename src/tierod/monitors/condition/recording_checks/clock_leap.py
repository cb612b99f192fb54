"""A clock of one bus that leaps in mid-drive: its sensors are late from then on, and none of them is at fault."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from tierod.core.findings import Episode
from tierod.monitors.condition.recording_checks.contradictions import Problem
from tierod.monitors.condition.recording_checks.wiring import Wiring
from tierod.monitors.condition.signals import SENSORS

BUSES = (SENSORS[:3], SENSORS[3:])
"""Sensors that share a clock: those of the chassis, and those of the steering."""
BEFORE = 1.0
"""Of the declaration of two sensors of one bus, in which the first of them may have been declared alone [s]."""


class ClockLeap:
    """Looks at what follows where two sensors of one bus are declared together for a shift in time between the buses.

    A single sensor that is late is a fault; two of one bus that are, with the angle late or early beside what tells the
    yaw rate, have lost their time base. Two faults of which one is a delay of the angle look the same.

    Args:
        look: makes what looks at signals for contradictions
    """

    def __init__(self, look: Callable[[], Wiring]):
        self._look = look
        self._wiring: Wiring | None = None
        self._since = 0.0

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray], faulty: np.ndarray) -> None:
        """The next piece.

        Args:
            time: [s], (n,)
            signals: by name, (n,) each; NaN where missing
            faulty: whether each element is declared, the sensors first, (n, elements)
        """
        first = 0
        if self._wiring is None:
            together = np.zeros(len(time), bool)
            for bus in BUSES:
                together |= faulty[:, [SENSORS.index(name) for name in bus]].sum(axis=1) >= 2
            if not together.any():
                return
            first = int(np.argmax(together))
            self._wiring, self._since = self._look(), float(time[first])
        self._wiring.add({name: values[first:] for name, values in signals.items()})

    def problems(self, episodes: Sequence[Episode]) -> tuple[Problem, ...]:
        """That the buses have lost their common time, if that is what was seen and no fault came before.

        Args:
            episodes: of all faults of the drive
        """
        if self._wiring is None or any(each.start < self._since - BEFORE for each in episodes):
            return ()
        return tuple(
            found._replace(cause=f"{found.cause} since about {self._since:.0f} s")
            for found in self._wiring.problems()
            if found.kind == "time" and found.elements == ("steering_wheel_angle",)
        )
