"""The three drivers: a recording (`scan`), a live stream (`Stream`), many vehicles at once (`batch`)."""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from numbers import Real
from typing import Any

import numpy as np

from tierod.block import Block, Tree, leaves, rebuild
from tierod.errors import InputError, nearest
from tierod.graph.kernel import CompiledKernel, Engine, LaneKernel, is_interpreted, kernel
from tierod.graph.printer import LANES
from tierod.graph.trace import Graph, flat_memory, initial_memory, trace
from tierod.recording import Aligned


@dataclass(frozen=True)
class Memory:
    """The state of a block between two runs.

    Args:
        values: flat, delay lines at the end, shape (numbers,)
        count: samples seen so far
    """

    values: np.ndarray
    count: int


@dataclass(frozen=True)
class Result:
    """What a block gave over many samples.

    Args:
        names: dotted names of the outputs, in order
        values: shape (n, outputs)
        state: to go on from
        tree: an output of zeros, in its shape
    """

    names: tuple[str, ...]
    values: np.ndarray
    state: Memory
    tree: Tree

    def __getitem__(self, name: str) -> np.ndarray:
        """One output over time, shape (n,)."""
        try:
            return self.values[:, self.names.index(name)]
        except ValueError:
            raise InputError(f"the block has no output '{name}'{nearest(name, self.names)}") from None

    def __len__(self) -> int:
        return len(self.values)

    def at(self, index: int) -> Tree:
        """The output of one sample as the block's own NamedTuple."""
        return rebuild(self.tree, self.values[index].tolist())


Samples = Aligned | np.ndarray | Sequence[Sequence[float]]


def scan(block: Block, samples: Samples, state: Memory | Tree | None = None, engine: Engine = "auto") -> Result:
    """Run a block over a recording.

    Args:
        block: estimator, detector, monitor, plant
        samples: signals aligned to one time grid (columns are found by name), or an array (n, inputs) in the order of
            the leaves of `block.Sample`
        state: to go on from: the `state` of an earlier result, or a state tree; the block's own initial state if None
        engine: "compiled", "virtual machine" or "auto"

    Raises:
        InputError: the samples do not have the block's signals
        TraceError: the block cannot be traced
    """
    runner = kernel(block, engine)
    memory = _memory(block, state)
    values = np.ascontiguousarray(_columns(runner.graph, samples))
    outputs = np.empty((len(values), len(runner.graph.output)))
    flat = memory.values.copy()
    runner.scan(flat, values, outputs, memory.count)
    return Result(runner.graph.output, outputs, Memory(flat, memory.count + len(values)), runner.graph.output_tree)


class Stream:
    """A block run live: one sample in, one output out. It changes with each sample, so one thread at a time may use it.

    Args:
        block: estimator, detector, monitor
        state: to go on from; the block's own initial state if None

    `push` takes names and gives names. Where every microsecond counts, write into `inputs`, call `advance()`, and read
    `outputs`: the same step on the same bound buffers, nothing in between.
    """

    def __init__(self, block: Block, state: Memory | Tree | None = None, engine: Engine = "auto"):
        runner = kernel(block, engine)
        graph, memory = runner.graph, _memory(block, state)
        self.names = graph.sample
        self.inputs = np.zeros(len(graph.sample))
        self.outputs = np.zeros(len(graph.output))
        self._flat = memory.values.copy()
        self._make = _builder(graph.output_tree)
        self._write = struct.Struct(f"{len(self.inputs)}d").pack_into
        self._read = struct.Struct(f"{len(self.outputs)}d").unpack_from
        self._input_bytes, self._output_bytes = self.inputs.data.cast("B"), self.outputs.data.cast("B")
        self._before = memory.count
        self.advance = self._bind(runner) if isinstance(runner, CompiledKernel) else self._interpreted(runner)

    def push(self, sample: Mapping[str, float] | Iterable[float]) -> Any:
        """One sample on.

        Args:
            sample: a mapping of (dotted) names to numbers, or the block's own `Sample`

        Returns:
            the block's output

        Raises:
            InputError: a signal is missing, or the count of numbers is wrong
        """
        try:
            if type(sample) is dict or isinstance(sample, Mapping):
                self._write(self._input_bytes, 0, *map(sample.__getitem__, self.names))
            else:
                self._write(self._input_bytes, 0, *sample)
        except (KeyError, TypeError, struct.error) as error:
            self._write(self._input_bytes, 0, *self._flattened(sample, error))
        self.advance()
        return self._make(*self._read(self._output_bytes))

    @property
    def state(self) -> Memory:
        """The present state, to be stored or to go on from."""
        return Memory(self._flat.copy(), self._count())

    def _flattened(self, sample: Any, error: Exception) -> list[float]:
        """The numbers of a sample that is a tree of tuples; anything else is refused."""
        if isinstance(sample, Mapping):
            missing = [name for name in self.names if name not in sample]
            if missing:
                raise InputError(
                    f"the sample has no '{missing[0]}' (NaN stands for a measurement that is missing)"
                    f"{nearest(missing[0], map(str, sample))}"
                ) from None
            sample = tuple(sample[name] for name in self.names)
        flat = [leaf for _, leaf in leaves(sample)]
        if len(flat) != len(self.names) or not all(isinstance(leaf, Real) for leaf in flat):
            raise InputError(
                f"a sample needs {len(self.names)} numbers ({', '.join(self.names)}): {error}; "
                "give a mapping of these names, or the block's own Sample"
            ) from None
        return flat

    def _bind(self, runner: CompiledKernel) -> Any:
        def pointer(array: np.ndarray) -> int:
            return array.ctypes.data

        self._bound = _Bound(pointer(self._flat), pointer(self.inputs), pointer(self.outputs), 0, self._before)
        self._carried = runner.carried
        self._bound.carried = pointer(self._carried)
        push = getattr(runner.library, f"{runner.name}_push")
        push.restype = None
        self._count = lambda: int(self._bound.count)
        return partial(push, ctypes.byref(self._bound))

    def _interpreted(self, runner: Any) -> Any:
        inputs, outputs = self.inputs.reshape(1, -1), self.outputs.reshape(1, -1)
        seen = [self._before]
        self._count = lambda: seen[0]

        def advance() -> None:
            runner.scan(self._flat, inputs, outputs, seen[0])
            seen[0] += 1

        return advance


def _builder(tree: Tree) -> Any:
    """A function from the leaves of a tree to the tree, as fast as Python can: a lambda written for its shape."""
    names: dict[str, Any] = {}

    def written(branch: Tree) -> str:
        if not isinstance(branch, tuple):
            names[f"v{len(names)}"] = None
            return f"v{len(names) - 1}"
        parts = "".join(f"{written(part)}, " for part in branch)
        if not hasattr(branch, "_fields"):
            return f"({parts})"
        kind = f"k{len(names)}"
        names[kind] = type(branch)
        return f"{kind}({parts})"

    body = written(tree)
    leaves_ = ", ".join(name for name in names if name.startswith("v"))
    return eval(f"lambda {leaves_}: {body}", {name: kind for name, kind in names.items() if kind is not None})


class _Bound(ctypes.Structure):
    _fields_ = (
        ("state", ctypes.c_void_p),
        ("inputs", ctypes.c_void_p),
        ("outputs", ctypes.c_void_p),
        ("carried", ctypes.c_void_p),
        ("count", ctypes.c_long),
    )


def batch(
    blocks: Block | Sequence[Block], recordings: Sequence[Samples], states: Sequence[Memory | Tree | None] | None = None
) -> list[Result]:
    """Run many vehicles at once, 64 side by side.

    Args:
        blocks: one for all, or one per recording; they may differ in their floats (calibrations), not in structure
        recordings: one set of samples per vehicle, as for `scan`; lengths may differ
        states: one per vehicle to go on from; the blocks' own initial states if None

    Returns:
        one result per vehicle, to the last bit what `scan` gives

    Raises:
        InputError: counts differ, or blocks of different structure are mixed
    """
    count = len(recordings)
    every: list[Any] = (
        list(blocks) if isinstance(blocks, (list, tuple)) and not hasattr(blocks, "step") else [blocks] * count
    )
    states = [None] * count if states is None else list(states)
    if len(every) != count or len(states) != count:
        raise InputError(f"{count} recordings came with {len(every)} blocks and {len(states)} states; give one of each")
    if any(trace(block) is not trace(every[0]) for block in every[1:]):
        raise InputError(
            "the blocks of a batch differ in structure; run each kind in a batch of its own, and write the numbers of "
            "a calibration as floats (1.0, not 1): whole numbers count as structure"
        )
    memories = [_memory(block, state) for block, state in zip(every, states, strict=True)]
    results: list[Result] = []
    for first in range(0, count, LANES):
        part = slice(first, first + LANES)
        results += _tile(every[part], recordings[part], memories[part])
    return results


def _tile(blocks: list[Block], recordings: Sequence[Samples], memories: list[Memory]) -> list[Result]:
    if is_interpreted() or len({memory.count for memory in memories}) > 1:
        return [
            scan(block, samples, memory) for block, samples, memory in zip(blocks, recordings, memories, strict=True)
        ]
    runner = LaneKernel(blocks)
    samples = [np.ascontiguousarray(_columns(runner.graph, recording)) for recording in recordings]
    lengths = [len(values) for values in samples]
    outputs = [np.empty((length, len(runner.graph.output))) for length in lengths]
    states = np.zeros((runner.graph.memory, LANES))
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
    """Samples start to stop of the lanes that reach so far; the others run idle on another lane's input."""
    running = [lane for lane, values in enumerate(samples) if len(values) >= stop]
    idle = np.empty((stop - start, outputs[0].shape[1]))
    lanes = [lane if lane in running else None for lane in range(LANES)]
    inputs = [samples[running[0] if lane is None else lane][start:] for lane in lanes]
    runner.batch(
        states, inputs, [idle if lane is None else outputs[lane][start:] for lane in lanes], stop - start, count + start
    )


def _memory(block: Block, state: Memory | Tree | None) -> Memory:
    """What a run starts from, of the size that the block's kernel reads and writes."""
    if state is None:
        return Memory(initial_memory(block), 0)
    memory = state if isinstance(state, Memory) else Memory(flat_memory(state), 0)
    values, needed = np.array(memory.values, dtype=float), trace(block).memory
    if values.shape != (needed,) or memory.count < 0:
        raise InputError(
            f"the state has the shape {values.shape} after {memory.count} samples, but {type(block).__name__} "
            f"remembers {needed} numbers; go on from the state of a block of the same structure"
        )
    return Memory(values, memory.count)


def _columns(graph: Graph, samples: Samples) -> np.ndarray:
    if isinstance(samples, Aligned):
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
