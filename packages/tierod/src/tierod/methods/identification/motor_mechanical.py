"""Inertia, damping and dry friction of a motor from torque and angle; ratio of measured torque to that of currents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tierod.methods.identification.experiment import Modulation, Rows, regress
from tierod.methods.identification.motor_electrical import Electrical, MotorRecording, Value
from tierod.physics.friction import dahl_update
from tierod.physics.motor import torque_constant

# Time step to which signals are averaged [s], short against the motion of a rotor; length of a window [s]
_STEP, _WINDOW = 1e-3, 0.04
# Largest number of intervals in which a load is linear in the angle; their smallest width [rad]
_KNOTS, _APART = 32, 0.1
_REACHES = (2e-3, 0.5)  # Smallest and largest angle of the build-up of dry friction [rad]
_SLOTS = 6.0  # Periods of the cogging torque per electrical turn, for the usual 3 slots per pole pair
# Relative uncertainty of the stiffness, by reversals between averaged samples [-]: the effect of a doubled step
_SAMPLED = 0.005
_MOVED = 1e-2  # Relative step of the build-up angle for its derivative


class Course(NamedTuple):
    """Measured and explained torque of a recording over time."""

    name: str
    time: np.ndarray  # [s], (n,)
    driving: np.ndarray  # torque of flux and current, less a measured load [N m], (n,)
    explained: np.ndarray  # torque of inertia, friction and a load as a function of the angle [N m], (n,)


@dataclass(frozen=True, eq=False)
class Mechanical:
    """Parameters of the shaft from torque and angle."""

    inertia: Value  # of the rotor and everything on its shaft [kg m^2]
    damping: Value  # viscous [N m s/rad]
    friction: Value  # level of dry friction [N m]
    stiffness: Value  # initial stiffness of the build-up of dry friction [N m/rad]
    turned: float  # total rotation of the shaft [rad]
    residual: float  # root mean square of the unexplained torque [N m]
    courses: tuple[Course, ...]


def identify_mechanical(recordings: Sequence[MotorRecording], electrical: Electrical, pole_pairs: float) -> Mechanical:
    """Inertia, damping and dry friction under a load that is measured or an arbitrary function of the angle.

    The torque is that of flux and current. An unmeasured load is a piecewise linear function of the angle, so that a
    spring does not count as friction; torque that depends on the direction of rotation is friction. The build-up angle
    of friction minimises the residuals. The standard deviations include half of the change with half as many intervals
    and samples.

    Source: Reinelt et al., eq (14) with 3/2 c_M and dry friction; P. Dahl, Aerospace Corp. TOR-0158 (1968).
    """
    from scipy.optimize import minimize_scalar

    shafts = [_Shaft(each, electrical, pole_pairs) for each in recordings]
    found = minimize_scalar(
        lambda x: _left(shafts, float(np.exp(x))), bounds=np.log(_REACHES), method="bounded", options={"xatol": 5e-3}
    )
    best = float(found.x)
    rows = _rows(shafts, float(np.exp(best)))
    fit = regress(rows)
    coarse = regress(_rows([_Shaft(each, electrical, pole_pairs, 0.5) for each in recordings], float(np.exp(best))))
    bent = 0.5 * (coarse.values[:3] - fit.values[:3])
    ahead, behind = (_rows(shafts, float(np.exp(best + side * _MOVED))) for side in (1.0, -1.0))
    wider = []
    for row, more, less in zip(rows, ahead, behind, strict=True):
        slope = fit.values[2] * (more.regressors[:, 2] - less.regressors[:, 2]) / (2.0 * _MOVED)
        columns = np.column_stack([row.regressors, slope])
        wider.append(Rows(row.target, columns, columns))
    whole = regress(wider)
    inertia, damping, friction = fit.values[:3]
    covariance = whole.covariance[np.ix_([0, 1, 2, -1], [0, 1, 2, -1])]
    scale = electrical.flux.deviation / max(electrical.flux.value, 1e-12)
    covariance[:3, :3] += np.outer(bent, bent)
    deviations = np.sqrt(np.diag(covariance)[:3] + (scale * fit.values[:3]) ** 2)
    reach = float(np.exp(best))
    along = np.array([1.0, -friction]) / reach
    stiffness = float(np.sqrt(max(along @ covariance[2:, 2:] @ along, 0.0)))
    stiffness = float(np.hypot(stiffness, _SAMPLED * friction / reach))
    at_edge = min(abs(best - np.log(each)) for each in _REACHES) < 0.05
    return Mechanical(
        Value(float(inertia), float(deviations[0])),
        Value(float(damping), float(deviations[1])),
        Value(float(friction), float(deviations[2])),
        Value(float(friction) / reach, np.inf if at_edge else stiffness),
        sum(shaft.turned for shaft in shafts),
        fit.residual,
        tuple(
            Course(shaft.name, shaft.time[shaft.known], row.target, row.regressors @ fit.values)
            for shaft, row in zip(shafts, rows, strict=True)
        ),
    )


class _Shaft:
    """One recording at a lower rate, with all regressors that do not depend on the build-up angle of friction."""

    def __init__(self, seen: MotorRecording, electrical: Electrical, pole_pairs: float, fineness: float = 1.0) -> None:
        many = max(round(_STEP / fineness / seen.step), 1)
        self._many, self._count = many, len(seen.time) // many
        step = many * seen.step
        length = max(round(_WINDOW / step), 12)
        self.window = Modulation(length, max(length // 4, 1), step)
        self.name, self.time = seen.name, self.window.mean(self._slower(seen.time))
        own = seen.current * np.exp(-1j * (pole_pairs * seen.angle + electrical.zero.value))
        saliency = 0.0
        if electrical.inductance_q is not None:
            saliency = electrical.inductance.value - electrical.inductance_q.value
        torque = torque_constant(pole_pairs, electrical.flux.value + saliency * own.real) * own.imag
        self.angle = self._slower(seen.angle)
        load = None if seen.load is None else self._slower(seen.load)
        driving = self._slower(torque) - (0.0 if load is None else load)
        self.target = self.window.mean(driving)
        electrical_angle = _SLOTS * (pole_pairs * self.angle + electrical.zero.value)
        others = [
            np.cos(electrical_angle),
            np.sin(electrical_angle),
            *self._loads(0 if load is not None else int(fineness * _KNOTS)),
        ]
        self.moving = [self.window.acceleration(self.angle), self.window.rate(self.angle)]
        self.others = [self.window.mean(each) for each in others]
        self.known = np.isfinite(self.target + sum(self.moving))

    def _slower(self, values: np.ndarray) -> np.ndarray:
        return np.asarray(values[: self._many * self._count].reshape(self._count, self._many).mean(axis=1))

    def _loads(self, most: int) -> list[np.ndarray]:
        low, high = float(np.nanmin(self.angle)), float(np.nanmax(self.angle))
        count = int(min((high - low) / _APART, most))
        if count < 1:
            return [np.ones_like(self.angle)]
        places = np.linspace(low, high, count + 1)
        return [np.interp(self.angle, places, one) for one in np.eye(count + 1)]

    @cached_property
    def steps(self) -> np.ndarray:
        """Increments of the angle from sample to sample [rad]; zero over a gap."""
        return np.nan_to_num(np.diff(self.angle))

    @property
    def turned(self) -> float:
        """Total rotation of the shaft [rad]."""
        return float(np.sum(np.abs(np.diff(self.angle[:: self.window.length])))) if len(self.angle) else 0.0

    def friction(self, reach: float) -> np.ndarray:
        """Dahl friction over its level, for a build-up angle `reach` [rad]."""
        # An update is linear in the friction before it, so that the coefficients of all steps are computed at once.
        gained, kept = dahl_update(0.0, self.steps, reach), dahl_update(1.0, self.steps, reach)
        share, out = 0.0, [0.0]
        for gain, keep in zip(gained.tolist(), (kept - gained).tolist(), strict=True):
            share = gain + keep * share
            out.append(share)
        return np.array(out)


def _rows(shafts: Sequence[_Shaft], reach: float) -> list[Rows]:
    counts = [len(shaft.others) for shaft in shafts]
    rows = []
    for number, shaft in enumerate(shafts):
        own = np.column_stack([*shaft.moving, shaft.window.mean(shaft.friction(reach))])
        nuisance = np.zeros((len(own), sum(counts)))
        start = sum(counts[:number])
        nuisance[:, start : start + counts[number]] = np.column_stack(shaft.others)
        columns = np.column_stack([own, nuisance])[shaft.known]
        rows.append(Rows(shaft.target[shaft.known], columns, columns))
    return rows


def _left(shafts: Sequence[_Shaft], reach: float) -> float:
    rows = _rows(shafts, reach)
    columns = np.concatenate([each.regressors for each in rows])
    target = np.concatenate([each.target for each in rows])
    values = np.linalg.lstsq(columns, target, rcond=1e-10)[0]
    return float(np.sum((target - columns @ values) ** 2))


def torque_ratio(seen: Sequence[MotorRecording], electrical: Electrical, pole_pairs: float) -> Value | None:
    """Ratio of the measured torque of the motor to that of flux and current; None without one of them."""
    if "motor_flux" in electrical.blind:
        return None
    rows = []
    for each in seen:
        if each.torque is None:
            continue
        time, measured = each.torque
        across = (each.current * np.exp(-1j * (pole_pairs * each.angle + electrical.zero.value))).imag
        expected = np.interp(time, each.time, torque_constant(pole_pairs, electrical.flux.value) * across)
        known = np.isfinite(expected + measured)
        columns = np.column_stack([expected, np.ones_like(expected)])[known]
        if np.ptp(columns[:, 0]) > 0.0:
            rows.append(Rows(measured[known], columns, columns))
    if not rows:
        return None
    fit = regress(rows)
    unsure = electrical.flux.deviation / electrical.flux.value
    return Value(float(fit.values[0]), float(np.hypot(fit.deviations[0], unsure * fit.values[0])))
