"""Scatter from drive to drive: random differences between cars and between sensors."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE, Number, check_ranges, numbers, replaced
from tierod.core.signals import SIGNALS
from tierod.core.toml import build, flat
from tierod.core.toml_document import Document, Location
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.sensors import Sensor, SensorSet

SENSORS = "sensors."  # Prefix of the paths of sensor parameters, such as "sensors.yaw_rate.bias"

DAMPING = ("damping", "pinion_damping", "rack_damping", "motor.damping")
INERTIA = (
    *("inertia", "wheel_inertia", "column_inertia", "pinion_inertia", "rack_mass", "motor.inertia"),
    *("steering_motor_1.inertia", "steering_motor_2.inertia"),
)
WITHIN = ("", "column.", "rack.")  # Prefixes of the parts of a steering that are steerings themselves
TRAIL = ("mechanical_trail", "contact_half_length", "kingpins.mechanical_trail", "front.tyre.trail")
FRONT_TYRES = ("front_stiffness", "front.tyre.cornering_stiffness")
REAR_TYRES = ("rear_stiffness", "rear.tyre.cornering_stiffness")
MASS = ("mass", "yaw_inertia")


@dataclass(frozen=True)
class UsualScatter:
    """Standard deviations of what differs from drive to drive; gains and parameters are log-normal.

    The defaults are those of the scatter study behind the friction monitor. `mass`, `tyre_stiffness` and `torque_delay`
    belong to its second, harder form and are off by default. Parameters that a car lacks are ignored.
    """

    torque_gain: Annotated[float, "", NOT_NEGATIVE] = 0.10
    damping: Annotated[float, "", NOT_NEGATIVE] = 0.4
    inertia: Annotated[float, "", NOT_NEGATIVE] = 0.3
    trail: Annotated[float, "", NOT_NEGATIVE] = 0.3
    driver_torque_offset: Annotated[float, "N*m", NOT_NEGATIVE] = 0.3
    lateral_acceleration_bias: Annotated[float, "m/s**2", NOT_NEGATIVE] = 0.3
    steering_wheel_rate_noise: Annotated[float, "rad/s", NOT_NEGATIVE] = 0.02
    tyre_stiffness: Annotated[float, "", NOT_NEGATIVE] = 0.0
    mass: Annotated[float, "", NOT_NEGATIVE] = 0.0
    torque_delay: Annotated[float, "s", NOT_NEGATIVE] = 0.0

    def __post_init__(self) -> None:
        check_ranges(self)

    def usual(self, known: Mapping[str, Number], generator: np.random.Generator) -> Iterator[tuple[str, float]]:
        """(path, value) of all parameters that the fields name.

        The number of draws is always the same, so that no parameter affects the draw of another.
        """

        def factor(deviation: float) -> float:
            return float(np.exp(deviation * generator.standard_normal()))

        for part, names, deviation in (
            ("steering", DAMPING, self.damping),
            ("steering", INERTIA, self.inertia),
            ("chassis", TRAIL, self.trail),
            ("chassis", MASS, self.mass),
            ("chassis", FRONT_TYRES, self.tyre_stiffness),
            ("chassis", REAR_TYRES, self.tyre_stiffness),
        ):
            drawn = factor(deviation)
            for path in (f"{part}.{within}{name}" for name in names for within in WITHIN):
                if path in known:
                    yield path, known[path].value * drawn
        sensors = {
            "driver_torque.gain": factor(self.torque_gain),
            "driver_torque.bias": self.driver_torque_offset * float(generator.standard_normal()),
            "driver_torque.delay": self.torque_delay,
            "motor_torque.gain": factor(self.torque_gain),
            "motor_torque.delay": self.torque_delay,
            "lateral_acceleration.bias": self.lateral_acceleration_bias * float(generator.standard_normal()),
            "steering_wheel_rate.noise": self.steering_wheel_rate_noise,
        }
        for name, value in sensors.items():
            path = f"{SENSORS}{name}"
            if path in known:
                yield path, value * known[path].value if name.endswith(".gain") else value


Drawn = TypeVar("Drawn", bound=Plant)

_TRIES = 1000  # Maximum number of draws for a value within its range


@dataclass(frozen=True)
class Spread:
    """Spread of one parameter, or of several together, from drive to drive."""

    deviation: Annotated[float | str, "{signal}", NOT_NEGATIVE]
    kind: Literal["log-normal", "normal"] = "log-normal"
    also: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True)
class Scatter(UsualScatter):
    """Scatter from drive to drive: the usual one, and that of any parameter of the car or its sensors."""

    # spread by dotted path of any float field of the car ("chassis.mass") or of its sensors ("sensors.yaw_rate.bias");
    # drawn after the usual scatter, each from its own random stream
    parameters: Mapping[str, Spread] = field(default_factory=dict)
    origin: tuple[Document, tuple[str | int, ...]] | None = field(default=None, compare=False, repr=False)

    @classmethod
    def from_table(
        cls, table: Mapping[str, Any], document: Document, location: Location = (), base: Scatter | None = None
    ) -> Scatter:
        """Scatter from a table of fields; in `parameters` a number is a log-normal deviation, a table a spread."""
        plain, place, base = dict(table), tuple(location), base or cls()
        given = plain.pop("parameters", {})
        usual = {each.name: getattr(base, each.name) for each in fields(UsualScatter)}
        own = build(UsualScatter, plain, document, place, base=UsualScatter(**usual))
        if not isinstance(given, dict):
            raise document.error((*place, "parameters"), "'parameters' has to be a table of deviations by path")
        spreads = dict(base.parameters)
        for path, value in flat(given, {"deviation", "kind", "also"}):
            spread = value if isinstance(value, dict) else {"deviation": value}
            spreads[path] = build(Spread, spread, document, (*place, "parameters", path))
        return cls(**vars(own), parameters=spreads, origin=(document, place))

    def draw(self, car: Drawn, sensors: SensorSet, generator: np.random.Generator) -> tuple[Drawn, SensorSet]:
        known = _known(car, sensors)
        spreads = self._fitted(known)
        changes = dict(self.usual(known, generator))
        # One integer is drawn for all paths, so that adding a path changes the draws of no other one.
        source = int(generator.integers(1 << 62)) if spreads else 0
        for path, spread in spreads.items():
            chance = np.random.default_rng([source, zlib.crc32(path.encode())])
            # The spread applies to the value that the usual scatter has drawn.
            for each in (path, *spread.also):
                known[each] = known[each]._replace(value=changes.get(each, known[each].value))
            changes |= self._drawn((path, *spread.also), spread, known, chance)
        of_sensors = {path: value for path, value in changes.items() if path.startswith(SENSORS)}
        of_car = {path: value for path, value in changes.items() if path not in of_sensors}
        return replaced(car, of_car), replaced(sensors, of_sensors)

    def _fitted(self, known: Mapping[str, Number]) -> dict[str, Spread]:
        spreads = {}
        for path, spread in self.parameters.items():
            for each in (path, *spread.also):
                if each not in known:
                    raise self._error(path, f"neither car nor sensors have a parameter '{each}'{nearest(each, known)}")
                if spread.kind == "log-normal" and known[each].value == 0.0:
                    raise self._error(path, f"'{each}' is 0, which no factor changes; give kind = 'normal'")
            unit = "" if spread.kind == "log-normal" else known[path].unit
            if isinstance(spread.deviation, str):
                document, place = self.origin or (Document({}, "", Path("scatter")), ())
                given = {"deviation": spread.deviation}
                spread = build(Spread, given, document, (*place, "parameters", path), base=spread, signal=unit)
            spreads[path] = spread
        return spreads

    def _error(self, path: str, message: str) -> ParameterError:
        if self.origin is None:
            return ParameterError(message)
        document, place = self.origin
        return document.error((*place, "parameters", path), message)

    def _drawn(
        self, paths: tuple[str, ...], spread: Spread, known: Mapping[str, Number], chance: np.random.Generator
    ) -> dict[str, float]:
        for _ in range(_TRIES):
            draw = float(spread.deviation) * float(chance.standard_normal())
            gain, offset = (1.0, draw) if spread.kind == "normal" else (math.exp(draw), 0.0)
            values = {path: known[path].value * gain + offset for path in paths}
            if all(limits is None or limits.holds(values[path]) for path in paths for limits in [known[path].limits]):
                return values
        message = f"of {_TRIES} draws none gave '{paths[0]}' a value in its range; lower the deviation"
        raise self._error(paths[0], message)


def _known(car: Plant, sensors: SensorSet) -> dict[str, Number]:
    known = dict(numbers(car))
    for name, sensor in sensors.items():
        own = _of_sensor(sensor, SIGNALS[name].unit)
        known |= {f"{SENSORS}{name}.{field}": number for field, number in own.items()}
    return known


@lru_cache(maxsize=1024)
def _of_sensor(sensor: Sensor, unit: str) -> dict[str, Number]:
    known = numbers(sensor)
    return {field: number._replace(unit=number.unit.format(signal=unit or "1")) for field, number in known.items()}
