"""What every behaviour of a fault has in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import check_ranges
from tierod.proving_ground.faults.chance import Chance
from tierod.proving_ground.sensors import Sensor

Amount = float | str
"""A number in SI units, or a text with a unit ("0.3 deg/s") that becomes one once the element is known."""

SIGNAL, LOOP, ACTUATOR, PARAMETER, SURROUNDING = "signal", "loop", "actuator", "parameter", "surrounding"
"""What an element can be: a recorded signal, one that the car's own control units read, an actuator, a parameter of the
car, or something around it."""


class Change(NamedTuple):
    """What becomes of a value: held at the one before the fault where `held` is true, then gain * value + offset."""

    gain: Any = 1.0
    offset: Any = 0.0
    held: Any = False


def si(amount: Amount) -> float:
    """An amount whose unit has been looked after.

    Raises:
        ParameterError: it is still a text
    """
    if isinstance(amount, str):
        raise ParameterError(f"'{amount}' has a unit, but nothing says of what; give the number in SI units")
    return float(amount)


@dataclass(frozen=True)
class Behaviour:
    """Base of the behaviours: frozen, with units and ranges in the annotations.

    `fits` says what elements can behave so, `main` which field is the size of the fault, `usual_duration` how long it
    lasts where nothing is said [s], None for until the end.
    """

    fits: ClassVar[frozenset[str]] = frozenset()
    main: ClassVar[str | None] = None
    usual_duration: ClassVar[float | None] = None

    def __post_init__(self):
        check_ranges(self)

    @property
    def core(self) -> Behaviour:
        """The behaviour itself, without what makes it come and go."""
        return self

    def change(self, since: np.ndarray, chance: Chance) -> Change:
        """What the fault does at times since its beginning [s], while it lasts."""
        raise NotImplementedError

    def on_channel(
        self, time: np.ndarray, values: np.ndarray, active: np.ndarray, sensor: Sensor, chance: Chance
    ) -> tuple[np.ndarray, np.ndarray]:
        """Time stamps and readings of a recorded channel with the fault.

        Args:
            time: stamps [s]
            values: readings
            active: whether the fault acts on each
            sensor: that read it
            chance: of the fault

        Returns:
            (time stamps, readings as the bus can hold them)
        """
        changed = values.copy()
        change = self.change(time[active] - chance.start, chance)
        source = np.arange(len(values))
        source[active] = np.where(change.held, 0, source[active])
        kept = values[np.maximum.accumulate(source)] if len(values) else values
        changed[active] = sensor.represented(change.gain * kept[active] + change.offset)
        return time, changed
