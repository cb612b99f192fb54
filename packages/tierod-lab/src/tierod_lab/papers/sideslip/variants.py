"""The observers of Yih, Ryu and Gerdes as variants of the sideslip monitor; the package registers each of them.

Source: Yih, Ryu, Gerdes, Vehicle state estimation using steering torque (2004).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from tierod.monitors.baseline import Baseline
from tierod.monitors.session import Session, Variant
from tierod.monitors.sideslip.definition import PAPER, Opener, SideslipSession, refuse_slow
from tierod.monitors.sideslip.facts import DECISIONS
from tierod.vehicles import Vehicle
from tierod_lab.papers.sideslip.observers import conventional_kalman, conventional_poles
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle
from tierod_lab.papers.sideslip.two_stage import two_stage_kalman, two_stage_poles

SLOWEST = {"two-stage-kalman": 50.0, "conventional-poles": 50.0}
"""Lowest rate of speed and yaw rate [Hz] at which a variant keeps its accuracy, where it is above the monitor's: at 20
Hz the disturbance observer of the first is 40 % worse, and poles as fast as those of the second cannot be placed."""


def _paper(name: str, build: Callable[[SteeredVehicle.Parameters, float], Any]) -> Opener:
    def open_(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        refuse_slow(rate, SLOWEST.get(name, 0.0))
        block = build(vehicle.parameters_for(SteeredVehicle.Parameters), 1.0 / rate)
        block = replace(block, axles=block.axles.of_vehicle(vehicle))
        return SideslipSession(block, vehicle, rate, f"sideslip, {name}", needs_torque=True)

    return open_


TWO_STAGE_KALMAN = Variant(
    "two-stage-kalman",
    "The first stage estimates the aligning torque, the second from it and the yaw rate the sideslip; Kalman "
    "gains. From 50 Hz on.",
    f"{PAPER}, eqs (18) to (24)",
    _paper("two-stage-kalman", two_stage_kalman),
    DECISIONS,
)

TWO_STAGE_POLES = Variant(
    "two-stage-poles",
    "The same with placed poles: twice as fast as the vehicle at every speed.",
    f"{PAPER}, eqs (18) to (25)",
    _paper("two-stage-poles", two_stage_poles),
    DECISIONS,
)

CONVENTIONAL_KALMAN = Variant(
    "conventional-kalman",
    "Vehicle and steering in one observer of four states; Kalman gains.",
    f"{PAPER}, eqs (13) to (15)",
    _paper("conventional-kalman", conventional_kalman),
    DECISIONS,
)

CONVENTIONAL_POLES = Variant(
    "conventional-poles",
    "The same with placed poles, as printed ten times as fast as the system: passes much noise. From 50 Hz on.",
    f"{PAPER}, eqs (14) to (17)",
    _paper("conventional-poles", conventional_poles),
    DECISIONS,
)
