"""Filter banks: copies of one block, each with its own calibration, and a judge that compares them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from tierod.core.block import Tree, leaves, values_of
from tierod.core.errors import TraceError
from tierod.core.graph.bank_graph import BankGraph, trace_bank
from tierod.core.graph.maths import is_symbol
from tierod.core.graph.memory_layout import BankState

KEEP = -1.0
"""Entry of `Verdict.adopt` for a lane that continues with its own state."""


class JudgeSample(NamedTuple):
    sample: Tree
    lanes: tuple[Tree, ...]


class Verdict(NamedTuple):
    """Result of a judge for one sample.

    Args:
        adopt: per lane the number of the lane whose state it takes over after this sample; `KEEP` for its own
        feedback: feedback of the judge to every lane with the next sample, () for none
    """

    output: Tree
    adopt: tuple[Any, ...]
    feedback: Tree = ()


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

    Args:
        lanes: blocks that differ in their floats only; `step(state, sample)`, or `step(state, sample, feedback)` where
            the judge gives feedback. No delay lines

    A bank is run by all drivers; it cannot stand inside another block.
    """

    lanes: tuple[Any, ...]
    judge: Any

    @property
    def Sample(self) -> type:
        sample: type = self.lanes[0].Sample
        return sample

    def init(self) -> BankState:
        return BankState(tuple(lane.init() for lane in self.lanes), self.judge.init(), self.judge.feedback())

    def step(self, state: BankState, sample: Tree) -> tuple[BankState, Tree]:
        """Advance by one sample, in plain numbers.

        Raises:
            TraceError: the sample holds symbols, that is, the bank stands inside another block
        """
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
        return trace_bank(self, JudgeSample)
