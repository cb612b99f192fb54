"""Fit of a column: parameters of the wheel by instrumental variables, all others by maximum likelihood."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.analysis.consistency import white_noise
from tierod.methods.identification.bench_recording import (
    BenchParameters,
    BenchRecording,
    RoundedColumn,
    SampledColumn,
    bridged,
)
from tierod.methods.identification.column_misfit import Misfit, misfit
from tierod.methods.identification.experiment import (
    Estimate,
    Experiment,
    Found,
    Free,
    blind_directions,
    instrumental,
    refusal,
)
from tierod.methods.identification.maximum_likelihood import MaximumLikelihood
from tierod.models.steering_column import ColumnWithFrictionParameters

# Standard deviation of the Gaussian smoothing in time [s]. It passes motion up to about 5 Hz, which separates inertia
# from damping, and limits the noise of the second derivative, which falls with its power of -2.5. With a noise of 0.05
# degrees the inertia from 16 s of motion scatters by 0.3 % at 8 ms and by 0.04 % from 24 ms on.
SMOOTHING = 0.03


class WheelMotion(NamedTuple):
    """One recording with a free wheel, on a uniform grid."""

    steering_wheel_angle: np.ndarray  # [rad]
    motor_angle: np.ndarray  # divided by the ratio of the gear [rad]; the instrument
    bar_torque: np.ndarray  # [N m], positive towards left
    sample_time: float  # sampling interval [s]


class WheelSide(NamedTuple):
    """Estimate of the wheel's inertia and damping; the inertia is NaN if it was given."""

    inertia: float  # J_sw [kg m^2]
    damping: float  # beta_sw [N m s/rad]
    inertia_deviation: float
    damping_deviation: float
    residual: float  # root mean square residual torque after smoothing [N m]
    strength: float


def wheel_side(recordings: Sequence[WheelMotion], inertia: float | None = None) -> WheelSide:
    """Fit of J w' + beta w + bar torque = constant, smoothed, with derivatives of the motor's angle as instruments.

    Smoothing and differentiation are weightings with a Gaussian curve and its derivatives, the same for all signals, so
    that no noisy signal is differentiated. The noise of the wheel's angle in the regressors would bias the coefficients
    towards zero; the motor's angle follows the wheel, but has independent noise.

    The standard deviations are the larger of two: the estimate for autocorrelated residuals, which is inaccurate after
    a few slow oscillations, and the one from the white noise of both sensors, propagated through the smoothing.

    Source: Raffone, eq (1) with T_driver = 0. Args: inertia: known inertia [kg m^2]; None to estimate it.
    """
    targets, regressors, instruments = [], [], []
    for each in recordings:
        weights = _weights(each.sample_time)
        torque = -_weighted(each.bar_torque, weights[0])
        known, seen = (
            [_weighted(angle - angle[0], weight) for weight in weights[1:]]
            for angle in (each.steering_wheel_angle, each.motor_angle)
        )
        if inertia is not None:
            torque = torque - inertia * known[1]
            known, seen = known[:1], seen[:1]
        constant = np.ones(len(torque))
        targets.append(torque)
        regressors.append(np.column_stack([*known, constant]))
        instruments.append(np.column_stack([*seen, constant]))
    found = instrumental(targets, regressors, instruments)
    both = inertia is None
    moments = float(found.values[1]) if inertia is None else inertia
    noises = [_noise(each, z, moments, found.values[0]) for each, z in zip(recordings, instruments, strict=True)]
    white = np.sum(noises, axis=0)
    sensors = found.inverse @ white @ found.inverse.T
    spread = np.sqrt(np.maximum(np.diag(found.covariance), np.diag(sensors)))
    return WheelSide(
        float(found.values[1]) if both else math.nan,
        float(found.values[0]),
        float(spread[1]) if both else math.nan,
        float(spread[0]),
        found.residual,
        found.strength,
    )


def _noise(motion: WheelMotion, instruments: np.ndarray, inertia: float, damping: float) -> np.ndarray:
    curve, first, second = (weight[::-1] for weight in _weights(motion.sample_time))
    torque = np.array([np.convolve(z, curve) for z in instruments.T]) * white_noise(motion.bar_torque)
    through = inertia * second + damping * first
    angle = np.array([np.convolve(z, through) for z in instruments.T]) * white_noise(motion.steering_wheel_angle)
    return torque @ torque.T + angle @ angle.T


def _weights(sample_time: float) -> list[np.ndarray]:
    reach = math.ceil(6.0 * SMOOTHING / sample_time)
    time = np.arange(-reach, reach + 1) * sample_time
    curve = np.exp(-0.5 * (time / SMOOTHING) ** 2) * sample_time / (SMOOTHING * math.sqrt(2.0 * math.pi))
    first = -time / SMOOTHING**2 * curve
    second = (time**2 / SMOOTHING**4 - 1.0 / SMOOTHING**2) * curve
    return [curve, first, second]


def _weighted(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.convolve(values, weights, mode="valid")


# Parameters identified by default, as in Raffone, section 2.2: damping of wheel and motor, and Dahl friction
DEFAULT_FREE = ("steering_wheel_damping", "motor_damping", "motor_friction", "motor_friction_stiffness")
DESIGN = ("motor_ratio",)  # Design parameters, which follow from numbers of teeth and are not identified
FRICTION = ("motor_friction", "motor_friction_stiffness")
WHEEL_SIDE = ("steering_wheel_inertia", "steering_wheel_damping")

# Nuisance parameters of the bench, with prior standard deviations, estimated together with the parameters
_NUISANCES = (
    Free("motor_torque_gain", False, 0.1),
    Free("motor_torque_offset", False, 0.1),
    Free("driver_torque_offset", False, 0.2),
)
# Initial standard deviation of the unrecorded torque at the motor per sample [N m]: noise of a good drive
TORQUE_DEVIATION = 0.01
# Further starts, as logarithms: friction from 1/4 to 2 times that of the vehicle file, its stiffness from 1/3 to 3
_STARTS = tuple((friction, stiffness) for friction in (-1.4, -0.7, 0.7) for stiffness in (-1.1, 0.0, 1.1))
# Unrecorded torque over recorded torque, above which the model does not explain a recording [-]: another law of
# friction gives a tenth, hands on the wheel more than half
MOST_UNKNOWN = 0.2
# Torque of the motor's damping over the unrecorded torque, below which the damping counts as unidentified [-]: the
# unrecorded torque is not exactly white, and its part that correlates with the speed would appear as damping
LEAST_SHARE = 0.3
# Longest gap in a signal of the wheel that is bridged linearly [s], a third of its smoothing time; shortest stretch
# between longer gaps that is used [s], several times the 0.36 s that the smoothing takes
LONGEST_GAP, SHORTEST_STRETCH = 0.01, 1.0

CURES = {
    "steering_wheel_inertia": "a sweep with the wheel free and no hands on it",
    "steering_wheel_damping": "a sweep with the wheel free and no hands on it",
    "torsion_bar_stiffness": "a sweep with the wheel free beside one with the wheel locked",
    "gear_stiffness": "a sweep up to 150 Hz",
    "gear_inertia": "a sweep up to 150 Hz",
    "motor_inertia": "a sweep with the wheel free, up to 20 Hz",
    "motor_damping": "fast motion, a sweep or steps with the wheel free",
    "motor_friction": "slow ramps of the motor's torque to and fro, with twice the torque that the friction holds",
    "motor_friction_stiffness": (
        "slow ramps of the motor's torque to and fro with the wheel locked, from less than the friction on"
    ),
}

Progress = Callable[[float], None]


def known_free() -> tuple[str, ...]:
    """Names of the parameters that can be identified."""
    return tuple(each.name for each in fields(ColumnWithFrictionParameters) if each.name not in DESIGN)


def search_of(
    parameters: BenchParameters,
    names: Sequence[str],
    rows: Sequence[BenchRecording],
    widened: bool = False,
    known: Mapping[str, float] | None = None,
) -> MaximumLikelihood:
    free = (*(Free(name) for name in names), *_NUISANCES, *(Free(n, spread=s) for n, s in (known or {}).items()))
    places = {name: k for k, name in enumerate(names)}
    starts = []
    for friction, stiffness in _STARTS:
        start = np.zeros(len(free))
        for name, shift in zip(FRICTION, (friction, stiffness), strict=True):
            if name in places:
                start[places[name]] = shift
        starts.append(tuple(start.tolist()))
    noise = np.max([row.deviation for row in rows], axis=0)
    factor = (5.0, 3.0) if widened else (1.0, 1.0)
    return MaximumLikelihood(
        SampledColumn,
        parameters,
        free,
        (factor[0] * TORQUE_DEVIATION,),
        tuple((factor[1] * noise).tolist()),
        RoundedColumn,
        starts=tuple(dict.fromkeys(starts)) if places.keys() & set(FRICTION) else (),
    )


@dataclass(frozen=True, eq=False)
class Fitted:
    """Result of one fit: parameters of the wheel by instruments, and the maximum-likelihood estimate of the others."""

    base: BenchParameters
    wanted: tuple[str, ...]
    wheel: Mapping[str, tuple[float, float]]
    estimate: Estimate
    remarks: tuple[str, ...]

    @property
    def parameters(self) -> BenchParameters:
        """Parameters of the column with the identified values."""
        found = self.estimate.parameters(self.base)
        return replace(found, **{name: value for name, (value, _) in self.wheel.items()})

    def found(self, deviations: Mapping[str, float | None]) -> list[Found]:
        """The identified parameters, before and after; `deviations` are those of the vehicle file."""
        rows = []
        for name in (each for each in known_free() if each in self.wanted):
            before = getattr(self.base, name), deviations.get(name)
            if name in self.wheel:
                rows.append(Found.normal(name, before, *self.wheel[name], "instruments"))
            else:
                ends = self.estimate.interval(name)
                value, deviation = self.estimate[name], self.estimate.deviation(name)
                rows.append(Found(name, *before, value, deviation, *ends, "likelihood"))
        return rows


@dataclass(frozen=True)
class ColumnFit:
    """Fit of a column: the parameters at the start, and the names of those to be identified."""

    parameters: BenchParameters
    wanted: tuple[str, ...]

    def run(
        self, rows: Sequence[BenchRecording], progress: Progress = lambda share: None, near: Fitted | None = None
    ) -> Fitted:
        """Fit the recordings, from all starts or from an earlier fit `near`."""
        wheel, remarks = self._wheel(rows)
        base = replace(self.parameters, **{name: value for name, (value, _) in wheel.items()})
        names = tuple(name for name in self.wanted if name not in wheel)
        search = search_of(base, names, rows, known={name: spread / value for name, (value, spread) in wheel.items()})
        experiments = [row.experiment for row in rows]
        start = None if near is None else search.place_of(near.estimate)
        estimate = search.fit(experiments, start, progress)
        if near is None:
            unidentified = _unidentified(estimate, names, rows)
            remarks += _bench_remarks(estimate, experiments)
            if unidentified or not estimate.converged or is_unexplained(estimate, experiments):
                wrong = misfit(search, estimate, experiments, [each for each in known_free() if each not in wheel])
                if unidentified:
                    raise InputError(_does_not_fit(wrong) if wrong else unidentified)
                remarks += [_does_not_fit(wrong)] if wrong else []
        return Fitted(self.parameters, self.wanted, wheel, estimate, tuple(remarks))

    def _wheel(self, rows: Sequence[BenchRecording]) -> tuple[dict[str, tuple[float, float]], list[str]]:
        motions = [each for row in rows if not row.locked for each in _motions(row, self.parameters.motor_ratio)]
        if not motions:
            return {}, []
        both = wheel_side(motions)
        known = self.parameters.steering_wheel_inertia
        wanted, remarks = [name for name in WHEEL_SIDE if name in self.wanted], []
        if "steering_wheel_inertia" not in wanted:
            if abs(both.inertia - known) > max(5.0 * both.inertia_deviation, 0.02 * known):
                remarks.append(
                    f"the wheel turns as if its inertia were {both.inertia:.4g} kg·m², not {known:.4g} as in the "
                    "vehicle file: check for hands on the wheel; without hands, add steering_wheel_inertia to --free"
                )
            if not wanted:
                return {}, remarks
            alone = wheel_side(motions, known)
            return {"steering_wheel_damping": (alone.damping, alone.damping_deviation)}, remarks
        values = {
            "steering_wheel_inertia": (both.inertia, both.inertia_deviation),
            "steering_wheel_damping": (both.damping, both.damping_deviation),
        }
        return {name: values[name] for name in wanted}, remarks


def _unidentified(estimate: Estimate, names: Sequence[str], rows: Sequence[BenchRecording]) -> str:
    """Message on unidentified parameters and what to record instead; empty if all are identified."""
    blind = blind_directions(estimate, names)
    if blind:
        return refusal(blind, [row.experiment.name for row in rows], CURES)
    return _slow(estimate, rows) if "motor_damping" in names else ""


def _does_not_fit(wrong: Misfit) -> str:
    return (
        f"{wrong.name}, held at {wrong.held:.3g} as in the vehicle file, does not fit: near {wrong.likelier:.2g} the "
        "recordings are far more likely, and until it is corrected they identify nothing else; add it to --free, or "
        "correct the vehicle file"
    )


def _slow(estimate: Estimate, rows: Sequence[BenchRecording]) -> str:
    """Message on a motor damping whose torque is too small against the unrecorded one; empty if it is not."""
    smooth = np.full(10, 0.1)
    turned = [
        np.diff(np.convolve(bridged(row.experiment.measured[:, 1]), smooth, "valid")) / row.sample_time for row in rows
    ]
    speed = float(np.sqrt(np.mean(np.concatenate(turned) ** 2)))
    likely = min(estimate["motor_damping"], estimate.start[estimate.index("motor_damping")])
    torque, unknown = likely * speed, estimate.input_deviation[0]
    if torque >= LEAST_SHARE * unknown:
        return ""
    return (
        f"the recordings do not excite motor_damping ({', '.join(row.experiment.name for row in rows)}): at "
        f"{speed:.2g} rad/s on average it causes {torque:.2g} N·m, against {unknown:.2g} N·m unrecorded (noise, "
        f"rounding, cogging); also record {CURES['motor_damping']}, or leave it out of --free"
    )


def _motions(row: BenchRecording, ratio: float) -> list[WheelMotion]:
    measured, step = row.experiment.measured, row.sample_time
    there = np.flatnonzero(np.isfinite(measured).all(axis=1))
    found = []
    for part in np.split(there, np.flatnonzero(np.diff(there) * step > LONGEST_GAP) + 1):
        if len(part) and (part[-1] - part[0]) * step > SHORTEST_STRETCH:
            wheel, motor, torque = (bridged(values) for values in measured[part[0] : part[-1] + 1].T)
            found.append(WheelMotion(wheel, motor / ratio, torque, step))
    return found


def _driving(experiments: Sequence[Experiment]) -> float:
    """Root mean square of the recorded torque [N m]."""
    return float(np.sqrt(np.mean(np.concatenate([each.inputs for each in experiments]) ** 2)))


def is_unexplained(estimate: Estimate, experiments: Sequence[Experiment]) -> bool:
    """Whether the estimated unrecorded torque is too large for the model to explain the recordings."""
    return estimate.input_deviation[0] > MOST_UNKNOWN * _driving(experiments)


def _bench_remarks(estimate: Estimate, experiments: Sequence[Experiment]) -> list[str]:
    gain, spread = estimate["motor_torque_gain"], estimate.deviation("motor_torque_gain")
    remarks = []
    if abs(gain - 1.0) > max(3.0 * spread, 0.002):
        remarks.append(
            f"the motor gives {100.0 * gain:.2f} ± {100.0 * spread:.2g} % of the recorded torque, judged by torsion "
            "bar and inertia; the parameters are those of the true torque"
        )
    driving, unknown = _driving(experiments), estimate.input_deviation[0]
    if is_unexplained(estimate, experiments):
        remarks.append(
            f"an unrecorded torque of {unknown:.2g} N·m at the motor moves the column besides the recorded "
            f"{driving:.2g} N·m: the model explains these recordings badly; check channels, vehicle file and time base"
        )
    if not estimate.converged:
        remarks.append("the search did not converge; the errors of the values may exceed their standard deviations")
    return remarks
