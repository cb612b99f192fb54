"""The sideslip monitor and its variants."""

from __future__ import annotations

from collections.abc import Callable

from tierod.core.errors import ParameterError
from tierod.monitors.harness.baseline import Baseline
from tierod.monitors.harness.session import Monitor, Session, Variant
from tierod.monitors.registry import variants_with_plugins
from tierod.monitors.sideslip.combined import CombinedSideslip
from tierod.monitors.sideslip.combined_tuning import BY_WIRE
from tierod.monitors.sideslip.decisions import COMBINED_DECISIONS
from tierod.monitors.sideslip.drive import TRUTHS
from tierod.monitors.sideslip.finding import LEAST_ENABLED
from tierod.monitors.sideslip.session import JUDGED, CombinedSession
from tierod.vehicles import Vehicle

PAPER = "Yih, Ryu, Gerdes, Vehicle state estimation using steering torque (2004)"

Opener = Callable[[Vehicle, float, Baseline | None], Session]


SLOWEST_BY_WIRE = 33.0
"""Lowest rate of the combined estimator where the torque of the steering is known [Hz]; with longer samples it
attributes steering friction to other causes and diverges. Without the torque it is as good at 20 Hz as at 100."""


def refuse_slow(rate: float, slowest: float) -> None:
    """Refuse a recording that comes too slowly for a variant, both in Hz.

    Raises:
        ParameterError: the rate is below the slowest one
    """
    if rate < slowest:
        raise ParameterError(
            f"it needs vehicle_speed and yaw_rate at {slowest:g} Hz or more, but has {rate:g} Hz; record them faster"
        )


def _combined(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
    refuse_slow(rate, SLOWEST_BY_WIRE if BY_WIRE in vehicle else 0.0)
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

COMBINED = Variant(
    "combined",
    "One filter for all measured signals; it also estimates stiffness, friction and bank. Needs no steering "
    "torque. From 33 Hz on in a car steered by wire.",
    f"beyond {PAPER}; docs/explanation/sideslip.md",
    _combined,
    COMBINED_DECISIONS,
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
    variants=variants_with_plugins("sideslip", {"combined": "tierod.monitors.sideslip.definition:COMBINED"}),
    default="combined",
    estimates=True,
)
