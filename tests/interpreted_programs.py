"""What a program of operations gives, worked out one by one."""

from __future__ import annotations

import ctypes
import ctypes.util

import numpy as np

from random_programs import Made
from tierod.core.graph.operations import NEXT_STATE, PUSH, RING, SAMPLE, STATE, TUNING, Program
from tierod.export.interface import added, is_own


class Interpreter:
    """Works a program out operation by operation.

    Args:
        step: that is worked out
        single: in single precision, with clocks that count
        fused: whether a product with a sum is rounded once
        counted: clocks, by the position of their state
    """

    def __init__(self, step: Program, single: bool = False, fused: bool = False, counted=None):
        self.step, self.kind, self.counted = step, np.float32 if single else np.float64, counted or {}
        self.fused, self.suffix = fused, "f" if single else ""

    def run(self, made: Made, samples: np.ndarray) -> np.ndarray:
        """Outputs (steps, outputs) from the first state on."""
        initial = {target: made.initial.operations[v].constant for target, v in made.initial.outputs.items()}
        state = [0 if k in self.counted else self.kind(initial[NEXT_STATE, k]) for k in range(made.states)]
        lines = [[self.kind(initial[PUSH, k])] * size for k, size in enumerate(made.rings)]
        found = np.zeros((len(samples), made.outputs))
        tuned = [self.kind(each) for each in made.tuning]
        with np.errstate(all="ignore"):
            for row, sample in enumerate(samples):
                heads = [line[0] for line in lines]
                groups = {TUNING: tuned, RING: heads, SAMPLE: [self.kind(each) for each in sample]}
                values = self._values(groups, state)
                after = list(state)
                for (group, place), value in self.step.outputs.items():
                    if group == NEXT_STATE:
                        counts = place in self.counted
                        after[place] = self._count(place, value, state, values) if counts else values[value]
                    elif group == PUSH:
                        lines[place] = [*lines[place][1:], values[value]]
                    else:
                        found[row, place] = values[value]
                state = after
        return found

    def _values(self, groups, state):
        values: list = []
        self.times = {}
        for operation in self.step.operations:
            if operation.name == "input":
                group, place = operation.constant
                if group != STATE:
                    values.append(groups[group][place])
                elif place in self.counted:
                    values.append((place,))
                else:
                    values.append(state[place])
            else:
                values.append(None)
        for index, operation in enumerate(self.step.operations):
            if operation.name != "input":
                arguments = [self._resolved(each, values, state) for each in operation.arguments]
                values[index] = self._one(operation, arguments)
        return [self._resolved(index, values, state) for index in range(len(values))]

    def _resolved(self, index, values, state):
        value = values[index]
        if isinstance(value, tuple):
            step = values[self.counted[value[0]].step]
            if step is None:
                step = self._alone(self.counted[value[0]].step, values)
            return self.kind(state[value[0]]) * step
        return value

    def _alone(self, index, values):
        """A value that follows from tuning alone, before its turn."""
        if values[index] is not None:
            return values[index]
        operation = self.step.operations[index]
        return self._one(operation, [self._alone(each, values) for each in operation.arguments])

    def _count(self, place, index, state, values):
        operation, own = self.step.operations[index], state[place]
        if operation.name in ("select", "if"):
            if values[operation.arguments[0]] != 0.0:
                return self._count(place, operation.arguments[1], state, values)
            return self._count(place, operation.arguments[2], state, values) if operation.name == "select" else 0
        more = added(self.step, index, place)
        if more is not None:
            return own + 1 if more.condition is None or values[more.condition] != 0.0 else own
        return own if is_own(self.step, index, place) else 0

    def _one(self, operation, a):
        name, kind = operation.name, self.kind
        if name == "constant":
            return kind(operation.constant)
        plain = {
            "add": lambda: a[0] + a[1], "sub": lambda: a[0] - a[1], "mul": lambda: a[0] * a[1],
            "div": lambda: a[0] / a[1], "inverse": lambda: kind(1.0) / a[0], "neg": lambda: -a[0],
            "assign": lambda: a[0], "fabs": lambda: abs(a[0]), "sqrt": lambda: np.sqrt(a[0]),
            "floor": lambda: np.floor(a[0]), "ceil": lambda: np.ceil(a[0]),
            "sign": lambda: kind(1.0) if a[0] > 0.0 else kind(-1.0) if a[0] < 0.0 else a[0],
            "lt": lambda: kind(a[0] < a[1]), "le": lambda: kind(a[0] <= a[1]),
            "eq": lambda: kind(a[0] == a[1]), "ne": lambda: kind(a[0] != a[1]),
            "and": lambda: kind(a[0] != 0.0 and a[1] != 0.0), "or": lambda: kind(a[0] != 0.0 or a[1] != 0.0),
            "not": lambda: kind(a[0] == 0.0), "select": lambda: a[1] if a[0] != 0.0 else a[2],
            "if": lambda: a[1] if a[0] != 0.0 else kind(0.0),
            "fma": lambda: self._fused(a[0], a[1], a[2]), "fms": lambda: self._fused(a[0], a[1], -a[2]),
            "fnma": lambda: self._fused(-a[0], a[1], a[2]), "pick": lambda: a[1 + _place(a[0], len(a) - 1)],
        }  # fmt: skip
        return plain[name]() if name in plain else self._called(name, *a)

    def _fused(self, a, b, c):
        return self._called("fma", a, b, c) if self.fused else a * b + c

    def _called(self, name, *a):
        function = getattr(_LIBRARY, name + self.suffix)
        kind = ctypes.c_float if self.suffix else ctypes.c_double
        function.restype, function.argtypes = kind, [kind] * len(a)
        return self.kind(function(*map(float, a)))


def _place(number, count):
    """The place of a value that is picked by its number."""
    return int(number) if 1.0 <= number <= count - 1 and number == np.floor(number) else 0


_LIBRARY = ctypes.CDLL(ctypes.util.find_library("m"))
