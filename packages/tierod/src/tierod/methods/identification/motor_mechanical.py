"""Inertia, damping and friction of a motor, and common mistakes in its recordings: signs, phases, poles, timing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.identification.experiment import Modulation, Rows, regress
from tierod.methods.identification.motor_electrical import Electrical, MotorRecording, Value, electrical_fit, held_fit
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


_MOST = 30_000  # Number of samples from the middle of a recording that are checked
# Unexplained share of the voltage above which mistakes are tried, since swapped currents of a fast motor leave only a
# fifth; share above which the recording is wrong in any case; residual with a mistake corrected over that without,
# below which the mistake is reported [-]
_LOOKED_INTO, _UNEXPLAINED, _BETTER = 0.05, 0.25, 0.4
_SURE = 3.0  # Standard deviations by which a resistance must be negative to be reported
_POLE_PAIRS = range(1, 13)  # Candidate numbers of pole pairs
# Candidate delays of the voltages [samples], if they belong to the step after or about a sample
_LATE = (-1.0, -0.5, 0.5, 1.0)
# Residual with shifted voltages over that without, below which they are shifted [-]. The averaging of two samples by a
# shift of half a sample must not count as an improvement.
_IN_TIME = 0.9


class _Slip(NamedTuple):
    recording: MotorRecording
    words: str


def refuse_slips(seen: MotorRecording, pole_pairs: float, expected: tuple[float, float, float]) -> None:
    """Check that currents, voltages and angle are consistent.

    Args: expected: resistance [ohm], inductance [H] and flux [V s] of the vehicle file.
    """
    part = _middle(seen)
    fit, share = electrical_fit([part], pole_pairs, expected)
    if share > _LOOKED_INTO:
        found = [(electrical_fit([slip.recording], pole_pairs, expected), slip) for slip in _slips(part, pole_pairs)]
        (best, left), slip = min(found, key=lambda each: each[0][1])
        if left < _BETTER * share and best.values[0] > -_SURE * best.deviations[0]:
            raise InputError(
                f"{seen.name}: currents, voltages and angle do not fit each other ({100.0 * share:.0f} % of the "
                f"voltage remains unexplained); {slip.words}, and {100.0 * left:.0f} % remain"
            )
    if share > _UNEXPLAINED:
        return
    if fit.values[0] < -_SURE * fit.deviations[0]:
        raise InputError(_opposite(seen.name, fit.values[0], fit.deviations[0], ""))
    held, _ = held_fit([part], pole_pairs, expected)
    unsure = not fit.deviations[0] < 0.25 * expected[0]
    if unsure and held.values[0] < -_SURE * held.deviations[0]:
        note = ", with the inductance of the vehicle file and the angle as recorded"
        raise InputError(_opposite(seen.name, held.values[0], held.deviations[0], note))


def in_time(
    seen: MotorRecording, pole_pairs: float, expected: tuple[float, float, float]
) -> tuple[MotorRecording, str]:
    """The recording with its voltages shifted to the right steps, and a remark; empty if they are not shifted.

    Args: expected: resistance [ohm], inductance [H] and flux [V s] of the vehicle file.
    """
    part = _middle(seen)

    def left(samples: float) -> float:
        return electrical_fit([_moved(part, samples)], pole_pairs, expected)[1]

    best = min(_LATE, key=left)
    if not left(best) < _IN_TIME * left(0.0):
        return seen, ""
    words = f"{abs(best):g} samples {'late' if best > 0.0 else 'early'}"
    return _moved(seen, best), (
        f"{seen.name}: the voltages are {words} and are shifted: a sample should hold their mean over the step that "
        "ends there; half a step changes the inductance by some per cent"
    )


def _moved(seen: MotorRecording, samples: float) -> MotorRecording:
    whole = int(np.floor(samples))
    padded = np.concatenate([[np.nan], seen.voltage, [np.nan, np.nan]])
    first = 1 + np.arange(len(seen.voltage)) + whole
    share = samples - whole
    ahead = padded[first + 1] if share else 0.0
    return replace(seen, voltage=(1.0 - share) * padded[first] + share * ahead)


def _opposite(name: str, value: float, deviation: float, note: str) -> str:
    return (
        f"{name}: the resistance is estimated at {value:.3g} ± {deviation:.2g} ohm{note}: the currents are counted "
        "positive out of the motor; give both of them 'sign = -1' in a channel map"
    )


def _middle(seen: MotorRecording) -> MotorRecording:
    start = max((len(seen.time) - _MOST) // 2, 0)
    part = slice(start, start + _MOST)

    def cut(values: np.ndarray | None) -> np.ndarray | None:
        return None if values is None else values[part]

    return replace(
        seen,
        time=seen.time[part],
        current=seen.current[part],
        voltage=seen.voltage[part],
        angle=seen.angle[part],
        temperature=cut(seen.temperature),
        load=None,
        torque=None,
    )


def _slips(seen: MotorRecording, pole_pairs: float) -> Iterator[_Slip]:
    both = replace(seen, current=np.conj(seen.current), voltage=np.conj(seen.voltage))
    yield _Slip(both, "the angle turns opposite to currents and voltages: change its sign, or swap two phases of both")
    yield _Slip(replace(seen, current=np.conj(seen.current)), "with two phases of the currents swapped they do")
    yield _Slip(replace(seen, voltage=np.conj(seen.voltage)), "with two phases of the voltages swapped they do")
    turned = replace(seen, current=1j * np.conj(seen.current))
    yield _Slip(turned, "with alpha and beta of the currents exchanged they do")
    turned = replace(seen, voltage=1j * np.conj(seen.voltage))
    yield _Slip(turned, "with alpha and beta of the voltages exchanged they do")
    yield _Slip(replace(seen, current=-seen.current), "with the currents counted the other way they do")
    for number in _POLE_PAIRS:
        if number == pole_pairs:
            continue
        if number == 1:
            words = "the angle is the electrical one: name it motor_angle_electrical, or check motor_pole_pairs (1?)"
        else:
            words = f"with motor_pole_pairs = {number} instead of {pole_pairs:g} they do"
        yield _Slip(replace(seen, angle=seen.angle * number / pole_pairs), words)
