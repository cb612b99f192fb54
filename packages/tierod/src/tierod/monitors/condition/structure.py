"""Structural model of the vehicle with its sensors and actuators, and the faults that are not isolable in it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import MISSING, fields
from typing import Annotated, Any, NamedTuple

from tierod.core.errors import ParameterError, nearest
from tierod.methods.analysis.structure import Equation, StructuralModel, isolability, structure_of
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.models.single_track import RollingCar
from tierod.monitors.condition.signals import ACCELERATIONS, MOTORS, OF_AUTOMATED, SENSORS, listed
from tierod.vehicles import Vehicle

ERRORS = ("front_force_error", "rear_force_error", "tie_rod_force_error")  # states for errors of the model's forces
OFFSETS = (
    *("yaw_rate_offset", "angle_offset", "wheel_speed_difference", "wheel_speed_scale", "drive_excess"),
    *("grade_acceleration", "bank_acceleration"),
)
"""Slowly varying states: offsets of sensors, radii of wheels, slopes of the road."""


class _Actuated:
    """Model of the vehicle with the acting torques as inputs.

    The steering motors work on one shaft, so that only their sum acts on the vehicle.
    """

    State, Output = AutomatedVehicle.State, AutomatedVehicle.Output

    class Input(NamedTuple):
        """Acting torques [N*m]."""

        steering_torque: Annotated[float, "N*m"]
        drive_left: Annotated[float, "N*m"]
        drive_right: Annotated[float, "N*m"]

    @staticmethod
    def transition(x: AutomatedVehicle.State, u: Input, p: AutomatedVehicle.Parameters) -> AutomatedVehicle.State:
        return AutomatedVehicle.transition(x._replace(torque_loss=0.0), _asked(u), p)

    @staticmethod
    def output(x: AutomatedVehicle.State, u: Input, p: AutomatedVehicle.Parameters) -> AutomatedVehicle.Output:
        return AutomatedVehicle.output(x._replace(torque_loss=0.0), _asked(u), p)


def _asked(u: _Actuated.Input) -> AutomatedVehicle.Input:
    torques = (u.steering_torque, 0.0, u.drive_left, u.drive_right)
    return AutomatedVehicle.Input(*torques, *torques, 0.0, 0.0, 0.0, 0.0)


def rolls(vehicle: Vehicle) -> bool:
    """Whether a vehicle is judged by its motion: its file lacks more parameters of a whole vehicle than of a car."""
    return len(_lacking(vehicle, RollingCar.Parameters)) < len(_lacking(vehicle, AutomatedVehicle.Parameters))


def _lacking(vehicle: Vehicle, wanted: type[Any]) -> list[str]:
    needed = (each for each in fields(wanted) if each.default is MISSING and each.default_factory is MISSING)
    return [each.name for each in needed if each.name not in vehicle]


def rolling_structure(vehicle: Vehicle, without: Collection[str] = (), steering_known: bool = True) -> StructuralModel:
    """Structural model of a car without known torques: speed and yaw rate may change arbitrarily at any time."""
    motion = ("speed", "acceleration", "yaw_rate", "yaw_acceleration", *(() if steering_known else ("steering_error",)))
    model = structure_of(
        RollingCar,
        vehicle.parameters_for(RollingCar.Parameters),
        {name: name for name in SENSORS if name in RollingCar.Output._fields},
        without=[name for name in RollingCar.State._fields if name not in motion],
        free=[name for name in motion if name not in ("speed", "yaw_rate")],
    )
    return model.without(*(name for name in without if name in model.by_name))


def vehicle_structure(vehicle: Vehicle, without: Collection[str] = (), forces_known: bool = True) -> StructuralModel:
    """Structural model of a vehicle with its sensors and actuators; every fault has the name of its element."""
    for name in without:
        if name not in (*SENSORS, *ACCELERATIONS):
            raise ParameterError(f"there is no sensor '{name}'{nearest(name, (*SENSORS, *ACCELERATIONS))}")
    if rolls(vehicle):
        return rolling_structure(vehicle, without, forces_known)
    model = structure_of(
        _Actuated,
        vehicle.parameters_for(AutomatedVehicle.Parameters),
        {**{name: name for name in OF_AUTOMATED}, **{f"known {name}": name for name in ("drive_left", "drive_right")}},
        known_inputs=("drive_left", "drive_right"),
        without=(*OFFSETS, "torque_loss", *(ERRORS if forces_known else ())),
        free=() if forces_known else ERRORS,
    ).without(*without)
    motors = [Equation.of(f"known {name}", {name}, {name}, name) for name in MOTORS]
    return model.plus(Equation.of("sum of the steering motors", {"steering_torque", *MOTORS}), *motors)


def further_sensors(model: StructuralModel) -> tuple[Equation, ...]:
    """Equations of sensors that a car could have in addition to those of the model, each with a fault of its own."""
    of_one = {
        "speed over ground": "speed",
        "optical sideslip sensor": "lateral_speed",
        **({} if "yaw_rate" in model.by_name else {"yaw rate sensor": "yaw_rate"}),
        "rack position sensor": "column_angle",
        "torque of steering motor 1, from its current": "steering_motor_1",
        "torque of steering motor 2, from its current": "steering_motor_2",
        "torque of the left drive, from its current": "drive_left",
        "torque of the right drive, from its current": "drive_right",
    }
    offered = [Equation.of(name, {state}, {name}, name) for name, state in of_one.items() if state in model.unknowns]
    for name in (*SENSORS, *ACCELERATIONS):
        if name in model.by_name:
            again = f"second {name.replace('_', ' ')}"
            offered.append(Equation.of(again, model.by_name[name].unknowns, {again}, again))
    return tuple(offered)


def limitations(vehicle: Vehicle, missing: Collection[str]) -> tuple[str, ...]:
    """Sentences on faults that are not detectable or not isolable without some sensors."""
    model = vehicle_structure(vehicle, missing)
    single = isolability(model)
    lack = f"without {listed(sorted(missing))}, " if missing else ""
    unseen, alike = single.undetectable, [group for group in single.groups if len(group) > 1]
    notes = [f"{lack}faults of {listed(unseen)} do not show in any equation"] if unseen else []
    notes += [f"{lack}faults of {listed(group)} are not distinguished from each other" for group in alike]
    if not notes and single.faults:
        notes = [f"{lack}single faults of {listed(single.faults)} are still distinguished by the equations"]
    return tuple(notes)
