"""From a table in a file to a fault."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from tierod.errors import ParameterError, TierodError, nearest
from tierod.proving_ground.faults.behaviours import BEHAVIOURS, AnyBehaviour, Intermittent
from tierod.proving_ground.faults.elements import unit_without_car
from tierod.proving_ground.faults.fault import Effect, Fault, Origin
from tierod.proving_ground.faults.triggers import Always, AnyTrigger, AtTime, trigger_of
from tierod.ranges import POSITIVE
from tierod.toml import Document, build
from tierod.toml_builder import kind_name


class Reader:
    """One table on its way to a fault, see `Fault.from_table`."""

    KEYS = ("use", "element", "behaviour", "size", "trigger", "start", "end", "duration", "name", "also")

    def __init__(self, document: Document, location: tuple[str | int, ...], table: Mapping[str, Any], base: Any):
        self.document, self.location, self.table, self.base = document, location, table, base

    def _error(self, key: str, message: str) -> ParameterError:
        return self.document.error((*self.location, key), message)

    def fault(self) -> Fault:
        """The fault.

        Raises:
            ParameterError: a slip, with file and line
        """
        for key in self.table:
            if key not in self.KEYS:
                raise self._error(key, f"'{key}' is not known here{nearest(key, self.KEYS)}")
        if "use" in self.table:
            self.base = self._used(self.table["use"])
        element = self._text("element", self.base.element if self.base else None)
        trigger = self._trigger()
        fields = {
            "element": element,
            "behaviour": self._behaviour(element),
            "trigger": trigger,
            "duration": self._duration(trigger),
            "name": self._text("name", self.base.name if self.base else ""),
            "also": self._also(),
            "origin": Origin(self.document, self.location),
        }
        return Fault(**fields)

    def _used(self, given: Any) -> Fault:
        from tierod.proving_ground.faults.shipped import load

        try:
            return load(str(given), self.document.path.parent).fault
        except ParameterError as error:
            raise self._error("use", str(error)) from None

    def _text(self, key: str, default: str | None) -> str:
        given = self.table.get(key, default)
        if given is None:
            raise self._error(key, f"'{key}' is missing; say what fails, for example 'yaw_rate'")
        if not isinstance(given, str):
            raise self._error(key, f"'{key}' is {given!r}, but has to be a text")
        return given

    def _behaviour(self, element: str) -> Any:
        given = self.table.get("behaviour", {})
        base = self.base.behaviour if self.base else None
        if isinstance(given, str):
            given = {"kind": given}
        if not given and base is None:
            raise self._error("behaviour", f"'behaviour' is missing; choose one of: {', '.join(sorted(BEHAVIOURS))}")
        if isinstance(given, dict) and "size" in self.table:
            given = self._with_size(given, base)
        place = (*self.location, "behaviour")
        return build(AnyBehaviour, given, self.document, place, base=base, signal=unit_without_car(element))

    def _with_size(self, given: dict[str, Any], base: Any) -> dict[str, Any]:
        kind = BEHAVIOURS.get(str(given.get("kind", "")).replace("_", "-").lower(), type(base))
        if kind is Intermittent:
            inner = given.get("behaviour", {})
            inner = {"kind": inner} if isinstance(inner, str) else inner
            return given | {"behaviour": self._with_size(inner, getattr(base, "behaviour", None))}
        main = getattr(kind, "main", None)
        if main is None:
            raise self._error("size", f"'{kind_name(kind)}' has no size; leave it out")
        if main in given:
            raise self._error("size", f"'size' and '{main}' say the same; leave one out")
        return given | {main: self.table["size"]}

    def _trigger(self) -> Any:
        given = self.table.get("trigger")
        if given is not None and "start" in self.table:
            raise self._error("start", "'start' and 'trigger' exclude each other; leave one out")
        if "start" in self.table:
            given = {"kind": "at-time", "time": self.table["start"]}
        if given is None:
            return self.base.trigger if self.base else Always()
        if isinstance(given, str):
            try:
                return trigger_of(given)
            except TierodError as error:
                raise self._error("trigger", str(error)) from None
        place = "start" if "start" in self.table else "trigger"
        return build(AnyTrigger, given, self.document, (*self.location, place))

    def _duration(self, trigger: Any) -> float | None:
        if "end" in self.table and "duration" in self.table:
            raise self._error("end", "'end' and 'duration' exclude each other; leave one out")
        for key in ("duration", "end"):
            if key in self.table:
                given = build(_Span, {"time": self.table[key]}, self.document, (*self.location, key)).time
                return given if key == "duration" else self._until(given, trigger)
        return self.base.duration if self.base else None

    def _until(self, end: float, trigger: Any) -> float:
        if not isinstance(trigger, Always | AtTime):
            raise self._error("end", "'end' needs a fault that begins at a given time; give its 'duration'")
        start = trigger.time if isinstance(trigger, AtTime) else 0.0
        if not end > start:
            raise self._error("end", f"the fault ends at {end:g} s, before it begins at {start:g} s; swap them")
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
            unknown = next((key for key in table if key not in ("element", "behaviour", "size")), None)
            if unknown is not None:
                raise self.document.error(
                    (*place, unknown), f"'{unknown}' is not known here{nearest(unknown, self.KEYS)}"
                )
            inner = Reader(self.document, place, table, None).fault()
            effects.append(Effect(inner.element, inner.behaviour))
        return tuple(effects)


@dataclass(frozen=True)
class _Span:
    time: Annotated[float, "s", POSITIVE]
