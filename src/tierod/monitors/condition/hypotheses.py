"""The hypotheses that the condition monitor weighs: which sensors and actuators are at fault."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product

from tierod.monitors.condition.signals import (
    ACTUATORS,
    DRIVES,
    FRONT_WHEELS,
    MOTORS,
    OF_AUTOMATED,
    OF_CARS,
    WHEELS,
)

HEALTHY = "healthy"
"""Name of the hypothesis that nothing is at fault."""


@dataclass(frozen=True)
class Hypothesis:
    """One hypothesis: its faulty elements, all else being fault-free.

    Args:
        name: "healthy", or the names of what is at fault joined by " + "
        sensors: at fault, names from `SENSORS`
        actuators: at fault, names from `ACTUATORS`
    """

    name: str
    sensors: tuple[str, ...] = ()
    actuators: tuple[str, ...] = ()

    @property
    def suspects(self) -> tuple[str, ...]:
        """Everything at fault, sensors first."""
        return self.sensors + self.actuators

    def agrees(self, other: Hypothesis) -> bool:
        """Whether both name the same actuators, as far as both name any: the joint loss of two is another loss.

        Args:
            other: hypothesis
        """
        return not self.actuators or not other.actuators or self.actuators == other.actuators


def hypotheses() -> tuple[Hypothesis, ...]:
    """All hypotheses that are weighed, 52 in a fixed order.

    Healthy; one sensor (6); one actuator (4); two sensors (15); a sensor and an actuator (24); two actuators that share
    a supply and lose the same share (2).
    """
    singles = [((name,), ()) for name in OF_AUTOMATED]
    motors = [((), (name,)) for name in ACTUATORS]
    pairs = [(pair, ()) for pair in combinations(OF_AUTOMATED, 2)]
    mixed = [((sensor,), (actuator,)) for sensor, actuator in product(OF_AUTOMATED, ACTUATORS)]
    shared = [((), MOTORS), ((), DRIVES)]
    return tuple(
        Hypothesis(" + ".join((*sensors, *actuators)) or HEALTHY, sensors, actuators)
        for sensors, actuators in [((), ()), *singles, *motors, *pairs, *mixed, *shared]
    )


def hypotheses_of_cars() -> tuple[Hypothesis, ...]:
    """Healthy, and one or two of the sensors of a car; not both wheels of an axle, whose slip looks the same."""
    pairs = [each for each in combinations(OF_CARS, 2) if each not in (WHEELS, FRONT_WHEELS)]
    return tuple(Hypothesis(" + ".join(each) or HEALTHY, each) for each in [(), *((name,) for name in OF_CARS), *pairs])


SLIDING = Hypothesis("sliding tyres")
"""That tyres slide, and nothing is at fault; no diagnosis, but a reason for none."""
