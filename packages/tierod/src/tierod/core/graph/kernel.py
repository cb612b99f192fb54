"""A block's compiled step, or the CasADi virtual machine where there is no compiler: one interface for both."""

from __future__ import annotations

import ctypes
import os
import warnings
from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import Any, Literal, Protocol

import numpy as np

from tierod.core.block import Block, tuning
from tierod.core.errors import CompileError, KernelWarning, ParameterError
from tierod.core.graph.bank import BankGraph
from tierod.core.graph.compiler import compiler, keep, kept, kernel_name, load, load_kept
from tierod.core.graph.known_graphs import kernel_entry
from tierod.core.graph.trace import LANES, TILE_STEPS, Graph, Interface, grouped, prefix, trace, ungrouped

# Samples per call of the unrolled map: enough that the cost of a call is negligible, few enough to build it fast
BLOCK = 1000


class VirtualMachine:
    """A block's step, interpreted; same interface as a compiled kernel.

    Tuning values are folded into the graph, except zeros: CasADi simplifies 0 * x to 0, but compiled code gives NaN
    where x is NaN.
    """

    def __init__(self, block: Block):
        import casadi

        self.graph = graph = trace(block)
        values = [value for _, value in tuning(block)]
        zeros = casadi.SX.sym("z", values.count(0.0))
        left = iter(casadi.vertsplit(zeros))
        tuned = casadi.vertcat(*(value if value != 0.0 else next(left) for value in values))
        state, heads, sample = (casadi.SX.sym(n, graph.function.size1_in(i)) for i, n in ((1, "x"), (2, "r"), (3, "u")))
        after, pushes, output = graph.function.call([casadi.SX(tuned), state, heads, sample])
        self._step = casadi.Function("step", [state, heads, sample, zeros], [after, pushes, output])
        # The place in a delay line depends on the number of samples, so that such blocks are stepped one by one.
        self._plain = None if graph.rings else casadi.Function("plain", [state, sample, zeros], [after, output])

    @cached_property
    def _mapped(self) -> tuple[Any, Callable[[], None], np.ndarray, np.ndarray]:
        """Buffer and call of the unrolled map, the states that it writes, and the zeros that it reads.

        Building the map costs more than a short run.
        """
        assert self._plain is not None
        states, zeros = np.empty((BLOCK, len(self.graph.state))), np.zeros((BLOCK, self._plain.numel_in(2)))
        buffer, run = self._plain.mapaccum("scan", BLOCK).buffer()
        buffer.set_arg(2, memoryview(zeros))  # type: ignore[call-arg,arg-type]
        buffer.set_res(0, memoryview(states))  # type: ignore[call-arg,arg-type]
        return buffer, run, states, zeros

    def scan(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> None:
        """Run over samples (n, inputs) into outputs (n, outputs); `memory` is updated, `count` steps came before."""
        done = 0
        if self._plain is not None and len(samples) >= BLOCK:
            buffer, run, states, _ = self._mapped
            buffer.set_arg(0, memoryview(memory))  # type: ignore[arg-type]
            while len(samples) - done >= BLOCK:
                block = slice(done, done + BLOCK)
                buffer.set_arg(1, memoryview(samples[block]))  # type: ignore[arg-type]
                buffer.set_res(1, memoryview(outputs[block]))  # type: ignore[arg-type]
                run()
                memory[:] = states[-1]
                done += BLOCK
        self._one_by_one(memory, samples[done:], outputs[done:], count + done)

    def _one_by_one(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> None:
        plain = len(self.graph.state)
        sizes = np.array([size for _, size in self.graph.rings], dtype=int)
        starts = plain + np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(int) if len(sizes) else sizes
        buffer, evaluate = self._step.buffer()
        state, heads, sample = np.zeros(plain), np.zeros(len(sizes)), np.zeros(samples.shape[1])
        after, pushes, output = np.zeros(plain), np.zeros(len(sizes)), np.zeros(outputs.shape[1])
        zeros = np.zeros(self._step.numel_in(3))
        for slot, array in enumerate((state, heads, sample, zeros)):
            buffer.set_arg(slot, memoryview(array))  # type: ignore[call-arg,arg-type]
        for slot, array in enumerate((after, pushes, output)):
            buffer.set_res(slot, memoryview(array))  # type: ignore[call-arg,arg-type]
        after[:] = memory[:plain]
        for k in range(len(samples)):
            at = starts + (count + k) % sizes if len(sizes) else starts
            state[:], heads[:], sample[:] = after, memory[at], samples[k]
            evaluate()
            memory[at], outputs[k] = pushes, output
        memory[:plain] = after


class BankMachine:
    """A bank's step, interpreted; same interface as a compiled kernel."""

    def __init__(self, bank: Any):
        traced: Any = trace(bank)
        self.graph: BankGraph = traced
        values = np.array([value for _, value in tuning(bank)], dtype=float)
        split = self.graph.count * len(self.graph.lane.tuning)
        self._lanes = _Call(self.graph.lane.function.map(self.graph.count), values[:split])
        self._judge = _Call(self.graph.judge.function, values[split:])

    def scan(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> None:
        """Run over samples (n, inputs) into outputs (n, outputs); `memory` is updated, `count` steps came before."""
        graph, lanes, judge = self.graph, self._lanes, self._judge
        own = graph.lanes_memory
        said = own + len(graph.judge.state)
        rings = said + len(graph.feedback)
        sizes = np.array([size for _, size in graph.rings], dtype=int)
        starts = rings + np.concatenate([[0], np.cumsum(sizes)]).astype(int)[: len(sizes)]
        states, seen = lanes.rows(1, graph.count), lanes.rows(3, graph.count)
        states[:] = ungrouped(memory[:own], graph.count)
        width = samples.shape[1]
        for k in range(len(samples)):
            at = starts + (count + k) % sizes if len(sizes) else starts
            seen[:, :width], seen[:, width:] = samples[k], memory[said:rings]
            lanes.run()
            judge.inputs[1][:], judge.inputs[2][:] = memory[own:said], memory[at]
            judge.inputs[3][:width], judge.inputs[3][width:] = samples[k], lanes.outputs[2]
            judge.run()
            verdict = judge.outputs[2]
            given = len(graph.output)
            outputs[k] = verdict[:given]
            memory[own:said], memory[at] = judge.outputs[0], judge.outputs[1]
            memory[said:rings] = verdict[given + graph.count :]
            states[:] = lanes.outputs[0].reshape(states.shape)[_sources(verdict[given : given + graph.count])]
        memory[:own] = grouped(states)


def _sources(adopt: np.ndarray) -> np.ndarray:
    valid = (adopt >= 0.0) & (adopt < len(adopt))
    return np.where(valid, np.where(valid, adopt, 0.0).astype(int), np.arange(len(adopt)))


class _Call:
    """A CasADi function bound to arrays of its own; the first input is filled with the tuning."""

    def __init__(self, function: Any, values: np.ndarray):
        self.inputs = [np.zeros(function.numel_in(k)) for k in range(function.n_in())]
        self.outputs = [np.zeros(function.numel_out(k)) for k in range(function.n_out())]
        self.inputs[0][:] = values
        self._buffer, self.run = function.buffer()
        for k, array in enumerate(self.inputs):
            self._buffer.set_arg(k, memoryview(array))  # type: ignore[arg-type]
        for k, array in enumerate(self.outputs):
            self._buffer.set_res(k, memoryview(array))  # type: ignore[arg-type]

    def rows(self, position: int, count: int) -> np.ndarray:
        return self.inputs[position].reshape(count, -1)


Engine = Literal["auto", "compiled", "virtual machine"]

CACHE_LINE = 64  # Size of a cache line of the processor [bytes]

_LOOP = (ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_long)


class Kernel(Protocol):
    """Executor of one block: its step over many samples."""

    @property
    def graph(self) -> Interface: ...

    def scan(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> None:
        """Run over samples (n, inputs) into outputs (n, outputs); `memory` is updated, `count` steps came before."""


class CompiledKernel:
    """A block's step as machine code; all that depends on its tuning alone is computed once."""

    def __init__(self, block: Block):
        self.graph = trace(block)
        self.library = _library(self.graph)
        self.name = prefix(self.graph)
        self.carried = _prepare(self.library, self.name, block)
        self._scan = getattr(self.library, f"{self.name}_scan")
        self._scan.argtypes, self._scan.restype = _LOOP, None

    def scan(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> None:
        """Run over samples (n, inputs) into outputs (n, outputs); `memory` is updated, `count` steps came before."""
        _run(self._scan, memory, samples, outputs, self.carried, count)


class LaneKernel:
    """Up to `LANES` blocks of one structure side by side; arrays are laid out `[time][signal][lane]`."""

    def __init__(self, blocks: list[Block]):
        self.graph = trace(blocks[0])
        tunings = [np.array([value for _, value in tuning(block)]) for block in blocks]
        own = any(not np.array_equal(tunings[0], other, equal_nan=True) for other in tunings[1:])
        library = _library(self.graph, own)
        name = prefix(self.graph)
        columns = [_prepare(library, name, block) for block in blocks] if own else [_prepare(library, name, blocks[0])]
        if own:  # unused lanes run too, so that they need a valid calibration
            columns += [columns[0]] * (LANES - len(columns))
        self.carried = np.ascontiguousarray(np.stack(columns, axis=1)).ravel()
        self._lanes = getattr(library, f"{name}_lanes")
        self._lanes.argtypes, self._lanes.restype = _LOOP, None
        self._batch = getattr(library, f"{name}_batch")
        self._batch.argtypes, self._batch.restype = (*_LOOP, ctypes.c_void_p, ctypes.c_void_p), None

    def scan(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> None:
        """Run over samples (n, inputs, lanes) into outputs (n, outputs, lanes); `memory` is updated likewise."""
        _run(self._lanes, memory, samples, outputs, self.carried, count)

    def batch(
        self, memory: np.ndarray, samples: list[np.ndarray], outputs: list[np.ndarray], steps: int, count: int
    ) -> None:
        """Run all lanes over arrays of their own: samples (>= steps, inputs) into outputs (>= steps, outputs) each."""
        widths = (len(self.graph.sample), len(self.graph.output))
        tiles = [lane_array(TILE_STEPS, width) for width in widths]
        pointers = [(ctypes.c_void_p * LANES)(*map(_address, arrays)) for arrays in (samples, outputs)]
        self._batch(
            steps, _address(memory), *map(ctypes.addressof, pointers), _address(self.carried), count,
            *map(_address, tiles),
        )  # fmt: skip


def lane_array(*shape: int) -> np.ndarray:
    """An array (..., lanes) aligned to a cache line: vectors across two lines cost up to a sixth of a lane's time."""
    size = int(np.prod(shape)) * LANES
    raw = np.empty(size + CACHE_LINE // 8)
    skipped = -raw.ctypes.data % CACHE_LINE // 8
    return raw[skipped : skipped + size].reshape(*shape, LANES)


def kernel(block: Block, engine: Engine = "auto") -> Kernel:
    """Kernel that runs a block.

    Args:
        engine: "compiled", "virtual machine", or "auto": compiled where there is a compiler; the environment
            variable TIEROD_ENGINE decides for "auto"
    """
    if not is_interpreted(engine):
        try:
            return CompiledKernel(block)
        except CompileError as error:
            _warn_interpreted(error, engine)
    return BankMachine(block) if isinstance(trace(block), BankGraph) else VirtualMachine(block)


def lane_kernel(blocks: list[Block]) -> LaneKernel | None:
    """Kernel that runs many blocks of one structure side by side; None where each has to run alone."""
    if is_interpreted() or isinstance(trace(blocks[0]), BankGraph):
        return None
    try:
        return LaneKernel(blocks)
    except CompileError as error:
        _warn_interpreted(error, "auto")
        return None


_INTERPRETED: set[str] = set()


def _warn_interpreted(error: CompileError, engine: str) -> None:
    """Warn once per process why blocks run on the virtual machine; an error where compilation was requested."""
    if _chosen(engine) == "compiled":
        raise error
    if not _INTERPRETED:
        _INTERPRETED.add(str(error))
        warnings.warn(f"{error}. The virtual machine is used, which is slower", KernelWarning, stacklevel=3)


def is_interpreted(engine: str = "auto") -> bool:
    """Whether blocks run on the virtual machine with this engine."""
    chosen = _chosen(engine)
    return chosen == "virtual machine" or (chosen == "auto" and compiler() is None)


def _chosen(engine: str) -> str:
    if engine == "auto":
        engine = os.environ.get("TIEROD_ENGINE", "auto")
    if engine not in ("auto", "compiled", "virtual machine"):
        raise ParameterError(f"engine '{engine}' is unknown; write 'auto', 'compiled' or 'virtual machine'")
    return engine


def _run(
    loop: Any, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, carried: np.ndarray, count: int
) -> None:
    addresses = map(_address, (memory, samples, outputs, carried))
    loop(len(samples), *addresses, count)


def _address(array: np.ndarray) -> int:
    if array.dtype != np.float64 or not array.flags.c_contiguous:
        raise ValueError(f"a kernel needs float64 in C order, not {array.dtype} with strides {array.strides}")
    return array.ctypes.data


def print_c(graph: Graph | BankGraph) -> str:
    """C of a graph; the printer is loaded only where no cache holds the kernel."""
    from tierod.core.graph import printer

    return printer.print_c(graph)


def print_lanes(graph: Any, own_tuning: bool) -> str:
    from tierod.core.graph import printer

    return printer.print_lanes(graph, own_tuning)


def _library(graph: Graph | BankGraph, own_tuning: bool | None = None) -> ctypes.PyDLL:
    """The library of a graph: for one block where `own_tuning` is None, else for lanes with own or shared tuning."""
    found = _attempted(graph, own_tuning)
    if isinstance(found, CompileError):
        raise found.with_traceback(None)
    return found


@lru_cache(maxsize=512)
def _attempted(graph: Any, own_tuning: bool | None) -> ctypes.PyDLL | CompileError:
    """The library, or the error: it is cached too, so that the next piece of a recording does not compile again."""
    name = prefix(graph)
    try:
        if own_tuning is None:
            library = _loaded(graph, "alone", lambda: print_c(graph), name)
        else:
            kind = "own_tuning" if own_tuning else "lanes"
            library = _loaded(graph, kind, lambda: print_lanes(graph, bool(own_tuning)), f"{name}_lanes")
    except CompileError as error:
        return error
    if not hasattr(library, f"{name}_carried"):
        return CompileError(
            "the C compiler did not build the expected library from generated code; choose another one with the "
            "environment variable "
            "TIEROD_CC (empty for none)"
        )
    return library


def _loaded(graph: Any, kind: str, source: Callable[[], str], name: str) -> ctypes.PyDLL:
    """The library of a graph; its C is printed only where no earlier process has compiled it."""
    entry = kernel_entry(graph.entry, kind) if graph.entry else None
    known = kept(entry) if entry else None
    library = load_kept(known.decode()) if known else None
    if library is None:
        text = source()
        library = load(text, name)
        command = compiler()
        if entry and command:
            keep(entry, kernel_name(command, text, name).encode())
    return library


def _prepare(library: ctypes.PyDLL, name: str, block: Block) -> np.ndarray:
    values = np.array([value for _, value in tuning(block)], dtype=float)
    carried = np.zeros(ctypes.c_long.in_dll(library, f"{name}_carried").value)
    prepare = getattr(library, f"{name}_prepare")
    prepare.argtypes, prepare.restype = (ctypes.c_void_p, ctypes.c_void_p), None
    prepare(_address(values), _address(carried))
    return carried
