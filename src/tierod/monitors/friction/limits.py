"""Where the limits of friction act, for an estimate: with the margin of the absolute ones, and by the own level."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tierod.monitors.friction.run import FrictionRun


@dataclass(frozen=True)
class Limit:
    """Where an alarm begins.

    Args:
        friction: the estimate [N*m]
        absolute: limit of the vehicle file [N*m]
        absolute_from: where that acts: the torques' gain and the estimate must not explain the excess [N*m]
        ratio: limit of friction to the own level [-]
        relative_from: where that acts [N*m]; infinite without an own level
    """

    friction: Annotated[float, "N*m"]
    absolute: Annotated[float, "N*m"]
    absolute_from: Annotated[float, "N*m"]
    ratio: Annotated[float, ""]
    relative_from: Annotated[float, "N*m"]

    @property
    def acts_from(self) -> float:
        """Where the first of them acts [N*m]."""
        return min(self.absolute_from, self.relative_from)

    @property
    def in_margin(self) -> bool:
        """Whether friction is above the limit of the vehicle file, but not by more than the margin."""
        return self.absolute < self.friction <= self.absolute_from


@dataclass(frozen=True)
class Limits:
    """Of rising friction, and of a fault."""

    rising: Limit
    fault: Limit

    @property
    def pending(self) -> bool:
        """Whether friction is above a limit that acts."""
        return self.rising.friction > self.rising.acts_from


def limits_of(run: FrictionRun) -> Limits:
    """The limits as they act on the last estimate of a run."""
    verdict, friction = run.verdict, run.last.friction_torque
    level = verdict.relative_level(run.output.level) if run.output.level > 0.0 else float("inf")
    deviation = run.last.friction_deviation / run.last.misfit

    def limit(absolute: float, ratio: float) -> Limit:
        return Limit(friction, absolute, verdict.acts_from(absolute, deviation), ratio, ratio * level)

    return Limits(
        limit(verdict.limits.rising_friction, verdict.tuning.rising_ratio),
        limit(verdict.limits.fault_friction, verdict.tuning.fault_ratio),
    )
