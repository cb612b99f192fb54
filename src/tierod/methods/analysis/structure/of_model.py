"""The structure of a model, read from its own functions: no second list of what stands where."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from tierod.core.block import leaves, rebuild, skeleton
from tierod.core.errors import ParameterError, nearest
from tierod.core.graph.derivatives import dependence
from tierod.methods.analysis.structure.structural_model import Equation, StructuralModel


def structure_of(
    model: Any,
    parameters: Any,
    faults: Mapping[str, str],
    known_inputs: Collection[str] = (),
    without: Collection[str] = (),
    free: Collection[str] = (),
) -> StructuralModel:
    """The equations of a model by what stands in them.

    Every state x has its equation "motion of x", in which its change stands, and one that says that the change is its
    own ("d x": its derivative, or its next value). Every output is a sensor's equation of its name.

    Args:
        model: continuous or discrete
        parameters: of the model; terms that are structurally zero with them are left out
        faults: name of the fault of an equation, by the equation's name: "motion of <state>", output, "known <input>"
        known_inputs: inputs that are known, each by an equation "known <input>"; the others are unknown
        without: states that stay at zero (what the model may be wrong by), and outputs that are not measured
        free: states that may be anything at any time: their equation of motion is left out

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
    told = [name for name in inputs if name in known_inputs]
    equations += [Equation.of(f"known {name}", {name}, {name}, faults.get(f"known {name}", "")) for name in told]
    zero = set(without)
    return StructuralModel(
        tuple(Equation(each.name, each.unknowns - zero, each.knowns, each.fault) for each in equations)
    )


def _inside(
    model: Any, parameters: Any, shapes: Mapping[str, Any], names: list[str]
) -> tuple[dict[str, set[str]], dict[str, set[str]]]:
    """States and inputs in every equation of motion, and in every output, by name."""
    motion = model.transition if hasattr(model, "transition") else model.derivative
    split = len(list(leaves(shapes["State"])))

    def both(values: Any) -> tuple[Any, ...]:
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
