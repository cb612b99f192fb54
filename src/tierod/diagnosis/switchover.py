"""Bumpless switchover from a sensor to its substitute and back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, named_tuple
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, either, negated, present, sqrt, where
from tierod.diagnosis.substitution import SubstitutionGraph

SENSOR = 0.0
"""Source of a value: the sensor itself; 1, 2, ... are its substitutes."""
HELD = -1.0
"""Source of a value: nothing is left, and the last one is held."""
NOTHING = -2.0
"""Source of a value: there was no value yet."""


class Supplied(NamedTuple):
    """A signal as others may use it.

    Args:
        value: of the sensor or its substitute [unit of the signal]
        deviation: standard deviation of the substitute, with what is left of a bump; grows while held; zero while the
            sensor is used
        source: 0 the sensor, 1, 2, ... the substitute, -1 the last value held, -2 no value yet
    """

    value: Scalar
    deviation: Scalar
    source: Scalar


class SupplyState(NamedTuple):
    """Switchover of one signal: last value, its source, and the remaining bump."""

    value: Scalar
    deviation: Scalar
    source: Scalar
    bump: Scalar


@dataclass(frozen=True)
class Switchover:
    """Supply every signal from its sensor, or from the best substitute whose own sensors are fault-free.

    A substitute that takes over from a fault-free value (another substitute, or the sensor when it comes back into use)
    begins where that one ended, and goes over to its own value with `fade`. After a sensor that has just been found
    faulty it begins at its own value at once.

    Args:
        graph: sensors and their substitutes
        growth: of the deviation of a value that is held, per signal [unit of the signal per s]
        fade: time constant of a switch
        sample_time: between two samples

    Raises:
        ParameterError: another number of growths than sensors, or a time not above zero

    The sample holds, per sensor, `measured`, `faulty` (1 or 0) and the values of its substitutes, NaN where one has
    none.
    """

    graph: SubstitutionGraph
    growth: tuple[float, ...]
    fade: Annotated[float, "s"]
    sample_time: Annotated[float, "s"]

    def __post_init__(self) -> None:
        if len(self.growth) != len(self.graph.sensors):
            raise ParameterError(
                f"{len(self.graph.sensors)} sensors came with {len(self.growth)} growths; give one for each"
            )
        if not (self.fade > 0.0 and self.sample_time > 0.0):
            raise ParameterError(
                f"fade is {self.fade} s and sample_time {self.sample_time} s; expected times above zero"
            )

    @cached_property
    def Sample(self) -> type:
        """Per sensor: measured, faulty, and its substitutes by name."""
        kinds = []
        for sensor, ways in self.graph.substitutes.items():
            fields = ["measured", "faulty", *(way.name.replace("-", "_") for way in ways)]
            kinds.append((sensor, named_tuple(f"Offered_{sensor}", [(name, float) for name in fields])))
        return named_tuple("Offered", kinds)

    @cached_property
    def Output(self) -> type:
        """Per sensor: what is supplied."""
        return named_tuple("AllSupplied", [(sensor, Supplied) for sensor in self.graph.sensors])

    def init(self) -> tuple[SupplyState, ...]:
        """No value yet."""
        return tuple(SupplyState(0.0, 0.0, NOTHING, 0.0) for _ in self.graph.sensors)

    def step(self, state: tuple[SupplyState, ...], sample: Tree) -> tuple[tuple[SupplyState, ...], Tree]:
        """One sample on."""
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
        """Bump added to the new source's own value, on its way to zero."""
        after_a_fault = both(before.source == SENSOR, negated(own))
        from_nothing = either(before.source == NOTHING, after_a_fault)
        begun = where(from_nothing, 0.0, before.value - value)
        kept = before.bump * (self.fade / (self.fade + self.sample_time))
        return where(source < SENSOR, 0.0, where(source == before.source, kept, begun))
