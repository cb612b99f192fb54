"""Recordings of a column on a bench, and the sampled model of the column that they are compared with."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar, rebuild
from tierod.core.errors import InputError
from tierod.core.graph.maths import exp, sqrt
from tierod.core.recording import Recording
from tierod.core.series import runs
from tierod.methods.analysis.consistency import white_noise
from tierod.methods.estimators.kernels import dot, plus, times
from tierod.methods.identification.experiment import Experiment
from tierod.models.steering_column import (
    ColumnInput,
    ColumnOutput,
    ColumnWithFriction,
    ColumnWithFrictionParameters,
    SteeringColumn,
)
from tierod.physics.friction import dahl_mean, dahl_update

OUTPUTS = ("steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
# Candidates for the input of the model; the first one that a recording contains is used
INPUTS = ("motor_torque", "motor_target_torque")
# Longest sampling interval [s], over three samples per period of the mode at 112 Hz; shortest duration [s]
SLOWEST, SHORTEST = 2.5e-3, 2.0
_FIRST = 20  # Number of samples from which the initial state is estimated
_STILL = 5.0  # Range of the wheel's angle over its noise, below which the wheel counts as locked
# Step of a recorded torque over the friction from which it is coarse; fewer levels belong to a test in steps
_COARSE, _LEVELS = 0.05, 20
# Smallest share of present samples of an output: every fourth sample, or the first quarter of a test
_LEAST_KNOWN = 0.25
# A channel is clipped if it stays at its extreme for this number of samples, in more than this share of all
_RUN, _SHARE = 20, 0.002


@dataclass(frozen=True, eq=False)
class BenchRecording:
    """A recording prepared for identification."""

    experiment: Experiment
    time: np.ndarray  # of the grid [s]
    deviation: tuple[float, ...]  # standard deviation of the noise of every output, from neighbouring samples
    remarks: tuple[str, ...] = ()

    @property
    def locked(self) -> bool:
        """Whether the steering wheel was locked."""
        return self.experiment.setting["wheel_freedom"] == 0.0

    @property
    def sample_time(self) -> float:
        """Sampling interval [s]."""
        return self.experiment.setting["sample_time"]

    def part(self, name: str, start: int, stop: int, parameters: BenchParameters) -> BenchRecording:
        """The samples from `start` to before `stop` as a separate experiment."""
        inputs, measured = self.experiment.inputs[start:stop], self.experiment.measured[start:stop]
        _require_known(name, measured)
        experiment = _experiment(name, inputs, measured, self.locked, self.sample_time, self.deviation, parameters)
        return replace(self, experiment=experiment, time=self.time[start:stop], remarks=())


def bench_recording(name: str, recording: Recording, parameters: BenchParameters) -> BenchRecording:
    """A recording of a column bench on a grid, with the state of its wheel (locked or free) and its noise."""
    driving = next((each for each in INPUTS if each in recording), None)
    missing = [each for each in OUTPUTS if each not in recording] + ([] if driving else ["motor_torque"])
    if missing or driving is None:
        raise InputError(
            f"{name} lacks {' and '.join(missing)}; the identification of a column needs the motor's torque "
            f"({' or '.join(INPUTS)}), {', '.join(OUTPUTS)}: name them in a channel map, or record them"
        )
    names = (driving, *OUTPUTS)
    step = max(_step(name, recording, each) for each in names)
    grid = _aligned(name, recording, names, step)
    inputs, measured = _without_gaps(name, driving, grid[:, 0]), grid[:, 1:].copy()
    _require_known(name, measured)
    remarks = [_rounded(name, driving, inputs, parameters.motor_friction)]
    remarks += [_cut_off(name, each, measured[:, k]) for k, each in enumerate(OUTPUTS)]
    deviation = tuple(white_noise(measured[:, k]) for k in range(len(OUTPUTS)))
    locked = _is_still(measured[:, 0], deviation[0])
    _require_motion(name, driving, inputs, measured, deviation, locked)
    time = np.arange(len(inputs)) * step
    experiment = _experiment(name, inputs[:, None], measured, locked, step, deviation, parameters)
    return BenchRecording(experiment, time, deviation, tuple(filter(None, remarks)))


def _step(name: str, recording: Recording, channel: str) -> float:
    time = recording[channel].time
    if len(time) < _FIRST or not time[-1] > time[0]:
        raise InputError(f"{name}: '{channel}' has {len(time)} samples; record at least {SHORTEST:g} s of motion")
    step = float(np.median(np.diff(time)))
    if step > 0.1:
        raise InputError(
            f"{name}: the samples of '{channel}' are {step:g} s apart, too far for a bench; if its stamps are in "
            "milliseconds, give them in seconds"
        )
    if not 2e-5 < step < SLOWEST * 1.01:
        raise InputError(
            f"{name}: the samples of '{channel}' are {1e3 * step:.3g} ms apart; a column swings at about 112 Hz, so "
            f"record every {1e3 * SLOWEST:g} ms or faster, at best every millisecond"
        )
    return step


def _aligned(name: str, recording: Recording, names: Sequence[str], step: float) -> np.ndarray:
    start = max(float(recording[each].time[0]) for each in names)
    stop = min(float(recording[each].time[-1]) for each in names)
    if stop - start < SHORTEST:
        raise InputError(
            f"{name} holds {max(stop - start, 0.0):.3g} s in which all channels are present; record at least "
            f"{SHORTEST:g} s of motion, at best 10 s or more"
        )
    rate = 1.0 / step
    held = recording.align(names[:1], rate, "hold", 3.0 * step, start, stop)
    between = recording.align(names[1:], rate, "linear", 3.0 * step, start, stop)
    return np.column_stack([held.values, between.values])


def _without_gaps(name: str, channel: str, values: np.ndarray) -> np.ndarray:
    known = np.isfinite(values)
    if known.mean() < 0.99 or not known[0]:
        raise InputError(
            f"{name}: '{channel}' is missing in {100.0 * (1.0 - known.mean()):.2g} % of the time; the input of the "
            "column must be known throughout: cut the recording, or record again"
        )
    return values[np.maximum.accumulate(np.where(known, np.arange(len(values)), 0))]


def _require_known(name: str, measured: np.ndarray) -> None:
    for each, share in zip(OUTPUTS, np.isfinite(measured).mean(axis=0), strict=True):
        if share < _LEAST_KNOWN:
            raise InputError(
                f"{name}: '{each}' is missing in {100.0 * (1.0 - share):.3g} % of the time; cut the recording to the "
                "part with this channel, or record again"
            )


def bridged(values: np.ndarray) -> np.ndarray:
    """Values with gaps bridged by linear interpolation."""
    index, known = np.arange(len(values)), np.isfinite(values)
    return np.asarray(np.interp(index, index[known], values[known]))


def _rounded(name: str, channel: str, values: np.ndarray, friction: float) -> str:
    """Remark on a motor torque that was recorded in coarse steps; empty if it was not."""
    levels = np.unique(values)
    step = float(np.min(np.diff(levels))) if len(levels) > 1 else 0.0
    if len(levels) < _LEVELS or step < _COARSE * friction:
        return ""
    return (
        f"{name}: '{channel}' is quantised in steps of {step:.2g} N·m, {100.0 * step / friction:.0f} % of the motor's "
        "friction; in slow ramps this looks like friction, and its stiffness may be wrong by as much: record it with "
        "finer steps"
    )


def _cut_off(name: str, channel: str, values: np.ndarray) -> str:
    """Set samples of a clipped channel to NaN, in place, and return a remark on it; empty if it is not clipped."""
    cut = np.zeros(len(values), bool)
    if np.nanmax(values) > np.nanmin(values):
        for extreme in (np.nanmax(values), np.nanmin(values)):
            at = values == extreme
            for first, last in zip(*runs(at), strict=True):
                cut[first:last] |= last - first >= _RUN and abs(extreme) > 0.0
    moving = len(np.unique(values)) > 100
    if cut.mean() < _SHARE or not moving:
        return ""
    values[cut] = np.nan
    return (
        f"{name}: '{channel}' stays at its largest value in {100.0 * cut.mean():.2g} % of the samples; they are "
        "treated as missing, since the sensor is at its limit"
    )


def _is_still(angle: np.ndarray, noise: float) -> bool:
    smooth = np.convolve(angle[np.isfinite(angle)], np.full(25, 0.04), mode="valid")
    return bool(np.ptp(smooth) < _STILL * noise + math.radians(0.02))


def _require_motion(
    name: str, driving: str, inputs: np.ndarray, measured: np.ndarray, deviation: Sequence[float], locked: bool
) -> None:
    if np.ptp(inputs) == 0.0:
        raise InputError(f"{name}: '{driving}' is constant at {inputs[0]:g} N·m; record a sweep, steps or ramps of it")
    constant = [
        each for k, each in enumerate(OUTPUTS) if k > 0 and np.nanmax(measured[:, k]) == np.nanmin(measured[:, k])
    ]
    if constant:
        raise InputError(f"{name}: '{constant[0]}' is constant throughout; check the sensor and the channel map")
    if _is_still(measured[:, 1], deviation[1]) or (locked and _is_still(measured[:, 2], deviation[2])):
        raise InputError(
            f"{name} does not excite the column: with a motor torque up to {np.max(np.abs(inputs)):.2g} N·m the motor "
            "hardly turns; record with at least twice the torque that the friction holds"
        )


def _experiment(
    name: str,
    inputs: np.ndarray,
    measured: np.ndarray,
    locked: bool,
    step: float,
    deviation: Sequence[float],
    p: BenchParameters,
) -> Experiment:
    first = np.arange(_FIRST) - 0.5 * (_FIRST - 1)
    known = np.column_stack([bridged(values)[:_FIRST] for values in measured.T])
    slopes = first @ known / (first @ first) / step
    angles = known.mean(axis=0) - slopes * step * 0.5 * (_FIRST - 1)
    wheel, motor, torque = float(angles[0]), float(angles[1]), float(angles[2])
    rate = math.sqrt(1.0 / (first @ first)) / step
    gear = wheel - torque / p.torsion_bar_stiffness
    bar = deviation[2] / p.torsion_bar_stiffness
    turning = (rate * deviation[1]) ** 2 + (0.1 * slopes[1]) ** 2
    mean = (
        0.0 if locked else float(slopes[0]),
        float(slopes[1]),
        float(slopes[1]) / p.motor_ratio,
        wheel,
        motor,
        gear,
        0.0,
    )
    variance = (
        1e-12 if locked else (rate * deviation[0]) ** 2 + (0.1 * slopes[0]) ** 2,
        turning,
        (rate * bar) ** 2 + turning / p.motor_ratio**2,
        deviation[0] ** 2,
        deviation[1] ** 2,
        bar**2 + 1e-6,
        0.3,
    )
    setting: Mapping[str, float] = {"wheel_freedom": 0.0 if locked else 1.0, "sample_time": step}
    return Experiment(name, inputs, measured, mean, tuple(map(float, variance)), setting)


# Terms of the power series of the matrix exponential, and halvings of its step: enough for steps up to about 5 ms with
# the fastest mode of 112 Hz
_TERMS, _HALVINGS = 8, 3
# Number of substeps for the path of the friction. With one, the identified stiffness of the friction is too high by
# 0.07 % on a noiseless bench, twice its standard deviation after 25 s; with three by a tenth of that.
_STROKES = 3
_MOTOR_ANGLE = 4
_Path = Callable[[Scalar], Scalar]


class BenchInput(NamedTuple):
    motor_torque: Annotated[float, "N*m"]


@dataclass(frozen=True)
class BenchParameters(ColumnWithFrictionParameters):
    motor_torque_gain: Annotated[float, ""] = 1.0  # true torque of the motor over the recorded one [-]
    motor_torque_offset: Annotated[float, "N*m"] = 0.0  # true torque less the recorded one [N m]
    driver_torque_offset: Annotated[float, "N*m"] = 0.0  # recorded torque of the bar less the true one [N m]
    wheel_freedom: Annotated[float, ""] = 1.0  # 1 for a free wheel, 0 for a locked one [-]
    sample_time: Annotated[float, "s"] = 1e-3  # sampling interval [s]
    # rotation of the motor within a sample over which `RoundedColumn` smooths the kink of the friction [rad]; about the
    # effect of a torque noise of 0.03 N m in a sample, and small against the Dahl angle
    rounding: Annotated[float, "rad"] = 2e-4


class SampledColumn:
    """The column with Dahl friction as a discrete model.

    The linear part is sampled exactly: the matrix exponential is computed from the parameters once, not in every step,
    so that the undamped mode of 112 Hz needs no substeps and keeps its frequency. The friction of a third of a sample
    is the Dahl mean over the path of the motor, which is predicted with the initial friction. If the motor reverses
    within it, the net rotation is used, which is too short by about a thousandth of the Dahl angle.

    Source: Raffone, eqs (1) to (4), corrected as in `SteeringColumn` and `ColumnWithFriction`.
    """

    State = ColumnWithFriction.State
    Input = BenchInput
    Output = ColumnOutput
    Parameters = BenchParameters

    @staticmethod
    def transition(x: ColumnWithFriction.State, u: BenchInput, p: BenchParameters) -> ColumnWithFriction.State:
        angle = _dahl_angle(p)
        step = replace(p, sample_time=p.sample_time / _STROKES)
        for _ in range(_STROKES):
            x = _advanced(
                x,
                u,
                step,
                lambda turned, share=x.normalised_friction: dahl_mean(share, turned, angle),  # type: ignore[misc]
                lambda turned, share=x.normalised_friction: dahl_update(share, turned, angle),  # type: ignore[misc]
            )
        return x

    @staticmethod
    def output(x: ColumnWithFriction.State, u: BenchInput, p: BenchParameters) -> ColumnOutput:
        none = ColumnInput(0.0, 0.0, 0.0)
        output = SteeringColumn.output(SteeringColumn.State(*x[:6]), none, p)
        return output._replace(driver_torque=output.driver_torque + p.driver_torque_offset)


class RoundedColumn(SampledColumn):
    """The sampled column with a smoothed kink of its friction, for the Jacobians of a filter, not for its mean.

    The slope of the friction is discontinuous where the motor reverses. With the slope at the estimated rate, the
    covariance of a filter, and with it the likelihood as a function of the parameters, is discontinuous too. Smoothing
    over the uncertain rotation makes it differentiable.
    """

    @staticmethod
    def transition(x: ColumnWithFriction.State, u: BenchInput, p: BenchParameters) -> ColumnWithFriction.State:
        share, angle = x.normalised_friction, _dahl_angle(p)

        def after(turned: Scalar) -> Scalar:
            length = sqrt(turned * turned + p.rounding * p.rounding)
            direction = turned / length
            return direction + (share - direction) * exp((p.rounding - length) / angle)

        return _advanced(x, u, p, lambda turned: 0.5 * (share + after(turned)), after)


def _dahl_angle(p: BenchParameters) -> Scalar:
    return p.motor_friction / p.motor_friction_stiffness


def _advanced(
    x: ColumnWithFriction.State, u: BenchInput, p: BenchParameters, mean: _Path, after: _Path
) -> ColumnWithFriction.State:
    rows, gains = _sampled(p)
    driving = p.motor_torque_gain * u.motor_torque + p.motor_torque_offset
    free = tuple(plus(dot(row, x[:6]), gain * driving) for row, gain in zip(rows, gains, strict=True))
    # The path is predicted with the friction at the start; the mean friction over it then corrects the step.
    held = gains[_MOTOR_ANGLE] * p.motor_friction * x.normalised_friction
    resisting = p.motor_friction * mean(free[_MOTOR_ANGLE] - held - x.motor_angle)
    ahead = [value - gain * resisting for value, gain in zip(free, gains, strict=True)]
    return rebuild(x, [*ahead, after(ahead[_MOTOR_ANGLE] - x.motor_angle)])


def _sampled(p: BenchParameters) -> tuple[list[list[Scalar]], list[Scalar]]:
    zero = SteeringColumn.State(*[0.0] * 6)
    units = [rebuild(zero, [float(i == j) for i in range(6)]) for j in range(6)]
    columns = [_slope(unit, 0.0, p) for unit in units] + [_slope(zero, 1.0, p)]
    step = p.sample_time / 2.0**_HALVINGS
    rows = [[times(column[i], step) for column in columns] for i in range(6)]
    whole = [[float(i == j) for j in range(7)] for i in range(7)]
    for term in range(_TERMS, 0, -1):
        grown = [[times(dot(row, column), 1.0 / term) for column in _columns(whole)] for row in rows]
        whole = [[plus(float(i == j), grown[i][j]) for j in range(7)] for i in range(6)] + [whole[6]]
    for _ in range(_HALVINGS):
        whole = [[dot(row, column) for column in _columns(whole)] for row in whole]
    return [row[:6] for row in whole[:6]], [row[6] for row in whole[:6]]


def _columns(matrix: list[list[Scalar]]) -> list[list[Scalar]]:
    return [list(column) for column in zip(*matrix, strict=True)]


def _slope(x: SteeringColumn.State, motor_torque: float, p: BenchParameters) -> list[Scalar]:
    slope = SteeringColumn.derivative(x, ColumnInput(motor_torque, 0.0, 0.0), p)
    wheel, motion = times(slope.steering_wheel_rate, p.wheel_freedom), slope.steering_wheel_angle
    return [wheel, slope.motor_speed, slope.gear_rate, times(motion, p.wheel_freedom), *slope[4:]]
