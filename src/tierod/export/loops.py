"""Loops over packs: which packs can be worked out turn by turn, and in which order loops and straight pieces follow."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass

from tierod.core.graph.operations import Program, is_constant
from tierod.export.net import Net
from tierod.export.packs import Pack


@dataclass(frozen=True)
class Cluster:
    """Packs that are worked out together in one loop, since each turn takes what the turn before gave; or one pack.

    Args:
        packs: in the order of a turn
        handed_on: columns that a turn takes from the turn before, and the members that they are from the second turn on
    """

    packs: tuple[Pack, ...]
    handed_on: Mapping[tuple[int, ...], tuple[int, ...]]

    @property
    def turns(self) -> int:
        """Of the loop."""
        return len(self.packs[0].members)


def clusters(net: Net, given: Sequence[Pack], truths: Set[int]) -> list[Cluster]:
    """Packs as loops can work them out; of those that wait for each other in a circle the smallest are left out.

    Args:
        net: of the program
        given: packs
        truths: values that are 0 or 1
    """
    kept = list(given)
    while True:
        home = {index: number for number, pack in enumerate(kept) for index in pack.members}
        circles = _circles(net, kept, home)
        found, dropped = [], set()
        for numbers, alone in circles:
            made = _cluster(net, [kept[k] for k in numbers], truths) if alone else None
            if made is None:
                dropped.add(min(numbers, key=lambda k: (len(kept[k].members), -k)))
            else:
                found.append(made)
        if not dropped:
            return found
        kept = [pack for k, pack in enumerate(kept) if k not in dropped]


def _circles(net: Net, kept: Sequence[Pack], home: Mapping[int, int]) -> Iterable[tuple[list[int], bool]]:
    """Packs that wait for each other, and whether nothing else is among them."""
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
    """A loop over packs that wait for each other; None where a turn needs more than itself and the turn before."""
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
        program: that it belongs to
        index: its number
        truths: values that are known to be
    """
    operation = program.operations[index]
    return index in truths or is_constant(operation, 0.0) or is_constant(operation, 1.0)


def ordered(numbers: Iterable[int], before: Mapping[int, Set[int]]) -> list[int] | None:
    """Numbers so that each comes after those that are before it; None where they are in a circle.

    Args:
        numbers: in the order that is kept where it may be
        before: number -> those that come before it
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
