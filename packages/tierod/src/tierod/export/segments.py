"""Order of the operations of a step, and their cutting into functions of bounded length that share a scratch array."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import accumulate, count

from tierod.core.graph.operations import NEXT_STATE, PUSH, RING, STATE, Branch, Condition, Program


def soon_taken(program: Program, parts: Sequence[Branch]) -> list[Branch]:
    """The same operations and branches, ordered output by output and each as late as possible."""
    home = {index: number for number, part in enumerate(parts) for index in part.operations}
    found = _Sorted(program, parts, home)
    for value in sorted(set(program.outputs.values()) & home.keys()):
        found.take(value)
    return found.parts


class _Sorted:
    def __init__(self, program: Program, given: Sequence[Branch], home: dict[int, int]):
        self.program, self.given, self.home = program, given, home
        self.parts: list[Branch] = []
        self._done: set[int] = set()
        self._users: dict[int, set[int]] = {}
        self._work: dict[int, int] = {}
        for index in (each for part in given for each in part.operations):
            arguments = program.operations[index].arguments
            self._work[index] = min(1 + sum(self._work.get(each, 0) for each in arguments), _MUCH)
            for each in arguments:
                self._users.setdefault(each, set()).add(index)

    def take(self, value: int) -> None:
        waiting = [(value, False)]
        while waiting:
            index, ready = waiting.pop()
            if index in self._done:
                continue
            part = self.given[self.home[index]]
            together = part.operations if part.condition else (index,)
            if ready:
                self._done.update(together)
                self._put(part, together)
                self._follow(together)
                continue
            waiting.append((index, True))
            own = set(together)
            needed = {each for member in together for each in self.program.operations[member].arguments}
            needed |= {part.condition.value} if part.condition else set()
            open_ = [each for each in needed if each in self.home and each not in self._done and each not in own]
            waiting += [(each, False) for each in sorted(open_, key=lambda each: (self._work[each], each))]

    def _follow(self, together: Sequence[int]) -> None:
        waiting = list(together)
        while waiting:
            index = waiting.pop()
            for user in sorted(self._users.get(index, set()) - self._done):
                part = self.given[self.home[user]]
                needed = [each for each in set(self.program.operations[user].arguments) if each in self.home]
                last = part.condition is None and any(self._users[each] - self._done == {user} for each in needed)
                if last and self._done.issuperset(needed):
                    self._done.add(user)
                    self._put(part, (user,))
                    waiting.append(user)

    def _put(self, part: Branch, together: tuple[int, ...]) -> None:
        if part.condition is None and self.parts and self.parts[-1].condition is None:
            self.parts[-1] = Branch(None, (*self.parts[-1].operations, *together))
        else:
            self.parts.append(Branch(part.condition, together))


# Limit of the cost estimate, which counts shared values once per use and would otherwise grow exponentially
_MUCH = 1 << 30


# Largest number of operations of one function; static analysers take hours for a kernel's functions of thousands. A
# step of the friction monitor needs 3 % more instructions on a Cortex-M7 with 60, and 1 % more with 120, because values
# cross functions or do not fit into registers.
LONGEST = 80

Target = tuple[int, int]  # (group, position) of an output of the program


@dataclass(frozen=True)
class Segment:
    """Operations that one function computes together."""

    condition: Condition | None  # that enables them; None if they are always executed
    operations: tuple[int, ...]  # numbers of the operations in order, without inputs and constants
    stores: tuple[Target, ...] = ()  # outputs of the program that are stored after them


@dataclass(frozen=True)
class Layout:
    """Segments in order, and storage of the values that more than one of them uses."""

    segments: tuple[Segment, ...]
    slots: dict[int, int]  # value -> element of the scratch array of its kind
    # value -> output of the program that already holds it, so that it needs no scratch element
    read_back: dict[int, Target]
    sizes: tuple[int, int]  # of the scratch arrays of numbers and of logical values


Needs = Mapping[Target, Set[int]]  # Values that the store of each output uses


def layout(
    program: Program,
    needs: Needs,
    parts: Sequence[Branch],
    truths: Set[int],
    longest: int = LONGEST,
    readable: Set[Target] = frozenset(),
) -> Layout:
    """Segments of a program, its outputs stored as early as possible, and scratch elements reused when free."""
    needed = _needed(program, needs, parts)
    cut = [
        Segment(part.condition, piece)
        for part in parts
        for piece in pieces(
            program, [each for each in part.operations if each in needed and _is_work(program, each)], longest
        )
    ]
    segments = _with_stores(program, needs, cut, longest)
    read_back = {
        program.outputs[target]: target
        for segment in segments
        for target in segment.stores
        if target in readable and program.outputs[target] in segment.operations
    }
    slots, sizes = _slots(program, needs, segments, truths, read_back)
    return Layout(tuple(segments), slots, read_back, sizes)


def pieces(program: Program, operations: Sequence[int], longest: int) -> Iterator[tuple[int, ...]]:
    """Pieces of operations, cut where the fewest values cross and at least two thirds of the longest length."""
    last = {each: place for place, index in enumerate(operations) for each in program.operations[index].arguments}
    living = [0] * (len(operations) + 1)
    for place, index in enumerate(operations):
        living[place + 1] += 1
        living[last.get(index, place) + 1 if last.get(index, place) < len(operations) else -1] -= 1
    crossing = list(accumulate(living))
    start = 0
    while len(operations) - start > longest:
        ends = range(start + longest, start + longest * 2 // 3, -1)
        stop = min(ends, key=lambda place: crossing[place])
        yield tuple(operations[start:stop])
        start = stop
    if start < len(operations):
        yield tuple(operations[start:])


def _needed(program: Program, needs: Needs, parts: Sequence[Branch]) -> set[int]:
    asked = {index: part.condition.value for part in parts if part.condition for index in part.operations}
    waiting = [value for values in needs.values() for value in values]
    found: set[int] = set()
    while waiting:
        index = waiting.pop()
        if index not in found:
            found.add(index)
            waiting += [*program.operations[index].arguments, *([asked[index]] if index in asked else [])]
    return found


def _is_work(program: Program, index: int) -> bool:
    return program.operations[index].name not in ("input", "constant") and index not in program.invariant


def _with_stores(program: Program, needs: Needs, cut: Sequence[Segment], longest: int) -> list[Segment]:
    """Segments with their stores; no state is overwritten before the last segment that reads it."""
    home = {index: place for place, segment in enumerate(cut) for index in segment.operations}
    read: dict[Target, int] = {}
    for place, segment in enumerate(cut):
        for memory in _remembered(program, _used(program, {}, segment)):
            read[memory] = place
    ready = {target: max((home.get(value, 0) for value in values), default=0) for target, values in needs.items()}
    for target, values in needs.items():
        for memory in set(_remembered(program, values)) - {target}:
            read[memory] = len(cut)  # copied to another output: stored after everything else
            ready[target] = max(ready[target], len(cut) - 1)
    stores: dict[int, list[Target]] = {}
    for target in sorted(needs):
        stores.setdefault(max(ready[target], read.get(target, 0)), []).append(target)
    segments: list[Segment] = []
    for place, segment in enumerate(cut):
        own = stores.get(place, [])
        segments.append(replace(segment, stores=() if segment.condition else tuple(own)))
        if segment.condition:
            segments += _stored(own, longest)
    # States copied to other states must all be read before the first one is written: in one segment.
    last = [each for place, own in sorted(stores.items()) if place >= len(cut) for each in own]
    return segments + _stored(last, max(longest, len(last)))


def _stored(targets: Sequence[Target], longest: int) -> list[Segment]:
    return [Segment(None, (), tuple(targets[k : k + longest])) for k in range(0, len(targets), longest)]


def _remembered(program: Program, values: Iterable[int]) -> list[Target]:
    inputs = (program.operations[value] for value in values)
    written = {STATE: NEXT_STATE, RING: PUSH}
    return [
        (written[each.constant[0]], each.constant[1])
        for each in inputs
        if each.name == "input" and each.constant[0] in written
    ]


def _slots(
    program: Program, needs: Needs, segments: Sequence[Segment], truths: Set[int], read_back: Mapping[int, Target]
) -> tuple[dict[int, int], tuple[int, int]]:
    home = {index: place for place, segment in enumerate(segments) for index in segment.operations}
    last: dict[int, int] = {}
    for place, segment in enumerate(segments):
        for index in _used(program, needs, segment):
            if index in home:
                last[index] = place
    crossing = sorted((home[i], i) for i, place in last.items() if place > home[i] and i not in read_back)
    slots: dict[int, int] = {}
    free: tuple[list[int], list[int]] = ([], [])
    ending: list[tuple[int, int]] = []
    sizes = [0, 0]
    for place, index in crossing:
        while ending and ending[0][0] < place:
            _, done = heapq.heappop(ending)
            heapq.heappush(free[done in truths], slots[done])
        kind = index in truths
        if not free[kind]:
            heapq.heappush(free[kind], sizes[kind])
            sizes[kind] += 1
        # The lowest free element first keeps the array short.
        slots[index] = heapq.heappop(free[kind])
        heapq.heappush(ending, (last[index], index))
    return slots, (sizes[0], sizes[1])


def _used(program: Program, needs: Needs, segment: Segment) -> set[int]:
    used = {argument for index in segment.operations for argument in program.operations[index].arguments}
    used = used.union(*(needs[target] for target in segment.stores))
    return used | ({segment.condition.value} if segment.condition else set())


FEWEST = 2  # Fewest operations and reads that a branch must save

SELECTIONS = ("select", "if")


@dataclass(frozen=True)
class Nested:
    """Selections with a common condition."""

    condition: int
    # number of every selection -> its values for a true and for a false condition; None for zero
    chosen: Mapping[int, tuple[int | None, int | None]]
    # operations needed only for a true and only for a false condition, in order
    sides: tuple[tuple[int, ...], tuple[int, ...]]


def nested(program: Program, operations: Sequence[int], uses: Mapping[int, Set[int]]) -> Iterator[int | Nested]:
    """Operations of a segment in order, with those that only one side of a selection needs inside branches.

    Args:
        uses: operations that use each value; -1 means a store or a use by another segment
    """
    place = dict(zip(operations, count()))
    groups: dict[int, list[int]] = {}
    for index in operations:
        if program.operations[index].name in SELECTIONS:
            condition = _asked(program, index, place).value
            if not is_presence(program, condition):
                groups.setdefault(condition, []).append(index)
    found: dict[int, Nested] = {}
    taken: set[int] = set()
    for condition, selections in groups.items():
        own = [each for each in selections if each not in taken]
        made = _branch(program, condition, own, place, uses, taken) if own else None
        if made is not None:
            found[own[0]] = made
            taken.update(made.chosen, *made.sides)
    chosen = {each for branch in found.values() for each in branch.chosen}
    values = {each for branch in found.values() for pair in branch.chosen.values() for each in pair}
    # A negation used only as a condition needs no variable; one that is also selected is a value like any other.
    asked: set[int] = set()
    for index in reversed(operations):
        if program.operations[index].name == "not" and uses[index] <= chosen | asked and index not in values:
            asked.add(index)
    for index in operations:
        if index in found:
            yield found[index]
        elif index not in taken and index not in asked:
            yield index


def is_presence(program: Program, index: int) -> bool:
    """Whether a value tests the finiteness of a value that is not an input of the sample.

    Such a value is always finite while the monitor holds its inputs, so no run would cover the branch.
    """
    operations = program.operations
    while operations[index].name == "not":
        index = operations[index].arguments[0]
    if operations[index].name != "lt":
        return False
    value, limit = (operations[each] for each in operations[index].arguments)
    endless = limit.name == "constant" and limit.constant == float("inf")
    return endless and value.name == "fabs" and operations[value.arguments[0]].name != "input"


def _branch(
    program: Program,
    condition: int,
    selections: list[int],
    place: Mapping[int, int],
    uses: Mapping[int, Set[int]],
    taken: Set[int],
) -> Nested | None:
    """Branch at the position of the first selection; None where it would save too little."""
    kept = list(selections)
    while True:
        chosen = {each: _values(program, each, place) for each in kept}
        sides = _sides(program, chosen, place, uses, taken)
        late = {each for each in kept[1:] if not _ready(program, each, chosen, sides, place, kept[0])}
        if not late:
            break
        kept = [each for each in kept if each not in late]
    ordered = tuple(tuple(sorted(side, key=place.__getitem__)) for side in sides)
    reads = sum(
        program.operations[value].name == "input" and value not in program.invariant and len(uses[value]) == 1
        for pair in chosen.values()
        for value in pair
        if value is not None
    )
    if len(ordered[0]) + len(ordered[1]) + reads < FEWEST:
        return None
    return Nested(condition, chosen, (ordered[0], ordered[1]))


def _asked(program: Program, selection: int, place: Mapping[int, int]) -> Condition:
    value, holds = program.operations[selection].arguments[0], True
    while value in place and program.operations[value].name == "not":
        value, holds = program.operations[value].arguments[0], not holds
    return Condition(value, holds)


def _values(program: Program, selection: int, place: Mapping[int, int]) -> tuple[int | None, int | None]:
    _, first, *rest = program.operations[selection].arguments
    pair = (first, rest[0] if rest else None)
    return pair if _asked(program, selection, place).holds else pair[::-1]


def _sides(
    program: Program,
    chosen: Mapping[int, tuple[int | None, int | None]],
    place: Mapping[int, int],
    uses: Mapping[int, Set[int]],
    taken: Set[int],
) -> tuple[set[int], set[int]]:
    sides: tuple[set[int], set[int]] = (set(), set())
    last = max(place[each] for each in chosen)
    for index in sorted(place, key=place.__getitem__, reverse=True):
        if place[index] >= last or index in taken or index in chosen:
            continue
        for side, other in ((0, 1), (1, 0)):
            if uses[index] and all(
                user in sides[side]
                or (
                    user in chosen
                    and chosen[user][side] == index
                    and chosen[user][other] != index
                    and program.operations[user].arguments[0] != index
                )
                for user in uses[index]
            ):
                sides[side].add(index)
    return sides


def _ready(
    program: Program,
    selection: int,
    chosen: Mapping[int, tuple[int | None, int | None]],
    sides: tuple[set[int], set[int]],
    place: Mapping[int, int],
    first: int,
) -> bool:
    for side, value in zip(sides, chosen[selection], strict=True):
        waiting = [value] if value is not None else []
        while waiting:
            index = waiting.pop()
            if index in side:
                waiting += program.operations[index].arguments
            elif place.get(index, -1) >= place[first]:
                return False
    return True
