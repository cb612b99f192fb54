"""The variables of a unit: inputs, outputs and parameters of a block, with value references in order."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from tierod.core.errors import InputError
from tierod.core.fields import ANY, Range, numbers
from tierod.core.graph.operations import OUTPUT, SAMPLE, TUNING, Program
from tierod.core.signals import SIGNALS
from tierod.core.units import dimensions
from tierod.export.described import Described
from tierod.export.interface import Interface
from tierod.export.members import elements

Kind = Literal["time", "input", "output", "status", "fixed", "tunable"]

CLOCKS = ("sample_time", "step_time")
"""Names of parameters that state how long a step is: the grid of a unit is part of its description, and fixed."""


@dataclass(frozen=True)
class Variable:
    """One variable.

    Args:
        name: structured, "filter.gain[1]"
        reference: value reference
        kind: what it is; "fixed" and "tunable" are parameters
        unit: in the notation of pint; "" for none
        meaning: in words
        start: value before the first step; NaN for an input that is missing
        limits: of a parameter
        place: C of its number within an instance; "" for time
    """

    name: str
    reference: int
    kind: Kind
    unit: str = ""
    meaning: str = ""
    start: float = 0.0
    limits: Range = ANY
    place: str = ""


@dataclass(frozen=True)
class Model:
    """Parts of a unit.

    Args:
        face: of the export
        starts: of inputs that are not missing before they are set, by name
        present: whether outputs belong to the present instant and inputs, as those of a plant do
    """

    face: Interface
    starts: dict[str, float]
    present: bool = False

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """All of them; the place in this list is the value reference."""
        rows = [Variable("time", 0, "time", "s", "Time of the run")]
        rows += [self._input(k, each) for k, each in enumerate(self.face.subject.sample)]
        rows += [self._output(k, each) for k, each in enumerate(self.face.subject.output)]
        rows += self._parameters()
        return tuple(_distinct(rows))

    def of(self, *kinds: Kind) -> tuple[Variable, ...]:
        """Variables of some kinds."""
        return tuple(each for each in self.variables if each.kind in kinds)

    def _input(self, position: int, each: Described) -> Variable:
        place = f"sample.{elements(self.face.sample)[position]}"
        start = self.starts.get(each.path, math.nan)
        return Variable(structured(each.path), 0, "input", _unit(each), each.meaning, start, place=place)

    def _output(self, position: int, each: Described) -> Variable:
        kind: Kind = "status" if position in self.face.statuses else "output"
        place = f"output.{elements(self.face.output)[position]}"
        return Variable(structured(each.path), 0, kind, _unit(each), _meaning(each), place=place)

    def _parameters(self) -> list[Variable]:
        """Parameters that the C takes: all the time, or for the first state alone."""
        stepped, begun = _taken(self.face.program, TUNING), _taken(self.face.initial, 0)
        known = numbers(self.face.subject.block)
        rows = []
        for k, (each, value) in enumerate(zip(self.face.subject.tuning, self.face.subject.values, strict=True)):
            if k not in stepped | begun or each.path.rpartition(".")[2] in CLOCKS:
                continue
            kind: Kind = "tunable" if k in stepped else "fixed"
            limits = known[each.path].limits if each.path in known else None
            place = f"parameters.{elements(self.face.parameters)[k]}"
            own = limits if limits is not None and limits.holds(value) else ANY
            rows.append(Variable(structured(each.path), 0, kind, _unit(each), each.meaning, value, own, place))
        return rows

    def inputs_of(self, variable: Variable) -> tuple[int, ...]:
        """Value references of the inputs on which an output depends at the same instant; none where it is sampled."""
        if not self.present:
            return ()
        outputs = self.of("output", "status")
        first = self.of("input")[0].reference if self.of("input") else 0
        position = outputs.index(variable)
        return tuple(first + each for each in sorted(_reached(self.face.program, position)))


def structured(path: str) -> str:
    """A dotted path in the structured notation of the standard: numbers at its end are places, counted from 1."""
    parts = path.split(".")
    found = ""
    places: list[str] = []
    for part in parts:
        if part.isdigit():
            places.append(str(int(part) + 1))
            continue
        found += f"[{','.join(places)}]" if places else ""
        places = []
        found += f".{part}" if found else part
    return found + (f"[{','.join(places)}]" if places else "")


def _distinct(rows: list[Variable]) -> Iterator[Variable]:
    """The same with their references; of two with one name the later one gets what it is in front of it."""
    taken: set[str] = set()
    for reference, each in enumerate(rows):
        name = each.name
        while name in taken:
            name = f"{each.kind}_{name}"
        taken.add(name)
        yield replace(each, name=name, reference=reference)


def _meaning(each: Described) -> str:
    """In words: of the catalogue where the last part is a signal's name."""
    last = each.path.rpartition(".")[2]
    signal = SIGNALS.get(last)
    return each.meaning or (signal.meaning.rstrip(".") if signal else "")


def _unit(each: Described) -> str:
    """The unit where it is one; a port's "unit of the signal" is none."""
    try:
        dimensions(each.unit)
    except InputError:
        return ""
    return each.unit


def _taken(program: Program, group: int) -> set[int]:
    """Positions of the inputs of a group that a program takes."""
    return {each.constant[1] for each in program.operations if each.name == "input" and each.constant[0] == group}


def _reached(program: Program, position: int) -> set[int]:
    """Positions of the inputs that an output is worked out from."""
    waiting, seen, found = [program.outputs[OUTPUT, position]], set[int](), set[int]()
    while waiting:
        index = waiting.pop()
        if index not in seen:
            seen.add(index)
            operation = program.operations[index]
            if operation.name == "input" and operation.constant[0] == SAMPLE:
                found.add(operation.constant[1])
            waiting += operation.arguments
    return found
