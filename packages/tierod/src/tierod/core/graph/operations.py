"""A graph as a list of operations in static single assignment, ready to be printed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from tierod.core.errors import TraceError

if TYPE_CHECKING:
    import casadi

TUNING, STATE, RING, SAMPLE = range(4)
NEXT_STATE, PUSH, OUTPUT = range(3)

Outputs: TypeAlias = dict[tuple[int, int], int]
"""(group, position) -> index of the operation."""

COMMUTATIVE = {"add", "mul", "and", "or", "eq", "ne"}
LOGICAL = {"lt", "le", "eq", "ne", "and", "or", "not", "member"}


class Operation(NamedTuple):
    """One value: an operation on earlier values; `constant` holds a number, or (group, position) of an input."""

    name: str
    arguments: tuple[int, ...] = ()
    constant: Any = None


def is_constant(operation: Operation, value: float) -> bool:
    """Whether an operation is this constant; 0.0 and -0.0 are different."""
    return operation.name == "constant" and repr(float(operation.constant)) == repr(value)


@dataclass(frozen=True)
class Program:
    """Operations in order, and the value of each output.

    Args:
        outputs: (group, position) -> index of the operation
        invariant: indices of the operations that depend on tuning alone, computed once before the loop
    """

    operations: tuple[Operation, ...]
    outputs: Outputs
    invariant: frozenset[int]

    def carried(self) -> list[int]:
        """Invariant values that the loop needs, in order; constants are written out instead."""
        wanted = {
            argument
            for index, operation in enumerate(self.operations)
            if index not in self.invariant and operation.name != "input"
            for argument in operation.arguments
        } | set(self.outputs.values())
        return sorted(i for i in wanted if i in self.invariant and self.operations[i].name != "constant")

    def counts(self) -> Counter[str]:
        """Number of operations of each kind that one step needs, invariant ones left out."""
        return Counter(
            operation.name
            for index, operation in enumerate(self.operations)
            if index not in self.invariant and operation.name not in ("input", "constant")
        )


def program(function: casadi.Function) -> Program:
    """The operations of a traced function: equal ones merged, shared divisors inverted once, sums of products fused."""
    operations, outputs = _read(function)
    operations, outputs = _invert_shared_divisors(operations, outputs)
    operations, outputs = drop_unused(operations, outputs)
    operations, outputs = drop_unused(_fuse(operations, outputs), outputs)
    return Program(tuple(operations), outputs, invariant_of(operations))


class Builder:
    """Value numbering: an operation that exists already is not written again."""

    def __init__(self) -> None:
        self.operations: list[Operation] = []
        self.known: dict[object, int] = {}

    def add(self, name: str, arguments: Iterable[int] = (), constant: object = None) -> int:
        """Index of an operation on earlier ones."""
        arguments = tuple(arguments)
        if name in COMMUTATIVE:
            arguments = tuple(sorted(arguments))
        operation = Operation(name, arguments, constant)
        # Constants by their text: 0.0 equals -0.0, but their reciprocals are infinities of opposite sign.
        key = repr(constant) if name == "constant" else operation
        if key not in self.known:
            self.known[key] = len(self.operations)
            self.operations.append(operation)
        return self.known[key]


def _read(function: casadi.Function) -> tuple[list[Operation], Outputs]:
    names = _instruction_names()
    builder = Builder()
    slot: dict[int, int] = {}
    outputs: Outputs = {}
    for k in range(function.n_instructions()):
        name = names.get(function.instruction_id(k))
        arguments, results = function.instruction_input(k), function.instruction_output(k)
        if name is None:
            raise TraceError(
                f"the graph holds the CasADi operation {function.instruction_id(k)}, for which no C is printed; "
                "write it with the functions of tierod.core.graph.maths"
            )
        if name == "output":
            outputs[results[0], results[1]] = slot[arguments[0]]
        elif name == "input":
            slot[results[0]] = builder.add("input", constant=tuple(arguments))
        elif name == "constant":
            slot[results[0]] = builder.add("constant", constant=function.instruction_constant(k))
        else:
            slot[results[0]] = _add(builder, name, [slot[argument] for argument in arguments])
    return builder.operations, outputs


def _add(builder: Builder, name: str, arguments: list[int]) -> int:
    operations = builder.operations
    # CasADi writes a selection as a sum of two values of which the condition makes one zero.
    if name == "add" and all(operations[a].name == "if" for a in arguments):
        (condition, first), (other, second) = (operations[a].arguments for a in arguments)
        if operations[other] == Operation("not", (condition,)):
            return builder.add("select", (condition, first, second))
        if operations[condition] == Operation("not", (other,)):
            return builder.add("select", (other, second, first))
    if name == "twice":
        return builder.add("add", (arguments[0], arguments[0]))
    if name == "square":
        return builder.add("mul", (arguments[0], arguments[0]))
    return builder.add(name, arguments)


def _invert_shared_divisors(operations: list[Operation], outputs: Outputs) -> tuple[list[Operation], Outputs]:
    """Products with the reciprocal for divisors used more than once; CasADi turns a * (1 / b) back into a / b."""
    shared = Counter(o.arguments[-1] for o in operations if o.name in ("div", "inverse"))
    builder = Builder()
    new: dict[int, int] = {}
    for index, operation in enumerate(operations):
        arguments = [new[argument] for argument in operation.arguments]
        if operation.name == "div" and shared[operation.arguments[1]] > 1:
            new[index] = builder.add("mul", (arguments[0], builder.add("inverse", (arguments[1],))))
        else:
            new[index] = builder.add(operation.name, arguments, operation.constant)
    return builder.operations, {key: new[value] for key, value in outputs.items()}


def _fuse(operations: list[Operation], outputs: Outputs) -> list[Operation]:
    """A product that is used once, in a sum, becomes one fused operation: shorter chains, one rounding less.

    It is fused here, in the graph, and not by the compiler, so that all drivers fuse alike and agree to the last bit.
    Of two products in one sum the later one is fused.
    """
    uses = Counter(argument for operation in operations for argument in operation.arguments)
    uses.update(outputs.values())
    fixed, depth, fused = invariant_of(operations), [0] * len(operations), []
    for index, operation in enumerate(operations):
        depth[index] = 1 + max((depth[argument] for argument in operation.arguments), default=0)
        fused.append(operation)
        if operation.name not in ("add", "sub") or index in fixed:
            continue
        products = [
            position
            for position, argument in enumerate(operation.arguments)
            if operations[argument].name == "mul" and uses[argument] == 1 and argument not in fixed
        ]
        if products:
            position = max(products, key=lambda place: depth[operation.arguments[place]])
            first, second = operations[operation.arguments[position]].arguments
            other = operation.arguments[1 - position]
            name = "fma" if operation.name == "add" else "fms" if position == 0 else "fnma"
            fused[-1] = Operation(name, (first, second, other))
    return fused


def drop_unused(operations: Sequence[Operation], outputs: Outputs) -> tuple[list[Operation], Outputs]:
    """The operations that outputs need, and the outputs with their new indices."""
    used, waiting = set(), list(outputs.values())
    while waiting:
        index = waiting.pop()
        if index not in used:
            used.add(index)
            waiting.extend(operations[index].arguments)
    number = {old: new for new, old in enumerate(sorted(used))}
    kept = [
        Operation(operations[old].name, tuple(number[a] for a in operations[old].arguments), operations[old].constant)
        for old in number
    ]
    return kept, {key: number[value] for key, value in outputs.items()}


def invariant_of(operations: Sequence[Operation]) -> frozenset[int]:
    """Indices of the operations that depend on tuning alone."""
    fixed: set[int] = set()
    for index, operation in enumerate(operations):
        if operation.name == "input":
            if operation.constant[0] == TUNING:
                fixed.add(index)
        elif all(argument in fixed for argument in operation.arguments):
            fixed.add(index)
    return frozenset(fixed)


@cache
def _instruction_names() -> dict[int, str]:
    import casadi

    words = {
        "INPUT": "input", "OUTPUT": "output", "CONST": "constant", "ASSIGN": "assign",
        "ADD": "add", "SUB": "sub", "MUL": "mul", "DIV": "div", "NEG": "neg", "INV": "inverse", "SQ": "square",
        "TWICE": "twice", "LT": "lt", "LE": "le", "EQ": "eq", "NE": "ne", "NOT": "not", "AND": "and", "OR": "or",
        "IF_ELSE_ZERO": "if", "FABS": "fabs", "SIGN": "sign", "FLOOR": "floor", "CEIL": "ceil", "SQRT": "sqrt",
        "EXP": "exp", "EXPM1": "expm1", "LOG": "log", "LOG1P": "log1p", "POW": "pow", "CONSTPOW": "pow",
        "HYPOT": "hypot", "SIN": "sin", "COS": "cos", "TAN": "tan", "ASIN": "asin", "ACOS": "acos", "ATAN": "atan",
        "ATAN2": "atan2", "SINH": "sinh", "COSH": "cosh", "TANH": "tanh",
    }  # fmt: skip
    return {getattr(casadi, f"OP_{key}"): word for key, word in words.items()}
