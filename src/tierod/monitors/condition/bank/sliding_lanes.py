"""Filters of a rolling car whose tyres slide, and the criterion for sliding."""

from __future__ import annotations

from dataclasses import replace

from tierod.monitors.condition.bank.low_grip import LowGrip
from tierod.monitors.condition.bank.rolling_filter import RollingFilter

LACKS = 0.7
"""Acceleration that is lacking where tyres slide [m/s**2]."""


def ploughing(base: RollingFilter) -> RollingFilter:
    """The filter of a car whose front axle slides: it does not turn as it is steered.

    Args:
        base: the filter that suspects nothing
    """
    return replace(base, model_error=replace(base.model_error, lateral_jerk=5.0, steering=0.5, steering_share=0.0))


def skidding(base: RollingFilter) -> RollingFilter:
    """The filter of a car whose tyres all slide: it goes where it will, and no two wheels turn alike.

    Args:
        base: the filter that suspects nothing
    """
    error = replace(
        base.model_error,
        jerk=20.0,
        lateral_jerk=20.0,
        steering=0.5,
        steering_share=0.0,
        slip=0.05,
        uneven=0.02,
        grade=5.0,
        bank=10.0,
    )
    return replace(base, model_error=error)


OF_SKIDDING = LowGrip(leads=-0.5, lacks=LACKS, largest=6.0, stays=1.0)
"""When tyres of a car slide: a filter of sliding tyres explains the readings about as well as any other, and force is
lacking. All of this was chosen on 119 tests at the limit of seven virtual cars (seed 41), and on faults of a virtual
city drive (seed 1), which it must leave to be named."""
