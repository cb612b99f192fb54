"""Filter banks: copies of one block, each with its own calibration, and a judge that compares them."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from typing import Any, NamedTuple, Protocol

from tierod.core.block import Ring, Tree, leaves, map_leaves, skeleton, structure, values_of
from tierod.core.errors import TraceError
from tierod.core.graph.known_graphs import entry_of, interface_of, keep_interface
from tierod.core.graph.maths import is_symbol
from tierod.core.graph.trace import GROUP, INTERFACE, BankState, Graph, straight_line


@dataclass(frozen=True, eq=False)
class BankGraph:
    name: str
    lane: Graph
    # graph of the judge, which takes the sample of the bank and the outputs of all lanes, and gives output, adopted
    # lanes and feedback
    judge: Graph
    count: int
    feedback: tuple[str, ...]  # dotted names of the judge's feedback to the lanes
    sample_tree: Tree
    output_tree: Tree
    # name under which later processes find names and kernel; None where they trace the bank themselves
    entry: str | None = None

    @property
    def groups(self) -> int:
        """Number of groups of lanes that are stepped together; the last group is padded."""
        return -(-self.count // GROUP)

    @property
    def lanes_memory(self) -> int:
        """Number of state values of all lanes, padding included."""
        return self.groups * len(self.lane.state) * GROUP

    @cached_property
    def tuning(self) -> tuple[str, ...]:
        """Dotted names of the floats of all lanes and of the judge, in order."""
        lanes = [f"lanes.{number}.{name}" for number in range(self.count) for name in self.lane.tuning]
        return (*lanes, *(f"judge.{name}" for name in self.judge.tuning))

    @cached_property
    def state(self) -> tuple[str, ...]:
        """Dotted names of the memory, in order, padding included and delay lines left out."""
        lanes = [
            f"lanes.{group * GROUP + lane}.{name}"
            for group in range(self.groups)
            for name in self.lane.state
            for lane in range(GROUP)
        ]
        judge = (f"judge.{name}" for name in self.judge.state)
        return (*lanes, *judge, *(f"feedback.{name}" for name in self.feedback))

    @property
    def rings(self) -> tuple[tuple[str, int], ...]:
        """(name, size) of the judge's delay lines; lanes have none."""
        return self.judge.rings

    @cached_property
    def sample(self) -> tuple[str, ...]:
        """Dotted names of the inputs."""
        return tuple(path for path, _ in leaves(self.sample_tree))

    @cached_property
    def output(self) -> tuple[str, ...]:
        return tuple(path for path, _ in leaves(self.output_tree))

    @property
    def memory(self) -> int:
        """Number of state values, padding and delay lines included."""
        return len(self.state) + sum(size for _, size in self.rings)


def trace_bank(bank: Bank) -> BankGraph:
    """The graph of a bank; where an earlier process has compiled it, its operations are traced only on demand."""
    entry = entry_of(structure(bank), type(bank).__name__)
    if entry is None:
        return _traced(bank)
    names = {each.name for each in fields(BankGraph)} - {"entry"}
    known = interface_of(entry)
    if known is not None and {*known} == names and all({*known[part]} == {*INTERFACE} for part in ("lane", "judge")):
        # Traced at most once, and only where the operations of lane or judge are needed.
        traced = cache(lambda: _traced(bank))
        lane = Graph(**known["lane"], make=lambda: traced().lane.function)
        judge = Graph(**known["judge"], make=lambda: traced().judge.function)
        return BankGraph(**{**known, "lane": lane, "judge": judge}, entry=entry)
    graph = _traced(bank)
    own = {name: getattr(graph, name) for name in names}
    keep_interface(entry, {**own, "lane": graph.lane.interface, "judge": graph.judge.interface})
    return replace(graph, entry=entry)


def _traced(bank: Bank) -> BankGraph:
    if not bank.lanes:
        raise TraceError("a bank has no lanes; give it one block at least")
    first, judge, count = bank.lanes[0], bank.judge, len(bank.lanes)
    if any(structure(lane) != structure(first) for lane in bank.lanes[1:]):
        raise TraceError(
            f"the lanes of a bank of {type(first).__name__} differ in more than their floats; "
            "let flags be floats (1.0, 0.0) that the step asks with `where`"
        )
    if any(isinstance(leaf, Ring) for leaf in values_of(first.init())):
        raise TraceError(f"{type(first).__name__} holds a delay line; lanes of a bank cannot, their judge can")
    said = judge.feedback()
    fed = any(leaves(said))
    inputs = skeleton(first.Sample)
    lane = straight_line(
        first, (inputs, said), lambda block, state, given: block.step(state, given[0], *(given[1:] if fed else ()))
    )
    judge_graph = straight_line(
        judge, (inputs, (lane.output_tree,) * count), lambda block, state, given: block.step(state, JudgeSample(*given))
    )
    verdict = judge_graph.output_tree
    _check_verdict(verdict, said, count, type(judge).__name__)
    return BankGraph(
        name=type(bank).__name__,
        lane=lane,
        judge=judge_graph,
        count=count,
        feedback=tuple(path for path, _ in leaves(said)),
        sample_tree=inputs,
        output_tree=map_leaves(lambda _: 0.0, verdict.output),
    )


def _check_verdict(verdict: Tree, said: Tree, count: int, name: str) -> None:
    if len(verdict.adopt) != count:
        raise TraceError(f"{name} names {len(verdict.adopt)} lanes to adopt for {count} lanes; give one for each")
    before, after = [path for path, _ in leaves(said)], [path for path, _ in leaves(verdict.feedback)]
    if before != after:
        raise TraceError(
            f"{name}.step gives feedback of another shape ({', '.join(after)}) than {name}.feedback "
            f"({', '.join(before)}); return the same fields in the same order"
        )


KEEP = -1.0  # Entry of `Verdict.adopt` for a lane that continues with its own state


class JudgeSample(NamedTuple):
    sample: Tree
    lanes: tuple[Tree, ...]


class Verdict(NamedTuple):
    """Result of a judge for one sample."""

    output: Tree
    # per lane the number of the lane whose state it takes over after this sample; `KEEP` for its own
    adopt: tuple[Any, ...]
    feedback: Tree = ()  # feedback of the judge to every lane with the next sample, () for none


class Judge(Protocol):
    """Block that compares the lanes of a bank."""

    def init(self) -> Tree: ...

    def feedback(self) -> Tree:
        """Feedback to every lane with the first sample; () where the judge gives the lanes none."""

    def step(self, state: Tree, sample: JudgeSample) -> tuple[Tree, Verdict]: ...


@dataclass(frozen=True)
class Bank:
    """Blocks of one structure side by side, and a judge that compares them.

    With every sample each lane steps; the judge then takes the sample and the outputs of all lanes, gives the output of
    the bank, and may let lanes take over the state of others. Lanes that take over and are taken over in one sample
    exchange the states that they had after their own step. Compiled, eight lanes are stepped at once.

    A bank is run by all drivers; it cannot stand inside another block.
    """

    # blocks that differ in their floats only; `step(state, sample)`, or `step(state, sample, feedback)` where the
    # judge gives feedback. No delay lines
    lanes: tuple[Any, ...]
    judge: Any

    @property
    def Sample(self) -> type:
        sample: type = self.lanes[0].Sample
        return sample

    def init(self) -> BankState:
        return BankState(tuple(lane.init() for lane in self.lanes), self.judge.init(), self.judge.feedback())

    def step(self, state: BankState, sample: Tree) -> tuple[BankState, Tree]:
        """Advance by one sample, in plain numbers."""
        if any(is_symbol(leaf) for leaf in values_of(sample)):
            raise TraceError("a Bank cannot be inside another block; run the blocks before and after it separately")
        said = [state.feedback] if any(leaves(state.feedback)) else []
        pairs = zip(self.lanes, state.lanes, strict=True)
        stepped = [lane.step(memory, sample, *said) for lane, memory in pairs]
        lanes, outputs = tuple(memory for memory, _ in stepped), tuple(output for _, output in stepped)
        judged, verdict = self.judge.step(state.judge, JudgeSample(sample, outputs))
        # As in compiled code, any number that is no lane's, NaN included, keeps the own state.
        taken = tuple(
            lanes[int(source)] if 0.0 <= source < len(lanes) else own
            for source, own in zip(verdict.adopt, lanes, strict=True)
        )
        return BankState(taken, judged, verdict.feedback), verdict.output

    def traced(self) -> BankGraph:
        return trace_bank(self)
