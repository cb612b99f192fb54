"""The Kalman filters of Raffone as variants of the driver-torque monitor; the package registers each of them.

Source: Raffone, Observers of an electric power steering column.
"""

from __future__ import annotations

from tierod.core.errors import ParameterError
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.definition import PAPER, Observer, opener
from tierod.monitors.driver_torque.design import SensorNoise, gear_is_too_fast
from tierod.monitors.driver_torque.facts import DECISIONS
from tierod.monitors.session import Variant
from tierod.vehicles import Vehicle
from tierod_lab.papers.column.printed import PrintedObserver

_BARE = ("statement.deviation", "disturbance_torque_deviation", "nis")  # Outputs that these filters lack


def _printed(column: str) -> Observer:
    def build(vehicle: Vehicle, rate: float, noise: SensorNoise, with_motor: bool) -> PrintedObserver:
        if column == "full" and gear_is_too_fast(vehicle, 1.0 / rate):
            raise ParameterError(
                f"the gear's vibration is too fast for {rate:g} samples per second; take a variant that leaves it out "
                "('interacting', 'fixed-lag', 'mechanical'), or record faster"
            )
        return PrintedObserver.of_column(vehicle.parameters_for(ColumnParameters), column, 1.0 / rate)

    return build


MECHANICAL = Variant(
    "mechanical",
    "The paper's Kalman filter of the column without its gear, torsion bar and gear as springs in series.",
    f"{PAPER}, eqs (8) to (13)",
    opener("mechanical", _printed("series spring"), _BARE, whole_column=True),
    DECISIONS,
)

BALANCED = Variant(
    "balanced",
    "The paper's Kalman filter of the column reduced by balanced singular perturbation.",
    f"{PAPER}, eqs (14) to (18)",
    opener("balanced", _printed("balanced"), _BARE, whole_column=True),
    DECISIONS,
)

FULL = Variant(
    "full",
    "The paper's Kalman filter of the whole column, scaled.",
    f"{PAPER}, eqs (1) to (8)",
    opener("full", _printed("full"), _BARE, whole_column=True),
    DECISIONS,
)
