"""Remarks on an inverter of which only the command was recorded."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from tierod.monitors.motor_angle.signals import IN_WORDS

KNEE_APART, KNEE_SIGMAS = 1.4, 4.0
"""A knee is another than the vehicle file's where it lies beyond this factor, and by so many standard deviations."""

KNEE_REACHED = 0.95
"""Share of the way to the end of what is learnt, from which the knee may lie beyond."""


class InverterLoss(NamedTuple):
    """What the inverter was found to take from its command.

    Args:
        voltage_loss: of a phase far above the knee
        knee_current: below which it falls
        knee_deviation: standard deviation of the logarithm of that
        nominal_knee: of the vehicle file
        widest: that the logarithm over that may reach
    """

    voltage_loss: Annotated[float, "V"]
    knee_current: Annotated[float, "A"]
    knee_deviation: float
    nominal_knee: Annotated[float, "A"]
    widest: float

    @property
    def apart(self) -> float:
        """Logarithm of the knee over the vehicle file's."""
        return math.log(max(self.knee_current, 1e-9) / self.nominal_knee)

    @property
    def beyond(self) -> bool:
        """Whether the knee may lie further away than is learnt."""
        return abs(self.apart) > KNEE_REACHED * self.widest


def inverter_remarks(lost: InverterLoss | None, voltages: str) -> tuple[str, ...]:
    """Which voltages a finding rests on, and whether the inverter is another than the vehicle file's.

    Args:
        lost: what the inverter was found to take; None where the voltages were measured
        voltages: that the observer was fed with
    """
    if lost is None:
        return ()
    rests_on = (
        f"the voltages are {IN_WORDS[voltages]}: {lost.voltage_loss:.2f} V a phase, with a knee at "
        f"{lost.knee_current:.2g} A; measured voltages tell the angle better"
    )
    if abs(lost.apart) < max(math.log(KNEE_APART), KNEE_SIGMAS * lost.knee_deviation):
        return (rests_on,)
    wrong = (
        f"the inverter's knee is {lost.knee_current:.2g} A and not {lost.nominal_knee:.2g} A as in the vehicle file: "
        "correct inverter_knee_current; the angle is known less well until it is learnt"
    )
    return (rests_on, wrong)


def knee_beyond(lost: InverterLoss) -> tuple[str, str] | None:
    """Cause and cure where the knee may be further away than an observer learns."""
    if not lost.beyond:
        return None
    return (
        f"the inverter's knee lies beyond what is learnt, at {lost.knee_current:.2g} A where the vehicle file says "
        f"{lost.nominal_knee:.2g} A",
        "find inverter_knee_current with 'tierod identify inverter', or record the voltages",
    )
