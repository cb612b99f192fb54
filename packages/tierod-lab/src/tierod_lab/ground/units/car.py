"""A vehicle that a functional mock-up unit computes, steered and driven by our driver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, Tree, leaves, named_tuple, skeleton, units
from tierod.core.fields import Range
from tierod.core.graph.maths import maximum
from tierod_lab.ground.control.blocks import Driving, Sensed
from tierod_lab.ground.control.driver import HumanDriver
from tierod_lab.ground.courses import Start
from tierod_lab.ground.parts import Demand, Driver, Plant, Road, Wind
from tierod_lab.ground.units.instance import Instance

FROM_DRIVER: Mapping[str, str] = {
    "hand_torque": "N*m",
    "steering_wheel_angle": "rad",
    "steering_wheel_rate": "rad/s",
    "drive_force": "N",
    "traction_force": "N",
    "braking_force": "N",
}
"""Signals that our driver gives, with their units; the last two are the drive force's parts, both not negative."""

_AROUND: Mapping[str, Any] = {"road": Road, "wind": Wind, "demand": Demand}
_PLACE = {"truth_distance": "m", "truth_lateral_offset": "m", "truth_heading_error": "rad"}


@cache
def offered() -> dict[str, str]:
    """Unit of every signal that an input of a unit can be given, by name."""
    found = dict(FROM_DRIVER)
    for group, kind in _AROUND.items():
        found |= {f"{group}.{name}": unit for (name, _), unit in zip(leaves(skeleton(kind)), units(kind), strict=True)}
    return found


class Output(NamedTuple):
    unit: Tree
    driving: Tree
    commands: Tree


@dataclass(frozen=True)
class UnitCar:
    """Driver of a vehicle that a unit computes; a unit that takes nothing and gives its distance has its own."""

    path: Path
    wiring: str
    takes: tuple[str, ...]
    gives: tuple[tuple[str, str], ...]
    driver: Driver = field(default_factory=HumanDriver)
    start: Start = field(default_factory=Start)
    step_time: Annotated[float, "s", Range(1e-5, 2e-2)] = 1e-3

    @property
    def drives(self) -> bool:
        """Whether our driver is needed, to drive or to track the position on the path."""
        return bool(set(FROM_DRIVER) & set(self.takes)) or "truth_distance" not in dict(self.gives)

    @property
    def Sample(self) -> type:
        """Class of the external inputs, including the outputs of the unit."""
        return _sample(self.gives)

    def lacking(self) -> list[str]:
        """Signals of which the driver needs one more each."""
        given = {name for name, _ in self.gives} | ({"steering_wheel_angle"} & set(self.takes))
        needed = ("truth_speed", "vehicle_speed"), ("yaw_rate",), ("steering_wheel_angle",)
        return [" or ".join(names) for names in needed if self.drives and not given & set(names)]

    def init(self) -> Tree:
        return Driving(self.driver, self.step_time).init() if self.drives else (), 0.0

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Output]:
        (driving, before), (*around, unit) = state, sample
        given = {
            f"{group}.{name}": getattr(part, name)
            for group, part in zip(_AROUND, around, strict=True)
            for name in part._fields
        }
        shown: dict[tuple[str, str], Scalar] = {}
        angle = getattr(unit, "steering_wheel_angle", before)
        if self.drives:
            sensed = self._sensed(unit, angle, (angle - before) / self.step_time, around[0], around[2])
            driving, done = Driving(self.driver, self.step_time).step(driving, sensed)
            turned, force = done.steering_wheel_angle, done.drive_force
            parts = force, maximum(force, 0.0), maximum(-force, 0.0)
            own = (done.hand_torque, turned, (turned - before) / self.step_time, *parts)
            given |= dict(zip(FROM_DRIVER, own, strict=True))
            angle = turned if "steering_wheel_angle" in self.takes else angle
            shown = dict(zip(_PLACE.items(), (done.distance, done.lateral_offset, done.heading_error), strict=True))
            shown |= {(f"truth_{name}", FROM_DRIVER[name]): given[name] for name in ("hand_torque", "drive_force")}
            shown |= {(name, FROM_DRIVER[name]): given[name] for name in self.takes if name.startswith("steering")}
        shown = {channel: value for channel, value in shown.items() if channel[0] not in dict(self.gives)}
        commands = _tuple(tuple((f"command_{k}", "") for k in range(len(self.takes))))
        channels = _tuple(tuple(shown))(*shown.values()) if shown else ()
        return (driving, angle), Output(unit, channels, commands(*(given[name] for name in self.takes)))

    def _sensed(self, unit: Any, angle: Scalar, rate: Scalar, road: Road, demand: Demand) -> Sensed:
        def first(*names: str, otherwise: Scalar = 0.0) -> Scalar:
            return next((getattr(unit, name) for name in names if hasattr(unit, name)), otherwise)

        speed, lateral = first("truth_speed", "vehicle_speed"), first("truth_lateral_speed", "lateral_speed")
        return Sensed(
            speed, lateral, first("yaw_rate"), angle, first("steering_wheel_rate", otherwise=rate), road, demand
        )

    def coupled(self, block: Plant, usual: Mapping[str, float], seconds: float) -> Instance:
        """The running unit, to be closed after use; arguments as in `Instance`."""
        return Instance(self, block, usual, seconds)


@cache
def _sample(gives: tuple[tuple[str, str], ...]) -> type:
    return named_tuple("Surroundings", [*_AROUND.items(), ("unit", _tuple(gives))])


@cache
def _tuple(channels: tuple[tuple[str, str], ...]) -> Any:
    return named_tuple("Channels", [(name, Annotated[Scalar, unit]) for name, unit in channels])
