"""Which single readings are not believed, and what stands in for every sensor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tierod.core.graph.maths import absolute, all_of, negated, present, where
from tierod.monitors.condition.bank.diagnosis import Elements
from tierod.monitors.condition.bank.readings import Readings


def gated(readings: Sequence[Any], seen: Any, faulty: Elements, gate: Any) -> Readings:
    """Readings far off that belong to nobody declared.

    Args:
        readings: of all sensors
        seen: output of the lane that is believed
        faulty: what is declared
        gate: number of standard deviations beyond which a reading is far off
    """
    return Readings(
        *(
            all_of(
                negated(known),
                present(reading),
                absolute(where(present(reading), reading, 0.0) - prediction) > gate * deviation,
            )
            for reading, prediction, deviation, known in zip(
                readings, seen.prediction, seen.deviation, faulty, strict=False
            )
        )
    )


def stand_ins(readings: Sequence[Any], seen: Any, faulty: Elements, off: Readings) -> Readings:
    """The value of every sensor: its own reading where it is trusted, else what the believed lane says.

    Args:
        readings: of all sensors
        seen: output of the lane that is believed
        faulty: what is declared
        off: readings that are far off, see `gated`
    """
    return Readings(
        *(
            where(all_of(present(reading), negated(known), negated(far)), reading, estimate)
            for reading, estimate, known, far in zip(readings, seen.estimate, faulty, off, strict=False)
        )
    )
