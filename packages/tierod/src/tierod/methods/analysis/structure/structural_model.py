"""Structural model: the incidence of unknowns in equations, derived from the functions of a model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from tierod.core.block import Tree, leaves, rebuild, skeleton
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.derivatives import dependence
from tierod.core.model import Model


@dataclass(frozen=True)
class Equation:
    """One equation, by the variables that it contains.

    Args:
        fault: that violates it; empty for none
    """

    name: str
    unknowns: frozenset[str]
    knowns: frozenset[str] = frozenset()
    fault: str = ""

    @classmethod
    def of(cls, name: str, unknowns: Iterable[str], knowns: Iterable[str] = (), fault: str = "") -> Equation:
        return cls(name, frozenset(unknowns), frozenset(knowns), fault)


@dataclass(frozen=True)
class StructuralModel:
    """A set of equations.

    A fault occurs in one equation only. A fault that acts on several is modelled as an unknown, with an equation that
    sets it to zero and contains the fault.

    Raises:
        ParameterError: two equations of one name, or a fault in two equations
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
        """The model without some of its equations, for example of a sensor that the car does not have.

        Raises:
            ParameterError: there is no such equation
        """
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

    Args:
        parameters: of the model; terms that are structurally zero with them are left out
        faults: name of the fault of an equation, by the equation's name: "motion of <state>", output, "known <input>"
        known_inputs: known inputs, each with an equation "known <input>"; the others are unknown
        without: states that are zero (such as model errors), and outputs that are not measured
        free: states that may vary arbitrarily: their equation of motion is left out

    Raises:
        ParameterError: a name that the model does not have
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
