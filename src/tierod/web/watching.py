"""Several monitors over one recording, whose estimates are stored at the rate of the monitor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tierod.core.recording import Channel
from tierod.monitors.harness.over_time import OverTime
from tierod.monitors.harness.run import Run
from tierod.monitors.together import Chosen, Together
from tierod.vehicles import Vehicle
from tierod.web.pyramid import SeriesWriter


class Watched(Together):
    """Monitors whose estimates are written as they are made.

    Args:
        car, chosen, spread: as in `Together`
        writer: writer of the estimates, which are named "monitor/estimate"
    """

    def __init__(self, car: Vehicle, chosen: Sequence[Chosen], spread: bool, writer: SeriesWriter):
        super().__init__(car, chosen, spread)
        for name, run in list(self._runs.items()):
            with self._refusing(name):
                kept = Written(name, lambda name=name: self._runs[name], writer)
                self._runs[name] = Run(run.monitor, run.variant, car, kept=kept, uncertain=spread)


class Written(OverTime):
    """Writes the estimates of a monitor.

    Args:
        monitor: name of the monitor
        run: returns the run of the monitor, which has the names and units of its estimates
        writer: writer of the estimates
    """

    def __init__(self, monitor: str, run: object, writer: SeriesWriter):
        super().__init__()
        self._monitor, self._run, self._writer = monitor, run, writer

    def add(self, time: np.ndarray, shown: Mapping[str, np.ndarray]) -> None:
        """Write the next piece; arguments as in `OverTime.add`."""
        traces: Mapping[str, str] = self._run().session.traces  # type: ignore[operator]
        stamps = np.array(time, float)
        self._writer.add(
            Channel(f"{self._monitor}/{name}", stamps, np.asarray(shown[name], float), unit, f"monitor {self._monitor}")
            for name, unit in traces.items()
            if name in shown
        )
