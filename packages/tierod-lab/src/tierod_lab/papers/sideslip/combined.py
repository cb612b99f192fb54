"""The combined estimator on the virtual car: errors, low friction, convergence, and an unscented filter."""

from __future__ import annotations

from collections.abc import Iterator

from tierod.core.content import Heading, Item
from tierod_lab.papers.sideslip import combined_learning, combined_limit, combined_table, combined_unscented
from tierod_lab.studies.effort import Effort


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Combined estimator",
        (
            "One extended Kalman filter over yaw rate, lateral acceleration and, where the car has it, the torque of "
            "the steering, beside the full chassis on two tracks with tyres of another law. Every 10 ms; noise of the "
            "yaw rate 0.003 rad/s, of the road-wheel angle 0.2 mrad, of the acceleration 0.1 m/s².",
        ),
    )
    yield from combined_table.items(effort)
    yield from combined_limit.items(effort)
    yield from combined_learning.items(effort)
    yield from combined_unscented.items(effort)
