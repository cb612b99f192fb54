"""Priors of a vehicle's parameters: its file, and the spread of its class where the file gives no deviation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

from tierod.methods.identification.drive_model import DriveNoises
from tierod.methods.identification.map_search import Prior
from tierod.models.lateral_parameters import LateralParameters
from tierod.vehicles import QUANTITIES, Vehicle
from tierod.vehicles.classes import BOUND, bound_distance, class_of, typical_spread

SHOWN = (
    "mass",
    "yaw_inertia",
    "front_distance",
    "rear_distance",
    "front_cornering_stiffness",
    "rear_cornering_stiffness",
    "steering_ratio",
    "tyre_friction",
    "rear_friction_ratio",
    "relaxation_length",
    "rear_relaxation_ratio",
    "roll_share",
    "sensor_forward",
)
"""Parameters that ordinary drives may identify."""

SIGNED = ("roll_share", "sensor_forward")  # Parameters that may be zero or negative
DISTANCES = ("front_distance", "rear_distance")
LEAST_DISTANCE = 0.13
"""Prior standard deviation of an axle distance above which it is identified from drives [m].

Pneumatic trail, roll steer and compliance of the steering have the same effect on the yaw motion as a centre of gravity
further ahead: in drives of two simulated cars and of a race car the most probable one was 0.19 to 0.23 m ahead of the
true one, three to five standard deviations."""
OF_ROAD = ("superelevation",)  # Quantities of the road that may be negative, for a bank towards the outside of bends
NOISES: dict[str, float] = {
    "yaw_rate_noise": 1.7,
    "lateral_speed_drift": 1.7,
    "yaw_rate_drift": 1.7,
    "bank_wander": 1.7,
    "road_wheel_angle_wander": 1.7,
    "superelevation": 1.0,
}
"""Noises that are identified together with the parameters, and their relative prior standard deviations."""


MODEL_ERRORS: dict[str, float] = {
    "yaw_inertia": 0.05,
    "front_cornering_stiffness": 0.08,
    "rear_cornering_stiffness": 0.15,
    "steering_ratio": 0.01,
    "relaxation_length": 0.25,
    "sensor_forward": 0.25,
}
"""Standard deviations of the bias by effects that the model lacks (torsion bar, load transfer, an inertial unit below
the roll axis), relative, for the position of the sensor in m. Measured as the errors of seven simulated cars (13
minutes each, seed 77) beyond the standard deviations by noise and fixed parameters."""


def spread_of(name: str, vehicle: Vehicle) -> tuple[float, bool]:
    """Prior standard deviation of a parameter, and whether it is from the vehicle file (else from its class).

    Args:
        name: of a parameter of the lateral motion, or in `SHOWN`
    """
    given = vehicle.parameters.get(name)
    if given is not None and given.standard_deviation is not None:
        return given.standard_deviation, True
    return typical_spread(name, _value(name, vehicle), class_of(vehicle)) or 0.0, False


def held_distances(vehicle: Vehicle, free: Sequence[str] = ()) -> tuple[str, ...]:
    """Names of the axle distances whose prior is more accurate than an identification from drives."""
    known = (name for name in DISTANCES if name not in free and not (name == BOUND and bound_distance(vehicle)))
    return tuple(name for name in known if 0.0 < spread_of(name, vehicle)[0] < LEAST_DISTANCE)


def priors_of(
    vehicle: Vehicle, usual: DriveNoises, with_ratio: bool = True, free: Sequence[str] = ()
) -> tuple[Prior, ...]:
    """Priors of parameters and noises; a parameter with a standard deviation of zero is fixed.

    Args:
        vehicle: with mass, yaw inertia, distances and cornering stiffnesses, and the steering ratio

    Raises:
        ParameterError: the vehicle lacks a parameter
    """
    vehicle.parameters_for(LateralParameters)
    if with_ratio:
        vehicle["steering_ratio"]
    priors = []
    held = held_distances(vehicle, free)
    for name in SHOWN:
        deviation, _ = spread_of(name, vehicle)
        follows = name == BOUND and bound_distance(vehicle)
        if (name == "steering_ratio" and not with_ratio) or not deviation or follows or name in held:
            continue
        priors.append(_prior(name, vehicle, deviation))
    noises = (
        Prior(name, getattr(usual, name), share * getattr(usual, name), name not in OF_ROAD)
        for name, share in NOISES.items()
    )
    return (*priors, *noises)


def considered(vehicle: Vehicle, priors: Sequence[Prior]) -> tuple[Prior, ...]:
    """Priors of the uncertain parameters of the lateral motion that are fixed in the search.

    Args:
        vehicle: with their standard deviations in its file, or else in its class
    """
    taken = {each.name for each in priors} | ({BOUND} if bound_distance(vehicle) else set())
    found = []
    for name in (each.name for each in fields(LateralParameters)):
        deviation, _ = (0.0, False) if name in taken or name.startswith("road_wheel_") else spread_of(name, vehicle)
        if deviation:
            found.append(_prior(name, vehicle, deviation))
    return tuple(found)


def _prior(name: str, vehicle: Vehicle, deviation: float) -> Prior:
    low, high = QUANTITIES[name].plausible
    return Prior(name, _value(name, vehicle), deviation, name not in SIGNED, low, high)


def _value(name: str, vehicle: Vehicle) -> float:
    defaults = {each.name: each.default for each in fields(LateralParameters)}
    return vehicle[name] if name in vehicle else float(defaults[name])  # type: ignore[arg-type]
