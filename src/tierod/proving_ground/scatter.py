"""Scatter from drive to drive: no two cars, and no two sensors, are alike."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import NOT_NEGATIVE, Number, check_ranges, numbers, replaced
from tierod.core.signals import SIGNALS
from tierod.core.toml import Document, Location, build
from tierod.proving_ground.sensors import Sensor, SensorSet
from tierod.proving_ground.usual_scatter import SENSORS, UsualScatter

_TRIES = 1000


@dataclass(frozen=True)
class Spread:
    """How one parameter, or several together, differ from drive to drive.

    Args:
        deviation: standard deviation: of the logarithm where log-normal, else in the unit of the parameter
        kind: "log-normal" multiplies the nominal value, "normal" adds to it
        also: paths that get the same draw
    """

    deviation: Annotated[float | str, "{signal}", NOT_NEGATIVE]
    kind: Literal["log-normal", "normal"] = "log-normal"
    also: tuple[str, ...] = ()

    def __post_init__(self):
        check_ranges(self)


@dataclass(frozen=True)
class Scatter(UsualScatter):
    """What differs from drive to drive: the usual, and any parameter of the car or its sensors.

    Args:
        parameters: by dotted path of any float field of the car ("chassis.mass"), or of its sensors
            ("sensors.yaw_rate.bias"); drawn after the usual, each from a source of its own
        origin: where it stands, for messages
    """

    parameters: Mapping[str, Spread] = field(default_factory=dict)
    origin: tuple[Document, tuple[str | int, ...]] | None = field(default=None, compare=False, repr=False)

    @classmethod
    def from_table(
        cls, table: Mapping[str, Any], document: Document, location: Location = (), base: Scatter | None = None
    ) -> Scatter:
        """The scatter that a table describes.

        Args:
            table: fields of this class; in `parameters` a number is a log-normal deviation, a table is a `Spread`
            document, location: where the table stands
            base: in place of the defaults

        Raises:
            ParameterError: a slip, with file and line
        """
        place = tuple(location)
        plain = {name: value for name, value in table.items() if name != "parameters"}
        base = base or cls()
        usual = {each.name: getattr(base, each.name) for each in fields(UsualScatter)}
        own = build(UsualScatter, plain, document, place, base=UsualScatter(**usual))
        given = table.get("parameters", {})
        if not isinstance(given, dict):
            raise document.error((*place, "parameters"), "'parameters' has to be a table of deviations by path")
        spreads = dict(base.parameters)
        for path, value in _flat(given):
            spread = value if isinstance(value, dict) else {"deviation": value}
            spreads[path] = build(Spread, spread, document, (*place, "parameters", path))
        return cls(**vars(own), parameters=spreads, origin=(document, place))

    def draw(self, car: Any, sensors: SensorSet, generator: np.random.Generator) -> tuple[Any, SensorSet]:
        """A car and its sensors, drawn around the given ones.

        Args:
            car: the nominal car
            sensors: the nominal sensors
            generator: source of chance

        Raises:
            ParameterError: a path that neither car nor sensors have, or a unit that does not fit
        """
        known = _known(car, sensors)
        spreads = self._fitted(known)
        changes = dict(self.usual(known, generator))
        source = int(generator.integers(1 << 62)) if spreads else 0
        for path, spread in spreads.items():
            chance = np.random.default_rng([source, zlib.crc32(path.encode())])
            for each in (path, *spread.also):
                known[each] = known[each]._replace(value=changes.get(each, known[each].value))
            changes |= self._drawn((path, *spread.also), spread, known, chance)
        of_sensors = {path: value for path, value in changes.items() if path.startswith(SENSORS)}
        of_car = {path: value for path, value in changes.items() if path not in of_sensors}
        return replaced(car, of_car), replaced(sensors, of_sensors)

    def fitted(self, car: Any, sensors: SensorSet) -> dict[str, Spread]:
        """The spreads of `parameters`, in the units of what they are about.

        Raises:
            ParameterError: a path that neither car nor sensors have, or a unit that does not fit
        """
        return self._fitted(_known(car, sensors))

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
        """Values of paths with one draw, repeated until all lie in their ranges."""
        for _ in range(_TRIES):
            draw = float(spread.deviation) * float(chance.standard_normal())
            if spread.kind == "normal":
                values = {path: known[path].value + draw for path in paths}
            else:
                values = {path: known[path].value * math.exp(draw) for path in paths}
            if all(limits is None or limits.holds(values[path]) for path in paths for limits in [known[path].limits]):
                return values
        message = f"of {_TRIES} draws none gave '{paths[0]}' a value in its range; lower the deviation"
        raise self._error(paths[0], message)


def _known(car: Any, sensors: SensorSet) -> dict[str, Number]:
    """Every float field of a car and its sensors, by path."""
    of_sensors = (
        (f"{SENSORS}{name}.{field}", number)
        for name, sensor in sensors.items()
        for field, number in _of_sensor(sensor, SIGNALS[name].unit).items()
    )
    return {**numbers(car), **dict(of_sensors)}


@lru_cache(maxsize=1024)
def _of_sensor(sensor: Sensor, unit: str) -> dict[str, Number]:
    """Every float field of a sensor; what is in the unit of the signal gets that unit."""
    known = numbers(sensor)
    return {field: number._replace(unit=number.unit.format(signal=unit or "1")) for field, number in known.items()}


def _flat(table: Mapping[str, Any], above: str = "") -> list[tuple[str, Any]]:
    """(dotted path, deviation or table of a `Spread`)."""
    pairs: list[tuple[str, Any]] = []
    for name, value in table.items():
        if isinstance(value, dict) and not {"deviation", "kind", "also"} & set(value):
            pairs.extend(_flat(value, f"{above}{name}."))
        else:
            pairs.append((f"{above}{name}", value))
    return pairs
