"""Linear systems with their unknown inputs as constant states."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.models.disturbances import with_disturbance_states
from tierod.models.linear import LinearSystem


def extended(system: LinearSystem, disturbances: Sequence[str]) -> LinearSystem:
    """The system with some of its inputs as states that stay as they are, in this order at the end.

    Args:
        system: continuous
        disturbances: names of inputs

    Raises:
        ParameterError: no such input

    Source: Raffone, eq (8), where the torques of driver and disturbance become states.
    """
    return with_disturbance_states(system, dict.fromkeys(disturbances, 1))
