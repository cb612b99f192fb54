"""The structure of a model, read from its own functions: no second list of what stands where."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from tierod.analysis.structure.structural_model import Equation, StructuralModel
from tierod.block import leaves, rebuild, skeleton
from tierod.errors import ParameterError, nearest
from tierod.graph.derivatives import dependence


def structure_of(
    model: Any,
    parameters: Any,
    faults: Mapping[str, str],
    known_inputs: Collection[str] = (),
    without: Collection[str] = (),
) -> StructuralModel:
    """The equations of a continuous model by what stands in them.

    Every state x has its equation of motion, named after it, in which its rate stands, and one that says that the rate
    is its derivative ("d x"). Every output is a sensor's equation.

    Args:
        model: with `derivative` and `output`
        parameters: of the model; terms that are structurally zero with them are left out
        faults: name of the fault of an equation, by the name of the equation (state, output, or "known " and an input)
        known_inputs: inputs that are known, each by an equation "known <input>"; the others are unknown
        without: states that stay at zero (what the model may be wrong by), and outputs that are not measured

    Raises:
        ParameterError: a name that the model does not have
    """
    shapes = {part: skeleton(getattr(model, part)) for part in ("State", "Input", "Output")}
    states, inputs, outputs = ([path for path, _ in leaves(tree)] for tree in shapes.values())
    names = [*states, *inputs]
    split = len(states)

    def both(values: Any) -> tuple[Any, ...]:
        x, u = rebuild(shapes["State"], values[:split]), rebuild(shapes["Input"], values[split:])
        return model.derivative(x, u, parameters), model.output(x, u, parameters)

    table = dependence(both, tuple(0.0 for _ in names))
    silent = set(without)
    inside = [{each for each, there in zip(names, row, strict=True) if there} - silent for row in table]
    equations = [
        Equation.of(name, {*found, f"d {name}"}, fault=faults.get(name, ""))
        for name, found in zip(states, inside[:split], strict=True)
        if name not in silent
    ]
    equations += [Equation.of(f"d {name}", (name, f"d {name}")) for name in states if name not in silent]
    equations += [
        Equation.of(name, found, {name}, faults.get(name, ""))
        for name, found in zip(outputs, inside[split:], strict=True)
        if name not in silent
    ]
    told = [name for name in inputs if name in known_inputs]
    equations += [Equation.of(f"known {name}", {name}, {name}, faults.get(f"known {name}", "")) for name in told]
    _refuse_unknown(faults, [*states, *outputs, *(f"known {name}" for name in inputs)])
    _refuse_unknown(without, [*states, *outputs])
    _refuse_unknown(known_inputs, inputs)
    return StructuralModel(tuple(equations))


def _refuse_unknown(given: Collection[str], known: Collection[str]) -> None:
    for name in given:
        if name not in known:
            raise ParameterError(f"the model has no '{name}'{nearest(name, known)}")
