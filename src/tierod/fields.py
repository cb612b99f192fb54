"""Fields of frozen dataclasses as parameters: unit, range, and a dotted path to each."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from functools import cache
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from tierod.errors import ParameterError, nearest
from tierod.ranges import Range


class Meaning(NamedTuple):
    """What an annotation says.

    Args:
        hint: the type without its notes
        unit: in the notation of pint; None where the annotation says none
        limits: the values that make sense; None where any does
    """

    hint: Any
    unit: str | None
    limits: Range | None


class Number(NamedTuple):
    """A float field somewhere in a dataclass."""

    value: float
    unit: str
    limits: Range | None


@cache
def hints(kind: type) -> dict[str, Any]:
    """Annotations of a class by field, with their notes."""
    return get_type_hints(kind, include_extras=True)


def meaning(annotation: Any) -> Meaning:
    """What an annotation like `Annotated[float, "kg", POSITIVE]` says."""
    if get_origin(annotation) is not Annotated:
        return Meaning(annotation, None, None)
    hint, *notes = get_args(annotation)
    unit = next((note for note in notes if isinstance(note, str)), None)
    return Meaning(hint, unit, next((note for note in notes if isinstance(note, Range)), None))


def alternatives(hint: Any) -> tuple[Any, ...]:
    """The members of a union without None; the hint itself where it is none."""
    if get_origin(hint) in (Union, UnionType):
        return tuple(member for member in get_args(hint) if member is not type(None))
    return (hint,)


def numbers(instance: Any) -> dict[str, Number]:
    """Every float field of a dataclass and of what is nested in it, by dotted path; elements of tuples by number."""
    return dict(_numbers(instance, Meaning(type(instance), None, None), ""))


def _numbers(value: Any, means: Meaning, path: str) -> Iterator[tuple[str, Number]]:
    if isinstance(value, float | int) and not isinstance(value, bool):
        members = [meaning(member) for member in alternatives(means.hint)]
        floats = [member for member in members if member.hint is float]
        if floats:
            yield path, Number(float(value), means.unit or floats[0].unit or "", means.limits or floats[0].limits)
        return
    for name, part, annotation in _parts(value, means):
        yield from _numbers(part, meaning(annotation), f"{path}.{name}" if path else name)


def _parts(value: Any, means: Meaning) -> list[tuple[str, Any, Any]]:
    """(name, value, annotation) of what a value is made of; none for a plain one."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        known = hints(type(value))
        return [(field.name, getattr(value, field.name), known[field.name]) for field in dataclasses.fields(value)]
    if isinstance(value, Mapping):
        inner = (get_args(means.hint) or (str, Any))[1]
        return [(str(name), part, _noted(inner, means)) for name, part in value.items()]
    if isinstance(value, tuple):
        members = [_noted(member, means) for member in alternatives(means.hint)]
        means = next((each for each in map(meaning, members) if get_origin(each.hint) is tuple), means)
        inner = get_args(means.hint)
        each = inner[:1] * len(value) if inner[-1:] == (Ellipsis,) or len(inner) != len(value) else inner
        return [(str(i), part, _noted(hint, means)) for i, (part, hint) in enumerate(zip(value, each, strict=False))]
    return []


def _noted(annotation: Any, means: Meaning) -> Any:
    """An element's annotation, with the unit and range of the whole where it has none itself."""
    own = meaning(annotation)
    notes = [note for note in (own.unit or means.unit, own.limits or means.limits) if note is not None]
    return Annotated[(own.hint, *notes)] if notes else annotation


def number(instance: Any, path: str, what: str = "") -> Number:
    """The float field at a dotted path.

    Args:
        instance: a dataclass
        path: for example "steering.friction.level"
        what: how to call the instance in a message; the name of its class where it is empty

    Raises:
        ParameterError: there is no float field of this path; the message names the nearest ones
    """
    known = numbers(instance)
    if path not in known:
        raise ParameterError(f"{what or type(instance).__name__} has no parameter '{path}'{nearest(path, known)}")
    return known[path]


def replaced(instance: Any, changes: Mapping[str, Any]) -> Any:
    """The dataclass with the values at some dotted paths replaced; the paths have to be there."""
    below: dict[str, dict[str, Any]] = {}
    values: dict[str, Any] = {}
    for path, value in changes.items():
        name, _, rest = path.partition(".")
        if rest:
            below.setdefault(name, {})[rest] = value
        else:
            values[name] = value
    for name, inner in below.items():
        values[name] = replaced(_part(instance, name), inner)
    return _with(instance, values)


def _part(instance: Any, name: str) -> Any:
    if isinstance(instance, Mapping):
        return instance[name]
    return instance[int(name)] if isinstance(instance, tuple) else getattr(instance, name)


def _with(instance: Any, values: dict[str, Any]) -> Any:
    if isinstance(instance, Mapping):
        return {**instance, **values}
    if isinstance(instance, tuple):
        return tuple(values.get(str(number), part) for number, part in enumerate(instance))
    return dataclasses.replace(instance, **values)
