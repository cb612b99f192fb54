"""What is known of a vehicle before it is identified: its file, and the spread of its class where that gives none."""

from __future__ import annotations

from dataclasses import fields

from tierod.methods.identification.drive_model import DriveNoises
from tierod.methods.identification.posterior import Prior
from tierod.models.lateral_parameters import LateralParameters
from tierod.vehicles import QUANTITIES, Vehicle
from tierod.vehicles.classes import class_of, typical_spread
from tierod.vehicles.uncertain import BOUND, bound_distance

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
"""Parameters that ordinary drives may show."""

SIGNED = ("roll_share", "sensor_forward")
"""May be zero or negative."""
OF_ROAD = ("superelevation",)
"""May be negative too, where a road falls off to the outside of its bends."""
NOISES: dict[str, float] = {
    "yaw_rate_noise": 1.7,
    "lateral_speed_drift": 1.7,
    "yaw_rate_drift": 1.7,
    "bank_wander": 1.7,
    "road_wheel_angle_wander": 1.7,
    "superelevation": 1.0,
}
"""Noises that are found beside the parameters, and their spread over drives relative to `DriveNoises`."""


def spread_of(name: str, vehicle: Vehicle) -> tuple[float, bool]:
    """Standard deviation of a parameter before, and whether the vehicle file gives it.

    Args:
        name: in `SHOWN`
        vehicle: whose file may give it
    """
    given = vehicle.parameters.get(name)
    if given is not None and given.standard_deviation is not None:
        return given.standard_deviation, True
    return typical_spread(name, _value(name, vehicle), class_of(vehicle)) or 0.0, False


def priors_of(vehicle: Vehicle, usual: DriveNoises, with_ratio: bool = True) -> tuple[Prior, ...]:
    """What is known before, of parameters and noises; a parameter with a deviation of zero is held.

    Args:
        vehicle: with mass, yaw inertia, distances and cornering stiffnesses, and the steering ratio
        usual: noises of drives before they are looked at closely
        with_ratio: whether the steering ratio is among them

    Raises:
        ParameterError: the vehicle lacks a parameter
    """
    vehicle.parameters_for(LateralParameters)
    if with_ratio:
        vehicle["steering_ratio"]
    priors = []
    for name in SHOWN:
        deviation, _ = spread_of(name, vehicle)
        follows = name == BOUND and bound_distance(vehicle)
        if (name == "steering_ratio" and not with_ratio) or not deviation or follows:
            continue
        low, high = QUANTITIES[name].plausible
        priors.append(Prior(name, _value(name, vehicle), deviation, name not in SIGNED, low, high))
    noises = (
        Prior(name, getattr(usual, name), share * getattr(usual, name), name not in OF_ROAD)
        for name, share in NOISES.items()
    )
    return (*priors, *noises)


def _value(name: str, vehicle: Vehicle) -> float:
    defaults = {each.name: each.default for each in fields(LateralParameters)}
    return vehicle[name] if name in vehicle else float(defaults[name])  # type: ignore[arg-type]
