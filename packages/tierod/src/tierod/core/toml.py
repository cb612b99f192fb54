"""Conversion of TOML files to frozen dataclasses: units are converted, ranges checked, errors reported with line.

    document = Document.read("drive.toml")
    car = build(Car, document.content["car"], document, ("car",))

A class that reads its table itself has a class method `from_table(table, document, location, base)`.
Numbers are SI, or texts with a unit: `speed = 16.7` is `speed = "60 km/h"`. A field that may hold one of several
dataclasses is chosen by the key `kind`: the name of the class in lower case with hyphens.
"""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections.abc import Mapping, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from tierod.core.errors import InputError, ParameterError, TierodError, nearest
from tierod.core.fields import Meaning, below, hints, meaning, members, numbers
from tierod.core.toml_document import Document, Location
from tierod.core.units import scale


def build(
    kind: object,
    table: object,
    document: Document,
    location: Location = (),
    *,
    base: object = None,
    signal: str | None = None,
) -> Any:
    """A frozen dataclass from a table.

    Args:
        signal: unit that replaces `SIGNAL_UNIT` in annotations; None where there is no signal
    """
    return Builder(document, signal).value(Meaning(kind, None, None), table, tuple(location), base)


def override(
    instance: object,
    changes: Mapping[str, object],
    document: Document | None = None,
    location: Location = (),
    what: str = "",
) -> Any:
    """A nested frozen dataclass with some of its fields replaced.

    Args:
        what: name of the instance in a message; that of its class where it is empty
    """
    source = document or Document({}, "", Path(what or type(instance).__name__))
    known = numbers(instance)
    places = {".".join(path.split(".")[:depth]) for path in known for depth in range(1, path.count(".") + 1)}
    nested: dict[str, Any] = {}
    for path, value in flat(changes, {"kind"}):
        if path not in known and path not in places and not _has(instance, path):
            raise source.error((*location, path), f"no parameter is called '{path}'{nearest(path, known)}")
        below = nested
        *above, last = path.split(".")
        for name in above:
            below = below.setdefault(name, {})
        below[last] = value
    return Builder(source, None).value(Meaning(type(instance), None, None), nested, tuple(location), instance)


def quoted(text: str) -> str:
    # The control character DEL needs no escape in JSON, but in TOML it does.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def flat(table: Mapping[str, Any], keys: Set[str], above: str = "") -> list[tuple[str, Any]]:
    """(dotted path, value) of nested tables."""
    pairs: list[tuple[str, Any]] = []
    for name, value in table.items():
        if isinstance(value, Mapping) and not keys & set(value):
            pairs.extend(flat(value, keys, f"{above}{name}."))
        else:
            pairs.append((f"{above}{name}", value))
    return pairs


def _has(instance: object, path: str) -> bool:
    for name in path.split("."):
        if not (dataclasses.is_dataclass(instance) and name in {field.name for field in dataclasses.fields(instance)}):
            return False
        instance = getattr(instance, name)
    return True


__all__ = ["Document", "Location", "build", "override", "quoted"]

# Placeholder for a unit that depends on the signal concerned; patterns such as "{signal}/s" are allowed
SIGNAL_UNIT = "{signal}"

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", re.DOTALL)


def kind_name(kind: type) -> str:
    """The name by which the key `kind` chooses a dataclass: "total-loss" for `TotalLoss`."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", kind.__name__).lower()


@dataclass(frozen=True)
class Builder:
    document: Document
    signal: str | None

    def value(self, means: Meaning, given: object, location: tuple[str | int, ...], base: object = None) -> Any:
        """The value converted to the type of an annotation."""
        known = members(means)
        classes: list[Any] = [each.hint for each in known if dataclasses.is_dataclass(each.hint)]
        if not classes and dataclasses.is_dataclass(base):
            # The field is declared as a protocol: the class of the base is the only one known.
            own: Any = type(base)
            known = (below(own, means),)
            classes = [type(base)]
        if classes and isinstance(given, dict):
            return self._instance(tuple(classes), given, location, base)
        others = [each for each in known if each.hint not in classes]
        if not others:
            raise self._error(location, f"is {_shown(given)}, but has to be a table")
        if isinstance(given, str) and str in {each.hint for each in others}:
            amounts = [each for each in others if each.hint is float and "{signal}" in (each.unit or "")]
            if amounts:
                return self._amount(amounts[0], given, location)
        if isinstance(given, float | int) and not isinstance(given, bool):
            others = [each for each in others if each.hint in (float, int)] or others
        refused: list[ParameterError] = []
        for each in others:
            try:
                return self._plain(each, given, location, base)
            except ParameterError as error:
                refused.append(error)
        raise refused[-1 if isinstance(given, str) else 0]

    def _error(self, location: Location, message: str) -> ParameterError:
        name = ".".join(map(str, location))
        return self.document.error(location, f"'{name}' {message}" if name else f"the document {message}")

    def _plain(self, means: Meaning, given: object, location: tuple[str | int, ...], base: object) -> Any:
        hint = means.hint
        origin = get_origin(hint)
        if hint is Any:
            return given
        if hint is float:
            return self._number(means, given, location, base)
        if origin is Literal:
            return self._choice(get_args(hint), given, location)
        if origin is tuple or hint is tuple:
            return self._elements(means, given, location, base)
        if isinstance(origin or hint, type) and issubclass(origin or hint, Mapping):
            return self._mapping(means, given, location, base)
        if hint is int and isinstance(given, float) and given.is_integer():
            given = int(given)
        wanted = {bool: "true or false", int: "a whole number", str: "a text"}
        if hint not in wanted:
            raise TypeError(f"tierod.core.toml cannot build {hint!r}")
        if not isinstance(given, hint) or (hint is int and isinstance(given, bool)):
            raise self._error(location, f"is {_shown(given)}, but has to be {wanted[hint]}")
        if means.limits is not None and not means.limits.holds(given):
            raise self._error(location, f"is {given}, but has to be {means.limits}")
        return given

    def _number(self, means: Meaning, given: object, location: tuple[str | int, ...], base: object) -> float:
        unit = self._unit(means)
        beside, within = (f" {unit}", f" in {unit}") if unit else ("", "")
        if isinstance(given, str):
            value = self._quantity(given, unit, location)
        elif isinstance(given, bool) or not isinstance(given, int | float):
            example = f' or a text with a unit, like "1{beside}"' if unit else ""
            raise self._error(location, f"is {_shown(given)}, but has to be a number{within}{example}")
        else:
            value = float(given)
        # An infinite default, such as an end that is never reached, may be written out.
        endless = math.isinf(value) and isinstance(base, float) and math.isinf(base)
        if math.isnan(value) or not (endless or math.isfinite(value)):
            raise self._error(location, f"is {value}, but has to be a finite number{within}")
        if means.limits is not None and not endless and not means.limits.holds(value):
            raise self._error(location, f"is {value:g}{beside}, but has to be {means.limits}{beside}")
        return value

    def _amount(self, means: Meaning, given: str, location: tuple[str | int, ...]) -> float | str:
        """A number in the unit of a signal; the text unchanged where the signal is not known yet."""
        if self._unit(means) is None and _QUANTITY.fullmatch(given):
            return given
        return self._number(means, given, location, None)

    def _unit(self, means: Meaning) -> str | None:
        """The unit of a number; None where it depends on a signal that is not known."""
        if means.unit is None or "{signal}" not in means.unit:
            return means.unit or ""
        if self.signal is None:
            return None
        return self.signal if means.unit == SIGNAL_UNIT else means.unit.format(signal=self.signal or "1")

    def _quantity(self, given: str, unit: str | None, location: tuple[str | int, ...]) -> float:
        parts = _QUANTITY.fullmatch(given)
        if parts is None:
            raise self._error(location, f"is '{given}', but has to be a number{f', in {unit}' if unit else ''}")
        if unit is None:
            raise self._error(location, f"is '{given}', but no unit is known here; give the number alone")
        try:
            return float(scale(parts[2], unit)(float(parts[1]))) if parts[2] else float(parts[1])
        except InputError as error:
            wanted = f"is measured in '{unit}': {error}" if unit else "has to be a number without unit"
            raise self._error(location, f"is '{given}', but {wanted}") from None

    def _choice(self, members: tuple[object, ...], given: object, location: tuple[str | int, ...]) -> Any:
        for member in members:
            if type(member) is type(given) and member == given:
                return member
        known = [str(member) for member in members]
        raise self._error(location, f"is {_shown(given)}, which is not among {', '.join(known)}")

    def _elements(
        self, means: Meaning, given: object, location: tuple[str | int, ...], base: object
    ) -> tuple[Any, ...]:
        inner = get_args(means.hint)
        if isinstance(given, dict) and isinstance(base, tuple) and all(key.isdigit() for key in given):
            merged: list[Any] = list(base)
            for key, value in given.items():
                position = int(key)
                if position >= len(base):
                    raise self._error((*location, key), f"is not there; the last of {len(base)} is {len(base) - 1}")
                hint = inner[0] if inner[-1:] == (Ellipsis,) else inner[position]
                merged[position] = self.value(below(hint, means), value, (*location, key), base[position])
            return tuple(merged)
        if not isinstance(given, list):
            raise self._error(location, f"is {_shown(given)}, but has to be a list")
        if inner[-1:] == (Ellipsis,):
            inner = inner[:1] * len(given)
        if len(inner) != len(given):
            raise self._error(location, f"has {len(given)} elements, but needs {len(inner)}")
        return tuple(
            self.value(below(hint, means), value, (*location, number))
            for number, (hint, value) in enumerate(zip(inner, given, strict=True))
        )

    def _mapping(self, means: Meaning, given: object, location: tuple[str | int, ...], base: object) -> dict[str, Any]:
        if not isinstance(given, dict):
            raise self._error(location, f"is {_shown(given)}, but has to be a table")
        inner = (get_args(means.hint) or (str, Any))[1]
        known: dict[str, Any] = dict(base) if isinstance(base, Mapping) else {}
        for name, value in given.items():
            known[name] = self.value(below(inner, means), value, (*location, name), known.get(name))
        return known

    def _instance(
        self, classes: tuple[type, ...], table: dict[str, object], location: tuple[str | int, ...], base: object
    ) -> Any:
        kind, given = self._chosen(classes, table, location, base)
        if hasattr(kind, "from_table"):
            return kind.from_table(given, self.document, location, base if isinstance(base, kind) else None)
        base = base if type(base) is kind else None
        known = {field.name: field for field in dataclasses.fields(kind) if field.init}
        for name in given:
            if name not in known:
                raise self.document.error((*location, name), f"'{name}' is not known here{nearest(name, known)}")
        values = {}
        for name, field in known.items():
            default = _default(field) if base is None else getattr(base, name)
            if name in given:
                means = below(hints(kind)[name], Meaning(None, None, None))
                values[name] = self.value(means, given[name], (*location, name), default)
            elif base is not None:
                values[name] = default
            elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
                unit = self._unit(meaning(hints(kind)[name]))
                raise self.document.error(location, f"'{name}' is missing; add it{f', in {unit}' if unit else ''}")
        try:
            return kind(**values)
        except TierodError as error:
            raise self.document.error(location, str(error)) from None

    def _chosen(
        self, classes: tuple[type, ...], table: dict[str, object], location: tuple[str | int, ...], base: object
    ) -> Any:
        named = {kind_name(each): each for each in classes}
        own = len(classes) == 1 and "kind" in hints(classes[0])
        if "kind" not in table or own:
            if len(classes) > 1 and type(base) not in classes:
                raise self.document.error(location, f"'kind' is missing; choose one of: {', '.join(sorted(named))}")
            return (classes[0] if len(classes) == 1 else type(base)), table
        name = str(table["kind"]).replace("_", "-").lower()
        if name not in named:
            raise self.document.error((*location, "kind"), f"no kind is called '{table['kind']}'{nearest(name, named)}")
        return named[name], {key: value for key, value in table.items() if key != "kind"}


def _default(field: dataclasses.Field[object]) -> Any:
    if field.default is not dataclasses.MISSING:
        return field.default
    return None if field.default_factory is dataclasses.MISSING else field.default_factory()


def _shown(given: object) -> str:
    if isinstance(given, bool):
        return "true" if given else "false"
    text = "a table" if isinstance(given, dict) else "a list" if isinstance(given, list) else repr(given)
    return text if len(text) <= 60 else f"{text[:57]}..."
