"""Filters of a rolling car with sliding tyres, and the criterion for sliding."""

from __future__ import annotations

from dataclasses import replace

from tierod.monitors.condition.bank.low_grip import LowGrip
from tierod.monitors.condition.bank.rolling_filter import RollingFilter

LACKS = 0.7
"""Least lateral acceleration that is lacking when tyres slide [m/s**2]."""


def ploughing(base: RollingFilter) -> RollingFilter:
    """Filter of a car with a sliding front axle, which does not turn as it is steered.

    Args:
        base: filter of the fault-free hypothesis
    """
    return replace(base, model_error=replace(base.model_error, lateral_jerk=5.0, steering=0.5, steering_share=0.0))


def skidding(base: RollingFilter) -> RollingFilter:
    """Filter of a car with all tyres sliding: any motion is possible, and no two wheels turn alike.

    Args:
        base: filter of the fault-free hypothesis
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
"""Criterion for sliding tyres of a car: a filter of sliding tyres explains the readings about as well as any other, and
force is lacking. Its numbers were chosen on 119 tests at the limit of seven virtual cars (seed 41), and on faults in a
virtual city drive (seed 1), which must still be declared."""
