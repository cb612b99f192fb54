"""A step rolled into loops: packs in loops, straight pieces between them, and storage of values crossing them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, replace

from tierod.core.graph.operations import Operation
from tierod.export.addresses import columns_of
from tierod.export.loops import Cluster, clusters, is_truth
from tierod.export.net import Net, linked
from tierod.export.packs import Pack, packs
from tierod.export.schedule import Loop, Part, arranged
from tierod.export.segments import pieces

WORTH = 24
"""Fewest operations of a loop; with fewer, straight code is shorter."""


@dataclass(frozen=True)
class Rolled:
    """A step as loops and straight pieces.

    Args:
        net: of the program; its loops use only values that the iteration number can address
        truths: logical values (0 or 1)
        parts: in order of execution
    """

    net: Net
    truths: frozenset[int]
    parts: tuple[Part, ...]


def rolled(
    net: Net,
    families: Iterable[Sequence[int]],
    truths: frozenset[int],
    reached: Callable[[int], str],
    longest: int,
) -> Rolled:
    """A step with its packs rolled into loops.

    Args:
        net: of the program
        families: families of inputs and outputs, see `packs`
        truths: logical values (0 or 1)
        reached: C code of an input, of a value that depends on parameters only, or of the destination of a store
        longest: largest number of operations of a loop body
    """
    found = packs(net, families, truths)
    while True:
        # Without a small pack the others may join differently, so loops are formed again until none is small.
        kept = [_put_away(net, each, reached) for each in found]
        made = clusters(net, [each for each in kept if each is not None], truths)
        parts = arranged(net, made, longest)
        small = {
            pack.members
            for part in parts
            if isinstance(part, Loop) and sum(len(pack.members) for pack in part.packs) < WORTH
            for pack in part.packs
        }
        if not small:
            break
        found = [pack for each in made for pack in each.packs if pack.members not in small]
    copier = _Copier(net, truths, reached)
    whole = [copier.reachable(each) for each in made]
    after = copier.net()
    parts = [
        piece
        for part in arranged(after, whole, longest)
        for piece in ([part] if isinstance(part, Loop) else pieces(after.program, part, longest))
    ]
    return Rolled(after, frozenset(copier.truths), tuple(parts))


def _put_away(net: Net, pack: Pack, reached: Callable[[int], str]) -> Pack | None:
    """The pack itself; None for stores whose destinations the iteration number cannot address."""
    if net.target(pack.members[0]) is None:
        return pack
    return pack if columns_of([reached(index) for index in pack.members]) is not None else None


class _Copier:
    """Copies, into adjacent scratch elements, of values that the iteration number cannot address."""

    def __init__(self, net: Net, truths: frozenset[int], reached: Callable[[int], str]):
        self._net, self._reached = net, reached
        self.truths = set(truths)
        self._operations = list(net.program.operations)
        self._copies: dict[tuple[int, bool], int] = {}

    def net(self) -> Net:
        """Net with the copies."""
        program = replace(self._net.program, operations=tuple(self._operations))
        return linked(program, [index for index in self._net.needed if self._net.target(index) is not None])

    def reachable(self, cluster: Cluster) -> Cluster:
        """A cluster that uses copies where necessary."""
        made = []
        for pack in cluster.packs:
            columns = [each if each in cluster.handed_on else self._column(each) for each in pack.columns]
            rows = tuple(zip(*columns, strict=True))
            for index, row in zip(pack.members, rows, strict=True):
                self._operations[index] = self._operations[index]._replace(arguments=row)
            made.append(replace(pack, arguments=rows))
        return replace(cluster, packs=tuple(made))

    def _column(self, column: tuple[int, ...]) -> tuple[int, ...]:
        """A column of arguments that an iteration number can address."""
        alike = {self._lies(index) for index in column}
        if len(set(column)) == 1 or (len(alike) == 1 and self._is_reached(column, alike.pop())):
            return column
        truth = all(is_truth(self._net.program, index, self.truths) for index in column)
        wanted = "truth" if truth else "number"
        return tuple(index if self._lies(index) == wanted else self._copy(index, truth) for index in column)

    def _lies(self, index: int) -> str:
        """Storage of a value: the scratch array of its kind, a constant, or outside."""
        if self._net.is_work(index) or index >= len(self._net.program.operations):
            return "truth" if index in self.truths else "number"
        return "constant" if self._operations[index].name == "constant" else "outside"

    def _is_reached(self, column: Sequence[int], where: str) -> bool:
        return where != "outside" or columns_of([self._reached(index) for index in column]) is not None

    def _copy(self, index: int, truth: bool) -> int:
        if (index, truth) not in self._copies:
            self._copies[index, truth] = len(self._operations)
            if truth:
                self.truths.add(len(self._operations))
            self._operations.append(Operation("assign", (index,)))
        return self._copies[index, truth]


# -- where values lie ------------------------------------------------------------------------------------------------


def outside(loop: Loop) -> list[tuple[int, ...]]:
    """Columns that a loop takes from other parts, each once.

    Args:
        loop: with its packs
    """
    own = {pack.members for pack in loop.packs}
    columns = dict.fromkeys(column for pack in loop.packs for column in pack.columns)
    return [each for each in columns if each not in own and each not in loop.handed_on]


def taken(net: Net, part: Part) -> set[int]:
    """Values that a part takes from other parts.

    Args:
        net: of the program
        part: a loop or a straight piece
    """
    if isinstance(part, Loop):
        found = {index for column in outside(part) for index in column}
        return found | {column[0] for column in part.handed_on}
    own = set(part)
    return {each for index in part for each in net.program.operations[index].arguments} - own


def places(step: Rolled) -> tuple[dict[int, int], tuple[int, int]]:
    """Scratch element of every value that crosses parts, and the sizes of both scratch arrays.

    Values that a loop computes or uses iteration by iteration are stored adjacently where possible.

    Args:
        step: rolled into loops
    """
    home = {index: number for number, part in enumerate(step.parts) for index in worked(part)}
    last: dict[int, int] = {}
    for number, part in enumerate(step.parts):
        last.update(dict.fromkeys((each for each in taken(step.net, part) if each in home), number))
    slots: dict[int, int] = {}
    busy: tuple[list[int], list[int]] = ([], [])
    bundles = sorted(_bundles(step, home, last), key=lambda each: min(home[index] for index in each))
    for bundle in bundles:
        begun, ended = min(home[index] for index in bundle), max(last.get(index, 0) for index in bundle)
        until = busy[bundle[0] in step.truths]
        first = _free(until, len(bundle), begun)
        until += [-1] * (first + len(bundle) - len(until))
        until[first : first + len(bundle)] = [ended] * len(bundle)
        slots.update({index: first + k for k, index in enumerate(bundle)})
    return slots, (len(busy[0]), len(busy[1]))


def worked(part: Part) -> Iterable[int]:
    """Operations and stores of a part.

    Args:
        part: a loop or a straight piece
    """
    return (index for pack in part.packs for index in pack.members) if isinstance(part, Loop) else part


def _free(until: Sequence[int], count: int, begun: int) -> int:
    """First of `count` adjacent elements that are free from a part on; they may extend beyond the present end."""
    first = 0
    for place, ended in enumerate(until):
        if place - first == count:
            break
        if ended >= begun:
            first = place + 1
    return first


def _bundles(step: Rolled, home: Mapping[int, int], last: Mapping[int, int]) -> list[tuple[int, ...]]:
    """Groups of values that are stored adjacently."""
    found: list[tuple[int, ...]] = []
    done: set[int] = set()

    def bundle(values: Sequence[int]) -> None:
        found.append(tuple(values))
        done.update(values)

    loops = [part for part in step.parts if isinstance(part, Loop)]
    for loop in loops:
        for pack in loop.packs:
            crossing = [index for index in pack.members if index in last]
            if crossing and not is_kept_at_the_end(loop, pack, last):
                bundle(pack.members)
    columns = [column for loop in loops for column in outside(loop) if all(index in last for index in column)]
    for column in sorted(columns, key=len, reverse=True):
        if done.isdisjoint(column) and len(set(column)) == len(column):
            bundle(column)
    for index in sorted(last.keys() - done, key=lambda each: (home[each], each)):
        bundle((index,))
    return found


def is_kept_at_the_end(loop: Loop, pack: Pack, crossing: Set[int] | Mapping[int, int]) -> bool:
    """Whether only the last value of a pack is used outside its loop, where the hand-over variable still holds it.

    Args:
        loop: that contains the pack
        pack: of the loop
        crossing: values used in other parts
    """
    others = any(index in crossing for index in pack.members[:-1])
    return not others and pack.members in loop.handed_on.values()
