"""A fault as data, separate from vehicle and scenario: what fails, how, when and for how long."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from tierod.core.errors import ParameterError
from tierod.core.fields import POSITIVE, check_ranges
from tierod.core.toml import Document, build, kind_name
from tierod_lab.ground.faults.behaviour import Behaviour
from tierod_lab.ground.faults.behaviours import AnyBehaviour
from tierod_lab.ground.faults.triggers import Always, AnyTrigger


@dataclass(frozen=True)
class Origin:
    """Place of a fault in a file."""

    document: Document
    location: tuple[str | int, ...]

    def error(self, part: str, message: str) -> ParameterError:
        """An error at the line of one part of the fault, or of the short form that replaces it."""
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
class Fault:
    """One fault.

    Args:
        element: a signal ("yaw_rate", both in the recording and where the car's control units read it), a parameter of
            the car ("steering.friction.level") or a quantity of its surroundings ("road.adhesion_left"); a prefix
            "sensor.", "loop.", "actuator." or "car." selects one kind; of names separated by "|" the first that the
            car has is taken, and "nothing" leaves the effect out
        duration: duration [s]; None until the end, or a second for an outlier
        name: short name; made from element and behaviour if empty
    """

    element: str
    behaviour: AnyBehaviour
    trigger: AnyTrigger = field(default_factory=Always)
    duration: Annotated[float, "s", POSITIVE] | None = None
    name: str = ""
    also: tuple[Effect, ...] = ()
    origin: Origin | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def label(self) -> str:
        """The name, or element and behaviour if it is empty."""
        return self.name or f"{self.element} {kind_name(type(self.behaviour))}"

    @property
    def effects(self) -> tuple[Effect, ...]:
        """All effects, the main one first."""
        return (Effect(self.element, self.behaviour, self.origin), *self.also)

    def error(self, part: str, message: str, effect: Effect | None = None) -> ParameterError:
        """An error at the line of the fault, or with its label if it comes from no file.

        Args:
            effect: effect that is wrong; the fault itself if None
        """
        origin = self.origin if effect is None else effect.origin
        if origin is None:
            return ParameterError(f"fault '{self.label}': {message}")
        return origin.error(part, message)


def resolved(fault: Fault, effect: Effect, unit: str | None) -> AnyBehaviour:
    """The behaviour of an effect with all amounts converted to the unit of its element.

    Raises:
        ParameterError: an amount whose unit does not fit
    """
    behaviour = effect.behaviour
    texts = _texts(behaviour)
    if not texts:
        return behaviour
    document = Document({}, "", Path(fault.label))
    try:
        known: AnyBehaviour = build(
            type(behaviour), texts, document, base=behaviour, signal="" if unit is None else unit
        )
    except ParameterError as error:
        raise fault.error("size", str(error).removeprefix(f"{document.path}: "), effect) from None
    return known


def _texts(behaviour: Behaviour) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for each in dataclasses.fields(behaviour):
        value = getattr(behaviour, each.name)
        if isinstance(value, Behaviour):
            inner = _texts(value)
            if inner:
                found[each.name] = inner
        elif isinstance(value, tuple) and any(isinstance(part, str) for part in value):
            found[each.name] = list(value)
        elif isinstance(value, str):
            found[each.name] = value
    return found
