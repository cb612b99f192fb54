"""Models behind the residuals: rack and single track, discretised exactly, and their filters."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Model, Scalar, Tree, leaves, rebuild, require_continuous, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.trace import jacobian
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.linear import sampled_model
from tierod.models.single_track import SingleTrack
from tierod.physics.steering import column_balance
from tierod_lab.ground.laws import lash_torque, smooth_coulomb
from tierod_lab.methods.unscented import UnscentedFilter

Rows = list[list[Scalar]]

_DEGREE = 6  # of the Taylor series of the smallest step; after squaring the error is 2e-7 of that step's norm at most


@lru_cache(maxsize=64)
def discretise_stiff(model: Model, squarings: int = 6, at: Tree = None) -> Model:
    """A model discretised by the exponential of its Jacobian, with inputs constant over a sample.

    Args:
        squarings: the series is taken over the sample divided by 2 to this power, and the row sums of the Jacobian
            times that part of a sample have to stay below 0.5
        at: state at which the Jacobian is taken; None takes it at every state. A fixed Jacobian depends on tuning alone
            and is computed once, before all samples; terms that are not linear are then explicit, of first order

    Returns:
        a discrete model with the same State, Input and Output; its Parameters are `continuous` (those of the model)
        and `sample_time` [s]

    Raises:
        ParameterError: less than one squaring, or a model that is not continuous

    Validity: exact for a model that is linear in its state, however stiff; otherwise of second order (first with a
    fixed Jacobian). Source: exponential Rosenbrock-Euler method, x + h phi(h A) f(x); Hochbruck and Ostermann, Acta
    Numerica 19 (2010) 209, eq (2.58).
    """
    require_continuous(model)
    if squarings < 1:
        raise ParameterError(f"squarings is {squarings}; expected at least 1")

    def transition(x: Tree, u: Tree, p: Tree) -> Tree:
        def slope(state: Tree) -> Tree:
            return model.derivative(state, u, p.continuous)

        part = p.sample_time / 2.0**squarings
        rows = [[part * each for each in row] for row in jacobian(slope, x if at is None else at)]
        rates = values_of(slope(x))
        moved = [
            p.sample_time * _total([a * b for a, b in zip(row, rates, strict=True)])
            for row in _mean_exponential(rows, squarings)
        ]
        return rebuild(x, [a + b for (_, a), b in zip(leaves(x), moved, strict=True)])

    return sampled_model(model, "stiffly", transition)


def _mean_exponential(rows: Rows, squarings: int) -> Rows:
    """phi(Z 2^s) = (exp(Z 2^s) - 1) / (Z 2^s): the mean of the exponential over a sample.

    Every doubling of the step: phi <- (phi + exp phi) / 2, exp <- exp^2. This needs no inverse of Z, which does not
    exist for a free body.
    """
    one: Rows = [[1.0 if i == j else 0.0 for j in range(len(rows))] for i in range(len(rows))]
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
    return sum(values[1:], start=values[0])


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
        rack_damping: Annotated[float, "N*s/m"]
        rack_ratio: Annotated[float, "m/rad"]  # rack travel per turn of the column
        nominal_friction: Annotated[float, "N*m"]  # dry friction of the fault-free steering at the column
        friction_width: Annotated[float, "rad/s"] = 0.2  # rate at which the smoothed friction has 76 % of its level

    @staticmethod
    def derivative(x: State, u: Input, p: Parameters) -> State:
        friction = smooth_coulomb(x.steering_wheel_rate, p.nominal_friction, p.friction_width)
        turning = x.steering_wheel_angle, x.steering_wheel_rate
        rack = p.rack_ratio, p.rack_stiffness, p.rack_damping
        left = column_balance(u.steering_shaft_torque, friction, u.tie_rod_force, *turning, *rack)
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
        """Parameters of `StiffRack`, and from Table A1 the mass of the rack and the teeth between column and rack."""

        rack_mass: Annotated[float, "kg"] = 3.0
        tooth_stiffness: Annotated[float, "N/m"] = 1e8
        tooth_damping: Annotated[float, "N*s/m"] = 1e3

    @staticmethod
    def derivative(x: State, u: StiffRack.Input, p: Parameters) -> State:
        travel = p.rack_ratio
        friction = smooth_coulomb(x.steering_wheel_rate, p.nominal_friction, p.friction_width)
        twist = travel * x.steering_wheel_angle - x.rack_position
        twisting = travel * x.steering_wheel_rate - x.rack_speed
        teeth = lash_torque(twist, twisting, p.tooth_stiffness, p.tooth_damping, 0.0)
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


ANGLE_NOISE, RATE_NOISE = 1e-8, 10.0
"""Process noise: variance of the angle per sample [rad**2] and of the column rate per second [rad**2/s**3]."""

MEASURED = 0.002**2  # Variance of the measured angle [rad**2], due to the quantisation of its sensor


def one_body(rack: StiffRack.Parameters, sample_time: float = 0.01) -> UnscentedFilter:
    """The filter of r1 that the residuals use, with column and rack as one rigid body."""
    model: Any = discretise_stiff(StiffRack)
    growth = ANGLE_NOISE, RATE_NOISE * sample_time
    return UnscentedFilter(model, model.Parameters(rack, sample_time), (0.0, 0.0), (0.1, 0.1), growth, (MEASURED,))


def two_bodies(rack: StiffRack.Parameters, sample_time: float = 0.01) -> UnscentedFilter:
    """The filter of eqs (3) and (4), with four states, sampled by the exponential of eq (3) with explicit friction.

    A missing rack position leaves the angle as the only measurement. If it is given as rack ratio times angle (eq 5),
    as in the paper, the one sensor counts twice, and the variance of the filter is almost half as large.
    """
    # In fast sliding friction has no slope, and the Jacobian is the matrix of eq (3): row sums of 3.3e7 1/s.
    model: Any = discretise_stiff(TwoBodyRack, 20, TwoBodyRack.State(0.0, 0.0, 0.0, 1e3))
    ratio = rack.rack_ratio * rack.rack_ratio
    angle, rate = ANGLE_NOISE, RATE_NOISE * sample_time
    return UnscentedFilter(
        model,
        model.Parameters(TwoBodyRack.Parameters(**asdict(rack)), sample_time),
        (0.0, 0.0, 0.0, 0.0),
        (0.1 * ratio, 0.1, 0.1 * ratio, 0.1),
        (angle * ratio, angle, rate * ratio, rate),
        (MEASURED * ratio, MEASURED),
    )


class PrintedSingleTrack(SingleTrack):
    """The single-track model with the printed lateral acceleration, whose first term is divided by the speed.

    Source: Li, Frey, Gauterin, eq (14), C[1,1] = -(cf + cr) / (m v), where -(cf + cr) / m is right.
    """

    @staticmethod
    def output(x: SingleTrack.State, u: SingleTrack.Input, p: SingleTrack.Parameters) -> SingleTrack.Output:
        right = SingleTrack.output(x, u, p)
        of_sideslip = (p.front_cornering_stiffness + p.rear_cornering_stiffness) / p.mass * x.sideslip_angle
        printed = right.lateral_acceleration + of_sideslip - of_sideslip / u.vehicle_speed
        return right._replace(lateral_acceleration=printed)


def lateral_filter(parameters: SingleTrack.Parameters, sample_time: float, printed: bool = False) -> KalmanFilter:
    """The filter of eqs (13) and (14), discretised exactly: the poles of the printed tyres lie at up to -560 1/s.

    Args:
        printed: whether the lateral acceleration is the printed one

    The model has more weight than the gyroscope, so that the estimated yaw rate does not follow a faulty reading: a
    random walk of 0.1 rad/s in a second against a noise of 0.1 rad/s of every reading. The paper prints no noises.
    """
    model: Any = discretise_stiff(PrintedSingleTrack if printed else SingleTrack)
    growth = 0.02**2 * sample_time, 0.1**2 * sample_time
    noises = 0.1**2, 0.5**2
    return KalmanFilter(model, model.Parameters(parameters, sample_time), (0.0, 0.0), (0.01, 0.01), growth, noises)
