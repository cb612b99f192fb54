"""Cut a straight line of operations into pieces of bounded length; what crosses them lies in a scratch array."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import accumulate

from tierod.core.graph.branches import Branch, Condition
from tierod.core.graph.operations import NEXT_STATE, PUSH, RING, STATE, Program

LONGEST = 80
"""Operations of one function: checkers of C take hours for the functions of thousands that a kernel is made of. With 60
a step of the friction monitor takes 3 % more instructions of a Cortex-M7, with 120 1 % more, since values cross
functions or do not fit in registers."""

Target = tuple[int, int]
"""(group, position) of an output of the program."""


@dataclass(frozen=True)
class Segment:
    """Operations that one function works out together.

    Args:
        condition: under which; None for what is always needed
        operations: their numbers, in order; inputs and constants are not among them
        stores: outputs of the program that are put away after them
    """

    condition: Condition | None
    operations: tuple[int, ...]
    stores: tuple[Target, ...] = ()


@dataclass(frozen=True)
class Layout:
    """Segments in order, and where the values lie that more than one of them uses.

    Args:
        segments: in order
        slots: value -> place in the scratch array of its kind
        read_back: value -> output of the program that holds it from where it is worked out, so that it needs no slot
        sizes: of the scratch arrays: of numbers and of truths
    """

    segments: tuple[Segment, ...]
    slots: dict[int, int]
    read_back: dict[int, Target]
    sizes: tuple[int, int]


Needs = Mapping[Target, Set[int]]
"""Values that the storing of each output takes."""


def layout(
    program: Program,
    needs: Needs,
    parts: Sequence[Branch],
    truths: Set[int],
    longest: int = LONGEST,
    readable: Set[Target] = frozenset(),
) -> Layout:
    """Segments of a program, its outputs stored as early as they may be, and places that are used again when free.

    Args:
        program: whose step is cut
        needs: of every output
        parts: all its operations, so ordered that each comes after what it needs
        truths: values that are 0 or 1; they lie in an array of their own
        longest: operations of a segment
        readable: outputs that hold a value as it was worked out
    """
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
    """Operations cut where the fewest values cross, not far below the longest piece.

    Args:
        program: that they belong to
        operations: in order
        longest: operations of a piece
    """
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
    """Values that the outputs take, and the conditions under which they are worked out."""
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
    """The segments with what each puts away: nothing remembered is overwritten before the last one that reads it."""
    home = {index: place for place, segment in enumerate(cut) for index in segment.operations}
    read: dict[Target, int] = {}
    for place, segment in enumerate(cut):
        for memory in _remembered(program, _used(program, {}, segment)):
            read[memory] = place
    ready = {target: max((home.get(value, 0) for value in values), default=0) for target, values in needs.items()}
    for target, values in needs.items():
        for memory in set(_remembered(program, values)) - {target}:
            read[memory] = len(cut)  # copied: stored when all else is done
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
    # States that become other states are all read before the first of them is written: in one segment.
    last = [each for place, own in sorted(stores.items()) if place >= len(cut) for each in own]
    return segments + _stored(last, max(longest, len(last)))


def _stored(targets: Sequence[Target], longest: int) -> list[Segment]:
    """Segments that put away and do nothing else."""
    return [Segment(None, (), tuple(targets[k : k + longest])) for k in range(0, len(targets), longest)]


def _remembered(program: Program, values: Iterable[int]) -> list[Target]:
    """Places where the states and delay lines among some values are overwritten."""
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
        slots[index] = heapq.heappop(free[kind])
        heapq.heappush(ending, (last[index], index))
    return slots, (sizes[0], sizes[1])


def _used(program: Program, needs: Needs, segment: Segment) -> set[int]:
    """Values that a segment takes."""
    used = {argument for index in segment.operations for argument in program.operations[index].arguments}
    used = used.union(*(needs[target] for target in segment.stores))
    return used | ({segment.condition.value} if segment.condition else set())
