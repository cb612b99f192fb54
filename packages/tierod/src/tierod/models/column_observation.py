"""Observation of a steering column with its disturbances as states."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Model, Tree, named_tuple, skeleton, units
from tierod.core.errors import ParameterError, nearest
from tierod.models.linear import (
    TOLERANCE,
    LinearSystem,
    Matrices,
    as_model,
    balance,
    describe,
    linearise,
    modes,
    sampled,
)
from tierod.models.steering_column import ColumnInput, ColumnOutput

DERIVATIVES = ("", "_rate", "_acceleration")  # Suffixes of the state names of an input and its derivatives


def with_disturbance_states(system: LinearSystem, orders: Mapping[str, int]) -> LinearSystem:
    """The system with some of its inputs as chains of integrators, of which the last state is constant.

    Source: Raffone, eqs (8) and (18), for order 1; the feed-through of such an input is kept.
    """
    for name, order in orders.items():
        if name not in system.inputs:
            raise ParameterError(f"the system has no input '{name}'{nearest(name, system.inputs)}")
        if not 1 <= order <= len(DERIVATIVES):
            raise ParameterError(f"order of '{name}' is {order}; expected 1 to {len(DERIVATIVES)}")
    n, extra = len(system.A), sum(orders.values())
    A = np.zeros((n + extra, n + extra))
    C = np.hstack([system.C, np.zeros((len(system.C), extra))])
    A[:n, :n] = system.A
    names, at = list(system.states), n
    for name, order in orders.items():
        column = system.inputs.index(name)
        A[:n, at], C[:, at] = system.B[:, column], system.D[:, column]
        for k in range(1, order):
            A[at + k - 1, at + k] = 1.0
        names += [name + DERIVATIVES[k] for k in range(order)]
        at += order
    kept = [k for k, name in enumerate(system.inputs) if name not in orders]
    B = np.vstack([system.B[:, kept], np.zeros((extra, len(kept)))])
    inputs = tuple(system.inputs[k] for k in kept)
    return LinearSystem(A, B, C, system.D[:, kept], tuple(names), inputs, system.outputs)


def with_offset_state(system: LinearSystem, output: str, name: str) -> LinearSystem:
    """The system with a constant added to one of its outputs, as its last state."""
    if output not in system.outputs:
        raise ParameterError(f"the system has no output '{output}'{nearest(output, system.outputs)}")
    n = len(system.A)
    A = np.zeros((n + 1, n + 1))
    A[:n, :n] = system.A
    column = np.array([[float(each == output)] for each in system.outputs])
    B = np.vstack([system.B, np.zeros((1, system.B.shape[1]))])
    states = (*system.states, name)
    return LinearSystem(A, B, np.hstack([system.C, column]), system.D, states, system.inputs, system.outputs)


def with_outputs(system: LinearSystem, outputs: tuple[str, ...]) -> LinearSystem:
    """The system with a selection of its outputs, in the given order."""
    for name in outputs:
        if name not in system.outputs:
            raise ParameterError(f"the system has no output '{name}'{nearest(name, system.outputs)}")
    rows = [system.outputs.index(name) for name in outputs]
    return LinearSystem(
        system.A, system.B, system.C[rows], system.D[rows], system.states, system.inputs, tuple(outputs)
    )


# Name and unit of the offset state of each sensor of a column that may have one
OFFSETS: Mapping[str, tuple[str, str]] = {
    "driver_torque": ("driver_torque_offset", "N*m"),
    "motor_angle_mechanical": ("motor_angle_offset", "rad"),
}


class MotorTorque(NamedTuple):
    """The known torque at the motor's shaft."""

    motor_torque: Annotated[float, "N*m"]


class ColumnObservation(NamedTuple):
    """A column prepared for an estimator."""

    continuous: LinearSystem
    discrete: LinearSystem
    model: Model
    parameters: Matrices


def linear_column(column: Model, parameters: Tree) -> LinearSystem:
    return linearise(column, parameters, skeleton(column.State), skeleton(column.Input))


def observed_column(
    column: LinearSystem,
    sample_time: float,
    hand_torque_order: int = 2,
    disturbance_torque_order: int = 1,
    offset: str | None = None,
    outputs: tuple[str, ...] = ColumnOutput._fields,
) -> ColumnObservation:
    """A column with the torque of the hands and the disturbance torque as states.

    Source: Raffone, eqs (8) and (18), where both torques are random walks. Args: column: continuous, with the inputs of
    `ColumnInput`; reduced or not; sample_time: sampling interval [s]; offset: sensor with an offset, "driver_torque" or
    "motor_angle_mechanical"; None for neither.
    """
    orders = {"hand_torque": hand_torque_order, "disturbance_torque": disturbance_torque_order}
    extended = with_outputs(with_disturbance_states(column, orders), outputs)
    if offset is not None:
        if offset not in OFFSETS or offset not in outputs:
            known = ", ".join(name for name in OFFSETS if name in outputs) or "no other: none of them is measured"
            raise ParameterError(f"offset is '{offset}'; expected None or {known}")
        extended = with_offset_state(extended, offset, OFFSETS[offset][0])
    discrete = sampled(extended, sample_time)
    linear = as_model(discrete, _state_class(extended.states), MotorTorque, _output_class(outputs))
    return ColumnObservation(extended, discrete, linear.model, linear.parameters)


_UNITS = {
    "hand_torque": "N*m",
    "disturbance_torque": "N*m",
    **dict(OFFSETS.values()),
    "angle": "rad",
    "speed": "rad/s",
}


@lru_cache(maxsize=64)
def _state_class(names: tuple[str, ...]) -> type:
    return named_tuple("ObservedColumnState", [(name, Annotated[float, _unit(name)]) for name in names])


@lru_cache(maxsize=64)
def _output_class(names: tuple[str, ...]) -> type:
    known = dict(zip(ColumnOutput._fields, units(ColumnOutput), strict=True))
    return named_tuple("ObservedColumnOutput", [(name, Annotated[float, known[name]]) for name in names])


def _unit(name: str) -> str:
    """Unit of a state from its name; empty for a state of a balanced system."""
    if name in _UNITS:
        return _UNITS[name]
    for derivative, per in (("_acceleration", "/s**2"), ("_rate", "/s")):
        if name.endswith(derivative):
            return _unit(name.removesuffix(derivative) if name.startswith(_TORQUES) else "angle") + per
    return next((unit for end, unit in _UNITS.items() if name.endswith(end)), "")


_TORQUES = ColumnInput._fields


# Eigenvalues below this share of the fastest count as zero [-]: rounding splits a multiple eigenvalue at zero, such as
# that of an angle under a constant torque, by as much
SPLIT = 1e-4
_ZERO = 1e-10


def require_fit(system: LinearSystem, what: str, sample_time: float) -> None:
    """Check that a continuous model does not grow, is observable, and is slow enough to be sampled exactly.

    Eigenvalues at zero, as of angles without a spring and of constant disturbances, pass; a vibration must stay below
    half the sample rate.
    """
    scale = balance(system.A)
    values, vectors = np.linalg.eig(system.A * scale / scale[:, None])
    size = np.abs(values)
    worst = int(np.argmax(np.where(size < SPLIT * size.max(), np.minimum(values.real, 0.0), values.real)))
    if values[worst].real > _ZERO * size.max() and size[worst] >= SPLIT * size.max():
        raise ParameterError(
            f"{what} is unstable: eigenvalue {values[worst]:.4g} 1/s in {_where(vectors[:, worst], system)}; check the "
            "signs of its stiffnesses and dampings, and that no inertia is zero or below"
        )
    fastest = int(np.argmax(np.abs(values.imag)))
    if (frequency := abs(values[fastest].imag)) * sample_time >= np.pi:
        raise ParameterError(
            f"{what} is too fast for its rate: eigenvalue {values[fastest]:.4g} 1/s ({frequency / (2.0 * np.pi):.3g} "
            f"Hz) in {_where(vectors[:, fastest], system)}; samples every {sample_time:g} s alias it to a slower one. "
            f"Step it at most {np.pi / frequency:.2g} s, or leave that mode out"
        )
    if (hidden := modes(system)[0]).margin < TOLERANCE:
        raise ParameterError(
            f"{what} cannot be observed through {', '.join(system.outputs) or 'no output'}: not observable: "
            f"{describe(hidden.direction, system.states)}; add an output by which it is observable, or leave that "
            "state out"
        )


def _where(vector: np.ndarray, system: LinearSystem) -> str:
    sizes = np.abs(vector)
    order = [int(k) for k in np.argsort(-sizes) if sizes[k] > 0.3 * sizes.max()]
    return ", ".join(system.states[k] for k in order)
