"""Faults read from files, and described in words."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from tierod.core.errors import ParameterError, TierodError, nearest
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, Meaning, Range, hints, meaning, members
from tierod.core.plugins import FileRegistry
from tierod.core.toml import SIGNAL_UNIT, Builder, build, kind_name
from tierod.core.toml_document import Document, Location
from tierod_lab.ground.faults.behaviours import BEHAVIOURS, AnyBehaviour, Behaviour, Intermittent
from tierod_lab.ground.faults.elements import unit_without_car
from tierod_lab.ground.faults.fault import (
    Always,
    AnyTrigger,
    AtTime,
    Effect,
    Fault,
    Origin,
    When,
    Within,
    trigger_of,
)


def of_effect(effect: Effect) -> str:
    """Behaviour of an effect, in words: "step: to 12.5 N*m"."""
    return _of_behaviour(effect.behaviour, unit_without_car(effect.element))


def _of_behaviour(behaviour: Behaviour, unit: str | None) -> str:
    parts = []
    kind: Any = type(behaviour)
    known = hints(kind)
    for field in dataclasses.fields(behaviour):
        value = getattr(behaviour, field.name)
        if value is None:
            continue
        own = _unit(known[field.name], unit)
        name = field.name.replace("_", " ")
        if isinstance(value, Behaviour):
            parts.append(f"({_of_behaviour(value, unit)})")
        elif isinstance(value, bool):
            parts += [name] if value else []
        elif isinstance(value, tuple):
            parts.append(f"{name} {', '.join(_amount(each, own) for each in value)}")
        else:
            parts.append(f"{name} {_amount(value, own)}")
    name = kind_name(kind).replace("-", " ")
    return f"{name}: {', '.join(parts)}" if parts else name


def _unit(annotation: object, signal: str | None) -> str:
    unit = next((means.unit for means in members(meaning(annotation)) if means.unit), "")
    if unit == SIGNAL_UNIT or signal is None:
        return (signal or "") if "{signal}" in unit else unit
    return unit.format(signal=signal or "1")


def _amount(value: float | str, unit: str) -> str:
    return value if isinstance(value, str) else f"{value:.6g} {unit}".strip()


def of_beginning(fault: Fault) -> str:
    """Onset of a fault, in words: "at 3 s"."""
    trigger = fault.trigger
    if isinstance(trigger, Within):
        return f"at random between {trigger.earliest:g} s and {trigger.latest:g} s"
    if isinstance(trigger, When):
        return f"when {trigger.condition}" + (f" for {trigger.hold:g} s" if trigger.hold else "")
    if isinstance(trigger, Always):
        return "from the beginning"
    return f"at {trigger.time:g} s" if isinstance(trigger, AtTime) else f"at {trigger.distance:g} m"


def of_duration(fault: Fault) -> str:
    return "until the end" if fault.lasts is None else f"{fault.lasts:g} s"


def of_fields(kind: type[Behaviour]) -> str:
    """Fields of a behaviour: "to [unit of the element], over [s]"; optional ones are in parentheses."""
    parts = []
    known = hints(cast("Any", kind))
    for field in dataclasses.fields(kind):
        unit = _unit(known[field.name], "unit of the element")
        needed = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        text = f"{field.name} [{unit}]" if unit else field.name
        parts.append(text if needed else f"({text})")
    return ", ".join(parts)


def fault_in_words(fault: Fault) -> str:
    """Effect, onset and duration of a fault, in words."""
    what = "; ".join(f"{effect.element} {kind_name(type(effect.behaviour))}" for effect in fault.effects)
    behaviour: Any = fault.behaviour.core
    size = ""
    if behaviour.main is not None:
        value = getattr(behaviour, behaviour.main)
        unit = _unit(hints(behaviour.__class__)[behaviour.main], unit_without_car(fault.element))
        size = f" {value:.4g} {unit}".rstrip() if isinstance(value, float) else f" {value}"
    name = f"{fault.name}: " if fault.name else ""
    return f"{name}{what}{size}, {of_beginning(fault)}{'' if fault.lasts is None else f', for {fault.lasts:g} s'}"


FAULTS = FileRegistry("tierod.faults", "fault", Path(__file__).parent / "shipped")
"""Registry of the fault files of tierod and of installed packages."""


@dataclass(frozen=True)
class FaultFile:
    """A file with one fault."""

    name: str
    description: str
    source: str
    fault: Fault
    path: Path


def shipped() -> tuple[str, ...]:
    """The names of the faults that tierod ships, in alphabetical order."""
    return tuple(FAULTS.own)


def load(name_or_path: str | Path, within: Document | None = None) -> FaultFile:
    """The fault of a shipped name or of a file.

    Args:
        within: document that refers to the fault; relative paths start at its folder, at the working directory if None
    """
    path = FAULTS.find(str(name_or_path), None if within is None else within.path.parent)
    document = Document.read(path, "fault") if within is None else within.beside(path.absolute(), "fault")
    table = dict(document.content)
    texts = {}
    for key in ("description", "source"):
        texts[key] = table.pop(key, None)
        if not isinstance(texts[key], str):
            raise document.error((key,), f"'{key}' is missing; describe the fault in a sentence")
    table.setdefault("name", path.stem)
    return FaultFile(path.stem, texts["description"], texts["source"], fault_of(table, document), path)


def fault_of(table: Mapping[str, Any], document: Document, location: Location = (), base: Fault | None = None) -> Fault:
    """The fault of a table.

    Args:
        table: `element`; `behaviour` as a table with `kind`, or its name beside `size`; `trigger` as a table with
            `kind` or a text for `trigger_of`, or `start`; `duration` or `end`; `name`; `also`. With `use`, the name of
            a shipped fault or a file beside the document, the other keys change that fault.
    """
    return _Reader(document, tuple(location), table, base).fault()


class _Reader:
    KEYS = ("use", "element", "behaviour", "size", "trigger", "start", "end", "duration", "name", "also")

    def __init__(
        self, document: Document, location: tuple[str | int, ...], table: Mapping[str, Any], base: Fault | None
    ):
        self.document, self.location, self.table, self.base = document, location, table, base

    def _error(self, key: str, message: str) -> ParameterError:
        return self.document.error((*self.location, key), message)

    def fault(self) -> Fault:
        for key in self.table:
            if key not in self.KEYS:
                raise self._error(key, f"'{key}' is not known here{nearest(key, self.KEYS)}")
        if "use" in self.table:
            self.base = self._used(self.table["use"])
        element = self._text("element", self.base.element if self.base else None)
        trigger = self._trigger()
        return Fault(
            element=element,
            behaviour=self._behaviour(element),
            trigger=trigger,
            duration=self._duration(trigger),
            name=self._text("name", self.base.name if self.base else ""),
            also=self._also(),
            origin=Origin(self.document, self.location),
        )

    def _used(self, given: object) -> Fault:
        try:
            return load(str(given), self.document).fault
        except ParameterError as error:
            raise self._error("use", str(error)) from None

    def _text(self, key: str, default: str | None) -> str:
        given = self.table.get(key, default)
        if given is None:
            raise self._error(key, f"'{key}' is missing; say what fails, for example 'yaw_rate'")
        if not isinstance(given, str):
            raise self._error(key, f"'{key}' is {given!r}, but has to be a text")
        return given

    def _behaviour(self, element: str) -> AnyBehaviour:
        given = _as_table(self.table.get("behaviour", {}))
        base = self.base.behaviour if self.base else None
        if not given and base is None:
            raise self._error("behaviour", f"'behaviour' is missing; choose one of: {', '.join(sorted(BEHAVIOURS))}")
        if isinstance(given, dict) and "size" in self.table:
            given = self._with_size(given, base, unit_without_car(element))
        place, unit = (*self.location, "behaviour"), unit_without_car(element)
        known: AnyBehaviour = build(AnyBehaviour, given, self.document, place, base=base, signal=unit)
        return known

    def _with_size(self, given: dict[str, Any], base: object, unit: str | None) -> dict[str, Any]:
        named = BEHAVIOURS.get(str(given.get("kind")).replace("_", "-").lower())
        kind: Any = named if "kind" in given else type(base) if base is not None else None
        if kind is None:
            return given
        if kind is Intermittent:
            inner = given.get("behaviour", {})
            if not isinstance(inner, dict):
                return given
            return given | {"behaviour": self._with_size(inner, getattr(base, "behaviour", None), unit)}
        if kind.main is None:
            raise self._error("size", f"'{kind_name(kind)}' has no size; leave it out")
        if kind.main in given:
            raise self._error("size", f"'size' and '{kind.main}' state the same; leave one out")
        means, place = meaning(hints(kind)[kind.main]), (*self.location, "size")
        return given | {kind.main: Builder(self.document, unit).value(means, self.table["size"], place)}

    def _trigger(self) -> AnyTrigger:
        given = self.table.get("trigger")
        if given is not None and "start" in self.table:
            raise self._error("start", "'start' and 'trigger' exclude each other; leave one out")
        if "start" in self.table:
            return AtTime(self._seconds("start", NOT_NEGATIVE))
        if given is None:
            return self.base.trigger if self.base else Always()
        if isinstance(given, str):
            try:
                return trigger_of(given)
            except TierodError as error:
                raise self._error("trigger", str(error)) from None
        known: AnyTrigger = build(AnyTrigger, given, self.document, (*self.location, "trigger"))
        return known

    def _duration(self, trigger: AnyTrigger) -> float | None:
        if "end" in self.table and "duration" in self.table:
            raise self._error("end", "'end' and 'duration' exclude each other; leave one out")
        for key in ("duration", "end"):
            if key in self.table:
                given = self._seconds(key, POSITIVE)
                return given if key == "duration" else self._until(given, trigger)
        return self.base.duration if self.base else None

    def _seconds(self, key: str, limits: Range) -> float:
        means = Meaning(float, "s", limits)
        return float(Builder(self.document, None).value(means, self.table[key], (*self.location, key)))

    def _until(self, end: float, trigger: AnyTrigger) -> float:
        if not isinstance(trigger, Always | AtTime):
            raise self._error("end", "'end' needs a fault that begins at a given time; give its 'duration'")
        start = trigger.time if isinstance(trigger, AtTime) else 0.0
        if not end > start:
            order = "before" if end < start else "as"
            raise self._error("end", f"the fault ends at {end:g} s, {order} it begins at {start:g} s; end it later")
        return end - start

    def _also(self) -> tuple[Effect, ...]:
        given = self.table.get("also")
        if given is None:
            return self.base.also if self.base else ()
        if not isinstance(given, list):
            raise self._error("also", "'also' has to be a list of tables with 'element' and 'behaviour'")
        effects = []
        for number, table in enumerate(given):
            place = (*self.location, "also", number)
            if not isinstance(table, dict):
                raise self.document.error(place, f"{table!r} has to be a table with 'element' and 'behaviour'")
            for key in table:
                if key not in ("element", "behaviour", "size"):
                    raise self.document.error((*place, key), f"'{key}' is not known here{nearest(key, self.KEYS)}")
            inner = _Reader(self.document, place, table, None).fault()
            effects.append(Effect(inner.element, inner.behaviour, inner.origin))
        return tuple(effects)


def _as_table(behaviour: Any) -> Any:
    if isinstance(behaviour, str):
        return {"kind": behaviour}
    if isinstance(behaviour, dict) and "behaviour" in behaviour:
        return behaviour | {"behaviour": _as_table(behaviour["behaviour"])}
    return behaviour
