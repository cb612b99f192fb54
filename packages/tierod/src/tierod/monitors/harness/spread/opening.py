"""Opening of a session, with the uncertain parameters that it reads."""

from __future__ import annotations

import dataclasses

from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.session import Monitor, Session, Variant, opened
from tierod.monitors.harness.spread.parameter_spread import ParameterSpread
from tierod.vehicles.uncertain import BOUND, FREE, WatchedParameters, bound_distance, may_move, with_spread
from tierod.vehicles.vehicle import Vehicle


class Uncertain:
    """Opens a session for a vehicle and determines which uncertain parameters it reads.

    Limits of the vehicle file that were designed on its own fault-free drives already contain the error of its
    parameters: a monitor with such limits runs without perturbations. Neither is a parameter perturbed whose spread the
    monitor includes in its own band (`tierod.vehicles.uncertain.held_deviation`).

    Args:
        monitor: monitor on the grid of the recording
        variant: variant of the monitor
        vehicle: vehicle of the file; parameters without a standard deviation get that of their class
        baseline: baseline from earlier recordings; None without one

    Raises:
        ParameterError: the variant cannot run with this vehicle

    `session` is the session for the unperturbed vehicle, `names` are the uncertain parameters, and `of_class` those of
    them with the spread of their class.
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
        """Parameter spread for a recording; None if the monitor reads no uncertain parameter."""
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
