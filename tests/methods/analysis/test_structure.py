"""Structure and observability."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.methods.analysis.structure import Equation, StructuralModel, isolability, structure_of
from tierod.models.column_observation import require_fit
from tierod.models.linear import LinearSystem


def drawn(seed, equations=12, unknowns=8, faults=5):
    chance = random.Random(seed)
    names = [f"x{j}" for j in range(unknowns)]
    inside = [set(chance.sample(names, chance.randint(1, 3))) for _ in range(equations)]
    for name in set(names) - set().union(*inside):
        inside[chance.randrange(equations)].add(name)
    faulty = dict(zip(chance.sample(range(equations), faults), (f"f{k}" for k in range(faults)), strict=True))
    return StructuralModel(tuple(Equation.of(f"e{i}", each, (), faulty.get(i, "")) for i, each in enumerate(inside)))


def by_toolbox(model):
    toolbox = pytest.importorskip("faultdiagnosistoolbox")
    faults = sorted(model.faults)
    rows = [[*sorted(each.unknowns), *([each.fault] if each.fault else [])] for each in model.equations]
    definition = {"type": "VarStruc", "x": list(model.unknowns), "f": faults, "z": [], "rels": rows}
    return toolbox.DiagnosisModel(definition, name="drawn")


SEEDS = range(12)


@pytest.mark.parametrize("seed", SEEDS)
def test_detectable_and_isolable_faults_are_those_of_the_toolbox(seed):
    model = drawn(seed)
    found, toolbox = isolability(model), by_toolbox(model)
    detectable, _ = toolbox.DetectabilityAnalysis()
    assert {fault for fault, seen in zip(found.faults, found.detectable, strict=True) if seen} == set(detectable)
    order = [found.faults.index(fault) for fault in toolbox.f]
    theirs = np.asarray(toolbox.IsolabilityAnalysis()) > 0.5
    seen = found.detectable[order]
    assert np.array_equal(found.mistaken[np.ix_(order, order)][seen], theirs[seen])


def three_sensors_of_one_speed(count):
    return StructuralModel(tuple(Equation.of(f"sensor {k}", ["speed"], [f"y{k}"], f"fault {k}") for k in range(count)))


def test_two_sensors_of_one_quantity_detect_a_fault_and_three_isolate_it():
    two, three = (isolability(three_sensors_of_one_speed(count)) for count in (2, 3))
    assert two.undetectable == ()
    assert two.isolable == ()
    assert two.groups == (("fault 0", "fault 1"),)
    assert two.mistaken_for("fault 0") == ("fault 1",)
    assert three.isolable == three.faults
    one = isolability(three_sensors_of_one_speed(1))
    assert one.undetectable == ("fault 0",)
    assert one.groups == ()


class Mass:
    """A mass on a spring with a force that is commanded; its position is measured."""

    class State(NamedTuple):
        position: float
        speed: float
        drift: float

    class Input(NamedTuple):
        force: float

    class Output(NamedTuple):
        position_sensor: float
        speed_sensor: float

    @dataclass(frozen=True)
    class Parameters:
        stiffness: float = 3.0
        offset: float = 0.0

    @staticmethod
    def derivative(x, u, p):
        return Mass.State(x.speed, u.force - p.stiffness * x.position + x.drift, 0.0)

    @staticmethod
    def output(x, u, p):
        return Mass.Output(x.position, x.speed + p.offset * u.force)


def test_the_structure_of_a_model_is_read_from_its_functions():
    faults = {"position_sensor": "position", "speed_sensor": "speed", "known force": "actuator"}
    model = structure_of(Mass, Mass.Parameters(), faults, known_inputs=["force"], without=["drift"])
    inside = {each.name: each.unknowns for each in model.equations}
    assert inside == {
        "motion of position": {"d position", "speed"},
        "motion of speed": {"d speed", "force", "position"},
        "d position": {"d position", "position"},
        "d speed": {"d speed", "speed"},
        "position_sensor": {"position"},
        "speed_sensor": {"speed"},
        "known force": {"force"},
    }
    found = isolability(model)
    assert found.undetectable == ()
    assert found.mistaken_for("actuator") == ()  # the two sensors agree all the same
    with_offset = structure_of(Mass, Mass.Parameters(offset=0.1), faults, ["force"], ["drift"])
    assert with_offset.by_name["speed_sensor"].unknowns == {"speed", "force"}


def oscillator(frequency=10.0, damping=0.1):
    """x'' = -w^2 x - 2 d w x', the angle measured."""
    A = [[0.0, 1.0], [-(frequency**2), -2.0 * damping * frequency]]
    return LinearSystem.of(A, [[1.0, 0.0]], states=("angle", "rate"))


BLIND = LinearSystem.of(np.diag([-1.0, -2.0]), [[1.0, 0.0]], states=("angle", "rate"))


@pytest.mark.parametrize(
    ("system", "said"),
    [
        (oscillator(damping=-0.1), r"eigenvalue 1[+-]9\.95j 1/s in (angle|rate)"),
        (BLIND, "not observable: 1 rate; add an output"),
        (oscillator(frequency=3200.0), "at most 0.00099 s"),
    ],
)
def test_a_model_that_does_not_fit_is_refused_with_its_direction(system, said):
    with pytest.raises(ParameterError, match=said):
        require_fit(system, "the pendulum", 1e-3)
    require_fit(oscillator(), "it", 1e-3)
