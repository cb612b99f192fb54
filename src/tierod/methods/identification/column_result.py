"""What the identification of a column finds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tierod.methods.identification.experiment import Estimate
from tierod.methods.identification.fit_quality import Whiteness


@dataclass(frozen=True)
class Found:
    """A parameter before and after.

    Args:
        name: as in a vehicle file
        before, before_deviation: of the vehicle file; the value is NaN, and the deviation None, where it says none
        value, deviation: found
        low, high: ends of the 95 % interval
        method: "instruments" or "likelihood"
    """

    name: str
    before: float
    before_deviation: float | None
    value: float
    deviation: float
    low: float
    high: float
    method: str

    @property
    def change(self) -> float:
        """Of the value, over that before; NaN where that was zero."""
        return self.value / self.before - 1.0 if self.before else math.nan


@dataclass(frozen=True)
class LeftOut:
    """An experiment left out of the fit.

    Args:
        name: of the experiment
        values: of the parameters from all others, by name
        errors: simulated against measured output of the experiment, normalised, by output
    """

    name: str
    values: Mapping[str, float]
    errors: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Shown:
    """An experiment with its simulation, for charts.

    Args:
        name: of the experiment
        locked: whether its wheel was
        time: [s]
        motor_torque: [N m]
        measured, simulated: outputs, (n, outputs)
        residuals: standardised innovations, (n, outputs)
        friction: at the motor as simulated [N m]
        errors: simulated against measured output, normalised, by output
    """

    name: str
    locked: bool
    time: np.ndarray
    motor_torque: np.ndarray
    measured: np.ndarray
    simulated: np.ndarray
    residuals: np.ndarray
    friction: np.ndarray
    errors: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class ColumnIdentification:
    """What was found of a column.

    Args:
        found: parameters, in the order of the vehicle file
        estimate: of the likelihood; its free parameters and what the bench adds
        left_out: one entry per experiment
        shown: every experiment with its simulation
        whiteness: of the innovations, by output
        remarks: what was noticed
        explained: whether the model explains the recordings
    """

    found: tuple[Found, ...]
    estimate: Estimate
    left_out: tuple[LeftOut, ...]
    shown: tuple[Shown, ...]
    whiteness: Mapping[str, Whiteness]
    remarks: tuple[str, ...]
    explained: bool = True

    @property
    def doubt(self) -> str:
        """Why the values may not be used; empty where they may."""
        if not self.explained:
            return "the model does not explain these recordings"
        return "" if self.estimate.converged else "the search did not come to an end"
