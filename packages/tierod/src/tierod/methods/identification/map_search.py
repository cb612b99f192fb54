"""Maximum a posteriori search of parameters from the innovations of filters: prior, bounds, likelihood, Fisher scoring.

The log-likelihood of innovations holds the logarithms of their standard deviations, which depend on the parameters. It
is no sum of squares, so that a solver of least squares finds neither its minimum nor its curvature.

Source: L. Ljung, System Identification (1999), sections 7.4 and 10.2; Fisher scoring after Levenberg, Marquardt."""

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

# Function that gives, at a place and for the recording of a number, the whitened innovations and the logarithms of
# their standard deviations, (n, 2 outputs)
Scored = Callable[[np.ndarray, int], np.ndarray]
# Largest decrease of the cost that an undamped step may still predict at convergence: the minimum is then within half a
# standard deviation in every direction. A search that stops farther off has not converged.
NEAR = 0.125
# Largest step of a coordinate, within which the derivatives are valid: a factor of 2.7 of a logarithm, or one prior
# standard deviation
LARGEST = 1.0


class Place(NamedTuple):
    """Cost at a place of the search, with its derivatives with respect to the moving coordinates."""

    cost: float  # negative logarithm of the posterior density, without its constant
    gradient: np.ndarray
    # of the cost with the prior, from the derivatives of innovations and of their standard deviations
    information: np.ndarray
    scores: tuple[np.ndarray, ...]  # gradient of every sample, per recording
    whitened: tuple[np.ndarray, ...]  # innovations over their standard deviations, per recording


class End(NamedTuple):
    """Coordinates at which a search stopped, and the cost there."""

    place: np.ndarray
    found: Place
    steps: int
    converged: bool


@dataclass(frozen=True, eq=False)
class MapSearch:
    """Search for the coordinates of least cost.

    Derivatives are finite differences of whole runs of the filter: a graph of sensitivities, because of the covariance,
    would be twenty times as large as the filter, which is compiled once and runs in 0.3 microseconds per sample.
    """

    scored: Scored
    count: int  # number of recordings
    centre: np.ndarray  # centre, precision: of the normal prior of every coordinate; a precision of zero for none
    precision: np.ndarray
    least: np.ndarray  # lower bounds of the coordinates
    step: float  # of the finite differences
    weight: float = 1.0  # exponent of the likelihood, which limits the effective number of measurements
    most_steps: int = 40
    # number of steps that end a search if they together gain less than the required decrease; several where the
    # quadratic approximation may predict a decrease that no step finds, as with gated measurements
    patience: int = 1

    def cost(self, place: np.ndarray) -> float:
        """Negative logarithm of the posterior density at a place, infinite where it is not finite."""
        total = 0.5 * float(np.sum(self.precision * (place - self.centre) ** 2))
        for recording in range(self.count):
            surprise, spread = np.hsplit(self.scored(place, recording), 2)
            total += self.weight * float(0.5 * np.sum(surprise**2) + np.sum(spread))
        return total if math.isfinite(total) else math.inf

    def at(self, place: np.ndarray, moving: Sequence[int] | None = None) -> Place:
        """Cost and derivatives at a place with respect to the coordinates `moving` (indices), by default to all."""
        own = list(range(len(place))) if moving is None else list(moving)
        away = place - self.centre
        cost = 0.5 * float(np.sum(self.precision * away**2))
        gradient, information = (self.precision * away)[own], np.diag(self.precision[own])
        scores, whitened = [], []
        for recording in range(self.count):
            values = self.scored(place, recording)
            surprise, spread = np.hsplit(values, 2)
            steps = self.step * np.eye(len(place))[own]
            changes = np.stack([self.scored(place + each, recording) - values for each in steps]) / self.step
            surprised, spreading = np.split(changes, 2, axis=2)
            score = self.weight * np.sum(surprised * surprise + spreading, axis=2).T
            expected = (surprised + surprise * spreading).reshape(len(own), -1)
            widths = spreading.reshape(len(own), -1)
            share = self.weight * (expected @ expected.T + 2.0 * widths @ widths.T)
            cost += self.weight * float(0.5 * np.sum(surprise**2) + np.sum(spread))
            gradient, information = gradient + score.sum(axis=0), information + share
            scores.append(score)
            whitened.append(surprise)
        return Place(cost, gradient, information, tuple(scores), tuple(whitened))

    def descend(
        self,
        place: np.ndarray,
        enough: float,
        moving: Sequence[int] | None = None,
        progress: Callable[[int], None] = lambda steps: None,
    ) -> End:
        """Search from a place until a smaller decrease of the cost than `enough` is left."""
        own = list(range(len(place))) if moving is None else list(moving)
        damping, now = 1e-2, self.at(place, own)
        costs = [now.cost]
        for steps in range(1, self.most_steps + 1):
            step = self._step(place, now, own, damping)
            step *= min(1.0, LARGEST / max(float(np.max(np.abs(step))), 1e-300))
            ahead = place.copy()
            ahead[own] += step
            ahead = np.maximum(ahead, self.least)
            hoped = -float(now.gradient @ step + 0.5 * step @ now.information @ step)
            gained = now.cost - self.cost(ahead)
            if gained > 0.0:
                place, now = ahead, self.at(ahead, own)
                costs.append(now.cost)
                damping = damping / 10.0 if gained > 0.5 * hoped else damping
            else:
                damping = max(10.0 * damping, 1e-4)
            progress(steps)
            stalled = gained > 0.0 and len(costs) > self.patience and costs[-1 - self.patience] - costs[-1] < enough
            if stalled or hoped < enough or damping > 1e8:
                near = float(-0.5 * now.gradient @ self._step(place, now, own, 0.0)) < NEAR
                return End(place, now, steps, near or (stalled and self.patience > 1))
        return End(place, now, self.most_steps, False)

    def _step(self, place: np.ndarray, now: Place, own: list[int], damping: float) -> np.ndarray:
        """A damped step of Fisher scoring; coordinates at their lower bound that would fall further are fixed."""
        kept = np.flatnonzero((place[own] > self.least[own] + 1e-9) | (now.gradient < 0.0))
        information = now.information[np.ix_(kept, kept)]
        damped = information + damping * np.diag(np.diag(information) + 1e-12)
        step = np.zeros(len(own))
        step[kept] = -np.linalg.solve(damped, now.gradient[kept])
        return step


STEP = 1e-3  # Step of the finite differences [prior standard deviations]
ENOUGH = 0.02  # Predicted increase of the log-posterior below which a search ends [nat]
PATIENCE = 4  # Number of steps that end a search if they together gain less than the required increase, see `MapSearch`
# Upper limit of the effective number of measurements: beyond it, errors of the model determine the accuracy
TRUSTED = 6000.0


@dataclass(frozen=True)
class Prior:
    """Prior of a parameter: normal, or lognormal if it is positive."""

    name: str
    value: float
    deviation: float  # one standard deviation, in the unit of the value
    positive: bool = True  # whether the logarithm is the coordinate
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
    """Result of a search."""

    priors: tuple[Prior, ...]
    place: np.ndarray  # of the most probable parameters, in prior standard deviations
    covariance: np.ndarray  # of the place, from recordings and prior
    at: Place
    steps: int
    converged: bool
    unseen: np.ndarray  # additional covariance by fixed parameters and model errors, see `considering`

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


# Function that gives the block of a recording (by index) with parameters by name. The first outputs of the block are
# whitened innovations, followed by the logarithms of their standard deviations.
Built = Callable[[dict[str, float], int], Block]


@dataclass(frozen=True, eq=False)
class Search:
    """Search for the most probable parameters."""

    priors: tuple[Prior, ...]
    recordings: Sequence[np.ndarray]  # samples of the blocks, (n, inputs) each
    built: Built
    outputs: int  # number of measurements per sample, the last inputs of the block
    trusted: float = TRUSTED  # upper limit of the effective number of measurements

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

        Args: start: place where the search starts; the prior values by default; enough: predicted increase of the
        log-posterior below which the search ends [nat].
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
