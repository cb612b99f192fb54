"""Integration of a plant in one step of a stiff method, motion along a path, and plants with parameters as inputs."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, NamedTuple, TypeVar, get_type_hints

from tierod.core.block import Scalar, Tree, leaves, named_tuple, rebuild, tuning, values_of
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.maths import cos, maximum, sin
from tierod.core.graph.trace import jacobian
from tierod_lab.ground.parts import Loads, Memory, Motion, Plant, Reaction, Steering

State = TypeVar("State")


def runge_kutta(derivative: Callable[[State], State], state: State, step: Scalar) -> State:
    """State after one step [s] of the classical Runge-Kutta method; the fastest rate stays below 2.7 per step."""
    first = derivative(state)
    second = derivative(_ahead(state, first, 0.5 * step))
    third = derivative(_ahead(state, second, 0.5 * step))
    fourth = derivative(_ahead(state, third, step))
    slopes = zip(*map(values_of, (first, second, third, fourth)), strict=True)
    mean = [(a + 2.0 * (b + c) + d) / 6.0 for a, b, c, d in slopes]
    return _ahead(state, rebuild(state, mean), step)


def _ahead(state: State, slope: State, step: Scalar) -> State:
    return rebuild(state, [x + step * rate for x, rate in zip(values_of(state), values_of(slope), strict=True)])


def implicit_inverse(derivative: Callable[[State], State], at: State, step: Scalar) -> list[list[Scalar]]:
    """Inverse of I - gamma step A for `rosenbrock` and a step [s], where A is the Jacobian of the stiff part.

    The linearisation point is made of parameters only, so that the inverse is computed once per run.
    Gaussian elimination without pivoting: for masses on springs and dampers, ordered as angle and rate, the pivots stay
    at or above one, however stiff the springs are.
    """
    rows = [[-GAMMA * step * entry for entry in row] for row in jacobian(derivative, at)]
    size = len(rows)
    for k in range(size):
        rows[k][k] = 1.0 + rows[k][k]
    inverse: list[list[Scalar]] = [[float(i == j) for j in range(size)] for i in range(size)]
    for k in range(size):
        pivot = 1.0 / rows[k][k]
        rows[k] = [entry * pivot for entry in rows[k]]
        inverse[k] = [entry * pivot for entry in inverse[k]]
        for i in range(size):
            factor = rows[i][k]
            if i != k and not _is_zero(factor):
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
                inverse[i] = [a - factor * b for a, b in zip(inverse[i], inverse[k], strict=True)]
    return inverse


def with_entry(inverse: list[list[Scalar]], row: int, column: int, entry: Scalar, step: Scalar) -> list[list[Scalar]]:
    """Inverse of `implicit_inverse` after one more entry [1/s] has been added to the Jacobian; it has to stay stable.

    Source: Sherman and Morrison, Ann. Math. Statist. 21 (1950) 124.
    """
    gain = GAMMA * step * entry
    share = gain / (1.0 - gain * inverse[column][row])
    return [
        [
            # Exact zeros are skipped, so that a traced program keeps the sparsity of the inverse.
            value if _is_zero(line[row]) or _is_zero(other) else value + share * line[row] * other
            for value, other in zip(line, inverse[column], strict=True)
        ]
        for line in inverse
    ]


def rosenbrock(
    derivative: Callable[[State], State], state: State, step: Scalar, stiff: str, inverse: list[list[Scalar]]
) -> State:
    """State after one step of the Rosenbrock method ROS2 with an inexact Jacobian.

    The stiff field of the state is treated implicitly, all others explicitly (Heun); the order is two for any Jacobian.

    Args:
        step: integration step [s]; for the explicit fields, step times the fastest rate must stay below about 2

    Source: Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20 (1999) 1456, eq (1.4), with gamma = 1 - 1/sqrt(2).
    """
    solved = [path == stiff or path.startswith(f"{stiff}.") for path, _ in leaves(state)]

    def implicit(slope: list[Scalar]) -> list[Scalar]:
        known = iter(_product(inverse, [value for value, own in zip(slope, solved, strict=True) if own]))
        return [next(known) if own else value for value, own in zip(slope, solved, strict=True)]

    first = implicit(values_of(derivative(state)))
    ahead = _ahead(state, rebuild(state, first), step)
    right = [after - 2.0 * before for after, before in zip(values_of(derivative(ahead)), first, strict=True)]
    second = implicit(right)
    mean = [1.5 * a + 0.5 * b for a, b in zip(first, second, strict=True)]
    return _ahead(state, rebuild(state, mean), step)


GAMMA = 1.0 - 0.5**0.5  # Coefficient of ROS2, which makes the method L-stable: modes too fast for the step are damped


def _product(matrix: list[list[Scalar]], vector: list[Scalar]) -> list[Scalar]:
    return [
        sum((entry * value for entry, value in zip(row, vector, strict=True) if not _is_zero(entry)), start=0.0)
        for row in matrix
    ]


def _is_zero(value: Scalar) -> bool:
    return isinstance(value, float) and value == 0.0


def steering_inverse(steering: Steering, motion: Motion, memory: Memory, step: Scalar) -> list[list[Scalar]]:
    """Inverse that `rosenbrock` needs for a steering at the start of a step [s].

    All but dry friction is linearised at one point that depends on parameters alone, so this part is computed once. Dry
    friction is stiff while it sticks and not stiff while it slides, so its entries follow its present state: treated as
    stiff throughout, it would brake sliding parts; left out, light parts would chatter.
    """
    rest, relaxed = steering.stiff(), steering.remembered()
    idle = Loads(0.0, 0.0, 0.0, (0.0,) * len(steering.actuators), 0.0, 0.0)
    inverse = implicit_inverse(lambda at: steering.derivative(at, at, relaxed, idle), rest, step)
    place = [path for path, _ in leaves(rest)].index
    for (rate, angle), entry in steering.sticking(motion, memory).items():
        inverse = with_entry(inverse, place(rate), place(angle), entry, step)
    return inverse


@dataclass(frozen=True)
class Varied:
    """A block with some of its float fields as inputs, in a branch `parameters` of its sample.

    Args:
        paths: dotted names of float fields ("steering.friction.level"); the inputs replace their values in the block
    """

    block: Plant
    paths: tuple[str, ...]

    def __post_init__(self) -> None:
        known = [path for path, _ in tuning(self.block)]
        for path in self.paths:
            if path not in known:
                raise ParameterError(f"{type(self.block).__name__} has no parameter '{path}'{nearest(path, known)}")

    @property
    def Sample(self) -> type:
        own: type = self.block.Sample
        return _sample(own, tuple(sorted(self.paths)))

    def init(self) -> Tree:
        return self.block.init()

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Tree]:
        *own, parameters = sample
        changed: Plant = _changed(self.block, parameters)
        return changed.step(state, self.block.Sample(*own))


_ITEM = "item_"


def path_of(name: str) -> str:
    """Dotted path of a `Varied` parameter from the name of an input, in which items of tuples carry a prefix."""
    return name.replace(f".{_ITEM}", ".")


@cache
def _sample(own: type, paths: tuple[str, ...]) -> type:
    hints = get_type_hints(own, include_extras=True)
    fields = [(name, hints[name]) for name in own._fields]  # type: ignore[attr-defined]  # a NamedTuple
    return named_tuple("Sample", [*fields, ("parameters", _branch("Parameters", paths))])


def _branch(name: str, paths: Iterable[str]) -> Any:
    below: dict[str, list[str]] = {}
    for path in paths:
        head, _, rest = path.partition(".")
        below.setdefault(head, []).append(rest)
    return named_tuple(
        name,
        [
            (_field(head), Annotated[float, ""] if rests == [""] else _branch(head.capitalize(), rests))
            for head, rests in below.items()
        ],
    )


def _field(head: str) -> str:
    return head if head.isidentifier() else f"{_ITEM}{head}"


def _changed(part: Any, values: Tree) -> Any:
    fresh = {
        name.removeprefix(_ITEM): _changed(_get(part, name), value) if isinstance(value, tuple) else value
        for name, value in zip(values._fields, values, strict=True)
    }
    if isinstance(part, tuple):
        names = getattr(part, "_fields", tuple(map(str, range(len(part)))))
        parts = [fresh.get(name, value) for name, value in zip(names, part, strict=True)]
        return type(part)(*parts) if hasattr(part, "_fields") else tuple(parts)
    copy = object.__new__(type(part))
    for field in dataclasses.fields(part):
        object.__setattr__(copy, field.name, fresh.get(field.name, getattr(part, field.name)))
    return copy


def _get(part: Any, name: str) -> Any:
    return part[int(name.removeprefix(_ITEM))] if name.startswith(_ITEM) else getattr(part, name)


INSIDE = 0.2
"""Lower bound of 1 - curvature * offset, since the coordinates along the path are singular at a bend's centre [-]."""


class Path(NamedTuple):
    """Motion along a path; the offset is positive to its left, the heading is over ground."""

    distance: Scalar  # distance of the nearest point of the path, along the path [m]
    lateral_offset: Scalar  # offset of the car from this point [m]
    heading_error: Scalar  # heading of the car relative to the path [rad]
    heading: Scalar  # heading of the car over ground [rad]


START = Path(0.0, 0.0, 0.0, 0.0)


def path_rate(path: Path, reaction: Reaction, curvature: Scalar) -> Path:
    """Rate of change of the motion along a path of a curvature [1/m].

    Source: Frenet frame; Rajamani, Vehicle Dynamics and Control (2012), section 2.5, without its small angles.
    """
    along, across = cos(path.heading_error), sin(path.heading_error)
    forward = reaction.speed * along - reaction.lateral_speed * across
    distance_rate = forward / maximum(1.0 - curvature * path.lateral_offset, INSIDE)
    sideways = reaction.speed * across + reaction.lateral_speed * along
    return Path(distance_rate, sideways, reaction.yaw_rate - curvature * distance_rate, reaction.yaw_rate)


def moved(position: tuple[Scalar, Scalar], reaction: Reaction, heading: Scalar, step: Scalar) -> tuple[Scalar, Scalar]:
    """Coordinates over ground after a step [s], x ahead and y to the left of the initial heading [m].

    Computed once per step with the speeds at its start: the accumulated error is at most half a step times the change
    of speed.
    """
    middle = heading + 0.5 * step * reaction.yaw_rate
    along, across = cos(middle), sin(middle)
    return (
        position[0] + step * (reaction.speed * along - reaction.lateral_speed * across),
        position[1] + step * (reaction.speed * across + reaction.lateral_speed * along),
    )
