"""Unknowns of the combined estimator that a drive identifies, and the direction among them that it identifies least."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tierod.core.block import rebuild
from tierod.core.graph import Memory
from tierod.methods.estimators.linear_algebra import unpack
from tierod.monitors.sideslip.combined import CombinedSideslip, CombinedState

IDENTIFIED = 0.75
"""Share by which the data must have reduced the prior variance of an unknown for it to count as identified [-]; its
standard deviation is then half of the prior one, or less."""

NAMED = 0.35
"""Component of an unknown in a unit direction from which the direction is named after it [-]."""

WORDS = {
    "log_front_stiffness": "front stiffness",
    "log_rear_stiffness": "rear stiffness",
    "log_friction": "friction of the tyres",
    "bank_angle": "bank",
    "side_force": "side force",
    "side_moment": "yaw moment of the wind",
    "lateral_acceleration_bias": "bias of the lateral acceleration",
    "yaw_rate_bias": "bias of the yaw rate",
    "road_wheel_angle_offset": "offset of the road-wheel angle",
    "log_steering_friction": "friction of the steering",
    "log_trail": "pneumatic trail",
}
"""Names of the unknowns in findings."""


@dataclass(frozen=True)
class Identifiability:
    """Identifiability of the unknowns from the data of a drive.

    Args:
        shares: share by which the data reduced the prior variance, by unknown, 0 to 1
        direction: components of the least identified direction, each unknown scaled by its prior
        left: share of the prior variance that remains in that direction
    """

    shares: Mapping[str, float]
    direction: Mapping[str, float]
    left: float

    @property
    def identified(self) -> tuple[str, ...]:
        """Unknowns that the data identify."""
        return tuple(name for name, share in self.shares.items() if share >= IDENTIFIED)

    @property
    def least(self) -> str:
        """The least identified direction, in words: "side force - yaw moment of the wind"."""
        parts = {name: part for name, part in self.direction.items() if abs(part) >= NAMED}
        first = next(iter(parts.values()))
        named = [f"{'+' if part * first > 0.0 else '-'} {WORDS[name]}" for name, part in parts.items()]
        return " ".join(named).removeprefix("+ ")

    def __str__(self) -> str:
        """One or two sentences for a finding."""
        known = [f"{WORDS[name]} ({share:.0%})" for name, share in self.shares.items() if name in self.identified]
        text = f"The drive identifies {', '.join(known)}." if known else "The drive identifies none of the unknowns."
        if self.left <= 1.0 - IDENTIFIED:
            return text
        return f"{text} It identifies least: {self.least} ({self.left:.0%} of the prior variance is left)."


def identifiability(estimator: CombinedSideslip, state: CombinedState | Memory) -> Identifiability:
    """Identifiability of the unknowns up to a state.

    Args:
        estimator: estimator of the state
        state: state after a sample, or the `state` of a result of `scan`

    An eigenvalue near one of the covariance, scaled by the priors, belongs to a direction that the data do not
    identify; parameters may each be identified and yet not be separable, or be separable and yet not identified.
    """
    reached: CombinedState = rebuild(estimator.init(), state.values.tolist()) if isinstance(state, Memory) else state
    count = len(estimator.filter.model.unknowns)
    covariance = np.asarray(unpack(reached.belief.covariance))[-count:, -count:]
    prior = np.sqrt(np.asarray(estimator.filter.initial_variance[-count:]))
    scaled = covariance / np.outer(prior, prior)
    values, vectors = np.linalg.eigh(scaled)
    names = estimator.filter.model.unknowns
    shares = np.clip(1.0 - np.diag(scaled), 0.0, 1.0)
    return Identifiability(
        dict(zip(names, shares.tolist(), strict=True)),
        dict(zip(names, vectors[:, -1].tolist(), strict=True)),
        float(min(values[-1], 1.0)),
    )
