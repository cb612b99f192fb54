"""Classes of cars, and how widely the parameters of a car of its class vary: for files without standard deviations."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Annotated

from tierod.vehicles.uncertain import may_move
from tierod.vehicles.vehicle import Parameter, Vehicle


@dataclass(frozen=True)
class CarClass:
    """Cars that are alike in size.

    Args:
        name: in words
        lightest, heaviest: mass as driven
        shortest, longest: wheelbase
        laden: relative standard deviation of the mass, from the load that nobody weighed; passengers weigh more in a
            light car, freight in a van [assumed: half of the load that the class may take, as three deviations]
        tyres: relative standard deviation of cornering stiffness and grip, from the tyres that may be mounted [assumed]
    """

    name: str
    lightest: Annotated[float, "kg"]
    heaviest: Annotated[float, "kg"]
    shortest: Annotated[float, "m"]
    longest: Annotated[float, "m"]
    laden: Annotated[float, ""]
    tyres: Annotated[float, ""]


CLASSES = (
    CarClass("quadricycle", 200.0, 650.0, 1.2, 2.2, 0.12, 0.25),
    CarClass("race car", 400.0, 1100.0, 2.2, 3.2, 0.04, 0.25),
    CarClass("small", 650.0, 1250.0, 1.9, 2.6, 0.10, 0.20),
    CarClass("midsize", 1150.0, 1750.0, 2.5, 2.85, 0.08, 0.20),
    CarClass("large", 1600.0, 2600.0, 2.75, 3.3, 0.07, 0.20),
    CarClass("SUV", 1500.0, 2800.0, 2.5, 3.0, 0.08, 0.20),
    CarClass("van", 1700.0, 60e3, 2.9, 8.0, 0.15, 0.25),
)
"""Ranges of mass and wheelbase [assumed: production cars of 1990 to 2025, a driver aboard]; a race car has a low centre
of gravity, an SUV a high one."""

LOW, HIGH = 0.45, 0.62
"""Heights of the centre of gravity below which a car is taken for a race car, and above which for an SUV [m]
[assumed]."""

RELATIVE = {
    "yaw_inertia": (0.12, "assumed: m a b holds within a tenth for cars, and the load is added"),
    "front_distance": (0.06, "assumed: weight in front 50 to 63 %, where only the wheelbase is known"),
    "rear_distance": (0.06, "assumed: weight in front 50 to 63 %, where only the wheelbase is known"),
    "centre_height": (0.08, "assumed: load and ride height"),
    "track_width": (0.03, "assumed: rims and offsets of a model"),
    "roll_arm": (0.2, "assumed"),
    "roll_share": (0.4, "assumed"),
    "roll_frequency": (0.2, "assumed"),
    "roll_damping_ratio": (0.3, "assumed"),
    "trail": (0.3, "assumed: the pneumatic half varies with tyre and pressure"),
    "mechanical_trail": (0.25, "assumed"),
    "pneumatic_trail": (0.25, "assumed"),
    "relaxation_length": (0.3, "assumed"),
    "rear_relaxation_ratio": (0.2, "assumed"),
    "rear_friction_ratio": (0.06, "assumed"),
    "front_force_shape": (0.08, "assumed"),
    "rear_force_shape": (0.08, "assumed"),
    "trail_shape": (0.08, "assumed"),
    "stiffness_growth": (0.3, "assumed"),
    "front_load_transfer": (0.2, "assumed"),
    "steering_ratio": (0.06, "assumed: a brochure gives one number for a ratio that varies with the angle"),
    "road_wheel_inertia": (0.2, "assumed"),
    "road_wheel_damping": (0.3, "assumed"),
    "road_wheel_friction": (0.3, "assumed"),
    "column_inertia": (0.3, "assumed"),
    "column_damping": (0.4, "assumed"),
    "steering_wheel_inertia": (0.2, "assumed: wheels of 1.5 to 3 kg"),
    "steering_wheel_damping": (0.5, "assumed"),
    "torsion_bar_stiffness": (0.15, "assumed: 80 to 170 N*m/rad are usual"),
    "motor_torque_constant": (0.1, "assumed"),
    "motor_resistance": (0.15, "copper gains 0.39 % per kelvin: 40 K as one deviation"),
    "motor_inductance": (0.1, "assumed"),
    "motor_flux": (0.05, "ferrite loses 0.2 %, NdFeB 0.1 % per kelvin: 25 to 40 K as one deviation"),
    "motor_inertia": (0.1, "assumed"),
    "motor_damping": (0.3, "assumed"),
    "motor_friction": (0.3, "assumed"),
    "gear_stiffness": (0.2, "assumed"),
    "gear_inertia": (0.2, "assumed"),
    "gearhead_efficiency": (0.05, "assumed"),
    "power_assist_factor": (0.1, "assumed"),
    "assist_linear_gain": (0.2, "assumed"),
    "assist_quadratic_gain": (0.2, "assumed"),
    "assist_half_speed": (0.2, "assumed"),
    "wheel_radius": (0.02, "assumed: wear and pressure"),
    "rolling_mass": (0.25, "assumed"),
    "rolling_resistance": (0.3, "assumed"),
    "drag": (0.2, "assumed"),
    "rack_damping": (0.3, "assumed"),
    "scrub_radius": (0.4, "assumed"),
    "jacking_torque": (0.4, "assumed"),
    "turn_slip_stiffness": (0.4, "assumed"),
}
"""Relative standard deviation of a quantity from car to car of a class, and where that comes from; quantities that are
not here are counted (pole pairs, gear ratios), chosen (limits), or zero on the average car (offsets)."""

TYRES = ("front_cornering_stiffness", "rear_cornering_stiffness", "tyre_friction")
"""Quantities that vary with the tyres."""


def car_class(vehicle: Vehicle) -> CarClass | None:
    """The class of a car by mass and wheelbase, and by the height of its centre of gravity where that is given.

    Args:
        vehicle: with what it gives of them

    Returns:
        the class whose middle is nearest; None for what has no mass: a bench
    """
    if "mass" not in vehicle:
        return None
    known = vehicle.parameters.get("centre_height")
    height = None if known is None else known.value
    fitting = [each for each in CLASSES if _may_be(each, height)]
    return min(fitting, key=lambda each: _distance(each, vehicle))


def _may_be(each: CarClass, height: float | None) -> bool:
    low = height is not None and height < LOW
    if low or each.name == "race car":
        return low and each.name == "race car"
    return each.name != "SUV" or (height is not None and height > HIGH)


def _distance(each: CarClass, vehicle: Vehicle) -> float:
    """Of a car from the middle of a class, in half widths of its ranges."""
    mass = _outside(vehicle["mass"], each.lightest, each.heaviest)
    if "front_distance" not in vehicle or "rear_distance" not in vehicle:
        return abs(mass)
    wheelbase = vehicle["front_distance"] + vehicle["rear_distance"]
    return math.hypot(mass, _outside(wheelbase, each.shortest, each.longest))


def _outside(value: float, low: float, high: float) -> float:
    return 2.0 * math.log(value / math.sqrt(low * high)) / math.log(high / low)


def with_spread(vehicle: Vehicle) -> tuple[Vehicle, tuple[str, ...]]:
    """The vehicle with the spread of its class where a parameter gives none, and the names of those parameters.

    Args:
        vehicle: whose parameters may lack a standard deviation
    """
    found = car_class(vehicle)
    taken = {
        name: spread
        for name, each in vehicle.parameters.items()
        if each.standard_deviation is None and may_move(name) and (spread := _spread(each, found))
    }
    if not taken:
        return vehicle, ()
    parameters = {
        name: dataclasses.replace(each, standard_deviation=taken[name]) if name in taken else each
        for name, each in vehicle.parameters.items()
    }
    return dataclasses.replace(vehicle, parameters=parameters), tuple(taken)


def _spread(each: Parameter, found: CarClass | None) -> float:
    """Standard deviation of a parameter in its class, in its unit; 0 where it has none."""
    if each.name == "mass":
        relative = 0.08 if found is None else found.laden
    elif each.name in TYRES:
        relative = 0.2 if found is None else found.tyres
    else:
        relative = RELATIVE.get(each.name, (0.0, ""))[0]
    return relative * abs(each.value)


def in_words(vehicle: Vehicle, names: tuple[str, ...]) -> str:
    """A sentence on parameters that took the spread of their class.

    Args:
        vehicle: whose they are
        names: of the parameters; empty gives ""
    """
    if not names:
        return ""
    found = car_class(vehicle)
    of = "of a usual column or motor" if found is None else f"of the class '{found.name}'"
    shown = f"{', '.join(names[:3])}{f' and {len(names) - 3} more' if len(names) > 3 else ''}"
    have = "has no standard deviation and takes that" if len(names) == 1 else "have no standard deviation and take that"
    return f"{shown} {have} {of}; give each its standard_deviation in the vehicle file, 0 where the value is exact"
