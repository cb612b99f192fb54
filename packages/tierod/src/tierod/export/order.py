"""Order of the operations of a step in which values are used soon after they are computed, to save registers."""

from __future__ import annotations

from collections.abc import Sequence

from tierod.core.graph.operations import Branch, Program


def soon_taken(program: Program, parts: Sequence[Branch]) -> list[Branch]:
    """The same operations and branches, ordered output by output and each as late as possible.

    Args:
        parts: all its operations, each after those that it depends on
    """
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


_MUCH = 1 << 30
"""Limit of the cost estimate, which counts shared values once per use and would otherwise grow exponentially."""
