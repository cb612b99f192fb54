"""Loops over packs: which packs a loop can compute iteration by iteration, and the order of their operations."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass

from tierod.core.graph.operations import Program, is_constant
from tierod.export.net import Net
from tierod.export.packs import Pack


@dataclass(frozen=True)
class Cluster:
    """Packs computed together in one loop, because each iteration uses results of the previous one; or a single pack.

    Args:
        packs: packs in the order of one iteration
        handed_on: columns taken from the previous iteration -> members that provide them from the second iteration on
    """

    packs: tuple[Pack, ...]
    handed_on: Mapping[tuple[int, ...], tuple[int, ...]]

    @property
    def turns(self) -> int:
        """Number of iterations."""
        return len(self.packs[0].members)


def clusters(net: Net, given: Sequence[Pack], truths: Set[int]) -> list[Cluster]:
    """Clusters of packs that loops can compute; the smallest packs of a cyclic dependence are dropped.

    Args:
        net: of the program
        given: packs
        truths: logical values (0 or 1)
    """
    kept = list(given)
    while True:
        home = {index: number for number, pack in enumerate(kept) for index in pack.members}
        circles = _circles(net, kept, home)
        found, dropped = [], set()
        for numbers, alone in circles:
            made = _cluster(net, [kept[k] for k in numbers], truths) if alone else None
            if made is None:
                # One pack per cycle and pass: without it the others may form a loop after all.
                dropped.add(min(numbers, key=lambda k: (len(kept[k].members), -k)))
            else:
                found.append(made)
        if not dropped:
            return found
        kept = [pack for k, pack in enumerate(kept) if k not in dropped]


def _circles(net: Net, kept: Sequence[Pack], home: Mapping[int, int]) -> Iterable[tuple[list[int], bool]]:
    """Packs that depend on each other cyclically, and whether the cycle consists of packs only."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components

    size = len(net.program.operations)
    unit = [size + home[index] if index in home else index for index in range(size)]
    pairs = {(unit[each], unit[index]) for index in range(size) if net.is_work(index) for each in net.awaited(index)}
    rows, columns = zip(*pairs, strict=True) if pairs else ((), ())
    whole = size + len(kept)
    graph = csr_matrix(([1] * len(pairs), (rows, columns)), shape=(whole, whole))
    _, labels = connected_components(graph, connection="strong")
    members: dict[int, list[int]] = defaultdict(list)
    for index, label in enumerate(labels.tolist()):
        if index not in home:
            members[label].append(index)
    for group in members.values():
        numbers = [index - size for index in group if index >= size]
        if numbers:
            yield numbers, len(numbers) == len(group)


def _cluster(net: Net, own: Sequence[Pack], truths: Set[int]) -> Cluster | None:
    """Loop over mutually dependent packs; None where an iteration needs more than itself and the previous one."""
    turns = len(own[0].members)
    if any(len(pack.members) != turns for pack in own):
        return None
    turn = {index: (number, k) for number, pack in enumerate(own) for k, index in enumerate(pack.members)}
    before: dict[int, set[int]] = defaultdict(set)
    handed_on: dict[tuple[int, ...], tuple[int, ...]] = {}
    for number, pack in enumerate(own):
        for column in pack.columns:
            inside = [turn.get(each) for each in column]
            if any(each is not None and each[1] != k for k, each in enumerate(inside)):
                source = next(each[0] for each in inside if each is not None)
                if column[0] in turn or column[1:] != own[source].members[:-1]:
                    return None
                if own[source].members[0] in truths and not is_truth(net.program, column[0], truths):
                    return None
                handed_on[column] = own[source].members
            else:
                before[number] |= {each[0] for each in inside if each is not None}
        for k, index in enumerate(pack.members):
            for reader in net.after.get(index, ()):
                if reader in turn:
                    if turn[reader][1] > k:
                        return None
                    before[number] |= {turn[reader][0]} if turn[reader][1] == k else set()
    order = ordered(range(len(own)), before)
    return None if order is None else Cluster(tuple(own[k] for k in order), handed_on)


def is_truth(program: Program, index: int, truths: Set[int]) -> bool:
    """Whether a value is 0 or 1.

    Args:
        program: that contains it
        index: number of the value
        truths: values known to be logical
    """
    operation = program.operations[index]
    return index in truths or is_constant(operation, 0.0) or is_constant(operation, 1.0)


def ordered(numbers: Iterable[int], before: Mapping[int, Set[int]]) -> list[int] | None:
    """Topological order of numbers; None where they form a cycle.

    Args:
        numbers: in the preferred order
        before: number -> numbers that must come before it
    """
    done: dict[int, bool] = {}
    found: list[int] = []
    for first in numbers:
        waiting = [(first, False)]
        while waiting:
            number, left = waiting.pop()
            if left:
                done[number] = True
                found.append(number)
            elif number not in done:
                done[number] = False
                waiting.append((number, True))
                for each in sorted(before.get(number, ()), reverse=True):
                    if done.get(each) is False:
                        return None
                    waiting.append((each, False))
    return found
