"""Descriptions of faults in words."""

from __future__ import annotations

import dataclasses
from typing import Any, cast

from tierod.core.fields import hints, meaning, members
from tierod.core.toml import SIGNAL_UNIT, kind_name
from tierod_lab.ground.faults.behaviour import Behaviour
from tierod_lab.ground.faults.elements import unit_without_car
from tierod_lab.ground.faults.fault import Effect, Fault
from tierod_lab.ground.faults.triggers import Always, AnyTrigger, AtDistance, AtTime, When, Within


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
    """Onset of a fault, in words."""
    trigger = fault.trigger
    if isinstance(trigger, Always):
        return "from the beginning"
    if isinstance(trigger, AtTime):
        return f"at {trigger.time:g} s"
    if isinstance(trigger, AtDistance):
        return f"at {trigger.distance:g} m"
    if isinstance(trigger, Within):
        return f"at random between {trigger.earliest:g} s and {trigger.latest:g} s"
    assert isinstance(trigger, When)
    held = f" for {trigger.hold:g} s" if trigger.hold else ""
    return f"when {trigger.condition}{held}"


def of_duration(fault: Fault) -> str:
    """Duration of a fault, in words."""
    lasts = fault.duration or fault.behaviour.usual_duration
    return "until the end" if lasts is None else f"{lasts:g} s"


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
    lasts = fault.duration or fault.behaviour.usual_duration
    name = f"{fault.name}: " if fault.name else ""
    return f"{name}{what}{_main(fault)}, {_when(fault.trigger)}{'' if lasts is None else f', for {lasts:g} s'}"


def _main(fault: Fault) -> str:
    """Magnitude of a fault with its unit; without the unit if the element's name does not determine it."""
    behaviour: Any = fault.behaviour.core
    if behaviour.main is None:
        return ""
    size = getattr(behaviour, behaviour.main)
    unit = _unit(hints(behaviour.__class__)[behaviour.main], unit_without_car(fault.element))
    return f" {size:.4g} {unit}".rstrip() if isinstance(size, float) else f" {size}"


def _when(trigger: AnyTrigger) -> str:
    if isinstance(trigger, AtTime):
        return f"from {trigger.time:g} s on"
    if isinstance(trigger, AtDistance):
        return f"from {trigger.distance:g} m on"
    if isinstance(trigger, Within):
        return f"from a time between {trigger.earliest:g} s and {trigger.latest:g} s on"
    if isinstance(trigger, When):
        return f"when {trigger.condition}" + (f" for {trigger.hold:g} s" if trigger.hold else "")
    return "all the time"
