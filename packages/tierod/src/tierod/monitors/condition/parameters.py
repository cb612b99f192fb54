"""Estimation of a vehicle's parameters from minutes of fault-free driving, by the likelihood of its filter."""

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
from tierod.core.recording import Recording
from tierod.methods.identification.experiment import sandwich
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.filter_updates import logarithm
from tierod.monitors.condition.limits import RATE, aligned, moving
from tierod.monitors.condition.signals import ConditionSample, Measured
from tierod.monitors.condition.vehicle_filter import SENSOR_NOISE, LeaveOutFilter, ModelError
from tierod.vehicles import Parameter, Vehicle
from tierod.vehicles.vehicle import QUANTITIES

_OUTPUTS = len(AutomatedVehicle.Output._fields)
_STEP = 1e-3
"""Step of finite differences, in prior standard deviations [-]; small, since the cost is smooth and computed to all
digits."""
_ENOUGH = 3.0
"""Gain of log-likelihood below which the search ends [nat]; one standard deviation of a parameter is half a nat."""
_MOST_STEPS = 8  # most steps of one stage; most stages end after three to five
_LARGEST = 1.5
"""Largest step of a parameter, in prior standard deviations [-]; beyond it the linearisation is no longer valid."""
_ODD = 4.0
"""Normalised innovation from which the cost grows linearly and no longer with the square [-]; one in sixteen thousand
normal innovations exceeds it."""
_UNBOUNDED = 1e3
"""Bound of a normalised innovation in the filter [-]; in the fit the cost is bounded instead of the filter."""
_WIDENED = (1.0, 0.4, 0.0)  # share of the parameters' spread in the noises of the filter, by stage [-]
_HELD = {
    "yaw_rate_offset": 1e-5,
    "angle_offset": 1e-5,
    "wheel_speed_difference": 1e-6,
    "wheel_speed_scale": 1e-6,
    "drive_excess": 1e-6,
}
"""Standard deviations that hold slow states of the filter practically constant, so that the parameters take them."""


@dataclass(frozen=True)
class WhitenedInnovations:
    """Block whose outputs are the whitened innovations of a filter and their widths."""

    filter: LeaveOutFilter  # fault-free filter

    Sample = ConditionSample
    Output = named_tuple(
        "Output",
        [(f"whitened_{k}", Annotated[float, ""]) for k in range(_OUTPUTS)]
        + [(f"spread_{k}", Annotated[float, ""]) for k in range(_OUTPUTS)],
    )

    def init(self) -> LeaveOutFilter.State:
        return self.filter.init()

    def step(self, state: LeaveOutFilter.State, sample: ConditionSample) -> tuple[LeaveOutFilter.State, Tree]:
        after, seen = self.filter.corrected(state, sample)
        correction = seen.correction
        return after, self.Output(*correction.whitened, *(0.5 * logarithm(wide) for wide in correction.widening))


class Point(NamedTuple):
    """Cost of a set of parameters on the drives, with its derivatives."""

    cost: float  # negative log posterior density without its constant [nat]
    gradient: np.ndarray
    information: np.ndarray
    scores: list[np.ndarray]  # gradients of every sample, one array per drive
    squares: np.ndarray  # mean NIS of every reading
    samples: int  # number of samples


class Found(NamedTuple):
    """Result of a search."""

    names: tuple[str, ...]  # names of the free parameters
    values: np.ndarray  # values, deviations: estimates and their standard deviations, in SI units
    deviations: np.ndarray
    # before, after: mean log posterior per sample before and after the search, without its constant [nat]
    before: float
    after: float
    # mean NIS of every reading, wheel speeds first; near one is consistent, above one overconfident
    squares: np.ndarray
    steps: int  # number of steps
    converged: bool  # whether the last stage converged


class Search:
    """Damped Gauss-Newton search in units of prior standard deviations; one batch computes all finite differences."""

    def __init__(self, vehicle: Vehicle, drives: Sequence[np.ndarray], free: Sequence[str]):
        self.vehicle, self.drives = vehicle, drives
        known = {name: vehicle.parameters[name] for name in free if name in vehicle}
        self.names = tuple(name for name, each in known.items() if each.standard_deviation)
        if not self.names:
            raise InputError(
                f"the vehicle '{vehicle.name}' gives no standard deviation for any parameter that is calibrated "
                f"({', '.join(free[:3])}, ...); add standard_deviation beside the value of each"
            )
        self.centre = np.array([known[name].value for name in self.names])
        self.scale = np.array([known[name].standard_deviation or 0.0 for name in self.names])
        plausible = np.array([QUANTITIES[name].plausible for name in self.names]).T
        self.least, self.most = (plausible - self.centre) / self.scale
        self.stage = self.stages()[0]

    def stages(self) -> list[LeaveOutFilter]:
        """Filters of the stages, with decreasing noise.

        A filter whose noise includes the parameter errors has a single minimum of the cost; the last one has many local
        minima far from the best.
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
        values = dict(zip(self.names, (self.centre + self.scale * place).tolist(), strict=True))
        return WhitenedInnovations(replace(self.stage, vehicle=replace(self.stage.vehicle, **values)))

    def at(self, place: np.ndarray) -> Point:
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
            # Beyond the bound the cost is linear: such innovations have a gradient, but no curvature.
            counted = (moved[:, :, :_OUTPUTS] * (np.abs(surprise) < _ODD)).reshape(count, -1)
            widths = moved[:, :, _OUTPUTS:].reshape(count, -1)
            cost += float(np.sum(_bounded_half_square(surprise)) + np.sum(spread))
            gradient += scores[-1].sum(axis=0)
            # Fisher information of a normal density: derivatives of its logarithmic width count twice.
            information += counted @ counted.T + 2.0 * widths @ widths.T
            squares, samples = squares + np.sum(surprise**2, axis=0), samples + len(drive)
        return Point(cost, gradient, information, scores, squares / samples, samples)

    def cost(self, place: np.ndarray) -> float:
        """Cost at a point; infinite where the filter diverges."""
        total = 0.5 * place @ place
        for drive in self.drives:
            result = scan(self.block(place), drive).values
            total += float(np.sum(_bounded_half_square(result[:, :_OUTPUTS])) + np.sum(result[:, _OUTPUTS:]))
        return float(total) if np.isfinite(total) else np.inf

    def run(self, progress: Callable[[float], None]) -> Found:
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

    def _descend(self, place: np.ndarray) -> tuple[np.ndarray, Point, int, bool]:
        """Minimum of one stage: point, its cost and derivatives, number of steps, and whether it converged."""
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
    return usual * math.pow(wide / usual, share)


def _error_between(wide: ModelError, share: float) -> ModelError:
    """Model errors interpolated between the usual and the wide ones; slow states are held by `_HELD`."""
    return ModelError(
        **{name: _between(low, getattr(wide, name), share) for name, low in vars(ModelError()).items()} | _HELD
    )


def _bounded_half_square(innovations: np.ndarray) -> np.ndarray:
    """Huber loss, half the square up to a bound and then linear, so that outliers do not disturb the fit."""
    from scipy.special import huber

    return np.asarray(huber(_ODD, innovations))


FREE = (
    *("mass", "yaw_inertia", "front_cornering_stiffness", "rear_cornering_stiffness"),
    *("tyre_friction", "relaxation_length", "pneumatic_trail", "rolling_resistance"),
    *("column_inertia", "rack_damping", "rack_stiffness", "nominal_friction", "column_friction_angle", "roll_share"),
    *("wheel_speed_scale", "wheel_speed_difference", "yaw_rate_offset", "steering_wheel_angle_offset"),
    *("steering_shaft_torque_offset", "tie_rod_force_offset"),
    *("longitudinal_acceleration_offset", "lateral_acceleration_offset"),
)
"""Free parameters of the estimation; all others keep their values of the vehicle file."""

SOURCE = "calibrated on healthy driving"
LEAST_SECONDS = 60.0  # shortest driving time with which all parameters are identifiable [s]; five minutes are better


@dataclass(frozen=True, eq=False)
class Calibration:
    """Vehicle with estimated parameters."""

    vehicle: Vehicle  # vehicle with the estimates, their standard deviations and `SOURCE`
    found: Found  # result of the search


def calibrate(
    recordings: Sequence[Recording], vehicle: Vehicle, progress: Callable[[float], None] = lambda share: None
) -> Calibration:
    """Fit the parameters of a vehicle to fault-free drives.

    The values of the vehicle file with their standard deviations are the prior. Offsets and wheel differences, which
    the filter otherwise estimates as slow states, are held constant, so that the parameters take them.
    """
    drives = [aligned(each) for each in recordings]
    driven = sum(int(moving(each).sum()) for each in drives) / RATE
    if driven < LEAST_SECONDS:
        raise InputError(
            f"the recordings hold {driven:.0f} s of driving; calibration needs {LEAST_SECONDS:.0f} s, better five "
            "minutes with bends to both sides, accelerating and braking"
        )
    found = Search(vehicle, drives, _free(drives)).run(progress)
    return Calibration(_calibrated(vehicle, found), found)


def _free(drives: Sequence[np.ndarray]) -> tuple[str, ...]:
    """Free parameters; with one rear wheel alone the difference between both is not identifiable."""
    both = all(any(np.isfinite(each[:, wheel]).any() for each in drives) for wheel in range(2))
    return tuple(name for name in FREE if both or name != "wheel_speed_difference")


def _calibrated(vehicle: Vehicle, found: Found) -> Vehicle:
    parameters = dict(vehicle.parameters)
    for name, value, deviation in zip(found.names, found.values.tolist(), found.deviations.tolist(), strict=True):
        parameters[name] = Parameter(name, value, parameters[name].unit, deviation, SOURCE)
    return replace(vehicle, parameters=parameters)
