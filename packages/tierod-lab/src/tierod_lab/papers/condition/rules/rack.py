"""Racks of the demonstrator: stiff as one body, and two bodies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple

from tierod.core.block import Model, Scalar, Tree, leaves, rebuild, require_continuous, skeleton, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.analysis import jacobian
from tierod.core.graph.maths import absolute, cos, exp, sin, sqrt, where
from tierod.models.linear import sampled_model
from tierod.physics.friction import smooth_coulomb
from tierod.physics.steering import column_balance
from tierod_lab.ground.laws import lash_torque


class StiffRack:
    """Column and rack that turn together, driven by a torque at the column against the tie rods.

    Validity: below some 100 Hz; the two bodies oscillate on their teeth at 666 Hz. The rack's 3 kg, which would add
    0.3 % to the inertia, are neglected. Source: Li, Frey, Gauterin, eq (2), its rows added with the rack's position as
    ratio times angle, as in eq (5) (printed inverted).
    """

    class State(NamedTuple):
        steering_wheel_angle: Annotated[float, "rad"]
        steering_wheel_rate: Annotated[float, "rad/s"]

    class Input(NamedTuple):
        steering_shaft_torque: Annotated[float, "N*m"]
        tie_rod_force: Annotated[float, "N"]

    class Output(NamedTuple):
        steering_wheel_angle: Annotated[float, "rad"]

    @dataclass(frozen=True)
    class Parameters:
        """Inertia, rack and friction."""

        column_inertia: Annotated[float, "kg*m**2"]  # of everything that turns with the column
        rack_stiffness: Annotated[float, "N/m"]  # of the rack towards its centre
        rack_damping: Annotated[float, "N*s/m"]  # of the rack
        rack_ratio: Annotated[float, "m/rad"]  # rack travel per turn of the column
        nominal_friction: Annotated[float, "N*m"]  # dry friction of the fault-free steering at the column
        friction_width: Annotated[float, "rad/s"] = 0.2  # rate at which the smoothed friction has 76 % of its level

    @staticmethod
    def derivative(x: State, u: Input, p: Parameters) -> State:
        friction = smooth_coulomb(x.steering_wheel_rate, p.nominal_friction, p.friction_width)
        left = column_balance(
            u.steering_shaft_torque,
            friction,
            u.tie_rod_force,
            x.steering_wheel_angle,
            x.steering_wheel_rate,
            p.rack_ratio,
            p.rack_stiffness,
            p.rack_damping,
        )
        return StiffRack.State(x.steering_wheel_rate, left / p.column_inertia)

    @staticmethod
    def output(x: State, u: Input, p: Parameters) -> Output:
        return StiffRack.Output(x.steering_wheel_angle)


class TwoBodyRack:
    """Column and rack with four states, driven by a torque at the column against the tie rods.

    Validity: any frequency, if the sampling is fast enough for the oscillation of the teeth (666 Hz with Table A1).
    Source: Li, Frey, Gauterin, eqs (2) to (4). There `i` must be the rack's travel per angle, and the first row lacks
    it before the force of the teeth; eq (3) is correct.
    """

    class State(NamedTuple):
        rack_position: Annotated[float, "m"]
        steering_wheel_angle: Annotated[float, "rad"]
        rack_speed: Annotated[float, "m/s"]
        steering_wheel_rate: Annotated[float, "rad/s"]

    Input = StiffRack.Input

    class Output(NamedTuple):
        rack_position: Annotated[float, "m"]
        steering_wheel_angle: Annotated[float, "rad"]

    @dataclass(frozen=True)
    class Parameters(StiffRack.Parameters):
        """Parameters of `StiffRack`, mass of the rack, and teeth between column and rack; defaults from Table A1."""

        rack_mass: Annotated[float, "kg"] = 3.0  # of the rack, m_R
        # tooth_stiffness, tooth_damping: of the teeth at the rack, k_TT and d_TT
        tooth_stiffness: Annotated[float, "N/m"] = 1e8
        tooth_damping: Annotated[float, "N*s/m"] = 1e3

    @staticmethod
    def derivative(x: State, u: StiffRack.Input, p: Parameters) -> State:
        travel = p.rack_ratio
        friction = smooth_coulomb(x.steering_wheel_rate, p.nominal_friction, p.friction_width)
        twist = travel * x.steering_wheel_angle - x.rack_position
        teeth = lash_torque(
            twist, travel * x.steering_wheel_rate - x.rack_speed, p.tooth_stiffness, p.tooth_damping, 0.0
        )
        centring = p.rack_stiffness * x.rack_position + p.rack_damping * x.rack_speed
        return TwoBodyRack.State(
            x.rack_speed,
            x.steering_wheel_rate,
            (teeth - centring - u.tie_rod_force) / p.rack_mass,
            (u.steering_shaft_torque - friction - travel * teeth) / p.column_inertia,
        )

    @staticmethod
    def output(x: State, u: StiffRack.Input, p: Parameters) -> Output:
        return TwoBodyRack.Output(x.rack_position, x.steering_wheel_angle)


_SMALL = 1e-8  # squared half difference of the eigenvalues times the step; below, the series is exact to rounding
_SINGULAR = 1e-8  # product of the eigenvalues times the squared step; below, one counts as zero: error 2e-9 at most
_SHORT = 1e-2  # eigenvalue times the step; below, four terms of the series have an error of 2e-11


@lru_cache(maxsize=64)
def discretise_pair(model: Model) -> Model:
    """A model of two states discretised by the exponential of its Jacobian, with inputs constant over a sample.

    Returns:
        a discrete model with the same State, Input and Output; its Parameters are `continuous` (those of the model)
        and `sample_time` [s]

    Raises:
        ParameterError: not two states, or a model that is not continuous

    Validity: exact for a model that is linear in its state, including one or two integrators; stable for any step if
    the model is. Source: x + h phi(h A) f(x), phi(Z) = (exp(Z) - 1) / Z, by the Cayley-Hamilton theorem.
    """
    require_continuous(model)
    count = len(list(leaves(skeleton(model.State))))
    if count != 2:
        raise ParameterError(
            f"{model.__name__} has {count} states; this exponential is of two: take tierod.models.linear"
        )

    def transition(x: Tree, u: Tree, p: Tree) -> Tree:
        def slope(at: Tree) -> Tree:
            return model.derivative(at, u, p.continuous)

        moved = _mean_slope(jacobian(slope, x), values_of(slope(x)), p.sample_time)
        return rebuild(x, [a + p.sample_time * b for (_, a), b in zip(leaves(x), moved, strict=True)])

    return sampled_model(model, "exponential", transition)


def _mean_slope(rows: list[list[Scalar]], slope: list[Scalar], step: Scalar) -> tuple[Scalar, Scalar]:
    (a, b), (c, d) = [[step * each for each in row] for row in rows]
    middle, spread = 0.5 * (a + d), 0.5 * (a - d)
    even, odd = _halves(middle, spread * spread + b * c)
    first = (
        even * slope[0] + odd * (spread * slope[0] + b * slope[1]) - slope[0],
        even * slope[1] + odd * (c * slope[0] - spread * slope[1]) - slope[1],
    )
    determinant = a * d - b * c
    apart = absolute(determinant) > _SINGULAR
    inverse = 1.0 / where(apart, determinant, 1.0)
    whole = (inverse * (d * first[0] - b * first[1]), inverse * (a * first[1] - c * first[0]))
    share = _of_one_eigenvalue(2.0 * middle)
    single = (slope[0] + share * (a * slope[0] + b * slope[1]), slope[1] + share * (c * slope[0] + d * slope[1]))
    return where(apart, whole[0], single[0]), where(apart, whole[1], single[1])


def _of_one_eigenvalue(value: Scalar) -> Scalar:
    away = absolute(value) > _SHORT
    safe = where(away, value, 1.0)
    series = 0.5 + value * (1.0 / 6.0 + value * (1.0 / 24.0 + value / 120.0))
    return where(away, (exp(safe) - 1.0 - safe) / (safe * safe), series)


def _halves(middle: Scalar, square: Scalar) -> tuple[Scalar, Scalar]:
    """exp(middle) times cosh(root) and sinh(root) / root, where the square of the root may be negative.

    Each eigenvalue has its own exponential, since the hyperbolic functions of a stiff pair would overflow.
    """
    away = absolute(square) > _SMALL
    root = sqrt(where(away, absolute(square), 1.0))
    apart = where(square > 0.0, root, 0.0)
    slow, fast, grown = exp(middle + apart), exp(middle - apart), exp(middle)
    real = (0.5 * (slow + fast), 0.5 * (slow - fast) / root)
    turning = (grown * cos(root), grown * sin(root) / root)
    series = (grown * (1.0 + 0.5 * square), grown * (1.0 + square / 6.0))
    return tuple(  # type: ignore[return-value]
        where(away, where(square > 0.0, p, q), s) for p, q, s in zip(real, turning, series, strict=True)
    )


Rows = list[list[Scalar]]

_DEGREE = 6  # of the Taylor series of the smallest step; after squaring the error is 2e-7 of that step's norm at most


@lru_cache(maxsize=64)
def discretise_stiff(model: Model, squarings: int, at: Tree = None) -> Model:
    """A model discretised by the exponential of its Jacobian, with inputs constant over a sample.

    Args:
        squarings: number of squarings; the series is taken over the sample divided by 2 to this power, and the row sums
            of the Jacobian times that part of a sample have to stay below 0.5
        at: state at which the Jacobian is taken; None takes it at every state. If the model is linear except for a few
            terms, a fixed Jacobian depends on tuning alone and is computed once, before all samples; those terms are
            then explicit, of first order, and must not be stiff

    Returns:
        a discrete model with the same State, Input and Output; its Parameters are `continuous` (those of the model)
        and `sample_time` [s]

    Raises:
        ParameterError: less than one squaring, or a model that is not continuous

    Validity: exact for a model that is linear in its state, however stiff; otherwise of second order (first with a
    fixed Jacobian). Source: exponential Rosenbrock-Euler method, x + h phi(h A) f(x); phi by the exponential of
    [[h A, h f], [0, 0]]; Hochbruck and Ostermann, Acta Numerica 19 (2010) 209, eq (2.58).
    """
    require_continuous(model)
    if squarings < 1:
        raise ParameterError(f"squarings is {squarings}; expected at least 1")

    def transition(x: Tree, u: Tree, p: Tree) -> Tree:
        def slope(state: Tree) -> Tree:
            return model.derivative(state, u, p.continuous)

        part = p.sample_time / 2.0**squarings
        rows = [[part * each for each in row] for row in jacobian(slope, x if at is None else at)]
        mean = _mean_exponential(rows, squarings)
        rates = values_of(slope(x))
        moved = [p.sample_time * _total([a * b for a, b in zip(row, rates, strict=True)]) for row in mean]
        return rebuild(x, [a + b for (_, a), b in zip(leaves(x), moved, strict=True)])

    return sampled_model(model, "stiffly", transition)


def _mean_exponential(rows: Rows, squarings: int) -> Rows:
    """phi(Z 2^squarings) = (exp(Z 2^s) - 1) / (Z 2^s): the mean of the exponential over a sample.

    Every doubling of the step: phi <- (phi + exp phi) / 2, exp <- exp^2. This needs no inverse of Z, which does not
    exist for a free body.
    """
    count = len(rows)
    one: Rows = [[1.0 if i == j else 0.0 for j in range(count)] for i in range(count)]
    mean = one
    for order in range(_DEGREE, 1, -1):
        mean = _sum(one, _product(rows, mean), 1.0 / order)
    whole = _sum(one, _product(rows, mean), 1.0)
    for number in range(squarings):
        mean = [[0.5 * each for each in row] for row in _sum(mean, _product(whole, mean), 1.0)]
        if number + 1 < squarings:
            whole = _product(whole, whole)
    return mean


def _sum(left: Rows, right: Rows, factor: float) -> Rows:
    return [[a + factor * b for a, b in zip(x, y, strict=True)] for x, y in zip(left, right, strict=True)]


def _product(left: Rows, right: Rows) -> Rows:
    columns = list(zip(*right, strict=True))
    return [[_total([a * b for a, b in zip(row, column, strict=True)]) for column in columns] for row in left]


def _total(values: list[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for value in values:
        total = total + value
    return total
