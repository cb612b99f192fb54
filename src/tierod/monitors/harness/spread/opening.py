"""A session with the spread of its vehicle's parameters beside it, as far as it reads uncertain ones."""

from __future__ import annotations

import dataclasses

from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.session import Monitor, Session, Variant, opened
from tierod.monitors.harness.spread.parameter_spread import ParameterSpread
from tierod.vehicles.uncertain import BOUND, FREE, WatchedParameters, bound_distance, may_move, with_spread
from tierod.vehicles.vehicle import Vehicle


class Uncertain:
    """Opens a session for a vehicle, and finds out which of its uncertain parameters are read.

    Limits in the vehicle file that were designed on its own fault-free drives hold the error of its parameters, so that
    a monitor with such limits is run for the vehicle as it is. A parameter whose spread the monitor says to hold itself
    (`tierod.vehicles.uncertain.held_deviation`) is in its own band already, and is not moved.

    Args:
        monitor: on the grid of the recording
        variant: of the monitor
        vehicle: as its file gives it; parameters without a standard deviation take that of its class
        baseline: baseline of earlier drives; None where there is none

    Raises:
        ParameterError: the variant cannot run with this vehicle

    `session` is that for the vehicle as it is, `names` are those parameters, `of_class` those that took the spread of
    their class.
    """

    def __init__(self, monitor: Monitor, variant: Variant, vehicle: Vehicle, baseline: Baseline | None):
        self._monitor, self._variant, self._baseline = monitor, variant, baseline
        watched = WatchedParameters(vehicle.parameters)
        self.session = opened(monitor, variant, dataclasses.replace(vehicle, parameters=watched), baseline)
        self.vehicle, filled = with_spread(vehicle)
        designed = monitor.name in vehicle.thresholds
        read = () if designed else watched.read
        follows = {BOUND} if bound_distance(self.vehicle) and FREE in read else set()
        held = watched.held.keys() | follows
        self.names = tuple(name for name in read if name not in held and self._is_uncertain(name))
        self.of_class = tuple(name for name in filled if name in self.names)

    def _is_uncertain(self, name: str) -> bool:
        return may_move(name) and bool(self.vehicle.parameters[name].standard_deviation)

    def _open(self, vehicle: Vehicle) -> Session:
        return opened(self._monitor, self._variant, vehicle, self._baseline)

    def spread(self) -> ParameterSpread | None:
        """The spread over a recording; None where the monitor reads no uncertain parameter."""
        if not self.names:
            return None
        return ParameterSpread(
            self._open,
            self.vehicle,
            self.names,
            self.session,
            self._variant.decisions,
            self._monitor.rate,
        )
