"""Guaranteed intervals of a motor's resistance, inductance and flux, from bounds of the errors of its sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
from tierod.methods.identification.motor_recording import MotorRecording

Array = np.ndarray


class Bounded(NamedTuple):
    """Equations y = regressors p + error with bounded errors."""

    regressors: Array  # (rows, parameters)
    values: Array  # y, (rows,)
    bound: Array  # largest error independent of the parameters, (rows,)
    slope: Array  # largest error per parameter, (rows, parameters): the bound of the error of each regressor


class Box(NamedTuple):
    """Smallest and largest value of every parameter, (parameters,) each."""

    low: Array
    high: Array

    @property
    def middle(self) -> Array:
        """Centre of the box."""
        return np.asarray(0.5 * (self.low + self.high))

    @property
    def half_width(self) -> Array:
        """Half width of the box."""
        return np.asarray(0.5 * (self.high - self.low))


def feasible_box(rows: Bounded) -> Box:
    """The smallest box around all nonnegative parameters that equations and bounds allow.

    The set is a polytope: |y - regressors p| <= bound + slope p with p >= 0 is linear in p, and each side of the box is
    the optimum of a linear programme. It is valid if the bounds are: no distribution, independence or number of samples
    is assumed; with fewer rows it is larger, but still valid.

    Raises:
        ParameterError: shapes that differ, or bounds below zero
        InputError: no parameters are feasible, since a bound or the model is wrong; or some parameter is not bounded

    Source: Milanese and Vicino, Automatica 27 (1991) 997, section 3; errors in the regressors as in Cerone, IEEE Trans.
    Automatic Control 38 (1993) 1729, for parameters of known sign.
    """
    from scipy.optimize import linprog

    regressors, values, bound, slope = rows
    if not (regressors.shape == slope.shape and values.shape == bound.shape == regressors.shape[:1]):
        shapes = f"{regressors.shape}, {slope.shape}, {values.shape}, {bound.shape}"
        raise ParameterError(f"regressors, slopes, values and bounds of shapes {shapes} do not match")
    if (bound < 0.0).any() or (slope < 0.0).any():
        raise ParameterError("a bound of an error is below zero; give its largest size")
    scale = np.maximum(np.abs(regressors).max(axis=0, initial=0.0), 1e-300)
    matrix = np.concatenate([regressors - slope, -regressors - slope]) / scale
    right = np.concatenate([values + bound, bound - values])
    ends = []
    for place in range(regressors.shape[1]):
        for sign in (1.0, -1.0):
            cost = np.zeros(regressors.shape[1])
            cost[place] = sign
            found = linprog(cost, A_ub=matrix, b_ub=right, bounds=(0.0, None), method="highs")
            if found.status == 2:
                raise InputError(
                    "no parameters agree with all readings within their bounds: a bound is too small, or the model "
                    "does not hold; give larger bounds, or leave out what it does not describe"
                )
            if found.status != 0:
                raise InputError(
                    f"parameter {place + 1} of {regressors.shape[1]} is not bounded by these readings; record a drive "
                    "that excites it"
                )
            ends.append(sign * found.fun / scale[place])
    return Box(np.array(ends[::2]), np.array(ends[1::2]))


NAMES = ("motor_resistance", "motor_inductance", "motor_flux")  # Names of the parameters, in the order of the box

LENGTHS = (4, 16, 64)  # Lengths of the windows over which the voltage is integrated [samples]

MOST_ROWS = 20000  # Largest number of windows that are used; without the others the set is larger, but still guaranteed


@dataclass(frozen=True)
class MotorErrorBounds:
    """Largest errors of the measurements of a motor, with offsets and quantisation."""

    current: Annotated[float, "A", POSITIVE]  # of a current in the stator's axes
    voltage: Annotated[float, "V", POSITIVE]  # of the mean voltage of a step
    angle: Annotated[float, "rad", NOT_NEGATIVE]  # of the shaft
    # largest second derivative of a current, which is interpolated linearly between samples
    curvature: Annotated[float, "A/s**2", NOT_NEGATIVE]

    def __post_init__(self) -> None:
        check_ranges(self)


def guaranteed_motor(
    recordings: Sequence[MotorRecording],
    pole_pairs: float,
    errors: MotorErrorBounds,
    lengths: Sequence[int] = LENGTHS,
) -> Box:
    """Intervals that certainly contain resistance, inductance and flux, if all errors are within their bounds.

    Args:
        pole_pairs: electrical turns per turn of the shaft
        lengths: of the windows [samples]

    Validity: no saliency, no saturation, constant resistance and flux; the bound of the voltage has to cover errors of
    the model.

    Raises:
        InputError: too few samples; no parameters agree with all readings; or the drive does not bound one of them

    Source: Reinelt et al., section on models ("unknown-but-bounded approaches"), with eqs (17) and (18) integrated over
    windows.
    """
    rows = [_rows(seen, pole_pairs, errors, length) for seen in recordings for length in lengths]
    parts = [np.concatenate(each) for each in zip(*rows, strict=True)]
    if not len(parts[1]):
        raise InputError("the recordings hold no window without missing samples; record some seconds without gaps")
    thin = -(-len(parts[1]) // MOST_ROWS)
    return feasible_box(Bounded(*(each[::thin] for each in parts)))


def _rows(seen: MotorRecording, pole_pairs: float, errors: MotorErrorBounds, length: int) -> Bounded:
    """Integrals of (17) and (18) over all windows of a length in both stator axes, with the bounds of their errors."""
    starts = np.arange(0, len(seen.time) - length, max(length // 2, 1))
    ends, step = starts + length, seen.step

    def between(values: np.ndarray) -> np.ndarray:
        total = np.concatenate([[0.0], np.cumsum(values)])
        return np.asarray(step * (total[ends] - total[starts]))

    voltage = between(seen.voltage[1:])
    charge = between(0.5 * (seen.current[1:] + seen.current[:-1]))
    rotor = np.exp(1j * pole_pairs * seen.angle)
    columns = [charge, seen.current[ends] - seen.current[starts], rotor[ends] - rotor[starts]]
    whole = np.isfinite(voltage + sum(columns))
    regressors = np.stack([each[whole] for each in columns], axis=1)
    time = length * step
    # The trapezoidal rule has an error of up to step^3 / 12 times the second derivative in each step.
    slopes = (
        time * errors.current + length * step**3 / 12.0 * errors.curvature,
        2.0 * errors.current,
        2.0 * min(pole_pairs * errors.angle, 2.0),  # a component of a direction changes by 2 at most
    )
    count = 2 * int(whole.sum())
    return Bounded(
        np.concatenate([regressors.real, regressors.imag]),
        np.concatenate([voltage[whole].real, voltage[whole].imag]),
        np.full(count, time * errors.voltage),
        np.tile(slopes, (count, 1)),
    )
