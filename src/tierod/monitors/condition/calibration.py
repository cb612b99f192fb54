"""Parameters of a vehicle from a few minutes of healthy driving, by maximum likelihood of the healthy filter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.block import named_tuple
from tierod.errors import InputError
from tierod.graph import batch, scan
from tierod.identification.long_run import sandwich
from tierod.monitors.condition.lane import LeaveOutFilter
from tierod.monitors.condition.signals import ConditionSample
from tierod.monitors.condition.tuning import ModelError, SensorNoise
from tierod.monitors.condition.updates import logarithm
from tierod.recording import Recording
from tierod.vehicles import Parameter, Vehicle

FREE = (
    "mass",
    "yaw_inertia",
    "front_cornering_stiffness",
    "rear_cornering_stiffness",
    "tyre_friction",
    "relaxation_length",
    "pneumatic_trail",
    "rolling_resistance",
    "column_inertia",
    "rack_damping",
    "rack_stiffness",
    "nominal_friction",
    "column_friction_angle",
    "roll_share",
    "wheel_speed_scale",
    "wheel_speed_difference",
    "yaw_rate_offset",
    "steering_wheel_angle_offset",
    "steering_shaft_torque_offset",
    "tie_rod_force_offset",
    "longitudinal_acceleration_offset",
    "lateral_acceleration_offset",
)
"""What is looked for; all else of the vehicle stays as its file says."""

SOURCE = "calibrated on healthy driving"
MAXIMUM_AGE = 0.006
"""A reading older than this is missing, as it is for the monitor: a held one would be one that stands still [s]."""
LEAST_SECONDS = 60.0
"""Shortest drive that tells all parameters apart [s]; five minutes are better."""

_OUTPUTS = 8
_STEP = 1e-3
_ENOUGH = 3.0
_MOST_STEPS = 8
_ODD = 4.0
_UNBOUNDED = 1e3
_WIDENED = (1.0, 0.4, 0.0)
_HELD = {"yaw_rate_offset": 1e-5, "angle_offset": 1e-5, "wheel_speed_difference": 1e-6}


@dataclass(frozen=True)
class WhitenedInnovations:
    """What every reading says that the filter could not foresee, each by itself.

    Args:
        filter: the healthy one
    """

    filter: LeaveOutFilter

    Sample = ConditionSample
    Output = named_tuple(
        "Output",
        [(f"whitened_{k}", Annotated[float, ""]) for k in range(_OUTPUTS)]
        + [(f"spread_{k}", Annotated[float, ""]) for k in range(_OUTPUTS)],
    )

    def init(self) -> Any:
        """Of the filter."""
        return self.filter.init()

    def step(self, state: Any, sample: Any) -> tuple[Any, Any]:
        """Innovations over their standard deviations, and the logarithms of those over the sensors' noise."""
        after, seen = self.filter.corrected(state, sample)
        correction = seen.correction
        return after, self.Output(*correction.whitened, *(0.5 * logarithm(wide) for wide in correction.widening))


@dataclass(frozen=True, eq=False)
class Calibration:
    """What a calibration found.

    Args:
        vehicle: with the values found, their standard deviations and `SOURCE`
        names: of the parameters that were looked for
        values, deviations: of them, in SI units
        before, after: mean log likelihood of a sample, without its constant
        squares: mean squared innovation over its variance of every reading, wheel speeds first; one where the filter
            knows what it does not know
        steps: of the search
        converged: whether it came to an end
    """

    vehicle: Vehicle
    names: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    before: float
    after: float
    squares: np.ndarray
    steps: int
    converged: bool


def calibrate(
    recordings: Sequence[Recording], vehicle: Vehicle, progress: Callable[[float], None] = lambda share: None
) -> Calibration:
    """Fit the parameters of a vehicle to healthy drives.

    The values of the vehicle file count as known before, with their standard deviations. What a filter else learns
    slowly on the way (offsets, difference of the wheels) is held, so that it goes into the parameters.

    Args:
        recordings: of healthy driving, with bends, braking and both directions
        vehicle: where to start from
        progress: called with the share that is done

    Raises:
        InputError: less than a minute of driving
    """
    drives = [aligned(each) for each in recordings]
    moving = sum(float(np.sum(np.abs(np.nan_to_num(each[:, 0])) > 1.0)) for each in drives) / 100.0
    if moving < LEAST_SECONDS:
        raise InputError(
            f"the recordings hold {moving:.0f} s of driving; calibration needs {LEAST_SECONDS:.0f} s, better five "
            "minutes with bends to both sides, accelerating and braking"
        )
    return _Search(vehicle, drives).run(progress)


def is_calibrated(vehicle: Vehicle) -> bool:
    """Whether somebody has measured what wheels and sensors of a vehicle read; else its filters know that they do not.

    Args:
        vehicle: with the parameters of `AutomatedVehicle`
    """
    return "wheel_speed_scale" in vehicle and not vehicle.parameters["wheel_speed_scale"].assumed


def aligned(recording: Recording, rate: float = 100.0) -> np.ndarray:
    """The samples of a recording, one row each.

    Args:
        recording: with the signals of `ConditionSample`; what is missing is NaN
        rate: of the rows [Hz]
    """
    return recording.align(ConditionSample._fields, rate, maximum_age=MAXIMUM_AGE).values


class _Place(NamedTuple):
    cost: float
    gradient: np.ndarray
    information: np.ndarray
    scores: list[np.ndarray]
    squares: np.ndarray
    samples: int


class _Search:
    """Gauss-Newton in units of what is known before, all differences of one step as lanes of one batch."""

    def __init__(self, vehicle: Vehicle, drives: Sequence[np.ndarray]):
        self.vehicle, self.drives = vehicle, drives
        known = {name: vehicle.parameters[name] for name in FREE if name in vehicle}
        self.names = tuple(name for name, each in known.items() if each.standard_deviation)
        self.centre = np.array([known[name].value for name in self.names])
        self.scale = np.array([known[name].standard_deviation or 0.0 for name in self.names])
        self.stage = self.stages()[0]

    def stages(self) -> list[LeaveOutFilter]:
        """Filters to be fitted one after the other.

        A filter that takes wrong parameters for noise has one hill to climb, the last one has many far from its top.
        """
        wide = replace(LeaveOutFilter.of_vehicle(self.vehicle), influence=_UNBOUNDED)
        return [
            replace(
                wide,
                sensor_noise=_between(SensorNoise(), wide.sensor_noise, share),
                model_error=replace(_between(ModelError(), wide.model_error, share), **_HELD),
            )
            for share in _WIDENED
        ]

    def block(self, place: np.ndarray) -> WhitenedInnovations:
        """The innovations with the parameters of a place."""
        values = dict(zip(self.names, (self.centre + self.scale * place).tolist(), strict=True))
        return WhitenedInnovations(replace(self.stage, vehicle=replace(self.stage.vehicle, **values)))

    def at(self, place: np.ndarray) -> _Place:
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
        return _Place(cost, gradient, information, scores, squares / samples, samples)

    def cost(self, place: np.ndarray) -> float:
        """Cost alone."""
        total = 0.5 * place @ place
        for drive in self.drives:
            result = scan(self.block(place), drive).values
            total += float(np.sum(_bounded_half_square(result[:, :_OUTPUTS])) + np.sum(result[:, _OUTPUTS:]))
        return float(total) if np.isfinite(total) else np.inf

    def run(self, progress: Callable[[float], None]) -> Calibration:
        """The calibrated vehicle."""
        place, steps, converged = np.zeros(len(self.names)), 0, False
        stages = self.stages()
        self.stage = stages[-1]
        before = self.cost(place)
        for number, self.stage in enumerate(stages):
            place, here, more, converged = self._descend(place)
            steps += more
            progress((number + 1.0) / len(stages))
        deviations = np.sqrt(np.diag(sandwich(here.information, here.scores, np.eye(len(place)))))
        values, found = self.centre + self.scale * place, self.scale * deviations
        return Calibration(
            self._calibrated(values, found),
            self.names,
            values,
            found,
            -before / here.samples,
            -here.cost / here.samples,
            here.squares,
            steps,
            converged,
        )

    def _descend(self, place: np.ndarray) -> tuple[np.ndarray, _Place, int, bool]:
        """The lowest place of one stage, after so many steps, and whether it is the end of the way."""
        here, damping, steps, converged = self.at(place), 1e-3, 0, False
        while steps < _MOST_STEPS and not converged:
            steps += 1
            damped = here.information + damping * np.diag(np.diag(here.information))
            move = np.clip(-np.linalg.solve(damped, here.gradient), -1.5, 1.5)
            cost = self.cost(place + move)
            if cost < here.cost:
                converged = here.cost - cost < _ENOUGH
                place, damping = place + move, 0.2 * damping
                here = self.at(place)
            else:
                damping, converged = max(10.0 * damping, 1e-3), damping > 1e4
        return place, here, steps, converged

    def _calibrated(self, values: np.ndarray, deviations: np.ndarray) -> Vehicle:
        parameters = dict(self.vehicle.parameters)
        for name, value, deviation in zip(self.names, values.tolist(), deviations.tolist(), strict=True):
            parameters[name] = Parameter(name, value, parameters[name].unit, deviation, SOURCE)
        return replace(self.vehicle, parameters=parameters)


def _between(usual: Any, wide: Any, share: float) -> Any:
    """Noises at a share of the way from the usual to the wide ones, in logarithms."""
    ends = zip(vars(usual).items(), vars(wide).values(), strict=True)
    return type(usual)(**{name: low * (high / low) ** share for (name, low), high in ends})


def _bounded_half_square(surprise: np.ndarray) -> np.ndarray:
    """Half of the square up to a bound, then a straight line (Huber): odd readings do not move the fit."""
    size = np.abs(surprise)
    return np.where(size < _ODD, 0.5 * surprise**2, _ODD * size - 0.5 * _ODD * _ODD)
