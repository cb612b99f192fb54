"""The sideslip monitor and its variants."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from tierod.core.errors import ParameterError
from tierod.models.steered_vehicle import SteeredVehicle
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.session import Monitor, Session, Variant
from tierod.monitors.sideslip.combined import CombinedSideslip
from tierod.monitors.sideslip.conventional import conventional_kalman, conventional_poles
from tierod.monitors.sideslip.decisions import COMBINED_DECISIONS, DECISIONS
from tierod.monitors.sideslip.drive import TRUTHS
from tierod.monitors.sideslip.finding import LEAST_ENABLED
from tierod.monitors.sideslip.monitor import BY_WIRE
from tierod.monitors.sideslip.session import JUDGED, CombinedSession, SideslipSession
from tierod.monitors.sideslip.two_stage import two_stage_kalman, two_stage_poles
from tierod.vehicles import Vehicle

PAPER = "Yih, Ryu, Gerdes, Vehicle state estimation using steering torque (2004)"

Opener = Callable[[Vehicle, float, Baseline | None], Session]


SLOWEST = {"two-stage-kalman": 50.0, "conventional-poles": 50.0}
"""Lowest rate of speed and yaw rate [Hz] at which a variant keeps its accuracy, where it is above the monitor's: at 20
Hz the disturbance observer of the first is 40 % worse, and poles as fast as those of the second cannot be placed."""

SLOWEST_BY_WIRE = 33.0
"""Lowest rate of the combined estimator where the torque of the steering is known [Hz]; with longer samples it
attributes steering friction to other causes and diverges. Without the torque it is as good at 20 Hz as at 100."""


def _refuse_slow(rate: float, slowest: float) -> None:
    if rate < slowest:
        raise ParameterError(
            f"it needs vehicle_speed and yaw_rate at {slowest:g} Hz or more, but has {rate:g} Hz; record faster, or "
            "choose the variant conventional-kalman, which is as accurate at 20 Hz"
        )


def _paper(name: str, build: Callable[[SteeredVehicle.Parameters, float], Any]) -> Opener:
    def open_(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        _refuse_slow(rate, SLOWEST.get(name, 0.0))
        block = build(vehicle.parameters_for(SteeredVehicle.Parameters), 1.0 / rate)
        block = replace(block, axles=block.axles.of_vehicle(vehicle))
        return SideslipSession(block, vehicle, rate, f"sideslip, {name}", needs_torque=True)

    return open_


def _combined(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
    _refuse_slow(rate, SLOWEST_BY_WIRE if BY_WIRE in vehicle else 0.0)
    block = CombinedSideslip.of_vehicle(vehicle, 1.0 / rate)
    return CombinedSession(block, vehicle, rate, "sideslip, combined", COMBINED_TRACES)


COMBINED_TRACES = {
    "front_stiffness": ("front_stiffness_ratio", ""),
    "front_stiffness_deviation": ("front_stiffness_ratio_standard_deviation", ""),
    "rear_stiffness": ("rear_stiffness_ratio", ""),
    "rear_stiffness_deviation": ("rear_stiffness_ratio_standard_deviation", ""),
    "front_friction_used": ("front_friction_used", ""),
    "front_friction_used_deviation": ("front_friction_used_standard_deviation", ""),
    "bank_angle": ("estimated_bank_angle", "rad"),
    "bank_angle_deviation": ("estimated_bank_angle_standard_deviation", "rad"),
    "limit_ahead": ("limit_ahead", ""),
    "limit_distance": ("limit_distance", ""),
}
"""Outputs of the combined estimator shown beside the sideslip: stiffness over that of the file, grip used, bank."""

_VARIANTS = (
    Variant(
        "combined",
        "One filter for all measured signals; it also estimates stiffness, friction and bank. Needs no steering "
        "torque. From 33 Hz on in a car steered by wire.",
        f"beyond {PAPER}; docs/explanation/sideslip.md",
        _combined,
        COMBINED_DECISIONS,
    ),
    Variant(
        "two-stage-kalman",
        "The first stage estimates the aligning torque, the second from it and the yaw rate the sideslip; Kalman "
        "gains. From 50 Hz on.",
        f"{PAPER}, eqs (18) to (24)",
        _paper("two-stage-kalman", two_stage_kalman),
        DECISIONS,
    ),
    Variant(
        "two-stage-poles",
        "The same with placed poles: twice as fast as the vehicle at every speed.",
        f"{PAPER}, eqs (18) to (25)",
        _paper("two-stage-poles", two_stage_poles),
        DECISIONS,
    ),
    Variant(
        "conventional-kalman",
        "Vehicle and steering in one observer of four states; Kalman gains.",
        f"{PAPER}, eqs (13) to (15)",
        _paper("conventional-kalman", conventional_kalman),
        DECISIONS,
    ),
    Variant(
        "conventional-poles",
        "The same with placed poles, as printed ten times as fast as the system: passes much noise. From 50 Hz on.",
        f"{PAPER}, eqs (14) to (17)",
        _paper("conventional-poles", conventional_poles),
        DECISIONS,
    ),
)

SIDESLIP = Monitor(
    name="sideslip",
    title="Sideslip of the vehicle",
    summary="Estimates the sideslip angle and the aligning torque of the front tyres, with their uncertainty.",
    source=PAPER,
    drive=f"Forward driving with a steering angle for at least {LEAST_ENABLED:g} s; some minutes with bends to both "
    "sides let it learn stiffnesses and offsets, and test the vehicle file.",
    required=("vehicle_speed", "yaw_rate"),
    optional=(*JUDGED, *TRUTHS),
    rests_on=("road_wheel_angle", "steering_wheel_angle", "lateral_acceleration"),
    rate=100.0,
    minimum_rate=20.0,
    maximum_age=0.1,
    slower=(50.0, 40.0, 33.3, 25.0, 20.0),
    variants={variant.name: variant for variant in _VARIANTS},
    default="combined",
    estimates=True,
)
