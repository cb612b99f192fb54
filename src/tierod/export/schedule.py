"""Order of loops and of the straight pieces between them, with as many independent packs in one loop as possible."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass

from tierod.export.loops import Cluster, ordered
from tierod.export.net import Net
from tierod.export.packs import Pack


@dataclass(frozen=True)
class Loop:
    """Packs computed together, iteration by iteration.

    Args:
        packs: packs in the order of one iteration
        handed_on: columns taken from the previous iteration, see `Cluster`
    """

    packs: tuple[Pack, ...]
    handed_on: Mapping[tuple[int, ...], tuple[int, ...]]

    @property
    def turns(self) -> int:
        """Number of iterations."""
        return len(self.packs[0].members)


Part = tuple[int, ...] | Loop
"""A straight sequence of operations, or a loop."""


def arranged(net: Net, found: Sequence[Cluster], longest: int) -> list[Part]:
    """All operations and stores in an order in which each follows those that it depends on.

    Args:
        net: of the program
        found: clusters; operations outside of all clusters form straight pieces
        longest: largest number of operations of a loop body
    """
    return list(_Scheduler(net, found, longest).parts())


class _Scheduler:
    """Scheduler of units: clusters, and single operations outside of them, numbered by cluster or operation."""

    def __init__(self, net: Net, found: Sequence[Cluster], longest: int):
        self.net, self.longest = net, longest
        size = len(net.program.operations)
        self.clusters = {size + number: each for number, each in enumerate(found)}
        self.turn = {
            index: (unit, k)
            for unit, each in self.clusters.items()
            for pack in each.packs
            for k, index in enumerate(pack.members)
        }
        self.before: dict[int, set[int]] = {}
        self.apart: set[tuple[int, int]] = set()
        for index in sorted(net.needed):
            self._wait(index)
        for unit in self.clusters:
            self._part(unit)
        stores = [self._unit(index) for index in sorted(net.needed) if net.target(index) is not None]
        order = ordered(dict.fromkeys(stores), self.before)
        if order is None:
            raise AssertionError("clusters that wait for each other are no clusters")
        self.order = order

    def _unit(self, index: int) -> int:
        return self.turn[index][0] if index in self.turn else index

    def _wait(self, index: int) -> None:
        """Record the units on which an operation's unit depends, and those that cannot share its loop."""
        own = self._unit(index)
        before = self.before.setdefault(own, set())
        for each in self.net.awaited(index):
            other = self._unit(each)
            if other != own:
                before.add(other)
                # A state must be overwritten in the same iteration that reads it or in a later one.
                if index in self.turn and each in self.turn and self.turn[index][1] < self.turn[each][1]:
                    self.apart.add((own, other))

    def _part(self, unit: int) -> None:
        """Record clusters that cannot share a loop, because a column does not take the values of exactly one pack."""
        whole = {pack.members for each in self.clusters.values() for pack in each.packs}
        for column in {column for pack in self.clusters[unit].packs for column in pack.columns} - whole:
            self.apart |= {(unit, self.turn[each][0]) for each in column if each in self.turn}

    def parts(self) -> Iterator[Part]:
        """Straight pieces and loops in order of execution."""
        left, done = list(self.order), set[int]()
        while any(unit in self.clusters for unit in left):
            free, together = self._open(left, done)
            turns = max(together, key=lambda each: (sum(self._size(unit) for unit in together[each]), each))
            chosen = together[turns]
            wanted = self._wanted(chosen, free)
            straight = tuple(unit for unit in left if unit in wanted)
            if straight:
                yield straight
            yield from self._cut(chosen)
            done |= wanted | set(chosen)
            left = [unit for unit in left if unit not in done]
        if left:
            yield tuple(left)

    def _size(self, unit: int) -> int:
        return sum(len(pack.members) for pack in self.clusters[unit].packs)

    def _open(self, left: Sequence[int], done: Set[int]) -> tuple[set[int], dict[int, list[int]]]:
        """Operations independent of any loop, and clusters that can form the next loop, by number of iterations."""
        free: set[int] = set()
        together: dict[int, list[int]] = {}
        home: dict[int, int] = {}
        for unit in left:
            waits = self.before.get(unit, set()) - done
            if unit not in self.clusters:
                if waits <= free:
                    free.add(unit)
                continue
            turns = self.clusters[unit].turns
            if all(each in free or (home.get(each) == turns and (unit, each) not in self.apart) for each in waits):
                together.setdefault(turns, []).append(unit)
                home[unit] = turns
        return free, together

    def _wanted(self, chosen: Sequence[int], free: Set[int]) -> set[int]:
        """Operations on which some clusters depend."""
        found: set[int] = set()
        waiting = [each for unit in chosen for each in self.before.get(unit, ())]
        while waiting:
            unit = waiting.pop()
            if unit in free and unit not in found:
                found.add(unit)
                waiting += self.before.get(unit, ())
        return found

    def _cut(self, chosen: Sequence[int]) -> Iterator[Loop]:
        """Loops with bodies of bounded length."""
        body: list[Cluster] = []
        for unit in chosen:
            own = self.clusters[unit]
            if body and sum(len(each.packs) for each in body) + len(own.packs) > self.longest:
                yield _loop(body)
                body = []
            body.append(own)
        yield _loop(body)


def _loop(body: Sequence[Cluster]) -> Loop:
    handed_on = {column: members for each in body for column, members in each.handed_on.items()}
    return Loop(tuple(pack for each in body for pack in each.packs), handed_on)
