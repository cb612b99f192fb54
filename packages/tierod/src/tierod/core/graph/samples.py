"""Data of all drivers: samples in, results and states out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from tierod.core.block import Block, Given, Output, State, rebuild
from tierod.core.errors import InputError, nearest
from tierod.core.graph.memory_layout import flat_memory
from tierod.core.graph.trace import Interface, initial_memory, trace
from tierod.core.recording import Aligned


@dataclass(frozen=True)
class Memory:
    """The state of a block between two runs.

    Args:
        values: flat, delay lines at the end, shape (numbers,)
    """

    values: np.ndarray
    count: int


@dataclass(frozen=True)
class Result(Generic[Output]):
    """Result of a block over many samples.

    Args:
        values: shape (n, outputs)
    """

    names: tuple[str, ...]
    values: np.ndarray
    state: Memory
    tree: Output

    def __getitem__(self, name: str) -> np.ndarray:
        """One output over time, shape (n,), as a contiguous copy, since a column of the table is slow to read."""
        try:
            return np.ascontiguousarray(self.values[:, self.names.index(name)])
        except ValueError:
            raise InputError(f"the block has no output '{name}'{nearest(name, self.names)}") from None

    def __len__(self) -> int:
        return len(self.values)

    def end(self) -> Result[Output]:
        """The result for the last sample alone, without the memory of the others; empty without samples."""
        return replace(self, values=self.values[-1:].copy())

    def at(self, index: int) -> Output:
        """The output of one sample as the block's own NamedTuple."""
        return rebuild(self.tree, self.values[index].tolist())


Samples = Aligned | np.ndarray | Sequence[Sequence[float]]


def memory_of(
    block: Block[State, Given, Output], state: Memory | State | None, traced: Interface | None = None
) -> Memory:
    """Memory at the start of a run, of the size that the block's kernel reads and writes.

    Args:
        state: state to continue from; the block's own initial state if None
        traced: the block's graph, where it is known

    Raises:
        InputError: the state belongs to a block of another structure
    """
    if state is None:
        return Memory(initial_memory(block), 0)
    memory = state if isinstance(state, Memory) else Memory(flat_memory(state), 0)
    values, needed = np.array(memory.values, dtype=float), (traced or trace(block)).memory
    if values.shape != (needed,) or memory.count < 0:
        raise InputError(
            f"the state has the shape {values.shape} after {memory.count} samples, but {type(block).__name__} "
            f"remembers {needed} numbers; go on from the state of a block of the same structure"
        )
    return Memory(values, memory.count)


def columns_of(graph: Interface, samples: Samples) -> np.ndarray:
    """The samples as an array (n, inputs) in the order of the graph's inputs.

    Raises:
        InputError: signals are missing, or the shape does not fit
    """
    if isinstance(samples, Aligned):
        if samples.names == graph.sample:
            return samples.values
        missing = [name for name in graph.sample if name not in samples.names]
        if missing:
            raise InputError(f"{graph.name} needs the signal '{missing[0]}'{nearest(missing[0], samples.names)}")
        return samples.values[:, [samples.names.index(name) for name in graph.sample]]
    try:
        values = np.asarray(samples, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"the samples of {graph.name} are not all numbers ({error}); give NaN where one is missing"
        ) from None
    if values.ndim == 1 and len(graph.sample) == 1:
        values = values[:, None]
    if values.ndim != 2 or values.shape[1] != len(graph.sample):
        raise InputError(
            f"{graph.name} takes {len(graph.sample)} signals ({', '.join(graph.sample)}); "
            f"the samples have the shape {values.shape}, expected (n, {len(graph.sample)})"
        )
    return values
