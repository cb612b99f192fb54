"""Structs of an exported bank: its lanes, the parameters in which they differ, and its judge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from tierod.core.block import values_of
from tierod.core.errors import TraceError
from tierod.core.graph.bank import BankGraph
from tierod.core.graph.operations import OUTPUT, SAMPLE, TUNING, Program, program
from tierod.core.graph.state import initial_program
from tierod.core.graph.trace import Graph
from tierod.export.described import Described, described
from tierod.export.interface import Interface
from tierod.export.members import Member, elements, identifier, members
from tierod.export.simplified import simplified


class _OfBank(Interface):
    @property
    def bank(self) -> BankGraph:
        bank: BankGraph = self.subject.graph
        return bank


class LaneInterface(_OfBank):
    """Interface of one lane in C: its own state, outputs and parameters, and the parameters shared by all lanes."""

    @property
    def graph(self) -> Graph:
        return self.bank.lane

    @cached_property
    def initial(self) -> Program:
        """Program that sets the initial state of a lane.

        Raises:
            TraceError: lanes have different initial states that do not follow from their parameters
        """
        lanes = self.subject.block.lanes
        found = initial_program(lanes[0])
        follows = any(each.name == "input" for each in found.operations)
        starts = [values_of(lane.init()) for lane in lanes]
        if not follows and any(start != starts[0] for start in starts):
            raise TraceError(
                f"the lanes of {self.subject.title} begin with different states that do not follow from their "
                "parameters; let `init` work them out of the fields with the functions of tierod.core.graph.maths"
            )
        return found

    @property
    def tuning(self) -> tuple[float, ...]:
        """Smallest value of each parameter over all lanes."""
        # `simplified` relies on positive parameters, which must be positive in every lane.
        return tuple(self._rows.min(axis=0).tolist())

    @property
    def _rows(self) -> np.ndarray:
        count = len(self.graph.tuning)
        return np.array(self.subject.values[: count * self.bank.count]).reshape(self.bank.count, count)

    @cached_property
    def statuses(self) -> tuple[int, ...]:
        """Positions of status outputs; a lane has none."""
        return ()

    @cached_property
    def own(self) -> tuple[int, ...]:
        """Positions of the parameters in which lanes differ."""
        rows = self._rows
        return tuple(int(k) for k in np.flatnonzero((rows != rows[0]).any(axis=0)))

    @cached_property
    def shared(self) -> tuple[int, ...]:
        """Positions of the parameters in which all lanes agree."""
        return tuple(k for k in range(len(self.graph.tuning)) if k not in set(self.own))

    @cached_property
    def shared_members(self) -> tuple[Member, ...]:
        return members([f"lanes.{self.graph.tuning[k]}" for k in self.shared])

    @cached_property
    def own_members(self) -> tuple[Member, ...]:
        """Parameters with a value of their own in each lane."""
        return members([self.graph.tuning[k] for k in self.own])

    @cached_property
    def feedback(self) -> tuple[Member, ...]:
        return members(self.bank.feedback)

    @cached_property
    def named(self) -> dict[tuple[str, int], str]:
        """C code of every number, by the letter of its struct and its position."""
        inputs = len(self.bank.sample)
        found = {("u", k): f"u->{text}" for k, text in enumerate(elements(members(self.bank.sample)))}
        found |= {("u", inputs + k): f"f->{text}" for k, text in enumerate(elements(self.feedback))}
        found |= {("y", k): f"o->{text}" for k, text in enumerate(elements(self.output))}
        for letter, places, all_ in (("p", self.shared, self.shared_members), ("q", self.own, self.own_members)):
            texts = elements(all_)
            found |= {("p", place): f"{letter}->{text}" for place, text in zip(places, texts, strict=True)}
        return found

    @cached_property
    def slots(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Slots of values that depend on parameters only: those equal in all lanes, and those of each lane."""
        varying: set[int] = set()
        own = set(self.own)
        for index, operation in enumerate(self.program.operations):
            is_own = operation.name == "input" and operation.constant[0] == TUNING and operation.constant[1] in own
            if is_own or not varying.isdisjoint(operation.arguments):
                varying.add(index)
        carried = self.program.carried()
        alike = tuple(slot for slot, value in enumerate(carried) if value not in varying)
        return alike, tuple(slot for slot, value in enumerate(carried) if value in varying)

    def carried(self, slot: int) -> str:
        """C code of a value that depends on parameters only."""
        alike, own = self.slots
        return f"c->value[{alike.index(slot)}]" if slot in alike else f"k->value[{own.index(slot)}]"

    def _sampled(self, position: int) -> str:
        return super()._sampled(position) if position < len(self.bank.sample) else self.named["u", position]

    def bit(self, position: int) -> str:
        """Name of the bit that marks an input as valid."""
        return identifier(self.bank.sample[position]).upper()

    def known(self, positions: Sequence[int]) -> tuple[Described, ...]:
        """Descriptions of the parameters of a lane at these positions."""
        return tuple(self.subject.tuning[k] for k in positions)

    @cached_property
    def known_state(self) -> tuple[Described, ...]:
        return tuple(described(self.subject.block.lanes[0].init()))

    @cached_property
    def known_output(self) -> tuple[Described, ...]:
        return tuple(described(self.graph.output_tree))


class BankInterface(_OfBank):
    """Interface of a bank in C as the caller sees it, and of its judge."""

    @cached_property
    def lane(self) -> LaneInterface:
        return LaneInterface(self.subject, self.options)

    @cached_property
    def graph(self) -> Graph:
        """Graph of one judge step, with the inputs and outputs of the bank."""
        judge = self.bank.judge
        return replace(
            judge,
            state=tuple(f"judge.{name}" for name in judge.state),
            tuning=tuple(f"judge.{name}" for name in judge.tuning),
            rings=tuple((f"judge.{name}", size) for name, size in judge.rings),
            sample=self.bank.sample,
            output=self.bank.output,
        )

    @cached_property
    def stepped(self) -> Program:
        """Simplified program of one judge step."""
        return simplified(program(self.bank.judge.function), self.initial, self.tuning)

    @cached_property
    def initial(self) -> Program:
        """Program that sets the initial state of the judge."""
        return initial_program(self.subject.block.judge)

    @property
    def tuning(self) -> tuple[float, ...]:
        """Values of the parameters of the judge."""
        return self.subject.values[self.tuned :]

    @cached_property
    def known_feedback(self) -> tuple[Described, ...]:
        """Descriptions of the feedback from the judge to the lanes."""
        return tuple(described(self.subject.block.judge.feedback()))

    @property
    def fed_first(self) -> tuple[float, ...]:
        """Feedback that the lanes receive with the first sample."""
        return tuple(float(leaf) for leaf in values_of(self.subject.block.judge.feedback()))

    @property
    def tuned(self) -> int:
        """Number of parameters of all lanes; those of the judge follow them."""
        return self.bank.count * len(self.bank.lane.tuning)

    def carried(self, slot: int) -> str:
        """C code of a judge value that depends on parameters only; these values follow those shared by all lanes."""
        return f"c->value[{len(self.lane.slots[0]) + slot}]"

    def taken(self, source: tuple[int, int]) -> str:
        """C code of an input of the judge, as a number."""
        group, position = source
        place = position - len(self.bank.sample)
        if group != SAMPLE or place < 0:
            return super().taken(source)
        number, output = divmod(place, len(self.bank.lane.output))
        return f"x->said[{number}].{self._said[output]}"

    def given(self, target: tuple[int, int]) -> str:
        """C code of an output of the judge: an output of the bank, an adopted lane or a feedback."""
        group, position = target
        place = position - len(self.bank.output)
        if group != OUTPUT or place < 0:
            return super().given(target)
        if place < self.bank.count:
            return f"a[{place}]"
        return f"x->feedback.{elements(self.lane.feedback)[place - self.bank.count]}"

    def gathered(self, positions: Sequence[int], number: str) -> str | None:
        """C code of one lane output by lane number; None unless the positions are this output of lanes 0, 1, ..."""
        first, width = positions[0] - len(self.bank.sample), len(self.bank.lane.output)
        if not 0 <= first < width or any(each != positions[0] + width * k for k, each in enumerate(positions)):
            return None
        return f"x->said[{number}].{self._said[first]}"

    @cached_property
    def _said(self) -> tuple[str, ...]:
        return elements(self.lane.output)
