"""Observability of a state by every choice of outputs, with a comparison of the methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from tierod.core.errors import ParameterError
from tierod.methods.analysis.observability import (
    Observability,
    Rank,
    observability,
    pbh_rank,
    scaled_rank,
    unscaled_rank,
)
from tierod.models.column_observation import with_disturbance_states, with_outputs
from tierod.models.linear import LinearSystem, sampled
from tierod.models.modes import TOLERANCE
from tierod_lab.papers.column.balancing import gramian_condition, observability_gramian
from tierod_lab.papers.column.cramer_rao import Bound, cramer_rao


def extended(system: LinearSystem, disturbances: Sequence[str]) -> LinearSystem:
    """The system with some of its inputs as constant states, in this order after the others.

    Args:
        system: continuous
        disturbances: names of inputs

    Raises:
        ParameterError: no such input

    Source: Raffone, eq (8), where the torques of driver and disturbance become states.
    """
    return with_disturbance_states(system, dict.fromkeys(disturbances, 1))


@dataclass(frozen=True)
class Sampling:
    """Sampling of the outputs, for the methods that depend on it.

    Args:
        noise: standard deviation of every output, in its unit, by name
        sample_time: sampling interval [s]
        duration: time of observation for the Gramian and the bound [s]
    """

    noise: Mapping[str, float]
    sample_time: float
    duration: float


@dataclass(frozen=True, eq=False)
class Shown:
    """Observability by one choice of outputs.

    Args:
        outputs: the choice
        exact: by the staircase of orthonormal bases of the scaled system, with `TOLERANCE` and unobservable directions
        unscaled: rank of the observability matrix in the units of the system, default tolerance
        scaled: rank of the observability matrix of the scaled system, default tolerance
        sampled: rank of the observability matrix of the sampled system in its units, default tolerance
        pbh: rank by the test of Popov, Belevitch and Hautus (`pbh_rank`)
        condition: condition number of the Gramian over the duration, with normalised states
        bound: Cramer-Rao bound of the state
    """

    outputs: tuple[str, ...]
    exact: Observability
    unscaled: Rank
    scaled: Rank
    sampled: Rank
    pbh: int
    condition: float
    bound: Bound

    @property
    def ranks(self) -> dict[str, int]:
        """The rank by method."""
        return {
            "staircase": self.exact.rank,
            "PBH": self.pbh,
            "scaled matrix": self.scaled.rank,
            "sampled matrix": self.sampled.rank,
            "unscaled matrix": self.unscaled.rank,
        }


def shown_by(system: LinearSystem, outputs: Sequence[str], sampling: Sampling) -> Shown:
    """Observability of the state by these outputs.

    Args:
        system: continuous
        outputs: names; may be empty
        sampling: noise, sample time and duration
    """
    part = with_outputs(system, tuple(outputs))
    exact = observability(part, TOLERANCE)
    return Shown(
        tuple(outputs),
        exact,
        unscaled_rank(part),
        scaled_rank(part),
        unscaled_rank(sampled(part, sampling.sample_time)),
        pbh_rank(part),
        gramian_condition(observability_gramian(part, sampling.duration)),
        cramer_rao(part, sampling.noise, sampling.duration, sampling.sample_time),
    )


def output_subsets(system: LinearSystem, sampling: Sampling) -> list[Shown]:
    """`shown_by` of every choice of outputs, single ones first.

    Raises:
        ParameterError: more than eight outputs, which have over 255 choices
    """
    if len(system.outputs) > 8:
        raise ParameterError(f"{len(system.outputs)} outputs have too many choices; choose eight with `with_outputs`")
    sizes = range(1, len(system.outputs) + 1)
    return [shown_by(system, choice, sampling) for size in sizes for choice in combinations(system.outputs, size)]
