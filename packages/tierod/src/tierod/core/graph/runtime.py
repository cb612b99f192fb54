"""Two of the three drivers: a recording (`scan`) and a live stream (`Stream`), with samples, results and states."""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from numbers import Real
from typing import Any, Generic

import numpy as np

from tierod.core.block import Block, Given, Output, State, Tree, rebuild, values_of
from tierod.core.errors import InputError, nearest
from tierod.core.graph.kernel import CompiledKernel, Engine, Kernel, LaneKernel, kernel, lane_array, lane_kernel
from tierod.core.graph.trace import LANES, Interface, flat_memory, initial_memory, trace
from tierod.core.recording import Aligned


@dataclass(frozen=True)
class Memory:
    """The state of a block between two runs."""

    values: np.ndarray  # flat, delay lines at the end, shape (numbers,)
    count: int


@dataclass(frozen=True)
class Result(Generic[Output]):
    names: tuple[str, ...]
    values: np.ndarray  # shape (n, outputs)
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
    """The samples as an array (n, inputs) in the order of the graph's inputs."""
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


def scan(
    block: Block[State, Given, Output], samples: Samples, state: Memory | State | None = None, engine: Engine = "auto"
) -> Result[Output]:
    """Run a block over a recording.

    Args:
        samples: signals aligned to one time grid (columns are found by name), or an array (n, inputs) in the order
            of the leaves of `block.Sample`
        state: state to continue from: that of an earlier result, or a state tree; the block's initial state if None
    """
    return Scanner(block, engine).scan(samples, state)


class Scanner(Generic[State, Given, Output]):
    """A block prepared once to be run over consecutive pieces of a recording.

    `names` and `outputs` are the names of its input and output signals, in order; `graph` is the block's graph.
    """

    def __init__(self, block: Block[State, Given, Output], engine: Engine = "auto"):
        self.block, self._kernel = block, kernel(block, engine)
        self.graph = self._kernel.graph
        self.names: tuple[str, ...] = tuple(self.graph.sample)
        self.outputs: tuple[str, ...] = tuple(self.graph.output)

    def scan(self, samples: Samples, state: Memory | State | None = None) -> Result[Output]:
        """Run the block over a piece; arguments and result as for `scan`."""
        graph = self.graph
        memory = memory_of(self.block, state, graph)
        values = np.ascontiguousarray(columns_of(graph, samples))
        outputs = np.empty((len(values), len(graph.output)))
        flat = memory.values.copy()
        self._kernel.scan(flat, values, outputs, memory.count)
        return Result(graph.output, outputs, Memory(flat, memory.count + len(values)), graph.output_tree)


class Stream(Generic[State, Given, Output]):
    """A block run live: one sample in, one output out. It changes with each sample, so one thread at a time may use it.

    `push` takes and returns named values. Where every microsecond counts, write into `inputs`, call `advance()`, and
    read `outputs`: the same step on the same bound buffers, without conversion.

    Args:
        state: state to continue from; the block's own initial state if None
    """

    def __init__(
        self, block: Block[State, Given, Output], state: Memory | State | None = None, engine: Engine = "auto"
    ):
        runner = kernel(block, engine)
        graph, memory = runner.graph, memory_of(block, state)
        self.names = graph.sample
        self.inputs = np.zeros(len(graph.sample))
        self.outputs = np.zeros(len(graph.output))
        self._flat = memory.values.copy()
        self._make: Callable[..., Output] = _builder(graph.output_tree)
        self._write = struct.Struct(f"{len(self.inputs)}d").pack_into
        self._read = struct.Struct(f"{len(self.outputs)}d").unpack_from
        self._input_bytes, self._output_bytes = self.inputs.data.cast("B"), self.outputs.data.cast("B")
        self._before = memory.count
        self._count: Callable[[], int]
        self.advance = self._bind(runner) if isinstance(runner, CompiledKernel) else self._interpreted(runner)

    def push(self, sample: Given | Mapping[str, float] | Iterable[float]) -> Output:
        """Advance by one sample.

        Returns:
            the block's output
        """
        # Flat numbers, the usual case, are packed without a check; trees of tuples and errors end in the exception.
        try:
            if type(sample) is dict or isinstance(sample, Mapping):
                self._write(self._input_bytes, 0, *map(sample.__getitem__, self.names))
            else:
                self._write(self._input_bytes, 0, *sample)  # type: ignore[misc]  # anything but a row of numbers raises
        except (KeyError, TypeError, struct.error) as error:
            self._write(self._input_bytes, 0, *self._flattened(sample, error))
        self.advance()
        return self._make(*self._read(self._output_bytes))

    @property
    def state(self) -> Memory:
        """The present state, to store or to continue from."""
        return Memory(self._flat.copy(), self._count())

    def _flattened(self, sample: object, error: Exception) -> list[float]:
        """The numbers of a sample that is a tree of tuples; anything else is refused."""
        if isinstance(sample, Mapping):
            missing = [name for name in self.names if name not in sample]
            if missing:
                raise InputError(
                    f"the sample has no '{missing[0]}' (NaN stands for a measurement that is missing)"
                    f"{nearest(missing[0], map(str, sample))}"
                ) from None
            sample = tuple(sample[name] for name in self.names)
        flat = values_of(sample)
        if len(flat) != len(self.names) or not all(isinstance(leaf, Real) for leaf in flat):
            raise InputError(
                f"a sample needs {len(self.names)} numbers ({', '.join(self.names)}): {error}; "
                "give a mapping of these names, or the block's own Sample"
            ) from None
        return flat

    def _bind(self, runner: CompiledKernel) -> Callable[[], None]:
        def pointer(array: np.ndarray) -> int:
            return array.ctypes.data

        self._bound = _Bound(pointer(self._flat), pointer(self.inputs), pointer(self.outputs), 0, self._before)
        self._carried = runner.carried
        self._bound.carried = pointer(self._carried)
        push = getattr(runner.library, f"{runner.name}_push")
        push.restype = None
        self._count = lambda: int(self._bound.count)
        return partial(push, ctypes.byref(self._bound))

    def _interpreted(self, runner: Kernel) -> Callable[[], None]:
        inputs, outputs = self.inputs.reshape(1, -1), self.outputs.reshape(1, -1)
        seen = [self._before]
        self._count = lambda: seen[0]

        def advance() -> None:
            runner.scan(self._flat, inputs, outputs, seen[0])
            seen[0] += 1

        return advance


def _builder(tree: Tree) -> Callable[..., Tree]:
    """A function from the leaves of a tree to the tree: for speed a lambda that is written for its shape."""
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
    kinds = {name: kind for name, kind in names.items() if kind is not None}
    made: Callable[..., Tree] = eval(f"lambda {leaves_}: {body}", kinds)
    return made


class _Bound(ctypes.Structure):
    _fields_ = (
        ("state", ctypes.c_void_p),
        ("inputs", ctypes.c_void_p),
        ("outputs", ctypes.c_void_p),
        ("carried", ctypes.c_void_p),
        ("count", ctypes.c_long),
    )


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
