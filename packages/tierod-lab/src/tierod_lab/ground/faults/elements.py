"""Elements of a car that faults can change, and their units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any, NamedTuple

from tierod.core.block import leaves, skeleton, units
from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import Meaning, Number, Range, hints, meaning, numbers
from tierod.core.graph.trace import trace
from tierod.core.signals import SIGNALS
from tierod.core.toml import kind_name
from tierod_lab.ground.faults.behaviours import (
    ACTUATOR,
    BEHAVIOURS,
    LOOP,
    PARAMETER,
    SIGNAL,
    SURROUNDING,
    Behaviour,
    Sluggish,
)
from tierod_lab.ground.parts import Demand, Road, Wind
from tierod_lab.ground.recorder import channel_names, declared_units
from tierod_lab.ground.sensors import SensorSet

NOTHING = "nothing"
"""Alternative after "|" with which an effect is left out if the car has none of the elements before it."""

LAGS = {
    "motor_torque": ("motor.control.lag", "steering.motor.lag"),
    "column_assist_torque": ("steering.column.motor.lag",),
    "feedback_torque": ("steering.feedback.lag",),
    "steering_motor_1_torque": ("steering.steering_motor_1.lag",),
    "steering_motor_2_torque": ("steering.steering_motor_2.lag",),
    "drive_torque_left": ("powertrain.left_lag",),
    "drive_torque_right": ("powertrain.right_lag",),
}
"""Parameters that are the time constant of an actuator; the first that a car has is taken."""

PREFIXES = {"sensor.": SIGNAL, "loop.": LOOP, "actuator.": ACTUATOR, "car.": PARAMETER}
"""Prefix of an element's name -> role, for names with several roles."""

CLOCK = "step_time"  # Name of the parameters that hold the sampling interval, which no fault changes

_AROUND: Mapping[str, Any] = {"road": Road, "wind": Wind, "demand": Demand}


class MisfitError(ParameterError):
    """A behaviour that does not fit an element."""


class Target(NamedTuple):
    """Target of an effect of a fault."""

    role: str
    name: str
    unit: str | None  # unit of its values; None if unknown
    usual: float | None = None  # fault-free value of a parameter; None where it is known only during the run
    limits: Range | None = None


def split(element: str) -> tuple[str, str]:
    """(prefix or "", rest) of the name of an element."""
    prefix = next((each for each in PREFIXES if element.startswith(each)), "")
    return prefix, element.removeprefix(prefix)


def unit_without_car(element: str) -> str | None:
    """The unit of an element if its name alone determines it, else None."""
    _, name = split(element.split("|")[0].strip())
    if name in SIGNALS:
        return SIGNALS[name].unit
    means = _around(name)
    return None if means is None else means.unit or ""


def _around(name: str) -> Meaning | None:
    """Meaning of a quantity of the car's surroundings, from its annotation; None for any other name."""
    head, _, rest = name.partition(".")
    known = hints(_AROUND[head]) if head in _AROUND else {}
    return meaning(known[rest]) if rest in known else None


class Reach:
    """All elements of a car and its sensors that faults can change."""

    def __init__(self, car: Any, sensors: SensorSet):
        self.car, self.sensors = car, sensors

    @cached_property
    def outputs(self) -> dict[str, str | None]:
        """Unit of every channel of the car, None if it has none."""
        declared = declared_units(trace(self.car).output_tree)
        return {name: SIGNALS[name].unit if name in SIGNALS else declared.get(name) for name in channel_names(self.car)}

    @cached_property
    def inputs(self) -> dict[str, str]:
        """Unit of every input of the car by dotted name."""
        names = [name for name, _ in leaves(skeleton(self.car.Sample))]
        return dict(zip(names, units(self.car.Sample), strict=True))

    @cached_property
    def parameters(self) -> dict[str, Number]:
        """Every float field of the car by dotted path, except sampling intervals."""
        return {path: each for path, each in numbers(self.car).items() if path.split(".")[-1] != CLOCK}

    @property
    def recorded(self) -> set[str]:
        """Measured channels."""
        return set(self.sensors.sensors) & set(self.outputs)

    @property
    def ports(self) -> set[str]:
        return {name.split(".")[1] for name in self.inputs if name.startswith("ports.")}

    @property
    def actuators(self) -> set[str]:
        steering = getattr(self.car, "steering", None)
        own = getattr(self.car, "actuators", getattr(steering, "actuators", ()))
        return {"motor_torque", *own} & self.ports

    @property
    def surroundings(self) -> set[str]:
        """Inputs of the car that are neither ports nor outputs of another tool's unit."""
        return {name for name in self.inputs if not name.startswith(("ports.", "unit."))}

    def by_role(self) -> dict[str, set[str]]:
        """Names of all elements that faults can change, by role."""
        return {
            SIGNAL: self.recorded,
            LOOP: self.ports - self.actuators,
            ACTUATOR: self.actuators,
            PARAMETER: set(self.parameters),
            SURROUNDING: self.surroundings,
        }

    def targets(self, element: str, behaviour: Behaviour) -> tuple[Target, ...]:
        """Targets of a behaviour of an element; a signal that is both recorded and read in the loop gives two targets.

        Args:
            element: name, or several separated by "|", of which the first that the car has is taken; "nothing" gives no
                target
        """
        known = self.by_role()
        names = [name.strip() for name in element.split("|")]
        for name in names:
            if name == NOTHING:
                return ()
            prefix, plain = split(name)
            roles = [role for role in known if plain in known[role] and PREFIXES.get(prefix, role) == role]
            if roles:
                return tuple(self._target(role, plain, behaviour) for role in _chosen(plain, roles, behaviour))
        raise ParameterError(self._missing(names[0], known))

    def nothing_of(self, elements: Iterable[str]) -> str:
        """Error message for a fault all of whose effects are left out."""
        names = (name.strip() for element in elements for name in element.split("|"))
        name = next((name for name in names if name != NOTHING), None)
        if name is None:
            return "the fault has no element; name one of the car"
        return f"the fault would change nothing: {self._missing(name, self.by_role())}"

    def _missing(self, name: str, known: Mapping[str, set[str]]) -> str:
        prefix, plain = split(name)
        if plain in SIGNALS and plain in self.outputs and not prefix:
            return f"no sensor records '{plain}'; add one to the sensors"
        if not prefix:
            return f"the car has no '{plain}' that could fail{nearest(plain, set().union(*known.values()))}"
        role = PREFIXES[prefix]
        others = [f"'{each}{plain}'" for each, kind in PREFIXES.items() if plain in known[kind]]
        instead = f"; write {' or '.join(others)}" if others else nearest(plain, known[role])
        return f"{_WORDS[role][1]} '{plain}'{instead}"

    def _target(self, role: str, name: str, behaviour: Behaviour) -> Target:
        if role == ACTUATOR and isinstance(behaviour.core, Sluggish):
            lags = [path for path in LAGS.get(name, ()) if path in self.parameters]
            if not lags:
                without = f"'{name}' of this car has no time constant that could grow"
                raise ParameterError(f"{without}; choose another behaviour")
            role, name = PARAMETER, lags[0]
        if role == PARAMETER:
            number = self.parameters[name]
            return Target(role, name, number.unit, number.value, number.limits)
        if role == SURROUNDING:
            means = _around(name)
            return Target(role, name, self.inputs[name], limits=means.limits if means else None)
        return Target(role, name, SIGNALS[name].unit if name in SIGNALS else self.outputs.get(name))


def _chosen(name: str, roles: list[str], behaviour: Behaviour) -> list[str]:
    fits, kind = behaviour.core.fits, kind_name(type(behaviour.core))
    if SIGNAL in roles and ACTUATOR in roles:
        if {SIGNAL, ACTUATOR} <= fits:
            raise ParameterError(
                f"'{name}' is an actuator and a recorded signal; write 'actuator.{name}' or 'sensor.{name}'"
            )
        roles = [ACTUATOR] if ACTUATOR in fits else [SIGNAL]
    for role in roles:
        if role not in fits:
            possible = sorted(each for each, kinds in BEHAVIOURS.items() if role in kinds.fits)
            message = f"'{kind}' does not fit '{name}', {_WORDS[role][0]}; possible: {', '.join(possible)}"
            if len(roles) > 1 and SIGNAL in fits:
                message += f"; or leave the loop alone with 'sensor.{name}'"
            raise MisfitError(message)
    return roles


# What an element of a role is, and what is said if there is none of a name
_WORDS = {
    SIGNAL: ("a recorded signal", "no sensor records"),
    LOOP: ("which a control unit of the car reads", "no control unit of the car reads"),
    ACTUATOR: ("an actuator", "no actuator of the car is called"),
    PARAMETER: ("a parameter of the car", "no parameter of the car is called"),
    SURROUNDING: ("something around the car", ""),
}
