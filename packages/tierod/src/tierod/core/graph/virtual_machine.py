"""Run a traced block, or a bank of blocks, on CasADi's virtual machine, for machines without a compiler."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from tierod.core.block import Block, tuning
from tierod.core.graph.bank_graph import BankGraph
from tierod.core.graph.memory_layout import grouped, ungrouped
from tierod.core.graph.trace import trace

BLOCK = 1000
"""Samples per call of the unrolled map: enough that the cost of a call is negligible, few enough to build it fast."""


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
