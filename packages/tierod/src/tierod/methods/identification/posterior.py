"""Maximum a posteriori estimation of parameters from recordings and a prior."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.graph import scan
from tierod.methods.identification.map_search import MapSearch, Place

STEP = 1e-3
"""Step of the finite differences [prior standard deviations]."""
ENOUGH = 0.02
"""Predicted increase of the log-posterior below which a search ends [nat]."""
PATIENCE = 4
"""Number of steps that end a search if they together gain less than the required increase, see `MapSearch`."""
TRUSTED = 6000.0
"""Upper limit of the effective number of measurements: beyond it, errors of the model determine the accuracy."""


@dataclass(frozen=True)
class Prior:
    """Prior of a parameter: normal, or lognormal if it is positive.

    Args:
        deviation: one standard deviation, in the unit of the value
        positive: whether the logarithm is the coordinate
    """

    name: str
    value: float
    deviation: float
    positive: bool = True
    low: float = -math.inf
    high: float = math.inf

    @property
    def scale(self) -> float:
        """Standard deviation of the value, or of its logarithm if the parameter is positive."""
        return math.log1p(self.deviation / abs(self.value)) if self.positive else self.deviation

    def at(self, place: float) -> float:
        """The value at a coordinate, which is the distance from the prior value in prior standard deviations."""
        moved = self.scale * place
        value = self.value * math.exp(moved) if self.positive else self.value + moved
        return min(max(value, self.low), self.high)

    def spread(self, place: float, deviation: float) -> float:
        """Standard deviation in the unit of the value, from one in prior standard deviations."""
        return deviation * self.scale * (abs(self.at(place)) if self.positive else 1.0)


class Posterior(NamedTuple):
    """Result of a search.

    Args:
        place: of the most probable parameters, in prior standard deviations
        covariance: of the place, from recordings and prior
        unseen: additional covariance by fixed parameters and model errors, see `considering`
    """

    priors: tuple[Prior, ...]
    place: np.ndarray
    covariance: np.ndarray
    at: Place
    steps: int
    converged: bool
    unseen: np.ndarray

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters, by name."""
        return {prior.name: prior.at(float(x)) for prior, x in zip(self.priors, self.place, strict=True)}

    @property
    def deviations(self) -> dict[str, float]:
        """Standard deviation of every parameter, in its unit; at most the prior one."""
        shares = np.sqrt(np.clip(np.diag(self.covariance + self.unseen), 0.0, 1.0))
        each = zip(self.priors, self.place, shares, strict=True)
        return {prior.name: prior.spread(float(x), float(share)) for prior, x, share in each}


Built = Callable[[dict[str, float], int], Block]
"""Function that gives the block of a recording (by index) with parameters by name. The first outputs of the block are
whitened innovations, followed by the logarithms of their standard deviations."""


@dataclass(frozen=True, eq=False)
class Search:
    """Search for the most probable parameters.

    Args:
        recordings: samples of the blocks, (n, inputs) each
        outputs: number of measurements per sample, the last inputs of the block
        trusted: upper limit of the effective number of measurements
    """

    priors: tuple[Prior, ...]
    recordings: Sequence[np.ndarray]
    built: Built
    outputs: int
    trusted: float = TRUSTED

    @cached_property
    def weight(self) -> float:
        """Exponent of the likelihood (coarsened posterior), which limits the effective number of measurements."""
        readings = sum(int(np.isfinite(each[:, -self.outputs :]).sum()) for each in self.recordings)
        return 1.0 / (1.0 + readings / self.trusted)

    def values(self, place: np.ndarray) -> dict[str, float]:
        return {prior.name: prior.at(float(x)) for prior, x in zip(self.priors, place, strict=True)}

    def scored(self, place: np.ndarray, recording: int) -> np.ndarray:
        """Whitened innovations of a recording and logarithms of their standard deviations, (n, 2 outputs)."""
        block = self.built(self.values(place), recording)
        return scan(block, self.recordings[recording]).values[:, : 2 * self.outputs]

    @cached_property
    def search(self) -> MapSearch:
        """The search over coordinates, in prior standard deviations from the prior values."""
        one = np.ones(len(self.priors))
        return MapSearch(
            self.scored, len(self.recordings), 0.0 * one, one, -np.inf * one, STEP, self.weight, patience=PATIENCE
        )

    def run(
        self,
        start: np.ndarray | None = None,
        progress: Callable[[float], None] = lambda share: None,
        enough: float = ENOUGH,
    ) -> Posterior:
        """The most probable parameters.

        Args:
            start: place where the search starts; the prior values by default
            enough: predicted increase of the log-posterior below which the search ends [nat]
            progress: called with the completed share, roughly
        """
        place = np.zeros(len(self.priors)) if start is None else start
        end = self.search.descend(place, enough, progress=lambda steps: progress(min(steps / 12.0, 0.95)))
        covariance = np.linalg.inv(end.found.information)
        progress(1.0)
        nothing = np.zeros_like(covariance)
        return Posterior(self.priors, end.place, covariance, end.found, end.steps, end.converged, nothing)


def considering(
    search: Search, found: Posterior, held: Sequence[Prior], model_errors: Mapping[str, float]
) -> Posterior:
    """The posterior with the additional covariance by fixed parameters and model errors.

    An error of a fixed parameter shifts the most probable place, and recordings do not reduce it (consider parameters).

    Args:
        held: priors of the parameters that were fixed at their values
        model_errors: standard deviations by name of a parameter, relative for positive parameters

    Source: Schmidt, Application of state-space methods to navigation problems, Advances in Control Systems 3, 1966.
    """
    count = len(found.place)
    unseen = np.diag([(model_errors.get(each.name, 0.0) / each.scale) ** 2 for each in found.priors])
    if not held:
        return found._replace(unseen=unseen)
    whole = dataclasses.replace(search, priors=(*search.priors, *held))
    information = whole.search.at(np.concatenate([found.place, np.zeros(len(held))])).information
    moved = np.linalg.solve(information[:count, :count], information[:count, count:])
    return found._replace(unseen=unseen + moved @ moved.T)
