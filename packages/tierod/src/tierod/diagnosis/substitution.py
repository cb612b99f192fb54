"""Substitutes of sensors, as a graph from every sensor to the sensors that its substitutes need."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tierod.core.errors import ParameterError, nearest


@dataclass(frozen=True)
class Substitute:
    """One substitute of a signal.

    Args:
        name: of the method, a few words with hyphens
        needs: monitored sensors that it requires
        deviation: measured root-mean-square error relative to the true signal [unit of the signal]
        source: origin of the measured error
    """

    name: str
    needs: tuple[str, ...]
    deviation: float
    source: str

    def __post_init__(self) -> None:
        if not (math.isfinite(self.deviation) and self.deviation > 0.0):
            raise ParameterError(
                f"substitute '{self.name}' has the deviation {self.deviation}; expected a measured error above zero"
            )


@dataclass(frozen=True)
class SubstitutionGraph:
    """Substitutes of every sensor, the most accurate first.

    Args:
        sensors: monitored sensors, with or without substitutes
        ways: substitutes of each sensor, in the same order

    Raises:
        ParameterError: a substitute needs an unknown sensor or the sensor that it replaces, or two have the same name
    """

    sensors: tuple[str, ...]
    ways: tuple[tuple[Substitute, ...], ...]

    def __post_init__(self) -> None:
        for sensor, ways in self.substitutes.items():
            names = [way.name for way in ways]
            for way in ways:
                if names.count(way.name) > 1:
                    raise ParameterError(f"'{sensor}' has two substitutes '{way.name}'; give each a name of its own")
                if sensor in way.needs:
                    raise ParameterError(f"substitute '{way.name}' of '{sensor}' needs '{sensor}' itself")
                for need in way.needs:
                    if need not in self.substitutes:
                        raise ParameterError(
                            f"substitute '{way.name}' of '{sensor}' needs '{need}'{nearest(need, self.substitutes)}"
                        )

    @property
    def substitutes(self) -> dict[str, tuple[Substitute, ...]]:
        return dict(zip(self.sensors, self.ways, strict=True))


def graph_from(table: Mapping[str, Any]) -> SubstitutionGraph:
    """Graph from a table: sensor -> list of {name, needs, deviation, source}, sorted by deviation."""
    keys = ("name", "needs", "deviation", "source")
    made: dict[str, tuple[Substitute, ...]] = {}
    for sensor, ways in table.items():
        for way in ways:
            for key in way:
                if key not in keys:
                    raise ParameterError(f"a substitute of '{sensor}' has no '{key}'{nearest(key, keys)}")
            missing = [key for key in keys if key not in way]
            if missing:
                raise ParameterError(f"a substitute of '{sensor}' lacks '{missing[0]}'; expected {', '.join(keys)}")
        read = [Substitute(way["name"], tuple(way["needs"]), float(way["deviation"]), way["source"]) for way in ways]
        made[sensor] = tuple(sorted(read, key=lambda way: way.deviation))
    return SubstitutionGraph(tuple(made), tuple(made.values()))
