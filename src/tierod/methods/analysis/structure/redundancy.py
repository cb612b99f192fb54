"""Redundancy of a set of equations, and its minimal sets that give a residual."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tierod.core.errors import ParameterError
from tierod.methods.analysis.structure.structural_model import Equation, StructuralModel


@dataclass(frozen=True)
class Decomposition:
    """Dulmage-Mendelsohn parts of a structure, and its degree of redundancy.

    Args:
        overdetermined: names of the equations in the part with more equations than unknowns, the only checkable one
        just_determined: names in the part with as many equations as unknowns
        underdetermined: names in the part with fewer equations than unknowns
        redundancy: number of equations less number of unknowns of the overdetermined part
    """

    overdetermined: tuple[str, ...]
    just_determined: tuple[str, ...]
    underdetermined: tuple[str, ...]
    redundancy: int


def decompose(model: StructuralModel) -> Decomposition:
    """Dulmage-Mendelsohn decomposition of a structural model.

    Args:
        model: its equations

    Source: Dulmage, Mendelsohn, Coverings of bipartite graphs, Canad. J. Math. 10 (1958).
    """
    rows, columns = _incidence(model.equations)
    row_of = _matched(rows, len(columns))
    over = _from_unmatched_rows(rows, row_of)
    under = _from_unmatched_columns(rows, row_of)
    names = [each.name for each in model.equations]
    parts = [over, set(range(len(rows))) - over - under, under]
    listed = [tuple(names[i] for i in sorted(part)) for part in parts]
    return Decomposition(listed[0], listed[1], listed[2], len(over) - len({j for i in over for j in rows[i]}))


def overdetermined(equations: Sequence[Equation]) -> tuple[Equation, ...]:
    """The overdetermined part of a set of equations, in which they can be checked against each other."""
    rows, columns = _incidence(equations)
    over = _from_unmatched_rows(rows, _matched(rows, len(columns)))
    return tuple(equations[i] for i in sorted(over))


def redundancy(equations: Iterable[Equation]) -> int:
    """Degree of redundancy: number of equations less number of their unknowns."""
    every = list(equations)
    return len(every) - len(frozenset().union(*(each.unknowns for each in every)))


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
    """Rows on alternating paths that start at an unmatched row."""
    seen = set(range(len(rows))) - set(row_of.tolist())
    waiting = list(seen)
    while waiting:
        for column in rows[waiting.pop()]:
            row = int(row_of[column])
            if row >= 0 and row not in seen:
                seen.add(row)
                waiting.append(row)
    return seen


def _from_unmatched_columns(rows: list[list[int]], row_of: np.ndarray) -> set[int]:
    """Rows on alternating paths that start at an unmatched column."""
    rows_with: dict[int, list[int]] = {}
    for i, inside in enumerate(rows):
        for column in inside:
            rows_with.setdefault(column, []).append(i)
    column_of = {int(row): column for column, row in enumerate(row_of) if row >= 0}
    waiting = [column for column, row in enumerate(row_of) if row < 0]
    columns, seen = set(waiting), set[int]()
    while waiting:
        for row in rows_with.get(waiting.pop(), []):
            seen.add(row)
            partner = column_of.get(row)
            if partner is not None and partner not in columns:
                columns.add(partner)
                waiting.append(partner)
    return seen


MOST = 100_000
"""Largest number of sets that are listed, since it grows exponentially with the redundancy."""


def minimal_redundant_sets(model: StructuralModel, most: int = MOST) -> tuple[frozenset[str], ...]:
    """Names of the equations of every minimal structurally overdetermined set.

    Args:
        model: its equations
        most: largest number of sets

    Raises:
        ParameterError: there are more than `most`

    Source: Krysander, Aslund, Nyberg, An efficient algorithm for finding minimal overconstrained subsystems for
    model-based diagnosis, IEEE Trans. SMC A 38 (2008), algorithm 3.
    """
    whole = overdetermined(model.equations)
    found: list[frozenset[str]] = []
    for equations in _minimal(whole, whole):
        if len(found) == most:
            raise ParameterError(
                f"the model has more than {most} minimal redundant sets; ask for the minimal test sets instead, "
                "or leave out sensors"
            )
        found.append(frozenset(each.name for each in equations))
    return tuple(found)


def _minimal(equations: Sequence[Equation], removable: Sequence[Equation]) -> Iterator[Sequence[Equation]]:
    """Minimal sets of an overdetermined set; only equations of `removable` are removed, so that no set occurs twice."""
    if not equations:
        return
    if redundancy(equations) == 1:
        yield equations
        return
    left = list(removable)
    while left:
        rest = overdetermined([each for each in equations if each is not left[0]])
        kept = {each.name for each in rest}
        gone = {each.name for each in equations} - kept
        if gone <= {each.name for each in left}:
            yield from _minimal(rest, [each for each in left if each.name in kept])
        left = [each for each in left if each.name not in gone]


def minimal_test_sets(model: StructuralModel) -> tuple[frozenset[str], ...]:
    """The smallest sets of faults that one residual can be sensitive to.

    Args:
        model: its equations

    Returns:
        sets of faults, none of which contains another; equations without fault do not count, so that there are far
        fewer than minimal redundant sets

    Source: Krysander, Aslund, Frisk, A structural algorithm for finding testable sub-models and multiple fault
    isolability analysis, 21st Workshop on Principles of Diagnosis (2010).
    """
    whole = overdetermined(model.equations)
    faults = [each for each in whole if each.fault]
    found = {frozenset(each.fault for each in equations if each.fault) for equations in _testable(whole, faults)}
    least = [each for each in found if not any(other < each for other in found)]
    return tuple(sorted(least, key=lambda each: (len(each), sorted(each))))


def _testable(equations: Sequence[Equation], removable: Sequence[Equation]) -> Iterator[Sequence[Equation]]:
    """Overdetermined sets with faults of which no smaller overdetermined part has any."""
    smaller = False
    left = list(removable)
    while left:
        rest = overdetermined([each for each in equations if each is not left[0]])
        kept = {each.name for each in rest}
        gone = {each.name for each in equations if each.fault} - kept
        if any(each.fault for each in rest):
            smaller = True
            if gone <= {each.name for each in left}:
                yield from _testable(rest, [each for each in left if each.name in kept])
        left = [each for each in left if each.name not in gone]
    if not smaller and any(each.fault for each in equations):
        yield equations
