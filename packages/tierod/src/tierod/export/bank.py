"""An exported bank: its structs, one function for all lanes, called in a loop, the judge, and the copying of states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from tierod.core.block import values_of
from tierod.core.errors import TraceError
from tierod.core.graph.bank import BankGraph
from tierod.core.graph.operations import OUTPUT, SAMPLE, TUNING, Program, program
from tierod.core.graph.trace import Graph, initial_program
from tierod.export.c_header import HASH, declared, outer_structs, rows_of, state_rows, struct, template
from tierod.export.c_source import assembled, braced, constants, initial, parameter_rows, prepare, step
from tierod.export.interface import Interface
from tierod.export.simplification import simplified
from tierod.export.subject import Described, Member, described, elements, identifier, members


class _OfBank(Interface):
    @property
    def bank(self) -> BankGraph:
        bank: BankGraph = self.subject.graph
        return bank


class LaneInterface(_OfBank):
    @property
    def graph(self) -> Graph:
        return self.bank.lane

    @cached_property
    def initial(self) -> Program:
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


def bank_structs(face: BankInterface) -> str:
    lane, prefix, count = face.lane, face.prefix, face.bank.count
    tuned, real = face.subject.tuning, face.spelling.real
    alike, own = lane.slots
    shared = rows_of(face, lane.shared_members, lane.known(lane.shared))
    parameters = [
        HASH, *shared, f"    /* what lanes differ in */\n    {prefix}_lane_parameters_t lane[{count}];\n",
        *rows_of(face, face.parameters, tuned[face.tuned :]),
    ]  # fmt: skip
    values = [f"    {real} value[{max(len(alike) + len(face.program.carried()), 1)}];\n"]
    values.append(f"    {prefix}_lane_constants_t lane[{count}];\n")
    feedback = rows_of(face, lane.feedback, face.known_feedback)
    state = [
        f"    {prefix}_lane_state_t lanes[{count}];\n",
        f"    /* what the lanes state at this step */\n    {prefix}_lane_output_t said[{count}];\n",
        f"    /* of a lane, while lanes exchange their states */\n    {prefix}_lane_state_t kept;\n",
        *([f"    {prefix}_feedback_t feedback;\n"] if feedback else []), *state_rows(face),
    ]  # fmt: skip
    fed = struct(face, "feedback", "What every lane is given with the next sample.", feedback) if feedback else ""
    own_values = [f"    {real} value[{max(len(own), 1)}];\n"]
    rows = (
        ("lane_parameters", "Of one lane.", rows_of(face, lane.own_members, lane.known(lane.own))),
        ("parameters", "Of the vehicle and of the monitor; those with lanes_ are shared by all lanes.", parameters),
        ("lane_constants", "What depends on the parameters of one lane.", own_values),
        ("constants", "What depends on the parameters alone; shared by all instances.", values),
        ("lane_state", "Memory of one lane.", state_rows(lane, lane.known_state)),
        ("lane_output", "What one lane states.", rows_of(face, lane.output, lane.known_output)),
        ("state", "Memory of one instance; it belongs to the caller.", state),
    )
    return outer_structs(face) + fed + "".join(struct(face, *each) for each in rows)


def bank_parameter_rows(face: BankInterface) -> str:
    lane, subject = face.lane, face.subject
    width, tuned = len(face.bank.lane.tuning), face.tuned
    values = [subject.values[k] for k in lane.shared]
    shared = parameter_rows(face, lane.shared_members, lane.known(lane.shared), values)
    rows = []
    for number in range(face.bank.count):
        own = [subject.values[number * width + k] for k in lane.own]
        members = ", ".join(f".{each.name} = {braced(face, each, own)}" for each in lane.own_members) or "0U"
        rows.append(f"        {{{members}}},\n")
    judge = parameter_rows(face, face.parameters, subject.tuning[tuned:], subject.values[tuned:])
    return f"{shared}    .lane = {{\n{''.join(rows)}    }},\n{judge}"


def bank_source(face: BankInterface) -> str:
    """C code of a bank's source file."""
    parts = (_prepare(face), _init(face), _steps(face), _whole(face))
    return assembled(face, "\n".join(parts))


def _arguments(face: BankInterface, letters: str, writes: str = "") -> dict[str, str]:
    kinds = {
        "p": "parameters", "q": "lane_parameters", "c": "constants", "k": "lane_constants", "x": "lane_state",
        "u": "sample", "o": "lane_output", "f": "feedback",
    }  # fmt: skip
    return {
        each: f"{'' if each in writes else 'const '}{face.prefix}_{kinds[each]}_t *{each}"
        for each in letters
        if each != "f" or face.lane.feedback
    }


def _prepare(face: BankInterface) -> str:
    """Functions that compute the values depending on parameters only: shared by all lanes, per lane, of the judge."""
    lane, prefix = face.lane, face.prefix
    alike, own = lane.slots
    lanes = constants(lane, alike, "prepare_lanes", _arguments(face, "pc", "c"), True)
    each = constants(lane, own, "prepare_lane", _arguments(face, "pqk", "k"), True)
    judge = prepare(face, "prepare_judge", static=True)
    given = f"{declared(face, 'p')}, {declared(face, 'c', writes=True)}"
    return (
        f"{lanes}\n{each}\n{judge}\nvoid {prefix}_prepare({given})\n{{\n"
        f"    {prefix}_prepare_lanes(p, c);\n    for (uint16_t i = 0U; i < {face.bank.count}U; i++) {{\n"
        f"        {prefix}_prepare_lane(p, &p->lane[i], &c->lane[i]);\n    }}\n    {prefix}_prepare_judge(p, c);\n}}\n"
    )


def _init(face: BankInterface) -> str:
    prefix = face.prefix
    lane = initial(face.lane, "init_lane", _arguments(face, "pqx", "x"), "", True)
    judge = initial(face, "init_judge", {"p": declared(face, "p"), "x": declared(face, "x")}, "", True)
    fed = "".join(
        f"    x->feedback.{each.name} = {face.spelling.number(value)};\n"
        for each, value in zip(face.lane.feedback, face.fed_first, strict=True)
    )
    return (
        f"{lane}\n{judge}\nvoid {prefix}_init({declared(face, 'p')}, {declared(face, 'x')})\n{{\n"
        f"    *x = ({prefix}_state_t){{0}};\n    for (uint16_t i = 0U; i < {face.bank.count}U; i++) {{\n"
        f"        {prefix}_init_lane(p, &p->lane[i], &x->lanes[i]);\n    }}\n    {prefix}_init_judge(p, x);\n{fed}}}\n"
    )


def _steps(face: BankInterface) -> str:
    lane = step(face.lane, "lane", _arguments(face, "ckxuof", "xo"))
    judged = {word: declared(face, word) for word in "cxuy"} | {"a": f"{face.spelling.real} a[{face.bank.count}U]"}
    judge = step(face, "judge", judged, face.gathered)
    adopt = template("adopt.c").replace("PREFIX", face.prefix).replace("COUNT", str(face.bank.count))
    limit = face.spelling.number(float(face.bank.count))
    return f"{lane}\n{judge}\n{adopt.replace('ZERO', face.spelling.number(0.0)).replace('LIMIT', limit)}"


def _whole(face: BankInterface) -> str:
    prefix, count = face.prefix, face.bank.count
    given = ", ".join(declared(face, word) for word in "cxuy")
    fed = ", &x->feedback" if face.lane.feedback else ""
    return (
        f"void {prefix}_step({given})\n{{\n    {face.spelling.real} a[{count}U];\n\n"
        f"    for (uint16_t i = 0U; i < {count}U; i++) {{\n"
        f"        {prefix}_lane(c, &c->lane[i], &x->lanes[i], u, &x->said[i]{fed});\n    }}\n"
        f"    {prefix}_judge(c, x, u, y, a);\n    {prefix}_adopt(x, a);\n}}\n"
    )
