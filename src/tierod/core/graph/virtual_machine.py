"""Run a traced block on CasADi's virtual machine, for machines without a compiler."""

from __future__ import annotations

import numpy as np

from tierod.core.block import Block, tuning
from tierod.core.graph.trace import trace

BLOCK = 1000
"""Samples per call of the unrolled map: large enough that the call does not count, small enough to build at once."""


class VirtualMachine:
    """A block's step, interpreted; same interface as a compiled kernel.

    Tuning is folded into the graph, but for zeros: CasADi would take 0 * x for 0, and compiled code does not where x is
    NaN.
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
        if not graph.rings:
            self._states = np.empty((BLOCK, len(graph.state)))
            plain = casadi.Function("plain", [state, sample, zeros], [after, output])
            self._buffer, self._run = plain.mapaccum("scan", BLOCK).buffer()
            self._zeros = np.zeros((BLOCK, zeros.numel()))
            self._buffer.set_arg(2, memoryview(self._zeros))  # type: ignore[call-arg,arg-type]
            self._buffer.set_res(0, memoryview(self._states))  # type: ignore[call-arg,arg-type]

    def scan(self, memory: np.ndarray, samples: np.ndarray, outputs: np.ndarray, count: int) -> None:
        """Run over samples (n, inputs) into outputs (n, outputs); `memory` is carried on, `count` steps came before."""
        done = 0
        if not self.graph.rings:
            self._buffer.set_arg(0, memoryview(memory))  # type: ignore[call-arg,arg-type]
            while len(samples) - done >= BLOCK:
                block = slice(done, done + BLOCK)
                self._buffer.set_arg(1, memoryview(samples[block]))  # type: ignore[call-arg,arg-type]
                self._buffer.set_res(1, memoryview(outputs[block]))  # type: ignore[call-arg,arg-type]
                self._run()
                memory[:] = self._states[-1]
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
