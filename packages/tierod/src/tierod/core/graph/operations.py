"""A graph as a list of operations in static single assignment, and its branches for a step that runs alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from tierod.core.errors import TraceError

if TYPE_CHECKING:
    import casadi

TUNING, STATE, RING, SAMPLE = range(4)
NEXT_STATE, PUSH, OUTPUT = range(3)

Outputs: TypeAlias = dict[tuple[int, int], int]  # (group, position) -> index of the operation

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
    """Operations in order, and the value of each output."""

    operations: tuple[Operation, ...]
    outputs: Outputs  # (group, position) -> index of the operation
    invariant: frozenset[int]  # indices of the operations that depend on tuning alone, computed once before the loop

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


FEWEST = 16  # Smallest number of operations that a branch pays for: fewer cost less than a mispredicted jump


class Condition(NamedTuple):
    """Condition that a value is not zero; where `holds` is False, that it is zero."""

    value: int
    holds: bool


@dataclass(frozen=True)
class Branch:
    """Operations that are evaluated together."""

    condition: Condition | None  # condition of their evaluation; None for those that are always needed
    operations: tuple[int, ...]


def branches(program: Program) -> list[Branch]:
    """All operations of a step except the invariant ones, ordered so that each follows those that it needs.

    An operation whose result is used only under a condition is evaluated in a branch.
    """
    chosen = _chosen(program, _conditions(program))
    rounds = _rounds(program, chosen)
    parts: dict[tuple[int, Condition | None], list[int]] = {}
    for index, number in rounds.items():
        parts.setdefault((number, chosen.get(index)), []).append(index)
    ordered = sorted(parts.items(), key=lambda part: (part[0][0], part[0][1] is not None, part[1][0]))
    return [Branch(condition, tuple(operations)) for (_, condition), operations in ordered]


def _conditions(program: Program) -> dict[int, frozenset[Condition]]:
    found: dict[int, frozenset[Condition]] = {value: frozenset() for value in program.outputs.values()}
    for index in range(len(program.operations) - 1, -1, -1):
        if index in program.invariant:
            continue
        own, operation = found.get(index, frozenset()), program.operations[index]
        for place, argument in enumerate(operation.arguments):
            under = own
            if operation.name in ("select", "if") and place > 0:
                under = own | {_condition(program, operation.arguments[0], place == 1)}
            found[argument] = found[argument] & under if argument in found else under
    return found


def _condition(program: Program, value: int, holds: bool) -> Condition:
    while program.operations[value].name == "not":
        value, holds = program.operations[value].arguments[0], not holds
    return Condition(value, holds)


def _chosen(program: Program, conditions: dict[int, frozenset[Condition]]) -> dict[int, Condition]:
    """For each operation the condition under which most operations are skipped; none where that saves too little."""
    worked = [
        index
        for index, operation in enumerate(program.operations)
        if index not in program.invariant and operation.name not in ("input", "constant")
    ]
    skipped = Counter(each for index in worked for each in conditions.get(index, ()))
    chosen = {}
    for index in worked:
        own = [each for each in conditions.get(index, ()) if each.value not in program.invariant]
        if own:
            chosen[index] = max(own, key=lambda each: (skipped[each], each))
    counted = Counter(chosen.values())
    return {index: each for index, each in chosen.items() if counted[each] >= FEWEST}


def _rounds(program: Program, chosen: dict[int, Condition]) -> dict[int, int]:
    rounds: dict[int, int] = {}
    for index, operation in enumerate(program.operations):
        if index in program.invariant:
            continue
        own = chosen.get(index)
        needed: Sequence[int] = operation.arguments if own is None else (*operation.arguments, own.value)
        # A result of another branch is needed a round later; within a branch the order of the operations suffices.
        rounds[index] = max((rounds[each] + (chosen.get(each) != own) for each in needed if each in rounds), default=0)
    return rounds


SHORTEST_CHAIN = 8  # Smallest number of values for which a table is faster than selections


def with_picks(program: Program) -> Program:
    """The same program with every chain "v1 if n == 1, v2 if n == 2, ... else v0" as one operation, "pick".

    Its arguments are n, v0, v1, ...; a number that is none of 1, 2, ... picks v0, as the chain does. A program without
    invariant operations, which is evaluated as a whole, stays without.
    """
    operations = list(program.operations)
    for index in range(len(operations)):
        picked = _pick(program.operations, index)
        if picked is not None and index not in program.invariant:
            operations[index] = picked
    kept, outputs = drop_unused(operations, program.outputs)
    fixed = invariant_of(kept) if program.invariant else program.invariant
    return replace(program, operations=tuple(kept), outputs=outputs, invariant=fixed)


def _pick(operations: tuple[Operation, ...], index: int) -> Operation | None:
    """The chain of selections that ends at an operation as one "pick"; None where there is none that is long enough."""
    values: list[int] = []
    number, wanted = -1, 0.0
    while wanted != 1.0 and operations[index].name == "select":
        condition, value, rest = operations[index].arguments
        compared = _compared(operations, condition)
        if compared is None or (values and compared != (number, wanted - 1.0)):
            break
        number, wanted = compared
        values.append(value)
        index = rest
    if wanted != 1.0 or len(values) < SHORTEST_CHAIN:
        return None
    return Operation("pick", (number, index, *reversed(values)))


def _compared(operations: tuple[Operation, ...], condition: int) -> tuple[int, float] | None:
    """(value that is compared with a constant, constant); None for any other condition."""
    asked = operations[condition]
    if asked.name != "eq":
        return None
    first, second = asked.arguments
    if operations[first].name == "constant":
        first, second = second, first
    return (first, float(operations[second].constant)) if operations[second].name == "constant" else None
