"""What every choice of outputs shows of a state, by every method side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from tierod.analysis.cramer_rao import Bound, cramer_rao
from tierod.analysis.gramian import gramian_condition, observability_gramian
from tierod.analysis.observability import Observability, observability
from tierod.analysis.observability_matrix import Rank, scaled_rank, unscaled_rank
from tierod.analysis.pbh import pbh_rank
from tierod.errors import ParameterError
from tierod.models.disturbances import with_outputs
from tierod.models.linear import LinearSystem, sampled
from tierod.models.modes import TOLERANCE

_NEAR = 10.0


@dataclass(frozen=True)
class Sampling:
    """How the outputs are sampled, for the methods that depend on it.

    Args:
        noise: standard deviation of every output, in its unit, by name
        sample_time: [s]
        duration: over which the Gramian and the bound are taken [s]
    """

    noise: Mapping[str, float]
    sample_time: float
    duration: float


@dataclass(frozen=True, eq=False)
class Shown:
    """What a choice of outputs shows.

    Args:
        outputs: the choice
        exact: by the staircase of orthonormal bases, tolerance `TOLERANCE` of the scaled system, with hidden directions
        unscaled: of the observability matrix in the units of the system, default tolerance
        scaled: of the same of the scaled system, default tolerance
        sampled: of that of the sampled system in its units, default tolerance
        pbh: states less hidden eigenvectors (test of Popov, Belevitch and Hautus, `pbh_rank`)
        condition: of the Gramian over the duration, in the best units
        bound: of the state (Cramer and Rao)
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

    def sentence(self) -> str:
        """Whether the methods agree, and where they do not, why."""
        differ = {name: rank for name, rank in self.ranks.items() if rank != self.exact.rank}
        if not differ:
            return "all methods agree" + self._by_a_hair()
        parts = []
        if "unscaled matrix" in differ:
            parts.append(self._about(self.unscaled, "unscaled"))
        if "sampled matrix" in differ:
            parts.append(self._about(self.sampled, "sampled"))
        if "scaled matrix" in differ:
            parts.append(self._about(self.scaled, "scaled"))
        if "PBH" in differ:
            parts.append(
                f"the PBH test says {self.pbh}: it tells that a state is hidden, but bounds how many from one side"
            )
        return "; ".join(parts)

    def _about(self, rank: Rank, which: str) -> str:
        values = rank.singular_values
        decades = np.log10(values[0] / max(values[-1], np.finfo(float).tiny))
        return (
            f"the {which} matrix says {rank.rank}, which is double precision and not the system: its singular values "
            f"span {decades:.0f} decades, the tolerance leaves {np.log10(values[0] / rank.tolerance):.0f}"
        )

    def _by_a_hair(self) -> str:
        margin = self.unscaled.margin
        if not 1.0 / _NEAR < margin < _NEAR:
            return ""
        return f"; the unscaled matrix by chance, a singular value is {margin:.2g} times its tolerance"


def shown_by(system: LinearSystem, outputs: Sequence[str], sampling: Sampling) -> Shown:
    """What these outputs show of the state.

    Args:
        system: continuous
        outputs: names; none at all shows nothing
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
