"""Detectability and isolability of faults by a set of equations, and the improvement by another sensor."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from tierod.methods.analysis.structure.structural_model import Equation, StructuralModel


@dataclass(frozen=True, eq=False)
class Isolability:
    """Detectability and isolability of faults.

    Args:
        faults: names, in the order of rows and columns
        mistaken: whether the fault of the column explains everything that the fault of the row causes; true on the
            diagonal. A set of faults does not count as an explanation of a part of itself
    """

    faults: tuple[str, ...]
    detectable: np.ndarray
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

    Args:
        at_once: largest number of simultaneous faults; with 2, rows and columns are single faults and pairs ("A + B")

    Source: Krysander, Frisk, Sensor placement for fault diagnosis, IEEE Trans. SMC A 38 (2008), section III.
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
    """Improvement by one more sensor.

    Args:
        detectable: faults of the present model that it makes detectable
        isolated_pairs: number of ordered pairs of the model's faults that it additionally isolates
        own_isolable: whether its own fault is isolable from all others
    """

    sensor: str
    detectable: tuple[str, ...]
    isolated_pairs: int
    own_isolable: bool


def gain_of_sensors(model: StructuralModel, sensors: Sequence[Equation], at_once: int = 1) -> tuple[SensorGain, ...]:
    """Improvement by each of several sensors alone, the largest first.

    Args:
        sensors: an equation for each, with its own fault
        at_once: largest number of simultaneous faults, see `isolability`
    """
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
