"""Packs: operations of a step that differ only in their operands, as unrolled loops over hypotheses or sensors do.

Tracing a graph unrolls Python's loops, so the operations for fifty hypotheses occur fifty times. The search for packs
starts from families of inputs and outputs, whose names differ in one part (`weights.fast.7`): operations of one kind
that take or give members of a family form a pack, and the operations next to them do so in turn. Only the kind of the
operations is assumed to be equal.
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from itertools import count, pairwise

from tierod.core.graph.operations import Operation
from tierod.export.net import CLOCK, Net

FEWEST = 4
"""Fewest operations of a pack; with fewer, a loop is no shorter than straight code."""

INTERCHANGEABLE = frozenset(["add", "mul", "and", "or", "eq", "ne", "fma", "fms", "fnma"])
"""Operations whose first two arguments can be swapped without changing a bit of the result."""

ALONE = frozenset(["pick", CLOCK])
"""Operations that never belong to a pack."""


@dataclass(frozen=True)
class Pack:
    """Operations of one kind, one for each iteration of a loop.

    Args:
        members: numbers of the operations, in the order of the iterations
        arguments: of each operation, in an order in which corresponding arguments form a column
    """

    members: tuple[int, ...]
    arguments: tuple[tuple[int, ...], ...]

    @property
    def columns(self) -> tuple[tuple[int, ...], ...]:
        """Corresponding arguments of all members, one tuple per argument position."""
        return tuple(zip(*self.arguments, strict=True))


def packs(net: Net, groups: Iterable[Sequence[int]], truths: Set[int]) -> list[Pack]:
    """Packs of a program; each operation belongs to at most one.

    Args:
        net: of the program
        groups: families of inputs and outputs, as numbers of operations
        truths: logical values (0 or 1), which a pack does not mix with numbers
    """
    finder = _Finder(net, truths)
    for family in groups:
        finder.begin(tuple(family))
    finder.work_off()
    return finder.packs


def families(named: Mapping[str, int]) -> list[list[int]]:
    """Groups of numbers whose names differ in one part only, or in their whole numbers only.

    Args:
        named: dotted name -> number
    """
    found: dict[str, list[int]] = defaultdict(list)
    for name, number in named.items():
        parts = name.split(".")
        keys = {".".join("*" if part.isdigit() else part for part in parts)}
        keys |= {".".join([*parts[:k], "*", *parts[k + 1 :]]) for k in range(len(parts))}
        for key in sorted(keys - {name}):
            found[key].append(number)
    return [each for each in found.values() if len(each) >= FEWEST]


class _Finder:
    """Search for packs, the largest first."""

    def __init__(self, net: Net, truths: Set[int]):
        self.net, self.program, self.truths = net, net.program, truths
        self.packs: list[Pack] = []
        self.home: dict[int, int] = {}
        self._waiting: list[tuple[int, int, tuple[int, ...]]] = []
        self._turn = count()
        self._users: dict[int, list[tuple[int, int]]] = defaultdict(list)
        self._before: list[int] = []
        # Predecessors as bit sets: independence of a whole group is then a single AND per member.
        for index, operation in enumerate(self.program.operations):
            before = 0
            for place, argument in enumerate(operation.arguments):
                before |= self._before[argument] | (1 << argument)
                if net.is_work(index):
                    self._users[argument].append((index, place))
            self._before.append(before)

    def begin(self, family: tuple[int, ...]) -> None:
        """Add candidates among the members of a family and the operations that use them."""
        self._put(family)
        self._forward(family)

    def work_off(self) -> None:
        """Form packs until no candidates remain."""
        while self._waiting:
            size, _, candidates = heapq.heappop(self._waiting)
            groups = self._groups(candidates)
            largest = max(map(len, groups), default=0)
            # Packs found since then have shrunk this group, so it is queued again under its present size.
            if 0 < largest < -size:
                self._put(candidates)
            else:
                for group in groups:
                    self._form(group)

    def _groups(self, candidates: Sequence[int]) -> list[list[int]]:
        """Candidates of one kind that occur once and belong to no pack yet."""
        often = Counter(candidates)
        groups: dict[object, list[int]] = defaultdict(list)
        for index in candidates:
            operation = self.program.operations[index]
            if often[index] == 1 and index not in self.home and self.net.is_work(index) and operation.name not in ALONE:
                groups[operation.name, len(operation.arguments), index in self.truths].append(index)
        return [group for group in groups.values() if len(group) >= FEWEST]

    def _put(self, candidates: tuple[int, ...]) -> None:
        largest = max(map(len, self._groups(candidates)), default=0)
        if largest:
            heapq.heappush(self._waiting, (-largest, next(self._turn), candidates))

    def _form(self, group: list[int]) -> None:
        if not self._is_parallel(group) and not self._is_chain(group):
            return
        pack = Pack(tuple(group), tuple(self._aligned(group)))
        self.home.update(dict.fromkeys(group, len(self.packs)))
        self.packs.append(pack)
        for column in pack.columns:
            self._put(column)
        self._forward(group)

    def _is_parallel(self, group: Sequence[int]) -> bool:
        together = sum(1 << index for index in group)
        return not any(self._before[index] & together for index in group)

    def _is_chain(self, group: Sequence[int]) -> bool:
        return all(self._before[later] >> index & 1 for index, later in pairwise(group))

    def _aligned(self, group: Sequence[int]) -> Iterable[tuple[int, ...]]:
        """Arguments of each member, the first two swapped where that makes them more similar to the first member's."""
        model = self.program.operations[group[0]].arguments
        for index in group:
            first, *rest = self.program.operations[index].arguments
            given = (first, *rest)
            if self.program.operations[index].name in INTERCHANGEABLE:
                turned = (rest[0], first, *rest[1:])
                given = max((given, turned), key=lambda each: self._alike(each[:2], model[:2]))
            yield given

    def _alike(self, pair: Sequence[int], model: Sequence[int]) -> int:
        operations = self.program.operations
        return sum(
            2 * (one == other)
            + (operations[one].name == operations[other].name)
            + (one in self.home and self.home[one] == self.home.get(other))
            for one, other in zip(pair, model, strict=True)
        )

    def _forward(self, group: Sequence[int]) -> None:
        """Add candidates among the users of the members: operations that use each member in the same way."""
        table: dict[object, dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
        for index in group:
            for user, place in self._users[index]:
                if user not in self.home:
                    operation = self.program.operations[user]
                    place = 0 if operation.name in INTERCHANGEABLE and place < 2 else place
                    table[place, self._kind(operation, user)][index].append(user)
        for takers in table.values():
            for rank in range(max(map(len, takers.values()))):
                self._put(tuple(takers[each][rank] for each in group if len(takers.get(each, ())) > rank))

    def _kind(self, operation: Operation, index: int) -> tuple[object, ...]:
        """Name of an operation, of its arguments' operations, and of its users' operations."""
        operations, fixed = self.program.operations, self.program.invariant
        taken = ["" if each in fixed else operations[each].name for each in operation.arguments]
        if operation.name in INTERCHANGEABLE:
            taken[:2] = sorted(taken[:2])
        return operation.name, tuple(taken), tuple(sorted({operations[user].name for user, _ in self._users[index]}))
