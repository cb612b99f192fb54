"""Fit of a column: parameters of the wheel by instrumental variables, all others by maximum likelihood."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.identification.bench_recording import BenchRecording, bridged
from tierod.methods.identification.column_misfit import Misfit, misfit
from tierod.methods.identification.experiment import Estimate, Experiment, Found, Free
from tierod.methods.identification.fit_quality import blind_directions, refusal
from tierod.methods.identification.maximum_likelihood import MaximumLikelihood
from tierod.methods.identification.sampled_column import BenchParameters, RoundedColumn, SampledColumn
from tierod.methods.identification.wheel_side import WheelMotion, wheel_side
from tierod.models.steering_column import ColumnWithFrictionParameters

DEFAULT_FREE = ("steering_wheel_damping", "motor_damping", "motor_friction", "motor_friction_stiffness")
"""Parameters identified by default, as in Raffone, section 2.2: damping of wheel and motor, and Dahl friction."""
DESIGN = ("motor_ratio",)
"""Design parameters, which follow from numbers of teeth and are not identified."""
FRICTION = ("motor_friction", "motor_friction_stiffness")
WHEEL_SIDE = ("steering_wheel_inertia", "steering_wheel_damping")

_NUISANCES = (
    Free("motor_torque_gain", False, 0.1),
    Free("motor_torque_offset", False, 0.1),
    Free("driver_torque_offset", False, 0.2),
)
"""Nuisance parameters of the bench, with prior standard deviations, estimated together with the parameters."""
TORQUE_DEVIATION = 0.01
"""Initial standard deviation of the unrecorded torque at the motor per sample [N m]: noise of a good drive."""
_STARTS = tuple((friction, stiffness) for friction in (-1.4, -0.7, 0.7) for stiffness in (-1.1, 0.0, 1.1))
"""Further starts, as logarithms: friction from 1/4 to 2 times that of the vehicle file, its stiffness from 1/3 to 3."""
MOST_UNKNOWN = 0.2
"""Unrecorded torque over recorded torque, above which the model does not explain a recording [-]: another law of
friction gives a tenth, hands on the wheel more than half."""
LEAST_SHARE = 0.3
"""Torque of the motor's damping over the unrecorded torque, below which the damping counts as unidentified [-]: the
unrecorded torque is not exactly white, and its part that correlates with the speed would appear as damping."""
LONGEST_GAP, SHORTEST_STRETCH = 0.01, 1.0
"""Longest gap in a signal of the wheel that is bridged linearly [s], a third of its smoothing time; shortest stretch
between longer gaps that is used [s], several times the 0.36 s that the smoothing takes."""

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
    """The maximum-likelihood search for parameters of a column.

    Args:
        known: relative standard deviations of parameters with a prior: they may vary, so that their uncertainty is
            included in that of the others
        widened: whether the noises are enlarged, for a rough start
    """
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
        """Fit the recordings, from all starts or from an earlier fit `near`.

        Raises:
            InputError: a parameter that the recordings do not identify
        """
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
