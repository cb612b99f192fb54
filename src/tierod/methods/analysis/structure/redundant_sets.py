"""Sets of equations from which one residual can be made, and no equation of which can be spared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tierod.core.errors import ParameterError
from tierod.methods.analysis.structure.decomposition import overdetermined, redundancy
from tierod.methods.analysis.structure.structural_model import Equation, StructuralModel

MOST = 100_000
"""Sets that are listed at most: their number grows exponentially with the redundancy."""


def minimal_redundant_sets(model: StructuralModel, most: int = MOST) -> tuple[frozenset[str], ...]:
    """Names of the equations of every minimal structurally overdetermined set.

    Args:
        model: its equations
        most: number of sets at which the search is given up

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


def _minimal(equations: Sequence[Equation], spared: Sequence[Equation]) -> Iterator[Sequence[Equation]]:
    """Minimal sets of an overdetermined set; only those of `spared` may be taken away, so that none comes twice."""
    if not equations:
        return
    if redundancy(equations) == 1:
        yield equations
        return
    left = list(spared)
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
        sets of faults, none of which holds another; equations without fault do not count, so there are far fewer than
        minimal redundant sets

    Source: Krysander, Aslund, Frisk, A structural algorithm for finding testable sub-models and multiple fault
    isolability analysis, 21st Workshop on Principles of Diagnosis (2010).
    """
    whole = overdetermined(model.equations)
    faults = [each for each in whole if each.fault]
    found = {frozenset(each.fault for each in equations if each.fault) for equations in _testable(whole, faults)}
    least = [each for each in found if not any(other < each for other in found)]
    return tuple(sorted(least, key=lambda each: (len(each), sorted(each))))


def _testable(equations: Sequence[Equation], spared: Sequence[Equation]) -> Iterator[Sequence[Equation]]:
    """Overdetermined sets from which no fault can be taken without taking all."""
    smaller = False
    left = list(spared)
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
