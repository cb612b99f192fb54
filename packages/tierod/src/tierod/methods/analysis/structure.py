"""Structural analysis of a model from the incidence of its equations: redundancy, detectable and isolable faults."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from tierod.core.block import Model, Tree, leaves, rebuild, skeleton
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.trace import dependence


@dataclass(frozen=True)
class Equation:
    """One equation, by the variables that it contains."""

    name: str
    unknowns: frozenset[str]
    knowns: frozenset[str] = frozenset()
    fault: str = ""  # that violates it; empty for none

    @classmethod
    def of(cls, name: str, unknowns: Iterable[str], knowns: Iterable[str] = (), fault: str = "") -> Equation:
        return cls(name, frozenset(unknowns), frozenset(knowns), fault)


@dataclass(frozen=True)
class StructuralModel:
    """A set of equations.

    A fault occurs in one equation only. A fault that acts on several is modelled as an unknown, with an equation that
    sets it to zero and contains the fault.
    """

    equations: tuple[Equation, ...]

    def __post_init__(self) -> None:
        for what, names in (
            ("equations are named", [each.name for each in self.equations]),
            ("equations hold the fault", [each.fault for each in self.equations if each.fault]),
        ):
            repeated = [name for name, count in Counter(names).items() if count > 1]
            if repeated:
                raise ParameterError(f"two {what} '{repeated[0]}'; give each a name of its own")

    @cached_property
    def by_name(self) -> dict[str, Equation]:
        return {each.name: each for each in self.equations}

    @cached_property
    def unknowns(self) -> tuple[str, ...]:
        """Unknowns in the order of their first occurrence."""
        return tuple(dict.fromkeys(name for each in self.equations for name in sorted(each.unknowns)))

    @cached_property
    def faults(self) -> dict[str, str]:
        """Name of the equation of each fault."""
        return {each.fault: each.name for each in self.equations if each.fault}

    def without(self, *names: str) -> StructuralModel:
        """The model without some of its equations, for example of a sensor that the car does not have."""
        for name in names:
            if name not in self.by_name:
                raise ParameterError(f"the model has no equation '{name}'{nearest(name, self.by_name)}")
        return StructuralModel(tuple(each for each in self.equations if each.name not in names))

    def plus(self, *equations: Equation) -> StructuralModel:
        """The model with further equations, for example of another sensor."""
        return StructuralModel((*self.equations, *equations))


def structure_of(
    model: Model,
    parameters: Tree,
    faults: Mapping[str, str],
    known_inputs: Collection[str] = (),
    without: Collection[str] = (),
    free: Collection[str] = (),
) -> StructuralModel:
    """The structural model of a dynamic model.

    Every state x has an equation "motion of x" for its change, and an equation "d x" that relates the change to x (as
    its derivative, or its next value). Every output is an equation of a sensor, with the name of the output.

    Args: parameters: of the model; terms that are structurally zero with them are left out; known_inputs: known inputs,
    each with an equation "known <input>"; the others are unknown.
    """
    shapes = {part: skeleton(getattr(model, part)) for part in ("State", "Input", "Output")}
    states, inputs, outputs = ([path for path, _ in leaves(tree)] for tree in shapes.values())
    _refuse_unknown(
        faults, [*(f"motion of {name}" for name in states), *outputs, *(f"known {name}" for name in inputs)]
    )
    _refuse_unknown(without, [*states, *outputs])
    _refuse_unknown(free, states)
    _refuse_unknown(known_inputs, inputs)
    inside = _inside(model, parameters, shapes, [*states, *inputs])
    moving = [name for name in states if name not in {*without, *free}]
    equations = [
        Equation.of(f"motion of {name}", {*inside[0][name], f"d {name}"}, (), faults.get(f"motion of {name}", ""))
        for name in moving
    ]
    equations += [Equation.of(f"d {name}", (name, f"d {name}")) for name in moving]
    measured = [name for name in outputs if name not in without]
    equations += [Equation.of(name, inside[1][name], {name}, faults.get(name, "")) for name in measured]
    known = [name for name in inputs if name in known_inputs]
    equations += [Equation.of(f"known {name}", {name}, {name}, faults.get(f"known {name}", "")) for name in known]
    zero = set(without)
    return StructuralModel(
        tuple(Equation(each.name, each.unknowns - zero, each.knowns, each.fault) for each in equations)
    )


def _inside(
    model: Model, parameters: Tree, shapes: Mapping[str, Tree], names: list[str]
) -> tuple[dict[str, set[str]], dict[str, set[str]]]:
    motion = model.transition if hasattr(model, "transition") else model.derivative
    split = len(list(leaves(shapes["State"])))

    def both(values: Tree) -> Tree:
        x, u = rebuild(shapes["State"], values[:split]), rebuild(shapes["Input"], values[split:])
        return motion(x, u, parameters), model.output(x, u, parameters)

    table = dependence(both, tuple(0.0 for _ in names))
    found = [{name for name, there in zip(names, row, strict=True) if there} for row in table]
    outputs = [path for path, _ in leaves(shapes["Output"])]
    return dict(zip(names[:split], found[:split], strict=True)), dict(zip(outputs, found[split:], strict=True))


def _refuse_unknown(given: Collection[str], known: Collection[str]) -> None:
    for name in given:
        if name not in known:
            raise ParameterError(f"the model has no '{name}'{nearest(name, known)}")


@dataclass(frozen=True, eq=False)
class Isolability:
    faults: tuple[str, ...]  # names, in the order of rows and columns
    detectable: np.ndarray
    # whether the fault of the column explains everything that the fault of the row causes; true on the diagonal. A set
    # of faults does not count as an explanation of a part of itself
    mistaken: np.ndarray

    @cached_property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """Detectable faults, isolable from all others but not from each other; a fault by itself is isolable."""
        alike = self.mistaken & self.mistaken.T
        seen: set[int] = set()
        groups = []
        for i in range(len(self.faults)):
            if self.detectable[i] and i not in seen:
                group = [j for j in range(len(self.faults)) if alike[i, j]]
                seen.update(group)
                groups.append(tuple(self.faults[j] for j in group))
        return tuple(groups)

    @property
    def undetectable(self) -> tuple[str, ...]:
        """Faults that are not detectable."""
        return tuple(fault for fault, seen in zip(self.faults, self.detectable, strict=True) if not seen)

    @property
    def isolable(self) -> tuple[str, ...]:
        """Faults that are isolable from every other."""
        alone = self.detectable & (self.mistaken.sum(axis=1) == 1)
        return tuple(fault for fault, one in zip(self.faults, alone, strict=True) if one)

    @property
    def isolated_pairs(self) -> int:
        """Number of ordered pairs of faults of which the first is detectable and not mistaken for the second."""
        return int(np.sum(~self.mistaken & self.detectable[:, None]))

    def mistaken_for(self, fault: str) -> tuple[str, ...]:
        """Other faults that explain everything that `fault` causes."""
        row = self.mistaken[self.faults.index(fault)]
        return tuple(other for other, same in zip(self.faults, row, strict=True) if same and other != fault)


def isolability(model: StructuralModel, at_once: int = 1) -> Isolability:
    """Detectable and isolable faults of a model, for single faults or for several at once.

    Fault A is isolable from B if its equation is still in the overdetermined part after that of B is removed. Only
    minimal explanations count: A and B together explain whatever A causes, but are no explanation of A.

    Source: Krysander, Frisk, Sensor placement for fault diagnosis, IEEE Trans. SMC A 38 (2008), section III. Args:
    at_once: largest number of simultaneous faults; with 2, rows and columns are single faults and pairs ("A + B").
    """
    sets = [each for size in range(1, at_once + 1) for each in combinations(model.faults, size)]
    left = {each: _faults_of(overdetermined(_without(model, each))) for each in sets}
    seen = _faults_of(overdetermined(model.equations))
    detectable = np.array([bool(set(each) & seen) for each in sets], dtype=bool)
    mistaken = np.array(
        [[not set(there) & left[other] and not set(there) < set(other) for other in sets] for there in sets], dtype=bool
    )
    return Isolability(tuple(" + ".join(each) for each in sets), detectable, mistaken.reshape(len(sets), len(sets)))


def _without(model: StructuralModel, faults: Iterable[str]) -> list[Equation]:
    return [each for each in model.equations if each.fault not in set(faults) or not each.fault]


def _faults_of(equations: Iterable[Equation]) -> set[str]:
    return {each.fault for each in equations if each.fault}


@dataclass(frozen=True)
class SensorGain:
    """Improvement by one more sensor."""

    sensor: str
    detectable: tuple[str, ...]  # faults of the present model that it makes detectable
    isolated_pairs: int  # number of ordered pairs of the model's faults that it additionally isolates
    own_isolable: bool  # whether its own fault is isolable from all others


def gain_of_sensors(model: StructuralModel, sensors: Sequence[Equation], at_once: int = 1) -> tuple[SensorGain, ...]:
    """Improvement by each of several sensors alone, the largest first."""
    now = isolability(model, at_once)
    gains = []
    for sensor in sensors:
        then = isolability(model.plus(sensor), at_once)
        old = [then.faults.index(fault) for fault in now.faults]
        among_old = Isolability(now.faults, then.detectable[old], then.mistaken[np.ix_(old, old)])
        shown = tuple(fault for fault in now.undetectable if fault not in among_old.undetectable)
        own = bool(sensor.fault) and sensor.fault in then.isolable
        gains.append(SensorGain(sensor.name, shown, among_old.isolated_pairs - now.isolated_pairs, own))
    return tuple(sorted(gains, key=lambda each: (-len(each.detectable), -each.isolated_pairs, not each.own_isolable)))


def overdetermined(equations: Sequence[Equation]) -> tuple[Equation, ...]:
    """The overdetermined part of a set of equations, in which they can be checked against each other.

    Source: Dulmage, Mendelsohn, Coverings of bipartite graphs, Canad. J. Math. 10 (1958).
    """
    rows, columns = _incidence(equations)
    over = _from_unmatched_rows(rows, _matched(rows, len(columns)))
    return tuple(equations[i] for i in sorted(over))


def _incidence(equations: Sequence[Equation]) -> tuple[list[list[int]], dict[str, int]]:
    columns: dict[str, int] = {}
    rows = [[columns.setdefault(name, len(columns)) for name in sorted(each.unknowns)] for each in equations]
    return rows, columns


def _matched(rows: list[list[int]], columns: int) -> np.ndarray:
    """The equation that each unknown is matched with in a maximum matching, -1 for none."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_bipartite_matching

    if not rows or not columns:
        return np.full(columns, -1)
    pointers = np.concatenate([[0], np.cumsum([len(row) for row in rows])]).astype(np.int32)
    indices = np.array([j for row in rows for j in row], dtype=np.int32)
    incidence = csr_array((np.ones(len(indices)), indices, pointers), shape=(len(rows), columns))
    return np.asarray(maximum_bipartite_matching(incidence, perm_type="row"))


def _from_unmatched_rows(rows: list[list[int]], row_of: np.ndarray) -> set[int]:
    seen = set(range(len(rows))) - set(row_of.tolist())
    waiting = list(seen)
    while waiting:
        for column in rows[waiting.pop()]:
            row = int(row_of[column])
            if row >= 0 and row not in seen:
                seen.add(row)
                waiting.append(row)
    return seen
