"""Ratio of the motor's torque to the driver's from ordinary drives: where the balance of torques closes at all speeds.

The driver's torque T and the motor's Tm act on one column, T + n Tm = X c + error, with X the terms of road, friction
and motion. Both torques answer the error, so that a regression of T on Tm gives far too little. What the error does not
follow are road and friction times functions of speed: the assist, which falls with speed, shares the same load
otherwise between driver and motor. Of all n the one is taken whose remainder those products explain least (limited
information maximum likelihood: Anderson and Rubin, Annals of Mathematical Statistics 20, 1949), and of all angles over
which friction builds up the one with the least remainder.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import exp, hypot, log
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.io.derive import complete
from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.balance_rows import BalanceRows
from tierod.monitors.friction.conditioning import SAMPLE_TIME
from tierod.monitors.friction.signals import SteeringSample
from tierod.vehicles import Vehicle

NAME = "motor_ratio"
TERMS = (
    *("finite", "exponential", "long", "aligning_torque", "squared_aligning_torque", "weight", "turn_slip", "drive"),
    *("loaded_friction", "rate", "acceleration"),
)
"""Of `Regressors`, on the side of road, friction and motion."""
SHORTEST, LONGEST, STEPS = 0.006, 0.06, 10
"""Angles over which friction builds up [rad], and steps of the first search between them."""
STRIDE = 10
"""Of the samples: nothing is faster than the low-pass."""
MODEL_ERROR = 0.09
"""Relative, of the balance: root mean square over ten drives of 13 minutes of six virtual cars (seed 77001); 0.03 but
for the van and the large car, whose gears are pressed harder than the balance knows."""
LEAST = 300.0
"""Driving with all signals that is needed [s]."""
PARTS = 5
"""Of the drives, each left out once for the standard deviation."""


class DriveRatio(NamedTuple):
    """Motor ratio as identified by drives, the vehicle file left out.

    Args:
        value: turns of the motor per turn of the column []
        deviation: standard deviation []
        dahl_angle: over which friction builds up [rad]
    """

    value: Annotated[float, ""]
    deviation: Annotated[float, ""]
    dahl_angle: Annotated[float, "rad"]


class _Balance(NamedTuple):
    """Samples of drives: both torques, terms of the other side, and these times functions of speed."""

    torques: np.ndarray
    terms: np.ndarray
    instruments: np.ndarray


def ratio_of_drives(
    recordings: Mapping[str, Recording], vehicle: Vehicle, progress: Callable[[float], None] = lambda share: None
) -> DriveRatio | None:
    """The ratio by drives alone; None where they or the vehicle file lack the data for it.

    Args:
        recordings: ordinary drives of one car by name
        vehicle: with the parameters of the friction monitor, torques in N*m
        progress: called with the share that is done
    """
    samples = [each for each in map(_samples, recordings.values()) if each is not None]
    if not vehicle.calibrated or not samples:
        return None
    try:
        parameters = replace(vehicle.parameters_for(FrictionParameters), sample_time=SAMPLE_TIME)
    except ParameterError:
        return None
    places = np.linspace(log(SHORTEST), log(LONGEST), STEPS).tolist()
    # A parabola through the best and its neighbours, then through closer ones.
    finer = 0.25 * (places[1] - places[0])
    found: dict[float, float] = {}
    for number, place in enumerate(places):
        found[place] = _left(_balance(samples, parameters, exp(place)))
        progress(0.7 * (number + 1) / STEPS)
    best = min(found, key=found.__getitem__)
    near = {best + k * finer: _left(_balance(samples, parameters, exp(best + k * finer))) for k in (-2, -1, 0, 1, 2)}
    progress(0.95)
    angle = exp(_lowest(near, finer))
    balance = _balance(samples, parameters, angle)
    if len(balance.torques) * STRIDE * SAMPLE_TIME < LEAST:
        return None
    return _with_deviation(balance, angle)


def _samples(recording: Recording) -> np.ndarray | None:
    whole = complete(recording, SteeringSample._fields)
    if any(name not in whole for name in SteeringSample._fields):
        return None
    return whole.align(SteeringSample._fields, 1.0 / SAMPLE_TIME, maximum_age=0.1).values


def _balance(samples: Sequence[np.ndarray], parameters: FrictionParameters, angle: float) -> _Balance:
    parts = [_of_drive(each, parameters, angle) for each in samples]
    return _Balance(*(np.concatenate([getattr(each, name) for each in parts]) for name in _Balance._fields))


def _of_drive(samples: np.ndarray, parameters: FrictionParameters, angle: float) -> _Balance:
    result = scan(BalanceRows(parameters, angle), samples)
    used = np.flatnonzero(result["used"] > 0.0)[::STRIDE]
    terms = {name: result[f"terms.{name}"][used] for name in (*TERMS, "driver_torque", "motor_torque")}
    speed = result["speed"][used]
    aligning = terms["aligning_torque"]
    # Tyres lean on their trail a little less, the faster a bend is driven: roll steer, and the load that it moves.
    columns = np.column_stack(
        [*(terms[name] for name in TERMS), aligning**3, aligning * speed / 30.0, np.ones(len(used))]
    )
    shares = (1.0 / (1.0 + speed / 10.0), 1.0 / (1.0 + speed / 25.0), speed / 30.0)
    instruments = np.column_stack([columns, *(columns * share[:, None] for share in shares)])
    return _Balance(np.column_stack([terms["driver_torque"], terms["motor_torque"]]), columns, instruments)


def _ratio(balance: _Balance) -> tuple[float, float]:
    """The ratio, and the unexplained share of the driving torque's power []; infinite where none closes the balance."""
    own, wide = (_beside(balance.torques, each) for each in (balance.terms, balance.instruments))
    left, explained = own.T @ own, wide.T @ wide
    try:
        values, vectors = np.linalg.eig(np.linalg.solve(explained, left))
    except np.linalg.LinAlgError:
        return np.nan, np.inf
    driver, motor = vectors[:, int(np.argmin(values.real))].real
    if not driver * motor > 0.0:
        return np.nan, np.inf
    both = np.array([1.0, motor / driver])
    power = both @ np.cov(balance.torques.T) @ both
    return float(both[1]), float(both @ left @ both / power) / len(balance.torques)


def _beside(torques: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Part of the torques that the columns do not explain."""
    size = np.linalg.norm(columns, axis=0)
    basis, _ = np.linalg.qr(columns[:, size > 0.0] / size[size > 0.0])
    return np.asarray(torques - basis @ (basis.T @ torques))


def _left(balance: _Balance) -> float:
    return _ratio(balance)[1] if len(balance.torques) > balance.instruments.shape[1] else np.inf


def _lowest(found: Mapping[float, float], step: float) -> float:
    """Minimum of a parabola through the lowest value and its neighbours; the lowest place at an end."""
    places = sorted(found)
    at = min(range(len(places)), key=lambda k: found[places[k]])
    if not 0 < at < len(places) - 1:
        return places[at]
    before, here, after = (found[places[at + k]] for k in (-1, 0, 1))
    bend = before - 2.0 * here + after
    return places[at] + (0.5 * step * (before - after) / bend if np.isfinite(bend) and bend > 0.0 else 0.0)


def _with_deviation(balance: _Balance, angle: float) -> DriveRatio | None:
    """Standard deviation by leaving out parts of the drives (jackknife), beside the error of the model."""
    value, _ = _ratio(balance)
    part = np.arange(len(balance.torques)) * PARTS // len(balance.torques)
    without = [_ratio(_Balance(*(each[part != k] for each in balance)))[0] for k in range(PARTS)]
    if not np.isfinite([value, *without]).all():
        return None
    spread = float(np.sqrt((PARTS - 1.0) * np.mean(np.square(np.subtract(without, value)))))
    return DriveRatio(value, hypot(spread, MODEL_ERROR * value), angle)
