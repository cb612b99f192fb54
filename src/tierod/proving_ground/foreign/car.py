"""A vehicle that a unit computes, with the driver and, if it has an input for the motor torque, the assist unit."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, Tree, named_tuple, tuning
from tierod.core.fields import Range, replaced
from tierod.core.graph.maths import maximum, tan
from tierod.proving_ground.cars.eps_car import Assisted
from tierod.proving_ground.control.assist import AssistUnit
from tierod.proving_ground.control.blocks import Driving, Sensed
from tierod.proving_ground.control.driver import HumanDriver
from tierod.proving_ground.courses import Start
from tierod.proving_ground.foreign.coupled import Coupled
from tierod.proving_ground.foreign.offers import ASSIST, ASSIST_READS, DRIVER, SPEED, port_of
from tierod.proving_ground.foreign.wiring import Tunable, Wiring
from tierod.proving_ground.parts import Demand, Driver, Memory, Plant, Road, Wind, pass_through, ports_type
from tierod.proving_ground.recorder import TRUTH

UNIT = "unit"
"""Branch of the inputs that holds the outputs of a unit."""


class Steered(NamedTuple):
    """Outputs of the driver, and position of the vehicle relative to its path."""

    truth_hand_torque: Annotated[Scalar, "N*m"]
    truth_drive_force: Annotated[Scalar, "N"]
    truth_distance: Annotated[Scalar, "m"]
    truth_lateral_offset: Annotated[Scalar, "m"]
    truth_heading_error: Annotated[Scalar, "rad"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]


class State(NamedTuple):
    """State of driver and assist unit between two steps.

    Args:
        driving: driver and path; () if the unit has its own
        assist: memory of the assist unit; () if there is none
        ports: held values of the ports
        angle: steering-wheel angle at the last step
    """

    driving: Tree
    assist: Memory
    ports: tuple[Scalar, ...]
    angle: Scalar


class Output(NamedTuple):
    """Channels of unit, driver and assist unit, and inputs of the unit."""

    unit: Tree
    driving: Tree
    control: Tree
    commands: Tree


@dataclass(frozen=True)
class ForeignCar:
    """Driver and assist unit of a vehicle that a unit computes.

    Every set of tunable parameters has its own class, with these parameters as further fields, made by `car_of`.

    Args:
        path: path of the unit
        wiring: connection of the unit, as text
        driver: driver who steers and requests drive and brake forces
        assist: unit that requests the motor torque; None if the vehicle has its own
        start: initial state of a run
        step_time: communication step
    """

    path: Path
    wiring: str
    driver: Driver = field(default_factory=HumanDriver)
    assist: AssistUnit | None = None
    start: Start = field(default_factory=Start)
    step_time: Annotated[float, "s", Range(1e-5, 2e-2)] = 1e-3

    def __reduce__(self) -> Any:
        """Pickle the fields only: classes made at run time are made again when the car is read."""
        own = (self.path, self.wiring, self.driver, self.assist, self.start, self.step_time)
        known = dict(tuning(self))
        return _restored, (own, tuple(known[each.path] for each in self.wires.tunable))

    @cached_property
    def wires(self) -> Wiring:
        """Connection of the unit."""
        return Wiring.from_text(self.wiring)

    @property
    def gives(self) -> tuple[str, ...]:
        """Signals of the unit's outputs, in order."""
        return tuple(each.signal for each in self.wires.outputs)

    @property
    def takes(self) -> tuple[str, ...]:
        """Signals of the unit's inputs, in order."""
        return tuple(each.signal for each in self.wires.inputs)

    @property
    def drives(self) -> bool:
        """Whether the driver model is needed, to drive or to track the position on the path."""
        return bool(set(DRIVER) & set(self.takes)) or "truth_distance" not in self.gives

    @property
    def actuators(self) -> tuple[str, ...]:
        """Inputs of the unit that driver and assist unit set, where faults can act."""
        return tuple(dict.fromkeys(name for name in self.takes if name in DRIVER or name == ASSIST))

    @property
    def ports(self) -> tuple[str, ...]:
        """Ports of the unit, then those of the loops of driver and assist unit."""
        unit = [port_of(name) for name in self.takes if port_of(name)]
        own = [*(ASSIST_READS if self.assist is not None else ()), *self.actuators]
        return tuple(dict.fromkeys([*unit, *own]))

    @property
    def Sample(self) -> type:
        """Class of the external inputs, including the outputs of the unit."""
        units = tuple((each.signal, each.unit) for each in self.wires.outputs)
        return _sample(self.ports, units)

    def init(self) -> State:
        """State on the path with relaxed muscles."""
        driving = self._driving.init() if self.drives else ()
        return State(driving, self.assist.remembered() if self.assist else (), (0.0,) * len(self.ports), 0.0)

    def step(self, state: State, sample: Tree) -> tuple[State, Output]:
        """One decision, based on the outputs of the unit at this instant."""
        road, wind, demand, ports, unit = sample
        held = dict(zip(self.ports, state.ports, strict=True))

        def read(name: str, value: Scalar) -> Scalar:
            held[name], passed = pass_through(getattr(ports, name), held[name], value)
            return passed

        sensed = self._sensed(state, unit, road, demand)
        given = _around(road, wind, demand, ports)
        driving, done = state.driving, None
        steered: Tree = ()
        if self.drives:
            driving, done = self._driving.step(state.driving, sensed)
            given |= _driven(done, (done.steering_wheel_angle - state.angle) / self.step_time)
        assist: Tree = state.assist
        control: Tree = ()
        if self.assist is not None:
            seen = [read(name, getattr(sensed, name, 0.0)) for name in ASSIST_READS[1:]]
            assist, torque = self.assist.decide(state.assist, read(ASSIST_READS[0], unit.driver_torque), *seen)
            given[ASSIST], control = torque, Assisted(torque)
        given |= {name: read(name, given[name]) for name in self.actuators}
        if done is not None:
            steered = self._shown(done, given)
        angle = given.get("steering_wheel_angle", sensed.steering_wheel_angle)
        commands = self._commands(given)
        kept = tuple(held[name] for name in self.ports)
        return State(driving, assist, kept, angle), Output(unit, steered, control, commands)

    def coupled(self, block: Plant, usual: Mapping[str, float], seconds: float, shape: tuple[int, int, int]) -> Coupled:
        """The running unit, to be closed after use; arguments as in `Coupled`."""
        return Coupled(self, self.path, block, usual, seconds, shape)

    @property
    def _driving(self) -> Driving:
        return Driving(self.driver, self.step_time)

    def _sensed(self, state: State, unit: Any, road: Road, demand: Demand) -> Sensed:
        """Inputs of a driver from the unit; without a steering-wheel rate, from the difference of the angle."""
        speed = next((getattr(unit, name) for name in SPEED if hasattr(unit, name)), 0.0)
        angle = getattr(unit, "steering_wheel_angle", state.angle)
        difference = (angle - state.angle) / self.step_time
        rate = getattr(unit, "steering_wheel_rate", difference)
        lateral = next((getattr(unit, name) for name in LATERAL if hasattr(unit, name)), None)
        if lateral is None:
            slip = next((getattr(unit, name) for name in SLIP if hasattr(unit, name)), 0.0)
            lateral = speed * tan(slip)
        return Sensed(speed, lateral, getattr(unit, "yaw_rate", 0.0), angle, rate, road, demand)

    def _shown(self, done: Any, given: Mapping[str, Scalar]) -> Tree:
        """Signals that are not outputs of the unit; the steering wheel's motion only if it is an input of the unit."""
        moved = given["steering_wheel_angle"], given["steering_wheel_rate"]
        place = done.distance, done.lateral_offset, done.heading_error
        whole = Steered(given["hand_torque"], given["drive_force"], *place, *moved)
        shown = {name for name in Steered._fields if name.startswith(TRUTH)} | set(self.takes)
        names = tuple(name for name in Steered._fields if name in shown and name not in self.gives)
        return _some_steered(names)(*(getattr(whole, name) for name in names))

    def _commands(self, given: Mapping[str, Scalar]) -> Tree:
        values = [given[name] for name in self.takes]
        for each in self.wires.tunable:
            part: Any = self
            for name in each.path.split("."):
                part = getattr(part, name)
            values.append(part)
        return _numbered(len(values))(*values)


LATERAL = ("truth_lateral_speed", "lateral_speed")
SLIP = ("truth_sideslip_angle", "sideslip_angle")


def _around(road: Road, wind: Wind, demand: Demand, ports: Any) -> dict[str, Scalar]:
    groups: dict[str, Any] = {"road": road, "wind": wind, "demand": demand}
    given = {f"{group}.{name}": getattr(part, name) for group, part in groups.items() for name in part._fields}
    return given | {
        f"ports.{port}.{name}": getattr(getattr(ports, port), name)
        for port in ports._fields
        for name in getattr(ports, port)._fields
    }


def _driven(done: Any, rate: Scalar) -> dict[str, Scalar]:
    return {
        "hand_torque": done.hand_torque,
        "steering_wheel_angle": done.steering_wheel_angle,
        "steering_wheel_rate": rate,
        "drive_force": done.drive_force,
        "traction_force": maximum(done.drive_force, 0.0),
        "braking_force": maximum(-done.drive_force, 0.0),
    }


@cache
def _sample(ports: tuple[str, ...], outputs: tuple[tuple[str, str], ...]) -> type:
    unit = named_tuple("UnitOutputs", [(name, Annotated[float, text]) for name, text in outputs])
    around: list[tuple[str, object]] = [("road", Road), ("wind", Wind), ("demand", Demand)]
    return named_tuple("Surroundings", [*around, ("ports", ports_type(ports)), (UNIT, unit)])


@cache
def _numbered(count: int) -> Any:
    return named_tuple("Commands", [(f"command_{k}", float) for k in range(count)])


@cache
def _some_steered(names: tuple[str, ...]) -> Any:
    return named_tuple("Steered", [(name, Steered.__annotations__[name]) for name in names])


@cache
def class_of(tunable: tuple[Tunable, ...]) -> Any:
    """A class `ForeignCar` with a field for every tunable parameter."""
    branches: dict[str, Any] = {}
    for each in tunable:
        below = branches
        *above, last = each.path.split(".")
        for name in above:
            below = below.setdefault(name, {})
        below[last] = each
    return _made("ForeignCar", branches, (ForeignCar,))


def _made(name: str, branches: Mapping[str, Any], bases: tuple[type, ...] = ()) -> Any:
    fields: list[tuple[str, Any, Any]] = []
    for key, each in branches.items():
        if isinstance(each, Tunable):
            limits = Range(each.low, each.high)
            fields.append((key, Annotated[float, each.unit, limits], field(default=each.value)))
        else:
            part = _made(key.capitalize(), each)
            fields.append((key, part, field(default_factory=part)))
    return dataclasses.make_dataclass(name, fields, bases=bases, frozen=True)


def _restored(own: tuple[Any, ...], values: tuple[float, ...]) -> ForeignCar:
    """The car from its pickled fields."""
    tunable = Wiring.from_text(own[1]).tunable
    car = class_of(tunable)(*own)
    given = {each.path: value for each, value in zip(tunable, values, strict=True) if value != each.value}
    restored: ForeignCar = replaced(car, given) if given else car
    return restored
