"""The third driver: many vehicles at once, in the lanes of vector registers (`batch`)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tierod.core.block import Block, Given, Output, State
from tierod.core.errors import InputError
from tierod.core.graph.kernel import LaneKernel, lane_array, lane_kernel
from tierod.core.graph.printer import LANES
from tierod.core.graph.runtime import Memory, Result, Samples, Scanner, columns_of, memory_of
from tierod.core.graph.trace import trace

# Smallest number of vehicles for lanes: used or not, all lanes together cost as much as two or three single runs
FEWEST = 3


def batch(
    blocks: Block[State, Given, Output] | Sequence[Block[State, Given, Output]],
    recordings: Sequence[Samples],
    states: Sequence[Memory | State | None] | None = None,
) -> list[Result[Output]]:
    """Run many vehicles at once, side by side in the lanes of vector registers.

    Args:
        blocks: one for all, or one per recording; they may differ in their floats (calibrations), not in structure
        recordings: one set of samples per vehicle, as for `scan`; lengths may differ
        states: one per vehicle to continue from; the blocks' own initial states if None

    Returns:
        one result per vehicle, equal to that of `scan` to the last bit
    """
    count = len(recordings)
    every = list(blocks) if isinstance(blocks, Sequence) else [blocks] * count
    states = [None] * count if states is None else list(states)
    if len(every) != count or len(states) != count:
        raise InputError(f"{count} recordings came with {len(every)} blocks and {len(states)} states; give one of each")
    if any(trace(block) is not trace(every[0]) for block in every[1:]):
        raise InputError("the blocks of a batch differ in structure; run each kind in a batch of its own")
    results: list[Result[Output]] = []
    for first in range(0, count, LANES):
        part = slice(first, first + LANES)
        results += SideBySide().scan(every[part], recordings[part], states[part])
    return results


class SideBySide:
    """Runs blocks side by side over consecutive pieces of recordings; prepares a kernel once for the same blocks."""

    def __init__(self) -> None:
        # The blocks are kept alive: after an object is deleted, another one may get its id.
        self._ready: dict[tuple[int, ...], tuple[Sequence[Block], LaneKernel | None, list[Scanner[Any, Any, Any]]]] = {}

    def scan(
        self,
        blocks: Sequence[Block[State, Given, Output]],
        recordings: Sequence[Samples],
        states: Sequence[Memory | State | None],
    ) -> list[Result[Output]]:
        """Run blocks over their next pieces.

        Args:
            recordings: one set of samples per block; lengths may differ
            states: one per block to continue from; its own initial state if None
        """
        key = tuple(map(id, blocks))
        if key not in self._ready:
            self._ready[key] = blocks, lane_kernel(list(blocks)) if len(blocks) >= FEWEST else None, []
        _, lanes, alone = self._ready[key]
        graph = None if lanes is None else lanes.graph
        memories = [memory_of(block, state, graph) for block, state in zip(blocks, states, strict=True)]
        if lanes is not None and len({memory.count for memory in memories}) == 1:
            return _scanned(lanes, recordings, memories)
        alone += [Scanner(block) for block in blocks[len(alone) :]]
        runs = zip(alone, recordings, memories, strict=True)
        return [each.scan(samples, memory) for each, samples, memory in runs]


def _scanned(runner: LaneKernel, recordings: Sequence[Samples], memories: Sequence[Memory]) -> list[Result[Any]]:
    found: dict[int, np.ndarray] = {}  # samples that lanes share, as with varied parameters, are arranged once
    samples = []
    for recording in recordings:
        if id(recording) not in found:
            found[id(recording)] = np.ascontiguousarray(columns_of(runner.graph, recording))
        samples.append(found[id(recording)])
    lengths = [len(values) for values in samples]
    # One array for all: the C library returns several large ones to the system each time, and fresh pages cost time.
    whole = np.empty((len(samples), max(lengths, default=0), len(runner.graph.output)))
    outputs = [each[:length] for each, length in zip(whole, lengths, strict=True)]
    states = lane_array(runner.graph.memory)
    states[:] = 0.0
    states[:, : len(memories)] = np.column_stack([memory.values for memory in memories])
    ended: dict[int, np.ndarray] = {}
    done = 0
    for stop in sorted(set(lengths)):
        _advance_lanes(runner, states, samples, outputs, done, stop, memories[0].count)
        ended |= {lane: states[:, lane].copy() for lane, length in enumerate(lengths) if length == stop}
        done = stop
    return [
        Result(
            runner.graph.output,
            values,
            Memory(ended[lane], memories[lane].count + len(values)),
            runner.graph.output_tree,
        )
        for lane, values in enumerate(outputs)
    ]


def _advance_lanes(
    runner: LaneKernel,
    states: np.ndarray,
    samples: list[np.ndarray],
    outputs: list[np.ndarray],
    start: int,
    stop: int,
    count: int,
) -> None:
    """Advance the lanes whose samples reach from start to stop; the others run idle on the input of another lane."""
    running = [lane for lane, values in enumerate(samples) if len(values) >= stop]
    idle = np.empty((stop - start, outputs[0].shape[1]))
    lanes = [lane if lane in running else None for lane in range(LANES)]
    inputs = [samples[running[0] if lane is None else lane][start:] for lane in lanes]
    runner.batch(
        states, inputs, [idle if lane is None else outputs[lane][start:] for lane in lanes], stop - start, count + start
    )
