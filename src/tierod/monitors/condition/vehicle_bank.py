"""The bank of filters of a vehicle, with the limits that its file holds."""

from __future__ import annotations

from tierod.core.graph import Bank
from tierod.monitors.condition.bank.judge import condition_bank
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.calibration.limits import has_own_limits, limits_of
from tierod.monitors.condition.uncalibrated import unsure
from tierod.vehicles import Vehicle


def bank_of(vehicle: Vehicle, sample_time: float = 0.01) -> Bank:
    """The bank as it judges a vehicle, calibrated or not.

    Args:
        vehicle: with the parameters of `AutomatedVehicle`
        sample_time: [s]

    Raises:
        ParameterError: parameters that are missing
    """
    bank = condition_bank(LeaveOutFilter.of_vehicle(vehicle, sample_time), limits_of(vehicle), sample_time=sample_time)
    return bank if has_own_limits(vehicle) else unsure(bank)
