"""Block some of whose parameters become time-varying inputs."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, get_type_hints

from tierod.core.block import Tree, named_tuple, tuning
from tierod.core.errors import ParameterError, nearest
from tierod_lab.ground.parts import Plant


@dataclass(frozen=True)
class Varied:
    """A block with some of its float fields as inputs, in a branch `parameters` of its sample.

    Args:
        paths: dotted names of float fields ("steering.friction.level"); the inputs replace their values in the block

    Raises:
        ParameterError: the block has no such float field
    """

    block: Plant
    paths: tuple[str, ...]

    def __post_init__(self) -> None:
        known = [path for path, _ in tuning(self.block)]
        for path in self.paths:
            if path not in known:
                raise ParameterError(f"{type(self.block).__name__} has no parameter '{path}'{nearest(path, known)}")

    @property
    def Sample(self) -> type:
        """Sample of the block, with a branch `parameters`."""
        own: type = self.block.Sample
        return _sample(own, tuple(sorted(self.paths)))

    def init(self) -> Tree:
        return self.block.init()

    def step(self, state: Tree, sample: Tree) -> tuple[Tree, Tree]:
        *own, parameters = sample
        changed: Plant = _changed(self.block, parameters)
        return changed.step(state, self.block.Sample(*own))


_ITEM = "item_"


def path_of(name: str) -> str:
    """Dotted path of a `Varied` parameter from the name of an input, in which items of tuples carry a prefix."""
    return name.replace(f".{_ITEM}", ".")


@cache
def _sample(own: type, paths: tuple[str, ...]) -> type:
    hints = get_type_hints(own, include_extras=True)
    fields = [(name, hints[name]) for name in own._fields]  # type: ignore[attr-defined]  # a NamedTuple
    return named_tuple("Sample", [*fields, ("parameters", _branch("Parameters", paths))])


def _branch(name: str, paths: Iterable[str]) -> Any:
    """Nested NamedTuple classes for dotted paths, in which a leaf has the name of the field it replaces."""
    below: dict[str, list[str]] = {}
    for path in paths:
        head, _, rest = path.partition(".")
        below.setdefault(head, []).append(rest)
    return named_tuple(
        name,
        [
            (_field(head), Annotated[float, ""] if rests == [""] else _branch(head.capitalize(), rests))
            for head, rests in below.items()
        ],
    )


def _field(head: str) -> str:
    return head if head.isidentifier() else f"{_ITEM}{head}"


def _changed(part: Any, values: Tree) -> Any:
    """Copy of a dataclass or tuple with fields replaced at any depth; without checks, since values may be symbols."""
    fresh = {
        name.removeprefix(_ITEM): _changed(_get(part, name), value) if isinstance(value, tuple) else value
        for name, value in zip(values._fields, values, strict=True)
    }
    if isinstance(part, tuple):
        names = getattr(part, "_fields", tuple(map(str, range(len(part)))))
        parts = [fresh.get(name, value) for name, value in zip(names, part, strict=True)]
        return type(part)(*parts) if hasattr(part, "_fields") else tuple(parts)
    copy = object.__new__(type(part))
    for field in dataclasses.fields(part):
        object.__setattr__(copy, field.name, fresh.get(field.name, getattr(part, field.name)))
    return copy


def _get(part: Any, name: str) -> Any:
    return part[int(name.removeprefix(_ITEM))] if name.startswith(_ITEM) else getattr(part, name)
