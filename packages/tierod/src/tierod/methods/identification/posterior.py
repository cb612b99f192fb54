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

STEP = 1e-3
"""Step of the finite differences [prior standard deviations]."""
ENOUGH = 0.02
"""Predicted increase of the log-posterior below which a search ends [nat]."""
MOST_STEPS = 40
STALLED = 4
"""Number of steps that end a search if they together gain less than the required increase: with gated measurements the
quadratic approximation may predict an increase that no step finds."""
LARGEST = 1.0
"""Largest step of a coordinate [prior standard deviations], within which the derivatives are valid."""
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


class Place(NamedTuple):
    """Cost of a set of parameters, with its derivatives.

    Args:
        cost: negative logarithm of the posterior density, without its constant
        gradient, information: of the cost with the prior, in prior standard deviations
        scores: gradient of every sample, per recording
        shares: information of each recording alone, without the prior
        whitened: innovations over their standard deviations, per recording
    """

    cost: float
    gradient: np.ndarray
    information: np.ndarray
    scores: tuple[np.ndarray, ...]
    shares: tuple[np.ndarray, ...]
    whitened: tuple[np.ndarray, ...]


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
    """Gauss-Newton search for the most probable parameters.

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

    def cost(self, place: np.ndarray) -> float:
        """Negative logarithm of the posterior density at a place, infinite where it is not finite."""
        total = 0.5 * float(place @ place)
        for k in range(len(self.recordings)):
            total += self.weight * _cost(self.scored(place, k), self.outputs)
        return total if math.isfinite(total) else math.inf

    def at(self, place: np.ndarray) -> Place:
        """Cost and derivatives at a place."""
        count, m = len(place), self.outputs
        cost, gradient, information = 0.5 * float(place @ place), place.copy(), np.eye(count)
        scores, shares, whitened = [], [], []
        for k in range(len(self.recordings)):
            here = self.scored(place, k)
            moved = np.stack([(self.scored(place + STEP * row, k) - here) / STEP for row in np.eye(count)])
            surprise, widths = moved[:, :, :m], moved[:, :, m:]
            score = self.weight * np.sum(surprise * here[:, :m] + widths, axis=2).T
            flat, wide = (surprise + here[:, :m] * widths).reshape(count, -1), widths.reshape(count, -1)
            share = self.weight * (flat @ flat.T + 2.0 * wide @ wide.T)
            cost, gradient, information = (
                cost + self.weight * _cost(here, m),
                gradient + score.sum(axis=0),
                information + share,
            )
            scores.append(score)
            shares.append(share)
            whitened.append(here[:, :m])
        return Place(cost, gradient, information, tuple(scores), tuple(shares), tuple(whitened))

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
        here, damping, steps = self.at(place), 1e-3, 0
        costs = [here.cost]
        while steps < MOST_STEPS and not _ended(here, enough) and not _stalled(costs, enough) and damping < 1e6:
            steps += 1
            damped = here.information + damping * np.diag(np.diag(here.information))
            move = np.clip(-np.linalg.solve(damped, here.gradient), -LARGEST, LARGEST)
            cost = self.cost(place + move)
            if cost < here.cost:
                place, damping = place + move, 0.1 * damping
                here = self.at(place)
                costs.append(here.cost)
            else:
                damping = max(10.0 * damping, 1e-3)
            progress(min(steps / 12.0, 0.95))
        converged = _ended(here, enough) or _stalled(costs, enough)
        covariance = np.linalg.inv(here.information)
        progress(1.0)
        return Posterior(self.priors, place, covariance, here, steps, converged, np.zeros_like(covariance))


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
    information = whole.at(np.concatenate([found.place, np.zeros(len(held))])).information
    moved = np.linalg.solve(information[:count, :count], information[:count, count:])
    return found._replace(unseen=unseen + moved @ moved.T)


def _ended(here: Place, enough: float) -> bool:
    return float(0.5 * here.gradient @ np.linalg.solve(here.information, here.gradient)) < enough


def _stalled(costs: Sequence[float], enough: float) -> bool:
    return len(costs) > STALLED and costs[-1 - STALLED] - costs[-1] < enough


def _cost(scored: np.ndarray, outputs: int) -> float:
    return float(0.5 * np.sum(scored[:, :outputs] ** 2) + np.sum(scored[:, outputs:]))
