"""Fields of frozen dataclasses as parameters: unit, range, and a dotted path to each.

A range follows the unit in the annotation: `Annotated[float, "kg", POSITIVE]`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from functools import cache
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from tierod.core.errors import ParameterError


class Range(NamedTuple):
    """Range of valid values, in the unit of the annotation."""

    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False  # whether the lower limit itself is excluded

    def holds(self, value: float) -> bool:
        """Whether a number is finite and lies inside."""
        return (
            math.isfinite(value) and (self.low < value if self.open_low else self.low <= value) and value <= self.high
        )

    def __str__(self) -> str:
        if self.high == math.inf:
            return f"above {self.low:g}" if self.open_low else f"at least {self.low:g}"
        return f"above {self.low:g} and at most {self.high:g}" if self.open_low else f"{self.low:g} to {self.high:g}"


ANY = Range()
POSITIVE = Range(0.0, math.inf, open_low=True)
NOT_NEGATIVE = Range(0.0)
SHARE = Range(0.0, 1.0)
COUNT = Range(1.0)


class Meaning(NamedTuple):
    hint: Any
    unit: str | None  # unit in the notation of pint; None where the annotation has none
    limits: Range | None  # range of valid values; None where any value is valid


class Number(NamedTuple):
    """Value, unit and range of a float field at any depth of a dataclass."""

    value: float
    unit: str
    limits: Range | None


@cache
def hints(kind: object) -> dict[str, Any]:
    """Annotations of a class by field, with their notes."""
    return get_type_hints(kind, include_extras=True)


@cache
def meaning(annotation: object) -> Meaning:
    """Unit and range of an annotation like `Annotated[float, "kg", POSITIVE]`."""
    if get_origin(annotation) is not Annotated:
        return Meaning(annotation, None, None)
    hint, *notes = get_args(annotation)
    unit = next((note for note in notes if isinstance(note, str)), None)
    return Meaning(hint, unit, next((note for note in notes if isinstance(note, Range)), None))


def alternatives(hint: object) -> tuple[Any, ...]:
    """The members of a union without None, as they are written; the hint itself where it is none."""
    if get_origin(hint) in (Union, UnionType):
        return tuple(member for member in get_args(hint) if member is not type(None))
    return (hint,)


@cache
def members(means: Meaning) -> tuple[Meaning, ...]:
    """The members of a union without None, nested unions included; without notes, they take those of the union."""
    parts = alternatives(means.hint)
    if parts == (means.hint,):
        return (means,)
    return tuple(found for part in parts for found in members(below(part, means)))


@cache
def below(annotation: object, above: Meaning) -> Meaning:
    """Meaning of the annotation of a part; notes that it lacks are taken from the whole."""
    own = meaning(annotation)
    return Meaning(own.hint, above.unit if own.unit is None else own.unit, own.limits or above.limits)


def numbers(instance: object) -> dict[str, Number]:
    """Every float field of a dataclass, nested ones included, by dotted path; elements of tuples by index."""
    return dict(_numbers(instance, Meaning(type(instance), None, None), ""))


def _numbers(value: object, means: Meaning, path: str) -> Iterator[tuple[str, Number]]:
    if isinstance(value, float | int) and not isinstance(value, bool):
        floats = [member for member in members(means) if member.hint is float]
        if floats:
            yield path, Number(float(value), floats[0].unit or "", floats[0].limits)
        return
    for name, part, inner in _parts(value, means):
        yield from _numbers(part, inner, f"{path}.{name}" if path else name)


@cache
def _meanings(kind: type) -> list[tuple[str, Meaning]]:
    known = hints(kind)
    return [(each.name, meaning(known[each.name])) for each in dataclasses.fields(kind)]


def _parts(value: object, means: Meaning) -> list[tuple[str, Any, Meaning]]:
    """(name, value, meaning) of the parts of a value; none for a plain one."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return [(name, getattr(value, name), means) for name, means in _meanings(type(value))]
    if isinstance(value, Mapping):
        inner = (get_args(means.hint) or (str, Any))[1]
        return [(str(name), part, below(inner, means)) for name, part in value.items()]
    if isinstance(value, tuple):
        whole = next((each for each in members(means) if get_origin(each.hint) is tuple), means)
        inner = get_args(whole.hint)
        each = inner[:1] * len(value) if inner[-1:] == (Ellipsis,) or len(inner) != len(value) else inner
        return [(str(i), part, below(hint, whole)) for i, (part, hint) in enumerate(zip(value, each, strict=False))]
    return []


def replaced(instance: Any, changes: Mapping[str, object]) -> Any:
    """The dataclass with the values at some dotted paths replaced; the paths must exist."""
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


def _part(instance: object, name: str) -> Any:
    if isinstance(instance, Mapping):
        return instance[name]
    return instance[int(name)] if isinstance(instance, tuple) else getattr(instance, name)


def _with(instance: Any, values: Mapping[str, object]) -> Any:
    if isinstance(instance, Mapping):
        return {**instance, **values}
    if isinstance(instance, tuple):
        return tuple(values.get(str(number), part) for number, part in enumerate(instance))
    return dataclasses.replace(instance, **values)


def check_ranges(instance: object) -> None:
    """Check the numbers of a dataclass against the ranges in its annotations; nested dataclasses check their own."""
    kind: Any = type(instance)
    known = hints(kind)
    for field in dataclasses.fields(kind):
        value = getattr(instance, field.name)
        if isinstance(value, bool) or not isinstance(value, float | int):
            continue
        for means in members(meaning(known[field.name])):
            if means.hint in (float, int) and means.limits is not None and not means.limits.holds(value):
                # A unit with a placeholder depends on a signal, which is not known here.
                unit = f" {means.unit}" if means.unit and "{" not in means.unit else ""
                raise ParameterError(f"'{field.name}' is {value:g}{unit}, but has to be {means.limits}{unit}")
