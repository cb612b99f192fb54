"""Trace a block once, with symbols, into one straight-line graph."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from tierod.core.block import (
    Block,
    Ring,
    Scalar,
    T,
    Tree,
    leaves,
    map_leaves,
    rebuild,
    skeleton,
    structure,
    tuning,
    values_of,
    with_tuning,
)
from tierod.core.errors import TraceError
from tierod.core.graph.compiler import vector_width
from tierod.core.graph.known_graphs import entry_of, interface_of, keep_interface
from tierod.core.graph.maths import is_symbol
from tierod.core.graph.operations import NEXT_STATE, PUSH, Operation, Program, invariant_of, is_constant, program

if TYPE_CHECKING:
    import casadi

LANES = vector_width()  # Number of vehicles that are stepped together: one vector register holds a number of each
TILE_STEPS = 64  # Number of samples of a tile: inputs and outputs of all vehicles then stay in the cache of a core


TRUTH_VALUE = "truth value"  # Part of CasADi's message where Python decides on a symbol


class Interface(Protocol):
    """Interface of the graph of a block or of a bank of blocks, for drivers: see `Graph`."""

    @property
    def name(self) -> str: ...
    @property
    def tuning(self) -> tuple[str, ...]: ...
    @property
    def state(self) -> tuple[str, ...]: ...
    @property
    def rings(self) -> tuple[tuple[str, int], ...]: ...
    @property
    def sample(self) -> tuple[str, ...]: ...
    @property
    def output(self) -> tuple[str, ...]: ...
    @property
    def output_tree(self) -> Tree: ...
    @property
    def memory(self) -> int: ...


@dataclass(frozen=True, eq=False)
class Graph:
    """One step of a block as a straight line of operations."""

    name: str  # name of the block's class, as a C identifier
    tuning: tuple[str, ...]
    state: tuple[str, ...]
    rings: tuple[tuple[str, int], ...]  # (name, size) of every delay line
    sample: tuple[str, ...]
    output: tuple[str, ...]
    sample_tree: Tree
    output_tree: Tree
    make: Callable[[], Any]
    # name under which later processes find names and kernels; None where they trace the step themselves
    entry: str | None = None

    @cached_property
    def function(self) -> Any:
        """(tuning, state, ring heads, sample) -> (next state, ring pushes, output), a CasADi function of SX."""
        return self.make()

    @property
    def interface(self) -> dict[str, Any]:
        """Fields that drivers need of a graph whose kernel is cached, by name."""
        return {name: getattr(self, name) for name in INTERFACE}

    @property
    def memory(self) -> int:
        """Number of state values, delay lines included."""
        return len(self.state) + sum(size for _, size in self.rings)


# Names of the fields that drivers need of a graph whose kernel is cached
INTERFACE = tuple(each.name for each in fields(Graph) if each.name not in ("make", "entry"))


def trace(block: Block) -> Graph:
    """The graph of a block's step, for a bank a `BankGraph`; blocks that differ only in their floats share one."""
    key = structure(block)
    try:
        hash(key)
    except TypeError as error:
        raise TraceError(
            f"{type(block).__name__} has a field that can change ({error}); give a tuple in place of a list or array, "
            "a frozen dataclass in place of another object"
        ) from None
    return _trace(_Structure(key, block))


class _Structure:
    def __init__(self, key: object, block: Block):
        self.key, self.block = key, block

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Structure) and self.key == other.key


@lru_cache(maxsize=256)
def _trace(structure_: _Structure) -> Graph:
    block: Any = structure_.block
    if hasattr(block, "traced"):
        bank: Graph = block.traced()
        return bank

    def traced() -> Graph:
        return straight_line(block, skeleton(block.Sample), lambda tuned, state, sample: tuned.step(state, sample))

    entry = entry_of(structure_.key, type(block).__name__)
    if entry is None:
        return traced()
    declared = {"sample_tree": skeleton(block.Sample), "output_tree": skeleton(getattr(block, "Output", None))}
    known = interface_of(entry)
    if known is not None and {*declared, *known} == set(INTERFACE):
        return Graph(**{**declared, **known}, make=lambda: traced().function, entry=entry)
    graph = traced()
    # Declared trees are not kept: their class may not be importable, such as one that is made for a car's signals.
    keep_interface(entry, {name: each for name, each in graph.interface.items() if not _same(each, declared.get(name))})
    return replace(graph, entry=entry)


def _same(tree: Tree, other: Tree) -> bool:
    if type(tree) is not type(other):
        return False
    return not isinstance(tree, tuple) or (len(tree) == len(other) and all(map(_same, tree, other)))


def straight_line(block: Any, sample_tree: Tree, step: Callable[[Any, Tree, Tree], tuple[Tree, Tree]]) -> Graph:
    """The graph of `step(block, state, sample)`, with the block's floats as inputs."""
    import casadi

    name = type(block).__name__
    names = tuple(path for path, _ in tuning(block))
    tuned = [casadi.SX.sym(path) for path in names]
    initial = block.init()
    state_in, plain_in, heads = _state_symbols(initial)
    sample_in = [casadi.SX.sym(path) for path, _ in leaves(sample_tree)]
    state, output = _step(step, with_tuning(block, tuned), state_in, rebuild(sample_tree, sample_in), name)
    plain_out, pushes = _next_state(initial, state, name)
    output_leaves = list(leaves(output))
    groups_in = [tuned, plain_in, heads, sample_in]
    groups_out = [plain_out, pushes, [leaf for _, leaf in output_leaves]]
    columns = [casadi.vertcat(*map(casadi.SX, group)) for group in groups_out]
    function = casadi.Function(name, [casadi.vertcat(*group) for group in groups_in], columns)
    _refuse_nan(function, name)
    return Graph(
        name=name,
        tuning=names,
        state=tuple(path for path, leaf in leaves(initial) if not isinstance(leaf, Ring)),
        rings=tuple((path, leaf.size) for path, leaf in leaves(initial) if isinstance(leaf, Ring)),
        sample=tuple(path for path, _ in leaves(sample_tree)),
        output=tuple(path for path, _ in output_leaves),
        sample_tree=map_leaves(lambda _: 0.0, sample_tree),
        output_tree=map_leaves(lambda _: 0.0, output),
        make=lambda: function,
    )


def initial_memory(block: Block) -> np.ndarray:
    """The block's state before the first sample as one flat array, delay lines at the end."""
    return flat_memory(block.init())


def _state_symbols(initial: Tree) -> tuple[Tree, list[Any], list[Any]]:
    import casadi

    plain: list[Any] = []
    heads: list[Any] = []
    values: list[Any] = []
    for path, leaf in leaves(initial):
        if isinstance(leaf, Ring) and not (isinstance(leaf.size, int) and leaf.size >= 1):
            raise TraceError(
                f"the delay line {path} holds {leaf.size} samples; give it a size of at least 1 (a whole number)"
            )
        symbol: Any = casadi.SX.sym(path)
        (heads if isinstance(leaf, Ring) else plain).append(symbol)
        values.append(Ring(leaf.size, leaf.initial, symbol) if isinstance(leaf, Ring) else symbol)
    return rebuild(initial, values), plain, heads


def _step(
    step: Callable[..., tuple[Tree, Tree]], block: Any, state: Tree, sample: Tree, name: str
) -> tuple[Tree, Tree]:
    try:
        return step(block, state, sample)
    except RuntimeError as error:
        if TRUTH_VALUE in str(error):
            raise TraceError(
                f"{name}.step decides on the value of a signal with `if`, `and`, `or`, `not`, `min`, `max` or a "
                "chained comparison; write where, both, either, minimum or maximum of tierod.core.graph.maths instead"
            ) from None
        raise _foreign(name, error) from error
    except TypeError as error:
        raise _foreign(name, error) from error


def _foreign(name: str, error: Exception) -> TraceError:
    return TraceError(
        f"{name}.step applies a function to a signal that takes only numbers ({error}); "
        "use the functions of tierod.core.graph.maths"
    )


def _next_state(initial: Tree, state: Tree, name: str) -> tuple[list[Any], list[Any]]:
    before = [(path, isinstance(leaf, Ring)) for path, leaf in leaves(initial)]
    after = [(path, isinstance(leaf, Ring)) for path, leaf in leaves(state)]
    if before != after:
        changed = sorted({path for path, _ in set(before) ^ set(after)})
        raise TraceError(
            f"{name}.step returns a state of another shape than {name}.init gives: they differ in "
            f"{', '.join(changed)}; return the same fields in the same order"
        )
    plain = [leaf for leaf in values_of(state) if not isinstance(leaf, Ring)]
    rings = [(path, leaf) for path, leaf in leaves(state) if isinstance(leaf, Ring)]
    for path, ring in rings:
        if ring.newest is None:
            raise TraceError(f"{name}.step returns the delay line {path} without a push; push one value a step")
    return plain, [ring.newest for _, ring in rings]


def _refuse_nan(function: casadi.Function, name: str) -> None:
    import casadi

    for k in range(function.n_instructions()):
        if function.instruction_id(k) == casadi.OP_CONST and math.isnan(function.instruction_constant(k)):
            raise TraceError(
                f"{name}.step holds a NaN constant: `math` or `float()` met a signal, or NaN was written; "
                "use the functions of tierod.core.graph.maths, and `present` to ask whether a value is there"
            )


GROUP = 8  # Number of lanes of a bank that are stepped together: the number of doubles in the widest vector register


class BankState(NamedTuple):
    lanes: tuple[Tree, ...]
    judge: Tree
    feedback: Tree  # feedback of the judge at the previous sample, for all lanes


def flat_memory(state: Tree) -> np.ndarray:
    """A state tree as one flat array, delay lines (filled with their initial value) at the end.

    The lanes of a bank come first, as `[group][number][lane of the group]`; the last group is padded with the first
    lane.
    """
    if not isinstance(state, BankState):
        plain, delayed = _plain_and_delayed(state)
        return np.array([*plain, *delayed], dtype=float)
    lanes = grouped(np.array([_plain_and_delayed(lane)[0] for lane in state.lanes], dtype=float))
    plain, delayed = _plain_and_delayed((state.judge, state.feedback))
    return np.concatenate([lanes, np.array([*plain, *delayed], dtype=float)])


def grouped(rows: np.ndarray) -> np.ndarray:
    """Rows, one per lane, in the layout of the memory: `[group][number][lane of the group]`, flat."""
    missing = -len(rows) % GROUP
    filled = np.concatenate([rows, np.repeat(rows[:1], missing, axis=0)])
    return filled.reshape(-1, GROUP, rows.shape[1]).transpose(0, 2, 1).ravel()


def ungrouped(flat: np.ndarray, count: int) -> np.ndarray:
    """The inverse of `grouped`: rows, one per lane."""
    groups = -(-count // GROUP)
    rows = flat.reshape(groups, -1, GROUP).transpose(0, 2, 1)
    return rows.reshape(groups * GROUP, -1)[:count]


def _plain_and_delayed(state: Tree) -> tuple[list[Any], list[Any]]:
    flat = values_of(state)
    plain = [leaf for leaf in flat if not isinstance(leaf, Ring)]
    return plain, [leaf.initial for leaf in flat if isinstance(leaf, Ring) for _ in range(leaf.size)]


def initial_program(block: Block) -> Program:
    """Program of `init` over the floats of a block: next states, and the value that fills each delay line.

    Where `init` cannot be traced with symbols, or gives other numbers with them, it holds the numbers as constants.
    """
    if hasattr(block, "traced"):
        raise TypeError("lanes and judge of a bank begin each by itself")
    values = [value for _, value in tuning(block)]
    plain, rings = _parted(block.init())
    fixed = _constants(plain, rings)
    try:
        import casadi

        tuned = [casadi.SX.sym(path) for path, _ in tuning(block)]
        groups = _parted(with_tuning(block, tuned).init())
        columns = [casadi.vertcat(*map(casadi.SX, group)) for group in groups]
        function = casadi.Function("initial", [casadi.vertcat(*tuned)], columns)
        found = [np.asarray(each, dtype=float).ravel() for each in function.call([casadi.DM(values)])]
    except (RuntimeError, TypeError, NotImplementedError):
        return fixed
    same = all(np.allclose(a, b, 1e-12, 0.0, equal_nan=True) for a, b in zip(found, (plain, rings), strict=True))
    return _with_signs(program(function), {NEXT_STATE: plain, PUSH: rings}) if same else fixed


def _with_signs(followed: Program, numbers: dict[int, list[float]]) -> Program:
    """The program with the signs of its constant zeros restored: CasADi has no negative zero."""
    operations, outputs = list(followed.operations), dict(followed.outputs)
    for (group, position), value in followed.outputs.items():
        if is_constant(operations[value], 0.0) and math.copysign(1.0, numbers[group][position]) < 0.0:
            outputs[group, position] = len(operations)
            operations.append(Operation("constant", (), -0.0))
    return Program(tuple(operations), outputs, invariant_of(operations))


def _parted(state: Tree) -> tuple[list[Any], list[Any]]:
    flat = values_of(state)
    return [each for each in flat if not isinstance(each, Ring)], [
        each.initial for each in flat if isinstance(each, Ring)
    ]


def _constants(plain: list[float], rings: list[float]) -> Program:
    operations = tuple(Operation("constant", (), float(value)) for value in (*plain, *rings))
    outputs = {(NEXT_STATE, k): k for k in range(len(plain))}
    outputs |= {(PUSH, k): len(plain) + k for k in range(len(rings))}
    return Program(operations, outputs, frozenset(range(len(operations))))


def prefix(graph: Interface) -> str:
    """Prefix of every name that the graph's C exports."""
    return f"tierod_{re.sub(r'[^0-9A-Za-z]+', '_', graph.name).lower()}"


def jacobian(function: Callable[[T], Tree], at: T) -> list[list[Scalar]]:
    """Derivative of every leaf of `function(x)` with respect to every leaf of `x`, at one point.

    Args:
        function: maps a tree of the shape of `at` to a tree; pure, written with tierod.core.graph.maths

    Returns:
        rows by output leaf, columns by input leaf; structural zeros and constants come back as floats,
        so that products with them can be left out
    """
    import casadi

    point = values_of(at)
    symbols = casadi.SX.sym("x", len(point))
    images = values_of(function(rebuild(at, casadi.vertsplit(symbols))))
    derivative = casadi.jacobian(casadi.vertcat(*images), symbols)
    # Even at a point of numbers the function may hold symbols of a running trace, such as a parameter.
    if any(map(is_symbol, point)) or casadi.symvar(casadi.substitute(derivative, symbols, casadi.DM.zeros(len(point)))):
        derivative = casadi.substitute(derivative, symbols, casadi.vertcat(*point))
    else:
        derivative = casadi.Function("derivative", [symbols], [derivative])(casadi.vertcat(*point))
    rows, columns = derivative.shape
    sparsity = derivative.sparsity()
    return [[_entry(derivative, i, j) if sparsity.has_nz(i, j) else 0.0 for j in range(columns)] for i in range(rows)]


def dependence(function: Callable[[T], Tree], shape: T) -> list[list[bool]]:
    """Sparsity pattern: which leaves of `function(x)` depend on which leaves of `x`, whatever their values.

    Args:
        function: maps a tree of the shape of `shape` to a tree; pure, written with tierod.core.graph.maths

    Returns:
        rows by output leaf, columns by input leaf
    """
    import casadi

    symbols = casadi.SX.sym("x", len(list(leaves(shape))))
    images = values_of(function(rebuild(shape, casadi.vertsplit(symbols))))
    pattern = casadi.Function("f", [symbols], [casadi.SX(casadi.vertcat(*images))]).jac_sparsity(0, 0)
    rows, columns = pattern.shape
    return [[pattern.has_nz(i, j) for j in range(columns)] for i in range(rows)]


def _entry(matrix: Any, row: int, column: int) -> Any:
    value = matrix[row, column]
    return value if is_symbol(value) and not value.is_constant() else float(value)
