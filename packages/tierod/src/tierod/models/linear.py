"""Linear systems: linearisation of models, and their sampling."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from tierod.core.block import Model, Scalar, Tree, leaves, model_like, rebuild, require_continuous, skeleton, values_of
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.trace import jacobian

Derivative = Callable[[Tree], Tree]


def _ahead(x: Tree, step: Scalar, slope: Tree) -> Tree:
    """x + step slope, leaf by leaf; a structural slope of 0.0 adds no operation to the graph."""
    pairs = zip(leaves(x), leaves(slope), strict=True)
    moved = [a if isinstance(b, float) and b == 0.0 else a + step * b for (_, a), (_, b) in pairs]
    return rebuild(x, moved)


def _euler(slope: Derivative, x: Tree, step: Scalar) -> Tree:
    return _ahead(x, step, slope(x))


def _midpoint(slope: Derivative, x: Tree, step: Scalar) -> Tree:
    return _ahead(x, step, slope(_ahead(x, 0.5 * step, slope(x))))


def _rk4(slope: Derivative, x: Tree, step: Scalar) -> Tree:
    first = slope(x)
    second = slope(_ahead(x, 0.5 * step, first))
    third = slope(_ahead(x, 0.5 * step, second))
    fourth = slope(_ahead(x, step, third))
    inner = _ahead(_ahead(first, 2.0, second), 2.0, third)
    return _ahead(x, step / 6.0, _ahead(inner, 1.0, fourth))


# One-step methods by name: order 1, 2 and 4
METHODS: dict[str, Callable[[Derivative, Tree, Scalar], Tree]] = {"euler": _euler, "midpoint": _midpoint, "rk4": _rk4}


@lru_cache(maxsize=256)
def discretise(model: Model, method: str, steps: int = 1) -> Model:
    """The model discretised by an explicit method, with inputs constant over a sample.

    Args: method: "euler", "midpoint" or "rk4" (order 1, 2, 4). Stable while the magnitude of the fastest eigenvalue
    times the step stays below about 2 (euler, midpoint) or 2.8 (rk4); a stiff linear model needs
    `tierod.models.linear.zero_order_hold`.

    Returns:
        a discrete model with the same State, Input and Output; its Parameters are `continuous` (those of the model)
        and `sample_time` [s]
    """
    if method not in METHODS:
        raise ParameterError(f"'{method}' is not a method of discretisation{nearest(method, METHODS)}")
    if steps < 1:
        raise ParameterError(f"steps is {steps}; expected at least 1")
    require_continuous(model)
    one_step = METHODS[method]

    def transition(x: Tree, u: Tree, p: Tree) -> Tree:
        for _ in range(steps):
            x = one_step(lambda at: model.derivative(at, u, p.continuous), x, p.sample_time / float(steps))
        return x

    made = sampled_model(model, method, transition)
    made.__made_by__ = (discretise, (model, method, steps))
    return made


def sampled_model(model: Model, method: str, transition: Callable[[Tree, Tree, Tree], Tree]) -> Model:
    """The discrete model with a given transition and the shapes and output of a continuous one."""

    def output(x: Tree, u: Tree, p: Tree) -> Tree:
        return model.output(x, u, p.continuous)

    name = model.__name__
    return model_like(
        model,
        f"{name}{method.capitalize()}",
        f"{name}, sampled by {method}.",
        Parameters=sampled_parameters(model),
        transition=transition,
        output=output,
    )


def sampled_parameters(model: Model) -> type:
    """The class of the parameters of a sampled model: those of the continuous one, and the sampling interval [s]."""
    fields = [("continuous", model.Parameters), ("sample_time", Annotated[float, "s"])]
    made: Any = dataclasses.make_dataclass("Parameters", fields, frozen=True)
    made.__made_by__ = (sampled_parameters, (model,))
    return made  # type: ignore[no-any-return]


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A linear system: x' (or the next x) = A x + B u, y = C x + D u."""

    A: np.ndarray  # state matrix, (n, n)
    B: np.ndarray  # input matrix, (n, inputs)
    C: np.ndarray  # output matrix, (outputs, n)
    D: np.ndarray  # feed-through, (outputs, inputs)
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @classmethod
    def of(
        cls,
        A: ArrayLike,
        C: ArrayLike,
        B: ArrayLike | None = None,
        D: ArrayLike | None = None,
        states: tuple[str, ...] = (),
    ) -> LinearSystem:
        """A system from its matrices alone."""
        A, C = np.atleast_2d(np.asarray(A, float)), np.atleast_2d(np.asarray(C, float))
        n = len(A)
        B = np.zeros((n, 0)) if B is None else np.asarray(B, float)
        B = B[:, None] if B.ndim == 1 else B
        D = np.zeros((len(C), B.shape[1])) if D is None else np.atleast_2d(np.asarray(D, float))
        if A.shape != (n, n) or C.shape[1] != n or len(B) != n or D.shape != (len(C), B.shape[1]):
            raise ParameterError(
                f"A is {A.shape}, B {B.shape}, C {C.shape} and D {D.shape}; "
                "expected (n, n), (n, inputs), (outputs, n) and (outputs, inputs)"
            )
        if not all(np.isfinite(matrix).all() for matrix in (A, B, C, D)):
            raise ParameterError("a matrix of the linear system holds NaN or infinity; expected finite numbers")
        names = states or tuple(f"x{k}" for k in range(n))
        return cls(A, B, C, D, names, _numbered("u", B.shape[1]), _numbered("y", len(C)))


def _numbered(letter: str, count: int) -> tuple[str, ...]:
    return tuple(f"{letter}{k}" for k in range(count))


def linearise(model: Model, parameters: Tree, state: Tree, inputs: Tree) -> LinearSystem:
    """The linear system of small deviations from an operating point, by the Jacobians of a model."""
    at = rebuild(skeleton(model.State), [float(leaf) for leaf in values_of(state)])
    given = rebuild(skeleton(model.Input), [float(leaf) for leaf in values_of(inputs)])
    equation = model.transition if hasattr(model, "transition") else model.derivative
    shapes = [tuple(path for path, _ in leaves(skeleton(kind))) for kind in (model.State, model.Input, model.Output)]
    n, m, p = map(len, shapes)
    A = jacobian(lambda x: equation(x, given, parameters), at)
    C = jacobian(lambda x: model.output(x, given, parameters), at)
    B = jacobian(lambda u: equation(at, u, parameters), given) if m else []
    D = jacobian(lambda u: model.output(at, u, parameters), given) if m else []
    wanted: list[tuple[Any, tuple[int, int]]] = [(A, (n, n)), (B, (n, m)), (C, (p, n)), (D, (p, m))]
    matrices = [np.array(rows, float).reshape(shape) for rows, shape in wanted]
    if not all(np.isfinite(matrix).all() for matrix in matrices):
        raise ParameterError(f"{model.__name__} has no finite Jacobian at {at}; choose another operating point")
    return LinearSystem(*matrices, *shapes)  # type: ignore[arg-type]


def sampled(system: LinearSystem, sample_time: float) -> LinearSystem:
    """The continuous system sampled exactly, with inputs constant over a sample (zero-order hold).

    Args: sample_time: sampling interval [s].
    """
    from scipy.linalg import expm

    if not sample_time > 0.0:
        raise ParameterError(f"sample_time is {sample_time}; expected a time greater than zero [s]")
    n, m = system.B.shape
    whole = np.zeros((n + m, n + m))
    whole[:n, :n], whole[:n, n:] = system.A * sample_time, system.B * sample_time
    exact = _with_structure(expm(whole), whole)
    names = (system.states, system.inputs, system.outputs)
    return LinearSystem(exact[:n, :n], exact[:n, n:], system.C, system.D, *names)


def _with_structure(exponential: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """exp(A) with exact zeros and ones where the structure of A gives them.

    Rounding leaves 1e-20 in their place, at different entries for every column, so that each column would need a
    compiled kernel of its own.
    """
    leads = matrix != 0.0
    for _ in range(len(matrix).bit_length()):
        leads = leads | (leads.astype(int) @ leads.astype(int) > 0)
    alone = ~np.diag(leads)
    found = np.where(leads, exponential, 0.0)
    np.fill_diagonal(found, np.where(alone, 1.0, np.diag(exponential)))
    return found


Entries: TypeAlias = tuple[tuple[float | int | None, ...], ...]


@dataclass(frozen=True)
class Matrices:
    """Entries of a linear model: floats are tuning; None (zero) and 1 (one) are structure and need no operation."""

    transition: Entries
    input: Entries
    output: Entries
    feedthrough: Entries


class Linear(NamedTuple):
    """A discrete model and its parameters, as an estimator takes them."""

    model: Model
    parameters: Matrices


def as_model(system: LinearSystem, state: type, inputs: type, output: type) -> Linear:
    entries = [_entries(matrix) for matrix in (system.A, system.B, system.C, system.D)]
    return Linear(linear_model(state, inputs, output), Matrices(*entries))


def zero_order_hold(model: Model, parameters: Tree, sample_time: float, state: Tree, inputs: Tree) -> Linear:
    """A continuous model, linearised at a point and sampled exactly.

    Args: model: continuous; a model that is linear through the origin is the same at every point; sample_time: sampling
    interval [s]; state, inputs: the point; the new model's state and input are deviations from it.
    """
    system = sampled(linearise(model, parameters, state, inputs), sample_time)
    return as_model(system, model.State, model.Input, model.Output)


def _entries(matrix: np.ndarray) -> Entries:
    return tuple(tuple(None if v == 0.0 else 1 if v == 1.0 else float(v) for v in row) for row in matrix)


@lru_cache(maxsize=256)
def linear_model(state: type, inputs: type, output: type) -> Model:
    """The discrete linear model for NamedTuple classes of state, input and output; its parameters are `Matrices`."""

    def transition(x: Tree, u: Tree, p: Matrices) -> Tree:
        return _combined(state, (p.transition, x), (p.input, u))

    def observed(x: Tree, u: Tree, p: Matrices) -> Tree:
        return _combined(output, (p.output, x), (p.feedthrough, u))

    shapes = {"State": state, "Input": inputs, "Output": output, "Parameters": Matrices}
    functions = {"transition": staticmethod(transition), "output": staticmethod(observed)}
    made = {"__doc__": "Linear discrete model.", "__made_by__": (linear_model, (state, inputs, output))}
    return type("LinearModel", (), {**made, **shapes, **functions})


def _combined(shape: type, *parts: tuple[Entries, Tree]) -> Tree:
    flat = [(matrix, values_of(tree)) for matrix, tree in parts]
    rows = []
    for k in range(len(parts[0][0])):
        terms = [
            value if isinstance(coefficient, int) else coefficient * value
            for matrix, values in flat
            for coefficient, value in zip(matrix[k], values, strict=True)
            if coefficient is not None
        ]
        rows.append(sum(terms[1:], start=terms[0]) if terms else 0.0)
    return rebuild(skeleton(shape), rows)


TOLERANCE = 1e-9  # for the scaled system; eigenvalues lose several of the 16 digits of double precision


class Mode(NamedTuple):
    """One eigenvalue of a system, with the observability of its direction."""

    eigenvalue: complex
    # least observable state direction at this eigenvalue, in the states' own units, largest entry 1, (n,)
    direction: np.ndarray
    margin: float  # smallest singular value of [A - eigenvalue I; C], both scaled to norm 1: 0 is unobservable

    @property
    def number(self) -> str:
        """The eigenvalue as text."""
        real = abs(self.eigenvalue.imag) < 1e-9 * max(abs(self.eigenvalue), 1.0)
        return f"{self.eigenvalue.real:.6g}" if real else f"{self.eigenvalue:.6g}"


class Scaled(NamedTuple):
    """A and C of a system in scaled states, the state scale, and the norm by which A was divided."""

    A: np.ndarray
    C: np.ndarray
    scale: np.ndarray
    size: float


def scaled(system: LinearSystem, state_scale: np.ndarray | None = None) -> Scaled:
    """A and C in scaled states, with outputs of norm 1 and A shifted by its mean eigenvalue and divided by its norm.

    Shifting and scaling A does not change the observable subspace, but separates the modes of a finely sampled system,
    whose A is nearly the identity.
    """
    n = len(system.A)
    shifted = system.A - np.trace(system.A) / n * np.eye(n)
    scale = balance(shifted) if state_scale is None else np.asarray(state_scale, float)
    A = shifted * scale / scale[:, None]
    size = float(np.linalg.norm(A, 2))
    # A multiple of the identity leaves only rounding errors after the shift, which must not be scaled to 1.
    size = size if size > 1e-12 * np.linalg.norm(system.A, 2) else 1.0
    C = system.C * scale
    rows = np.linalg.norm(C, axis=1, keepdims=True)
    return Scaled(A / size, C / np.where(rows > 0.0, rows, 1.0), scale, size)


def balance(matrix: np.ndarray) -> np.ndarray:
    """State scale (powers of two) that balances the norms of rows and columns of a matrix."""
    from scipy.linalg import matrix_balance

    _, (scale, _) = matrix_balance(matrix, permute=False, separate=True)
    return np.asarray(scale)


def modes(system: LinearSystem, state_scale: np.ndarray | None = None) -> list[Mode]:
    """Every eigenvalue with its margin (Popov-Belevitch-Hautus test), the least observable first."""
    A, C, scale, size = scaled(system, state_scale)
    shift = np.trace(system.A) / len(A)
    eigenvalues = np.linalg.eigvals(A)
    shifted = A - eigenvalues[:, None, None] * np.eye(len(A))
    _, values, rows = np.linalg.svd(np.concatenate([shifted, np.broadcast_to(C, (len(A), *C.shape))], axis=1))
    found = [
        Mode(complex(eigenvalue * size + shift), _phased(scale * direction.conj()), float(margin))
        for eigenvalue, direction, margin in zip(eigenvalues, rows[:, -1], values[:, len(A) - 1], strict=True)
    ]
    return sorted(found, key=lambda mode: mode.margin)


def _phased(vector: np.ndarray) -> np.ndarray:
    """The vector divided by its largest entry; real if all entries then are."""
    turned: np.ndarray = vector / vector[np.argmax(np.abs(vector))]
    return turned.real if (np.abs(turned.imag) <= 1e-9).all() else turned


def describe(direction: np.ndarray, names: tuple[str, ...]) -> str:
    """A direction as text, largest component first: "0.99 friction - 0.11 angle"."""
    real = np.asarray(direction).real
    strongest = np.abs(real).max()
    order = [k for k in np.argsort(-np.abs(real)) if abs(real[k]) > 0.02 * strongest]
    parts = [f"{'-' if real[k] < 0.0 else '+'} {abs(real[k]):.2g} {names[k]}" for k in order]
    return " ".join(parts).removeprefix("+ ")
