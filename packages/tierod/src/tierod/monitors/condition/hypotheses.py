"""Fault hypotheses of the condition monitor: combinations of faulty sensors and actuators."""

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
"""Name of the fault-free hypothesis."""


@dataclass(frozen=True)
class Hypothesis:
    """Fault hypothesis: these elements are faulty, all others are fault-free.

    Args:
        name: "healthy", or the names of the faulty elements joined by " + "
        sensors: faulty sensors, names from `SENSORS`
        actuators: faulty actuators, names from `ACTUATORS`
    """

    name: str
    sensors: tuple[str, ...] = ()
    actuators: tuple[str, ...] = ()

    @property
    def suspects(self) -> tuple[str, ...]:
        """All faulty elements, sensors first."""
        return self.sensors + self.actuators

    def agrees(self, other: Hypothesis) -> bool:
        """Whether both suspect the same actuators, or one of them suspects none.

        The lost torque is one state of a lane: the joint loss of two actuators is another quantity than that of one.

        Args:
            other: hypothesis
        """
        return not self.actuators or not other.actuators or self.actuators == other.actuators


def hypotheses() -> tuple[Hypothesis, ...]:
    """All 52 hypotheses for a whole vehicle, in a fixed order.

    Fault-free; one sensor (6); one actuator (4); two sensors (15); a sensor and an actuator (24); two actuators that
    share a supply and lose the same share (2).
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
    """All hypotheses for a car: fault-free, and one or two faulty sensors.

    Both wheels of an axle are excluded, since their fault looks like slip of the axle.
    """
    pairs = [each for each in combinations(OF_CARS, 2) if each not in (WHEELS, FRONT_WHEELS)]
    return tuple(Hypothesis(" + ".join(each) or HEALTHY, each) for each in [(), *((name,) for name in OF_CARS), *pairs])


SLIDING = Hypothesis("sliding tyres")
"""Hypothesis that the tyres slide without any fault; it is no diagnosis, but prevents one."""
