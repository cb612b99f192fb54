"""The likeliest parameters of a vehicle: whitened innovations of its healthy filter, and the search for their least."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import repeat
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Tree, named_tuple
from tierod.core.errors import InputError
from tierod.core.graph import batch, scan
from tierod.methods.identification.regression import sandwich
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.bank.tuning import SENSOR_NOISE, ModelError
from tierod.monitors.condition.bank.updates import logarithm
from tierod.monitors.condition.signals import ConditionSample, Measured
from tierod.vehicles import Vehicle
from tierod.vehicles.catalogue import QUANTITIES

_OUTPUTS = len(AutomatedVehicle.Output._fields)
_STEP = 1e-3
"""Of differences, in standard deviations of what is known before: the cost is smooth, and all digits are there."""
_ENOUGH = 3.0
"""Gain of log likelihood below which a search ends [nat]; the standard deviations stand for half a nat each."""
_MOST_STEPS = 8
"""Of one stage; most end after three to five."""
_LARGEST = 1.5
"""Step of a parameter, in standard deviations of what is known before: farther, its derivatives no longer hold."""
_ODD = 4.0
"""Standard deviations beyond which an innovation counts by its size and no longer by its square: of normal ones, one in
sixteen thousand."""
_UNBOUNDED = 1e3
"""Influence of a reading in standard deviations: in the fit the cost is bounded, not the filter."""
_WIDENED = (1.0, 0.4, 0.0)
"""Shares of what is not known yet in the noises of the stages."""
_HELD = {
    "yaw_rate_offset": 1e-5,
    "angle_offset": 1e-5,
    "wheel_speed_difference": 1e-6,
    "wheel_speed_scale": 1e-6,
    "drive_excess": 1e-6,
}
"""What a filter else learns on the way wanders by next to nothing, so that it goes into the parameters."""


@dataclass(frozen=True)
class WhitenedInnovations:
    """Whitened innovations: the part of every reading that the filter could not predict, each by itself.

    Args:
        filter: the fault-free one
    """

    filter: LeaveOutFilter

    Sample = ConditionSample
    Output = named_tuple(
        "Output",
        [(f"whitened_{k}", Annotated[float, ""]) for k in range(_OUTPUTS)]
        + [(f"spread_{k}", Annotated[float, ""]) for k in range(_OUTPUTS)],
    )

    def init(self) -> LeaveOutFilter.State:
        """First state of the filter."""
        return self.filter.init()

    def step(self, state: LeaveOutFilter.State, sample: ConditionSample) -> tuple[LeaveOutFilter.State, Tree]:
        """Innovations over their standard deviations, and the logarithms of those over the sensors' noise."""
        after, seen = self.filter.corrected(state, sample)
        correction = seen.correction
        return after, self.Output(*correction.whitened, *(0.5 * logarithm(wide) for wide in correction.widening))


class Place(NamedTuple):
    """Cost of a set of parameters by the drives, with its derivatives.

    Args:
        cost: negative logarithm of the posterior density, without its constant
        gradient, information: of it, in standard deviations of what is known before
        scores: gradients of every sample of every drive
        squares: mean squared innovation over its variance of every reading
        samples: number of them
    """

    cost: float
    gradient: np.ndarray
    information: np.ndarray
    scores: list[np.ndarray]
    squares: np.ndarray
    samples: int


class Found(NamedTuple):
    """Point at which a search ended.

    Args:
        names: of the parameters that were looked for
        values, deviations: of them, in SI units
        before, after: mean log likelihood of a sample, without its constant
        squares: mean squared innovation over its variance of every reading, wheel speeds first; near one is
            consistent, above one is overconfident
        steps: of the search
        converged: whether it came to an end
    """

    names: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    before: float
    after: float
    squares: np.ndarray
    steps: int
    converged: bool


class Search:
    """Gauss-Newton in units of the prior deviations, all differences of one step as lanes of one batch.

    Args:
        vehicle: where to start from; its standard deviations are those of what is known before
        drives: rows of `ConditionSample`
        free: names of the unknowns, where the vehicle file gives their uncertainty

    Raises:
        InputError: the vehicle file gives the uncertainty of none
    """

    def __init__(self, vehicle: Vehicle, drives: Sequence[np.ndarray], free: Sequence[str]):
        self.vehicle, self.drives = vehicle, drives
        known = {name: vehicle.parameters[name] for name in free if name in vehicle}
        self.names = tuple(name for name, each in known.items() if each.standard_deviation)
        if not self.names:
            raise InputError(
                f"the vehicle '{vehicle.name}' gives no standard deviation for any parameter that is calibrated "
                f"({', '.join(free[:3])}, ...); write how well each is known beside its value"
            )
        self.centre = np.array([known[name].value for name in self.names])
        self.scale = np.array([known[name].standard_deviation or 0.0 for name in self.names])
        plausible = np.array([QUANTITIES[name].plausible for name in self.names]).T
        self.least, self.most = (plausible - self.centre) / self.scale
        self.stage = self.stages()[0]

    def stages(self) -> list[LeaveOutFilter]:
        """Filters to be fitted one after the other.

        A filter that takes wrong parameters for noise has one hill to climb, the last one has many far from its top.
        """
        wide = replace(LeaveOutFilter.of_vehicle(self.vehicle), influence=_UNBOUNDED)
        return [
            replace(
                wide,
                sensor_noise=Measured(*map(_between, SENSOR_NOISE, wide.sensor_noise, repeat(share))),
                model_error=_error_between(wide.model_error, share),
            )
            for share in _WIDENED
        ]

    def block(self, place: np.ndarray) -> WhitenedInnovations:
        """The innovations with the parameters of a place."""
        values = dict(zip(self.names, (self.centre + self.scale * place).tolist(), strict=True))
        return WhitenedInnovations(replace(self.stage, vehicle=replace(self.stage.vehicle, **values)))

    def at(self, place: np.ndarray) -> Place:
        """Cost and derivatives of it."""
        count = len(place)
        places = [place, *(place + _STEP * np.eye(count)[k] for k in range(count))]
        cost, gradient, information = 0.5 * place @ place, place.copy(), np.eye(count)
        scores, squares, samples = [], np.zeros(_OUTPUTS), 0
        for drive in self.drives:
            results = [result.values for result in batch([self.block(each) for each in places], [drive] * len(places))]
            surprise, spread = results[0][:, :_OUTPUTS], results[0][:, _OUTPUTS:]
            moved = np.stack([(each - results[0]) / _STEP for each in results[1:]])
            bounded = np.clip(surprise, -_ODD, _ODD)
            scores.append(np.sum(moved[:, :, :_OUTPUTS] * bounded + moved[:, :, _OUTPUTS:], axis=2).T)
            counted = (moved[:, :, :_OUTPUTS] * (np.abs(surprise) < _ODD)).reshape(count, -1)
            widths = moved[:, :, _OUTPUTS:].reshape(count, -1)
            cost += float(np.sum(_bounded_half_square(surprise)) + np.sum(spread))
            gradient += scores[-1].sum(axis=0)
            information += counted @ counted.T + 2.0 * widths @ widths.T
            squares, samples = squares + np.sum(surprise**2, axis=0), samples + len(drive)
        return Place(cost, gradient, information, scores, squares / samples, samples)

    def cost(self, place: np.ndarray) -> float:
        """Cost alone."""
        total = 0.5 * place @ place
        for drive in self.drives:
            result = scan(self.block(place), drive).values
            total += float(np.sum(_bounded_half_square(result[:, :_OUTPUTS])) + np.sum(result[:, _OUTPUTS:]))
        return float(total) if np.isfinite(total) else np.inf

    def run(self, progress: Callable[[float], None]) -> Found:
        """The likeliest parameters.

        Args:
            progress: called with the share that is done
        """
        place, steps, converged = np.zeros(len(self.names)), 0, False
        stages = self.stages()
        self.stage = stages[-1]
        before = self.cost(place)
        for number, self.stage in enumerate(stages):
            place, here, more, converged = self._descend(place)
            steps += more
            progress((number + 1.0) / len(stages))
        deviations = np.sqrt(np.diag(sandwich(here.information, here.scores, np.eye(len(place)))))
        return Found(
            self.names,
            self.centre + self.scale * place,
            self.scale * deviations,
            -before / here.samples,
            -here.cost / here.samples,
            here.squares,
            steps,
            converged,
        )

    def _descend(self, place: np.ndarray) -> tuple[np.ndarray, Place, int, bool]:
        """The lowest place of one stage, after so many steps, and whether it is the end of the way."""
        here, damping, steps, converged = self.at(place), 1e-3, 0, False
        while steps < _MOST_STEPS and not converged:
            steps += 1
            damped = here.information + damping * np.diag(np.diag(here.information))
            move = np.clip(-np.linalg.solve(damped, here.gradient), -_LARGEST, _LARGEST)
            there = np.clip(place + move, self.least, self.most)
            cost = self.cost(there)
            if cost < here.cost:
                converged = bool(here.cost - cost < _ENOUGH)
                place, damping = there, 0.2 * damping
                here = self.at(place)
            else:
                damping, converged = max(10.0 * damping, 1e-3), damping > 1e4
        return place, here, steps, converged


def _between(usual: float, wide: float, share: float) -> float:
    """A noise at a share of the way from the usual to the wide one, in logarithms."""
    return usual * math.pow(wide / usual, share)


def _error_between(wide: ModelError, share: float) -> ModelError:
    """The model's errors at a share of the way from the usual to the wide ones; those under fit are held."""
    return ModelError(
        **{name: _between(low, getattr(wide, name), share) for name, low in vars(ModelError()).items()} | _HELD
    )


def _bounded_half_square(innovations: np.ndarray) -> np.ndarray:
    """Half of the square up to a bound, then a straight line (Huber): odd readings do not move the fit."""
    from scipy.special import huber

    return np.asarray(huber(_ODD, innovations))
