"""Bumpless switchover from a sensor to its substitute and back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, Tree, named_tuple
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.maths import both, either, negated, present, sqrt, where


@dataclass(frozen=True)
class Substitute:
    """One substitute of a signal."""

    name: str  # of the method, a few words with hyphens
    needs: tuple[str, ...]  # monitored sensors that it requires
    deviation: float  # measured root-mean-square error relative to the true signal [unit of the signal]
    source: str  # origin of the measured error

    def __post_init__(self) -> None:
        if not (math.isfinite(self.deviation) and self.deviation > 0.0):
            raise ParameterError(
                f"substitute '{self.name}' has the deviation {self.deviation}; expected a measured error above zero"
            )


@dataclass(frozen=True)
class SubstitutionGraph:
    """Substitutes of every sensor, the most accurate first."""

    sensors: tuple[str, ...]
    ways: tuple[tuple[Substitute, ...], ...]  # substitutes of each sensor, in the same order

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


SENSOR = 0.0  # Source of a value: the sensor itself; 1, 2, ... are its substitutes.
HELD = -1.0  # Source of a value: neither sensor nor substitute is available, and the last value is held
NOTHING = -2.0  # Source of a value: there has been no value yet


class Supplied(NamedTuple):
    """A signal as supplied to its users."""

    value: Scalar  # value of the sensor or its substitute [unit of the signal]
    # standard deviation of the substitute including the remaining bump; grows while the value is held; zero while the
    # sensor is used
    deviation: Scalar
    source: Scalar  # 0 the sensor, 1, 2, ... the substitute, -1 last value held, -2 no value yet


class SupplyState(NamedTuple):
    """Switchover state of one signal: last value, deviation, source, and the remaining bump."""

    value: Scalar
    deviation: Scalar
    source: Scalar
    bump: Scalar


@dataclass(frozen=True)
class Switchover:
    """Supplies every signal from its sensor, or from the best substitute whose own sensors are fault-free.

    A source that takes over from a fault-free value (another substitute, or the sensor when it returns to use) begins
    at the last value and approaches its own with the time constant `fade`. A substitute for a sensor that has just been
    found faulty begins at its own value at once.

    The sample contains, per sensor, `measured`, `faulty` (1 or 0) and the values of its substitutes, NaN where a
    substitute has no value.
    """

    graph: SubstitutionGraph
    growth: tuple[float, ...]  # growth rate of the deviation of a held value, per signal [unit of the signal per s]
    fade: Annotated[float, "s"]
    sample_time: Annotated[float, "s"]

    def __post_init__(self) -> None:
        if len(self.growth) != len(self.graph.sensors):
            raise ParameterError(
                f"{len(self.graph.sensors)} sensors were given with {len(self.growth)} growths; give one for each"
            )
        if not (self.fade > 0.0 and self.sample_time > 0.0):
            raise ParameterError(
                f"fade is {self.fade} s and sample_time {self.sample_time} s; expected times above zero"
            )

    @cached_property
    def Sample(self) -> type:
        kinds = []
        for sensor, ways in self.graph.substitutes.items():
            fields = ["measured", "faulty", *(way.name.replace("-", "_") for way in ways)]
            kinds.append((sensor, named_tuple(f"Offered_{sensor}", [(name, float) for name in fields])))
        return named_tuple("Offered", kinds)

    @cached_property
    def Output(self) -> type:
        return named_tuple("AllSupplied", [(sensor, Supplied) for sensor in self.graph.sensors])

    def init(self) -> tuple[SupplyState, ...]:
        return tuple(SupplyState(0.0, 0.0, NOTHING, 0.0) for _ in self.graph.sensors)

    def step(self, state: tuple[SupplyState, ...], sample: Tree) -> tuple[tuple[SupplyState, ...], Tree]:
        faulty = dict(zip(self.graph.sensors, (offered.faulty for offered in sample), strict=True))
        supplies = [
            self._supply(index, before, offered, faulty)
            for index, (before, offered) in enumerate(zip(state, sample, strict=True))
        ]
        return tuple(after for after, _ in supplies), self.Output(*(supplied for _, supplied in supplies))

    def _supply(
        self, index: int, before: SupplyState, offered: Tree, faulty: dict[str, Scalar]
    ) -> tuple[SupplyState, Supplied]:
        own = both(faulty[self.graph.sensors[index]] < 0.5, present(offered.measured))
        held = both(before.source > NOTHING, negated(own))
        value, source = before.value, where(held, HELD, NOTHING)
        deviation = where(held, before.deviation + self.growth[index] * self.sample_time, 0.0)
        ways = self.graph.ways[index]
        # From the least to the most accurate substitute, so that the best usable one has the last word.
        for rank in reversed(range(len(ways))):
            usable = present(offered[rank + 2])
            for need in ways[rank].needs:
                usable = both(usable, faulty[need] < 0.5)
            value = where(usable, offered[rank + 2], value)
            source = where(usable, rank + 1.0, source)
            deviation = where(usable, ways[rank].deviation, deviation)
        value, source = where(own, offered.measured, value), where(own, SENSOR, source)
        bump = self._bump(before, own, value, source)
        spread = where(source > SENSOR, sqrt(deviation * deviation + bump * bump), where(own, 0.0, deviation))
        supplied = Supplied(value + bump, spread, source)
        return SupplyState(supplied.value, spread, source, bump), supplied

    def _bump(self, before: SupplyState, own: Scalar, value: Scalar, source: Scalar) -> Scalar:
        """Difference between the supplied and the source's own value, which decays to zero."""
        after_a_fault = both(before.source == SENSOR, negated(own))
        from_nothing = either(before.source == NOTHING, after_a_fault)
        begun = where(from_nothing, 0.0, before.value - value)
        # Implicit Euler step of an exponential decay, stable for any sampling interval.
        kept = before.bump * (self.fade / (self.fade + self.sample_time))
        return where(source < SENSOR, 0.0, where(source == before.source, kept, begun))
