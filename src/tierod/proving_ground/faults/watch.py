"""Waiting for what begins a fault during a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.proving_ground.faults.elements import Reach
from tierod.proving_ground.faults.triggers import AtDistance, Comparison, When

DISTANCE = "truth_distance"
"""Channel that tells how far the car has gone."""


class Watch:
    """Looks at the outputs of a car, piece by piece, until a condition has held for long enough.

    Args:
        trigger: what is waited for
        reach: of the car

    Raises:
        ParameterError: the car has no such channel, or it is measured in another unit
    """

    def __init__(self, trigger: AtDistance | When, reach: Reach):
        self.hold = 0.0 if isinstance(trigger, AtDistance) else trigger.hold
        self.comparisons: list[tuple[Comparison, str]] = []
        self.since: float | None = None
        if isinstance(trigger, AtDistance):
            wanted: tuple[Comparison, ...] = (Comparison(DISTANCE, False, ">=", trigger.distance, "m"),)
        else:
            wanted = trigger.comparisons
        for comparison in wanted:
            name = comparison.signal
            if name not in reach.outputs:
                raise ParameterError(f"the car has no channel '{name}' to wait for{nearest(name, reach.outputs)}")
            unit = reach.outputs[name] or ""
            try:
                comparison.holds(np.zeros(1), unit)
            except InputError as error:
                raise ParameterError(
                    f"'{name}' cannot be held against {comparison.value:g} {comparison.unit}: {error}"
                ) from None
            self.comparisons.append((comparison, unit))

    def held(self, time: np.ndarray, outputs: Mapping[str, np.ndarray]) -> bool:
        """Whether the condition has held for long enough by the end of these samples.

        Args:
            time: of the samples [s], right after those of the call before
            outputs: every channel at these times
        """
        true = np.ones(len(time), dtype=bool)
        for comparison, unit in self.comparisons:
            true &= comparison.holds(outputs[comparison.signal], unit)
        begins = np.where(true, time, np.inf)
        for place in np.flatnonzero(true):
            before = self.since if place == 0 else (begins[place - 1] if true[place - 1] else None)
            begins[place] = time[place] if before is None else before
            if time[place] - begins[place] >= self.hold - 1e-9:
                return True
        self.since = float(begins[-1]) if true[-1] else None
        return False
