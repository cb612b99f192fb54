"""Priors of a vehicle before it is identified: its file, and the spread of its class where that gives none."""

from __future__ import annotations

from collections.abc import Sequence
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
DISTANCES = ("front_distance", "rear_distance")
LEAST_DISTANCE = 0.13
"""Standard deviation of a distance of an axle from which drives are asked for it [m].

Trail of the tyres, roll steer and what the steering yields act on the yaw as a centre of gravity further ahead does: in
drives of two virtual cars and of a race car the most probable one lay 0.19 to 0.23 m ahead of the true one, three to
five of its deviations."""
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


MODEL_ERRORS: dict[str, float] = {
    "yaw_inertia": 0.05,
    "front_cornering_stiffness": 0.08,
    "rear_cornering_stiffness": 0.15,
    "steering_ratio": 0.01,
    "relaxation_length": 0.25,
    "sensor_forward": 0.25,
}
"""Standard deviations of what a car has and the model lacks, relative, of the sensor's place in m: a torsion bar that
yields, load transfer, an inertial unit below the roll axis. What the most probable values of seven virtual cars (13
minutes each, seed 77) lay off the true ones beyond their deviation by noise and by parameters that are held."""


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


def held_distances(vehicle: Vehicle, free: Sequence[str] = ()) -> tuple[str, ...]:
    """Distances of the axles that a brochure gives better than drives do.

    Args:
        vehicle: whose file gives them
        free: parameters that are asked for by name
    """
    known = (name for name in DISTANCES if name not in free and not (name == BOUND and bound_distance(vehicle)))
    return tuple(name for name in known if 0.0 < spread_of(name, vehicle)[0] < LEAST_DISTANCE)


def priors_of(
    vehicle: Vehicle, usual: DriveNoises, with_ratio: bool = True, free: Sequence[str] = ()
) -> tuple[Prior, ...]:
    """Priors of parameters and noises; a parameter with a deviation of zero is held.

    Args:
        vehicle: with mass, yaw inertia, distances and cornering stiffnesses, and the steering ratio
        usual: noises of drives before they are looked at closely
        with_ratio: whether the steering ratio is among them
        free: parameters that are asked for by name

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
    """Priors of the parameters of the motion that the search holds, as far as they are uncertain.

    Args:
        vehicle: whose file may give their deviation; else that of its class
        priors: of the search
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
