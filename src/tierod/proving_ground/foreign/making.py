"""Replacement of a scenario's car by a unit, with remarks for the user."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from tierod.core.block import tuning
from tierod.core.errors import ParameterError
from tierod.core.fields import replaced
from tierod.proving_ground.courses import Start
from tierod.proving_ground.foreign.car import LATERAL, SLIP, ForeignCar, class_of
from tierod.proving_ground.foreign.description import Unit
from tierod.proving_ground.foreign.offers import ASSIST, SPEED
from tierod.proving_ground.foreign.wiring import Wiring
from tierod.proving_ground.parts import Plant


def car_of(unit: Unit, wiring: Wiring, own: Plant) -> ForeignCar:
    """A unit in place of a car, with the driver and the assist unit of this car.

    Args:
        unit: description of the unit
        wiring: connection of the unit
        own: car of a scenario

    Raises:
        ParameterError: the unit lacks inputs of driver or assist unit, or the scenario's car has none of these
    """
    driver: Any = getattr(own, "driver", None)
    if driver is None:
        raise ParameterError(
            f"{type(own).__name__} of the scenario has no driver for the unit {unit.path.name}; take a scenario of a "
            "car on a road"
        )
    assist: Any = getattr(own, "assist", None) if any(each.signal == ASSIST for each in wiring.inputs) else None
    car: ForeignCar = class_of(wiring.tunable)(
        unit.path, wiring.text(), _stepped(driver, wiring.step), None, Start(), wiring.step
    )
    if any(each.signal == ASSIST for each in wiring.inputs) and assist is None:
        raise ParameterError(
            f"the unit {unit.path.name} takes the torque of an assist motor, and {type(own).__name__} of the scenario "
            "has no assist unit that asks for it; take a scenario of a car with EPS"
        )
    if assist is not None:
        car = replace(car, assist=_stepped(assist, wiring.step))
    _require_outputs(car, unit)
    return car


def _stepped(part: Any, step: float) -> Any:
    """A part with all its sampling intervals set to a step [s]."""
    clocks = {path: step for path, _ in tuning(part) if path.rpartition(".")[2] == "step_time"}
    return replaced(part, clocks) if clocks else part


def _require_outputs(car: ForeignCar, unit: Unit) -> None:
    gives = set(car.gives)
    lacking = []
    if car.drives:
        lacking += [] if gives & set(SPEED) else ["a speed (truth_speed or vehicle_speed)"]
        lacking += [] if "yaw_rate" in gives else ["yaw_rate"]
        holds = {"steering_wheel_angle", "steering_wheel_rate"} & set(car.takes)
        lacking += [] if "steering_wheel_angle" in gives or holds else ["steering_wheel_angle"]
    if car.assist is not None:
        lacking += [name for name in ("driver_torque", "steering_wheel_angle") if name not in gives]
    if lacking:
        who = "the assist unit" if not car.drives else "our driver"
        raise ParameterError(
            f"the unit {unit.path.name} gives {', '.join(sorted(gives))}, but {who} needs "
            f"{', '.join(dict.fromkeys(lacking))} of it; name the variable in the table 'outputs' of the plant file, "
            "or export it with the unit"
        )


def remarks(car: ForeignCar, unit: Unit, acting: Iterable[str]) -> list[str]:
    """Remarks for the user on the connection, in sentences.

    Args:
        car: car with its unit
        unit: description of the unit
        acting: inputs that the course sets
    """
    found = []
    idle = sorted(name for name in acting if name not in car.takes and not name.startswith("demand."))
    idle = [name for name in idle if not (name == "road.curvature" and car.drives)]
    if idle:
        found.append(f"the unit takes no {', '.join(idle)}: these inputs of the course have no effect")
    if not car.wires.start:
        found.append("no parameter of the unit is its speed at the start ('start_speed'): it begins at its own speed")
    if car.drives and not {*LATERAL, *SLIP} & set(car.gives):
        found.append("the unit gives no lateral speed: its lateral position on the path is computed without it")
    if bare := _without_unit(car, unit):
        found.append(
            f"the unit states no unit of measurement for {', '.join(bare)}: taken as they are; write one in the plant "
            "file where they differ"
        )
    free = sorted(name for name in unit.of("input") if name not in {each.variable for each in car.wires.inputs})
    if free:
        shown = ", ".join(free[:8]) + (f" and {len(free) - 8} more" if len(free) > 8 else "")
        found.append(f"inputs of the unit that are left at their start: {shown}")
    return found


def _without_unit(car: ForeignCar, unit: Unit) -> list[str]:
    """Connected variables without a unit of measurement, each with the unit that is assumed for it."""
    wires = [*car.wires.inputs, *car.wires.outputs]
    plain = [each for each in wires if (each.gain, each.offset) == (1.0, 0.0) and each.unit not in ("", "1")]
    return [f"{each.variable} [{each.unit}]" for each in plain if not unit.variables[each.variable].unit]
