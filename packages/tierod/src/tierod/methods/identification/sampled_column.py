"""A steering column on a bench as a discrete model: exact for the linear part, with Dahl friction along the path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, rebuild
from tierod.core.graph.maths import exp, sqrt
from tierod.methods.estimators.linear_algebra import dot, plus, times
from tierod.models.steering_column import (
    ColumnInput,
    ColumnOutput,
    ColumnWithFriction,
    ColumnWithFrictionParameters,
    SteeringColumn,
)
from tierod.physics.friction import dahl_mean, dahl_update

_TERMS, _HALVINGS = 8, 3
"""Terms of the power series of the matrix exponential, and halvings of its step: enough for steps up to about 5 ms with
the fastest mode of 112 Hz."""

_STROKES = 3
"""Number of substeps for the path of the friction. With one, the identified stiffness of the friction is too high by
0.07 % on a noiseless bench, twice its standard deviation after 25 s; with three by a tenth of that."""

_MOTOR_ANGLE = 4
_Path = Callable[[Scalar], Scalar]


class BenchInput(NamedTuple):
    """Input of a column on a bench: the recorded torque of the motor."""

    motor_torque: Annotated[float, "N*m"]


@dataclass(frozen=True)
class BenchParameters(ColumnWithFrictionParameters):
    """A column with dry friction at the motor, and parameters of the bench."""

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
