"""A fault: an element, its behaviour and the trigger of its start."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
from tierod.core.toml import build, kind_name
from tierod.core.toml_document import Document
from tierod.core.units import scale
from tierod_lab.ground.faults.behaviours import AnyBehaviour, Behaviour


class _Checked:
    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True)
class Always:
    """Trigger at the start of the run."""


@dataclass(frozen=True)
class AtTime(_Checked):
    """Trigger at a time of the run."""

    time: Annotated[float, "s", NOT_NEGATIVE]


@dataclass(frozen=True)
class AtDistance(_Checked):
    """Trigger once the car has travelled a distance along its path."""

    distance: Annotated[float, "m", NOT_NEGATIVE]


@dataclass(frozen=True)
class Within(_Checked):
    """Trigger at a random time between two, drawn for every seed."""

    earliest: Annotated[float, "s", NOT_NEGATIVE]
    latest: Annotated[float, "s", NOT_NEGATIVE]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.earliest < self.latest:
            raise ParameterError(f"the earliest time, {self.earliest:g} s, is not before the latest, {self.latest:g} s")


class Comparison(NamedTuple):
    """Comparison of a signal with a value."""

    signal: str
    magnitude: bool
    relation: str
    value: float
    unit: str

    def holds(self, values: np.ndarray, unit: str) -> np.ndarray:
        limit = self.value if not self.unit else scale(self.unit, unit)(self.value)
        seen = np.abs(values) if self.magnitude else values
        return {">": seen > limit, ">=": seen >= limit, "<": seen < limit, "<=": seen <= limit}[self.relation]


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_COMPARISON = re.compile(rf"\s*(\|?)\s*([A-Za-z_]\w*)\s*(\|?)\s*(>=|<=|>|<)\s*({_NUMBER})\s*(.*?)\s*")
_EXAMPLE = "write it like 'vehicle_speed > 36 km/h and |yaw_rate| > 0.1 rad/s'"


@dataclass(frozen=True)
class When(_Checked):
    """Trigger once a condition on true signals of the car has held for a time."""

    condition: str
    hold: Annotated[float, "s", NOT_NEGATIVE] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if re.search(r"\sfor\s", self.condition):
            raise ParameterError(f"'{self.condition}': give what follows 'for' as 'hold', or the whole as a text")
        _ = self.comparisons

    @cached_property
    def comparisons(self) -> tuple[Comparison, ...]:
        """Comparisons that have to hold simultaneously."""
        return tuple(_comparison(part) for part in re.split(r"\s+and\s+", self.condition.strip()))


def _comparison(text: str) -> Comparison:
    found = _COMPARISON.fullmatch(text)
    if found is None or found[1] != found[3]:
        raise ParameterError(f"'{text}' is not a condition; {_EXAMPLE}")
    return Comparison(found[2], bool(found[1]), found[4], float(found[5]), found[6])


AnyTrigger = Always | AtTime | AtDistance | Within | When  # Union of all triggers

_QUANTITY = rf"({_NUMBER})\s*([^\s\d][^\s]*)"


def trigger_of(text: str) -> AnyTrigger:
    plain = text.strip()
    if plain == "always":
        return Always()
    if at := re.fullmatch(rf"at\s+{_QUANTITY}", plain):
        for kind, unit in ((AtTime, "s"), (AtDistance, "m")):
            try:
                return kind(float(scale(at[2], unit)(float(at[1]))))
            except InputError:
                continue
        raise ParameterError(f"'{plain}' is neither a time nor a distance; write 'at 30 s' or 'at 500 m'")
    if between := re.fullmatch(rf"between\s+{_QUANTITY}\s+and\s+{_QUANTITY}", plain):
        return Within(_seconds(between[1], between[2]), _seconds(between[3], between[4]))
    held = re.fullmatch(rf"(.*)\s+for\s+{_QUANTITY}", plain)
    return When(held[1], _seconds(held[2], held[3])) if held else When(plain)


def _seconds(number: str, unit: str) -> float:
    try:
        return float(scale(unit, "s")(float(number)))
    except InputError as error:
        raise ParameterError(f"'{number} {unit}' is not a time: {error}") from None


def trigger_table(trigger: AnyTrigger) -> dict[str, Any]:
    return {"kind": kind_name(type(trigger))} | {name: getattr(trigger, name) for name in trigger.__match_args__}


@dataclass(frozen=True)
class Origin:
    """Place of a fault in a file."""

    document: Document
    location: tuple[str | int, ...]

    def error(self, part: str, message: str) -> ParameterError:
        table: Any = self.document.content
        for name in self.location:
            table = table[name]
        forms = {"size": ("size", "behaviour"), "trigger": ("start", "trigger"), "duration": ("end", "duration")}
        known = forms.get(part, (part,))
        return self.document.error((*self.location, next((key for key in known if key in table), known[-1])), message)


@dataclass(frozen=True)
class Effect:
    """Behaviour of one element; `origin` is its place in a file, for error messages."""

    element: str
    behaviour: AnyBehaviour
    origin: Origin | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Fault(_Checked):
    """One fault."""

    # a signal ("yaw_rate", both in the recording and where the car's control units read it), a parameter of the car
    # ("steering.friction.level") or a quantity of its surroundings ("road.adhesion_left"); a prefix "sensor.", "loop.",
    # "actuator." or "car." selects one kind; of names separated by "|" the first that the car has is taken, and
    # "nothing" leaves the effect out
    element: str
    behaviour: AnyBehaviour
    trigger: AnyTrigger = field(default_factory=Always)
    # duration [s]; None until the end, or a second for an outlier
    duration: Annotated[float, "s", POSITIVE] | None = None
    name: str = ""  # short name; made from element and behaviour if empty
    also: tuple[Effect, ...] = ()
    origin: Origin | None = field(default=None, compare=False, repr=False)

    @property
    def label(self) -> str:
        """The name, or element and behaviour if it is empty."""
        return self.name or f"{self.element} {kind_name(type(self.behaviour))}"

    @property
    def lasts(self) -> float | None:
        """Duration [s]; None until the end of the run."""
        return self.duration or self.behaviour.usual_duration

    @property
    def effects(self) -> tuple[Effect, ...]:
        """All effects, the main one first."""
        return (Effect(self.element, self.behaviour, self.origin), *self.also)

    def error(self, part: str, message: str, effect: Effect | None = None) -> ParameterError:
        origin = self.origin if effect is None else effect.origin
        if origin is None:
            return ParameterError(f"fault '{self.label}': {message}")
        return origin.error(part, message)


def resolved(fault: Fault, effect: Effect, unit: str | None) -> AnyBehaviour:
    behaviour = effect.behaviour
    texts = _texts(behaviour)
    if not texts:
        return behaviour
    document = Document({}, "", Path(fault.label))
    try:
        known: AnyBehaviour = build(type(behaviour), texts, document, base=behaviour, signal=unit or "")
    except ParameterError as error:
        raise fault.error("size", str(error).removeprefix(f"{document.path}: "), effect) from None
    return known


def _texts(behaviour: Behaviour) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for each in dataclasses.fields(behaviour):
        value = getattr(behaviour, each.name)
        if isinstance(value, Behaviour):
            found |= {each.name: inner} if (inner := _texts(value)) else {}
        elif isinstance(value, str) or (isinstance(value, tuple) and any(isinstance(part, str) for part in value)):
            found[each.name] = list(value) if isinstance(value, tuple) else value
    return found
