"""Which unknown stands in which equation: all that structural analysis looks at."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from tierod.core.errors import ParameterError, nearest


@dataclass(frozen=True)
class Equation:
    """One equation by what stands in it.

    Args:
        name: of the equation
        unknowns: that stand in it
        knowns: measured signals and targets that stand in it
        fault: that makes it wrong; empty where none does
    """

    name: str
    unknowns: frozenset[str]
    knowns: frozenset[str] = frozenset()
    fault: str = ""

    @classmethod
    def of(cls, name: str, unknowns: Iterable[str], knowns: Iterable[str] = (), fault: str = "") -> Equation:
        """An equation from any collections of names."""
        return cls(name, frozenset(unknowns), frozenset(knowns), fault)


@dataclass(frozen=True)
class StructuralModel:
    """A set of equations.

    A fault stands in one equation only; one that acts on several is given an unknown of its own, and an equation that
    holds it at zero.

    Args:
        equations: with names of their own

    Raises:
        ParameterError: two equations of one name, or a fault in two equations
    """

    equations: tuple[Equation, ...]

    def __post_init__(self):
        for what, names in (
            ("equations are named", [each.name for each in self.equations]),
            ("equations hold the fault", [each.fault for each in self.equations if each.fault]),
        ):
            repeated = [name for name, count in Counter(names).items() if count > 1]
            if repeated:
                raise ParameterError(f"two {what} '{repeated[0]}'; give each a name of its own")

    @cached_property
    def by_name(self) -> dict[str, Equation]:
        """Equations by name."""
        return {each.name: each for each in self.equations}

    @cached_property
    def unknowns(self) -> tuple[str, ...]:
        """Unknowns in the order in which they first stand."""
        return tuple(dict.fromkeys(name for each in self.equations for name in sorted(each.unknowns)))

    @cached_property
    def faults(self) -> dict[str, str]:
        """Name of the equation of each fault."""
        return {each.fault: each.name for each in self.equations if each.fault}

    def without(self, *names: str) -> StructuralModel:
        """The model without some of its equations: a sensor that the car does not have.

        Raises:
            ParameterError: there is no such equation
        """
        for name in names:
            if name not in self.by_name:
                raise ParameterError(f"the model has no equation '{name}'{nearest(name, self.by_name)}")
        return StructuralModel(tuple(each for each in self.equations if each.name not in names))

    def plus(self, *equations: Equation) -> StructuralModel:
        """The model with further equations: another sensor."""
        return StructuralModel((*self.equations, *equations))
